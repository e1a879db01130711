#pragma once

#include "scenes/glb.h"

/// Drawn textures of the default level. Those of floors tile without a seam.
namespace lightgrid::scenes {

Picture wood_planks();      // twelve boards, side by side along v
Picture checkered_tiles();  // two by two, with grout
Picture paving();           // garden flags, three by three
Picture rug();              // 3 : 2
Picture painting();         // a low sun over hills, 4 : 3
Picture print();            // circles, 3 : 4
Picture leaf();             // tip at the top; outside the leaf alpha is 0

}  // namespace lightgrid::scenes
