#pragma once

#include "scenes/shapes.h"

/// Furniture of the default level, standing on y = 0 around the Y axis unless said otherwise; materials by index.
namespace lightgrid::scenes {

Shape chair(int wood, int cushion);                          // the back is at -Z
Shape sofa(int fabric, int cushion, int wood, float width);  // looks along +Z
Shape armchair(int fabric, int cushion, int wood);           // looks along +Z
Shape table(int top, int legs, glm::vec3 size);              // width, height, depth
Shape round_table(int top, int legs, float radius, float height);
Shape shelf(int wood, glm::vec3 size, int boards);  // open along +Z
Shape book(int cover, int paper);                   // unit cube, standing; its spine looks along +Z
Shape plant(int pot, int soil, int leaf, int leaves, float height);
Shape floor_lamp(int metal, int shade, float height);
Shape pendant(int metal, int bulb, float cord, float radius);  // hangs from y = 0 down
Shape desk_lamp(int metal, int bulb);                          // leans towards +X
Shape picture_frame(int frame, int picture, glm::vec2 size);   // its back is the plane z = 0
Shape vase(int glaze, float height);
Shape bowl(int glaze, int fruit, float radius);
Shape plate(int china);
Shape column(int stone, float radius, float height);
Shape window_frame(int frame, int glass, glm::vec2 size, glm::ivec2 panes);  // in the plane z = 0, from (0, 0)
Shape curtain(int cloth, float width, float height);                         // in the plane z = 0, from (0, 0)

}  // namespace lightgrid::scenes
