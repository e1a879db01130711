#pragma once

#include "scenes/glb.h"

/// The levels; scenes/README.md says what each is for and which light it must have.
namespace lightgrid::scenes {

// Rooms and a court, known by reference runs, and the default level that the demo bakes.
Glb cornell();
Glb thin_wall();
Glb door_ajar();
Glb courtyard();
/// Its group of lamps shines, or is dark.
Glb inn(bool lamps);
Glb default_level();

// Closed forms.
Glb furnace(float albedo);
Glb ground();
Glb occluder();
Glb point_light();
Glb spot_light();
Glb emitter_rect();
Glb blend_cover();
Glb glass_cover();

}  // namespace lightgrid::scenes
