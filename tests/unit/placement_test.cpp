#include "probes/placement.h"

#include "core/error.h"
#include "core/sh.h"
#include "probes/grid_choice.h"
#include "probes/headroom.h"
#include "probes/outer_walls.h"
#include "tests/scene_builder.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

namespace lightgrid {
namespace {

/// Under a sky, where light is of no help to tell inside from outside.
const LightEvidence dark_below_sky = {[](glm::vec3) { return false; }, true};
const LightEvidence dark = {[](glm::vec3) { return false; }, false};
const LightEvidence lit = {[](glm::vec3) { return true; }, false};

Box box_of(glm::dvec3 min, glm::dvec3 max) {
    Box box;
    box.min = min;
    box.max = max;
    return box;
}

Grid grid_over(glm::dvec3 min, glm::dvec3 max, glm::ivec3 counts) {
    Grid grid;
    grid.origin = min;
    grid.counts = counts;
    grid.spacing = (max - min) / glm::dvec3(counts - 1);
    return grid;
}

std::size_t slot_of(const Volume& volume, glm::ivec3 probe) {
    for (std::size_t b = 0; b < volume.bricks.size(); ++b) {
        const glm::ivec3 local = probe - volume.bricks[b].origin;
        if (glm::all(glm::greaterThanEqual(local, glm::ivec3(0))) && glm::all(glm::lessThan(local, glm::ivec3(4)))) {
            return b * probes_per_brick + static_cast<std::size_t>((local.z * 4 + local.y) * 4 + local.x);
        }
    }
    ADD_FAILURE() << "no such probe";
    return 0;
}

template <typename What>
void for_each_probe(const Volume& volume, What what) {
    const glm::ivec3 counts = volume.grids[0].counts;
    for (int z = 0; z < counts.z; ++z) {
        for (int y = 0; y < counts.y; ++y) {
            for (int x = 0; x < counts.x; ++x) what(slot_of(volume, {x, y, z}));
        }
    }
}

/// How deep inside the box, negative outside: the distance to its nearest side by maximum norm.
double depth_in(const Box& box, glm::dvec3 point) {
    const glm::dvec3 depth = glm::min(point - box.min, box.max - point);
    return std::min({depth.x, depth.y, depth.z});
}

/// A crate of 2 m on a ground of 20 m.
struct Crate {
    Box box = box_of({1, 0, 1}, {3, 2, 3});
    Scene scene;

    Crate() {
        const int wood = add_grey(scene, 0.5F);
        add_quad(scene, wood, {-10, -0.02F, -10}, {0, 0, 20}, {20, 0, 0});
        add_box(scene, wood, glm::vec3(box.min), glm::vec3(box.max), Facing::outward);
    }
};

TEST(Placement, ProbesInsideASolidAreMovedOutWithinHalfACellElseMarked) {
    const Crate crate;
    const Tracer tracer(crate.scene);
    Volume volume = make_volume({grid_over({-0.7, 0.4, -0.7}, {4.9, 3.2, 4.9}, {15, 8, 15})}, 1);  // 0.4 m
    const PlacementCounts counts = place_probes(volume, tracer, dark_below_sky);
    const double clearance = 0.04;
    std::size_t valid = 0;
    std::size_t moved = 0;
    std::size_t invalid = 0;
    for_each_probe(volume, [&](std::size_t slot) {
        const glm::dvec3 place = lattice_position(volume, slot);
        const glm::dvec3 gathered = gather_position(volume, slot);
        const double depth = depth_in(crate.box, place);
        switch (volume.states[slot]) {
            case ProbeState::valid:
                ++valid;
                EXPECT_EQ(place, gathered);
                EXPECT_LT(depth, -0.8 * clearance);
                break;
            case ProbeState::moved: {
                ++moved;
                EXPECT_LT(depth_in(crate.box, gathered), -0.8 * clearance);
                const glm::dvec3 offset = glm::abs(gathered - place);
                EXPECT_LE(std::max({offset.x, offset.y, offset.z}), 0.2 + 1e-6);
                // The least: straight out, and two clearances beyond.
                if (depth > clearance) {
                    EXPECT_LT(glm::length(offset), depth + 2 * clearance + 1e-5);
                }
                break;
            }
            default:
                ++invalid;
                EXPECT_EQ(volume.states[slot], ProbeState::missing);
                EXPECT_GT(depth, 0.2 - 2 * clearance - 1e-6) << "could have been moved";
        }
    });
    EXPECT_EQ(counts.valid, valid);
    EXPECT_EQ(counts.moved, moved);
    EXPECT_EQ(counts.invalid, invalid);
    EXPECT_GT(moved, 20U);
    EXPECT_GT(invalid, 20U);
    EXPECT_GT(valid, 1000U);
}

TEST(Placement, ProbesOnFacesEdgesAndVerticesAreMovedOff) {
    Scene scene;
    const Box box = box_of({0, 0, 0}, {2, 2, 2});
    add_box(scene, add_grey(scene, 0.5F), glm::vec3(0), glm::vec3(2), Facing::outward);
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over({-1, -1, -1}, {3, 3, 3}, {5, 5, 5})}, 1);
    place_probes(volume, tracer, dark_below_sky);
    std::array<int, 4> on = {};  // by how many faces a probe is on: 1 face, 2 edge, 3 vertex
    for_each_probe(volume, [&](std::size_t slot) {
        const glm::dvec3 place = lattice_position(volume, slot);
        if (depth_in(box, place) != 0) return;
        const int faces =
            static_cast<int>(place.x != 1) + static_cast<int>(place.y != 1) + static_cast<int>(place.z != 1);
        ++on[static_cast<std::size_t>(faces)];
        EXPECT_EQ(volume.states[slot], ProbeState::moved) << place.x << " " << place.y << " " << place.z;
        EXPECT_LT(depth_in(box, gather_position(volume, slot)), -0.05);
    });
    EXPECT_EQ(on, (std::array<int, 4>{0, 6, 12, 8}));
    EXPECT_EQ(volume.states[slot_of(volume, {2, 2, 2})], ProbeState::missing) << "one cell deep";
}

TEST(Placement, ProbesOnTheWallsOfARoomAreMovedInside) {
    // A grid over the level's bounds has its outermost probes in the walls; they must not end up outside.
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), glm::vec3(-2), glm::vec3(2), Facing::inward);
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over({-2, -2, -2}, {2, 2, 2}, {5, 5, 5})}, 1);
    const PlacementCounts counts = place_probes(volume, tracer, lit);
    EXPECT_EQ(counts.invalid, 0U);
    EXPECT_EQ(counts.moved, 125U - 27U);
    for_each_probe(volume, [&](std::size_t slot) {
        EXPECT_GT(depth_in(box_of(glm::dvec3(-2), glm::dvec3(2)), gather_position(volume, slot)), 0.05);
    });
}

TEST(Placement, ProbesNearAThinWallStayOnTheirSide) {
    for (const float facing : {1.0F, -1.0F}) {
        Scene scene;
        const int material = add_grey(scene, 0.5F);
        add_quad(scene, material, {-5, -5, 0}, {10, 0, 0}, {0, 10 * facing, 0});
        if (facing < 0) scene.meshes[0].positions = {{-5, 5, 0}, {5, 5, 0}, {5, -5, 0}, {-5, -5, 0}};
        scene.meshes[0].positions.reserve(5);
        const Tracer tracer(scene);
        for (const double side : {0.05, -0.05}) {
            Volume volume = make_volume({grid_over({-1, -1, side - 1}, {1, 1, side + 1}, {3, 3, 3})}, 1);
            place_probes(volume, tracer, lit);
            for (int x = 0; x < 3; ++x) {
                const std::size_t slot = slot_of(volume, {x, 1, 1});
                EXPECT_EQ(volume.states[slot], ProbeState::moved);
                EXPECT_GT(gather_position(volume, slot).z * side, 0);
                EXPECT_GT(std::abs(gather_position(volume, slot).z), 0.08);
            }
        }
    }
}

TEST(Placement, AShellWoundInsideOutIsFreeWhereThereIsLight) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), glm::vec3(-2), glm::vec3(2), Facing::outward);
    const Tracer tracer(scene);
    const Grid inner = grid_over({-1, -1, -1}, {1, 1, 1}, {3, 3, 3});
    Volume with_lamp = make_volume({inner}, 1);
    EXPECT_EQ(place_probes(with_lamp, tracer, lit).valid, 27U);
    Volume on_walls = make_volume({grid_over(glm::dvec3(-2), glm::dvec3(2), glm::ivec3(5))}, 1);
    EXPECT_EQ(place_probes(on_walls, tracer, lit).moved, 125U - 27U);
    Volume without = make_volume({inner}, 1);
    EXPECT_EQ(place_probes(without, tracer, dark).invalid, 27U) << "nothing tells it from a solid";
}

TEST(Placement, AnOpenShellWoundInsideOutIsFreeUnderASky) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), glm::vec3(-2), glm::vec3(2), Facing::outward);
    std::vector<glm::uvec3>& sides = scene.meshes[0].triangles;
    sides.erase(sides.begin() + 6, sides.begin() + 8);  // +y
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over({-1, 0.2, -1}, {1, 1.8, 1}, {3, 3, 3})}, 1);
    EXPECT_EQ(place_probes(volume, tracer, dark_below_sky).valid, 27U);
}

TEST(Placement, ARoomWithoutLightIsFree) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), glm::vec3(-2), glm::vec3(2), Facing::inward);
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over({-1, -1, -1}, {1, 1, 1}, {3, 3, 3})}, 1);
    EXPECT_EQ(place_probes(volume, tracer, dark).valid, 27U);
}

TEST(Placement, BackFacesOfPanesTellNothing) {
    Scene scene;
    Material glass;
    glass.transmission = 0.9F;
    add_box(scene, add_material(scene, glass), glm::vec3(-2), glm::vec3(2), Facing::outward);
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over({-1, -1, -1}, {1, 1, 1}, {3, 3, 3})}, 1);
    EXPECT_EQ(place_probes(volume, tracer, dark).valid, 27U);
}

TEST(Placement, InsideADoubleSidedBoxLightDecides) {
    // Exporters set doubleSided on everything, so it does not clear a dark box of being solid.
    Scene scene;
    Material sheet;
    sheet.double_sided = true;
    add_box(scene, add_material(scene, sheet), glm::vec3(-2), glm::vec3(2), Facing::outward);
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over({-1, -1, -1}, {1, 1, 1}, {3, 3, 3})}, 1);
    EXPECT_EQ(place_probes(volume, tracer, dark).valid, 0U);
    volume = make_volume({grid_over({-1, -1, -1}, {1, 1, 1}, {3, 3, 3})}, 1);
    EXPECT_EQ(place_probes(volume, tracer, {[](glm::vec3) { return 1.0; }, false}).valid, 27U);
}

TEST(Placement, TheOutsideOfALevelWithoutASkyIsInvalid) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), glm::vec3(-1), glm::vec3(1), Facing::inward);
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over({-4, -4, -4}, {4, 4, 4}, {3, 3, 3})}, 1);
    const LightEvidence lit_inside = {[](glm::vec3 p) { return glm::length(p) < 1; }, false};
    const PlacementCounts counts = place_probes(volume, tracer, lit_inside);
    EXPECT_EQ(counts.valid, 1U);
    EXPECT_EQ(counts.invalid, 26U);
    volume = make_volume({grid_over({-4, -4, -4}, {4, 4, 4}, {3, 3, 3})}, 1);
    EXPECT_EQ(place_probes(volume, tracer, dark_below_sky).valid, 27U) << "with a sky it is the open";
}

TEST(Placement, BorderProbesBehindTheOuterWallsOfARoomAreMovedIntoIt) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), glm::vec3(-1), glm::vec3(1), Facing::inward);
    const Tracer tracer(scene);
    const LightEvidence all_lit = {[](glm::vec3) { return 1.0; }, true};
    // Cells of 0.55 m; the walls are 0.1 m inside of the border: what is behind them is a third of what weighs there.
    Volume volume = make_volume({grid_over(glm::dvec3(-1.1), glm::dvec3(1.1), glm::ivec3(5))}, 1);
    const PlacementCounts counts = place_probes(volume, tracer, all_lit);
    EXPECT_EQ(counts.moved, 125U - 27U);
    for (std::size_t slot = 0; slot < volume.slots(); ++slot) {
        if (volume.states[slot] == ProbeState::absent) continue;
        const glm::dvec3 place = glm::abs(gather_position(volume, slot));
        EXPECT_LT(std::max({place.x, place.y, place.z}), 1) << "slot " << slot;
    }
    // Walls farther in than half a cell: most of what weighs at the border is outside.
    volume = make_volume({grid_over(glm::dvec3(-1.4), glm::dvec3(1.4), glm::ivec3(5))}, 1);
    EXPECT_EQ(place_probes(volume, tracer, all_lit).moved, 0U);
}

TEST(Placement, AProbeBehindAWallAsksForLightFourTimesAtMost) {
    Scene scene;
    // Solid: from within, all that is seen are back faces, and only light could say that it is a room.
    add_box(scene, add_grey(scene, 0.5F), glm::vec3(-1), glm::vec3(1), Facing::outward);
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over(glm::dvec3(-1.1), glm::dvec3(1.1), glm::ivec3(5))}, 1);
    std::atomic<int> looks = 0;
    const LightEvidence dark_inside = {[&](glm::vec3) {
                                           ++looks;
                                           return 0.0;
                                       },
                                       true};
    EXPECT_EQ(place_probes(volume, tracer, dark_inside).moved, 0U);
    const int inner = 27;
    const int border = 98;
    EXPECT_GT(looks, inner);
    EXPECT_LE(looks, inner + 4 * border);
}

TEST(Placement, ProbesOfAListAreMarkedButNeverMoved) {
    const Crate crate;
    const Tracer tracer(crate.scene);
    Volume volume = make_probe_list({{2, 1, 2}, {1, 1, 2}, {0, 1, 0}, {1.02, 1, 2}}, 1);
    place_probes(volume, tracer, dark_below_sky);
    EXPECT_EQ(volume.states[0], ProbeState::missing);
    EXPECT_EQ(volume.states[1], ProbeState::valid) << "on a face it sees half of the sky";
    EXPECT_EQ(volume.states[2], ProbeState::valid);
    EXPECT_EQ(volume.states[3], ProbeState::missing);
    EXPECT_TRUE(volume.offsets.empty());
    EXPECT_EQ(fill_invalid(volume, tracer), 0U) << "a list has no neighbours";
}

TEST(Placement, PositionsAreTheLevelsOwnAlsoFarFromItsOrigin) {
    Crate crate;
    crate.scene.origin = {1e5, -2e4, 3e6};  // what the loader subtracted
    const Tracer tracer(crate.scene);
    Grid grid = grid_over({-0.7, 0.4, -0.7}, {4.9, 3.2, 4.9}, {15, 8, 15});
    grid.origin += crate.scene.origin;
    Volume far = make_volume({grid}, 1);
    place_probes(far, tracer, dark_below_sky);
    const Crate near_crate;
    const Tracer near_tracer(near_crate.scene);
    Volume near = make_volume({grid_over({-0.7, 0.4, -0.7}, {4.9, 3.2, 4.9}, {15, 8, 15})}, 1);
    place_probes(near, near_tracer, dark_below_sky);
    EXPECT_EQ(far.states, near.states);
}

/// Two rooms, x < 0 lit and x > 0 dark, and blocks of stone on the wall between them.
struct TwoRooms {
    Scene scene;
    Volume volume;

    TwoRooms(float wall, bool turned) {
        const int stone = add_grey(scene, 0.5F);
        add_box(scene, stone, {-4, 0, -2}, {4, 4, 2}, Facing::inward);
        if (wall > 0) {
            add_box(scene, stone, {-wall / 2, -0.1F, -2.1F}, {wall / 2, 4.1F, 2.1F}, Facing::outward);
        } else {
            add_quad(scene, stone, {0, -0.1F, turned ? 2.1F : -2.1F}, {0, 4.2F, 0}, {0, 0, turned ? -4.2F : 4.2F});
        }
        add_box(scene, stone, {-2.2F, 0.5F, -1.5F}, {-0.1F, 3.5F, 1.5F}, Facing::outward);
        add_box(scene, stone, {0.1F, 0.5F, -1.5F}, {2.2F, 3.5F, 1.5F}, Facing::outward);
        volume = make_volume({grid_over({-3.75, 0.25, -1.75}, {3.75, 3.75, 1.75}, {16, 8, 8})}, 1);
    }
    [[nodiscard]] Volume filled() const {
        const Tracer tracer(scene);
        Volume result = volume;
        place_probes(result, tracer, {});  // by surroundings alone
        for_each_probe(result, [&](std::size_t slot) {
            const bool bright = lattice_position(result, slot).x < 0 && is_valid(result.states[slot]);
            result.coefficients[slot] = glm::vec3(bright ? 1 : 0);
            result.errors[slot] = glm::vec3(bright ? 0.25F : 0);
        });
        fill_invalid(result, tracer);
        return result;
    }
};

TEST(Placement, FillingDoesNotCrossAThinWall) {
    for (const float wall : {0.0F, 1e-3F, 0.1F}) {
        for (const bool turned : {false, true}) {
            const Volume volume = TwoRooms(wall, turned).filled();
            int filled = 0;
            for_each_probe(volume, [&](std::size_t slot) {
                EXPECT_NE(volume.states[slot], ProbeState::missing);
                if (volume.states[slot] != ProbeState::filled) return;
                ++filled;
                const glm::dvec3 place = lattice_position(volume, slot);
                EXPECT_EQ(volume.coefficients[slot].x, place.x < 0 ? 1 : 0)
                    << place.x << " " << place.y << " " << place.z;
                EXPECT_EQ(volume.errors[slot].x, place.x < 0 ? 0.25F : 0);
            });
            EXPECT_GT(filled, 50);
        }
    }
}

TEST(Placement, FillingGoesThroughWallsWhereNothingElseIsLeft) {
    // A stone in a shell of its own: two surfaces between it and any light.
    Scene scene;
    const int stone = add_grey(scene, 0.5F);
    add_box(scene, stone, glm::vec3(-1.4F), glm::vec3(1.4F), Facing::outward);
    add_box(scene, stone, glm::vec3(-1.45F), glm::vec3(1.45F), Facing::outward);
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over({-2, -2, -2}, {2, 2, 2}, {5, 5, 5})}, 2);
    place_probes(volume, tracer, dark_below_sky);
    EXPECT_EQ(volume.states[slot_of(volume, {2, 2, 2})], ProbeState::missing);
    for_each_probe(volume, [&](std::size_t slot) {
        for (int i = 0; i < 4; ++i)
            volume.coefficients[slot * 4 + i] = glm::vec3(is_valid(volume.states[slot]) ? i + 1 : 0);
    });
    EXPECT_EQ(fill_invalid(volume, tracer), 27U);
    for_each_probe(volume, [&](std::size_t slot) {
        for (int i = 0; i < 4; ++i) EXPECT_NEAR(volume.coefficients[slot * 4 + i].x, i + 1, 1e-5);
    });
}

TEST(Placement, WithoutAnyValidProbeNothingIsFilled) {
    Scene scene;
    add_box(scene, add_grey(scene, 0.5F), glm::vec3(-9), glm::vec3(9), Facing::outward);
    const Tracer tracer(scene);
    Volume volume = make_volume({grid_over({-1, -1, -1}, {1, 1, 1}, {3, 3, 3})}, 1);
    place_probes(volume, tracer, dark);
    EXPECT_EQ(fill_invalid(volume, tracer), 0U);
    for_each_probe(volume, [&](std::size_t slot) { EXPECT_EQ(volume.states[slot], ProbeState::missing); });
}

TEST(Placement, FlatCellsArePlacedLikeOthers) {
    // Aspect 100:1: clearance goes by the shortest side, reach by each.
    const Crate crate;
    const Tracer tracer(crate.scene);
    Volume volume = make_volume({grid_over({-6, 0.005, -6}, {6, 0.105, 6}, {13, 11, 13})}, 1);
    place_probes(volume, tracer, dark_below_sky);
    for_each_probe(volume, [&](std::size_t slot) {
        const glm::dvec3 place = lattice_position(volume, slot);
        const glm::dvec3 offset = glm::abs(gather_position(volume, slot) - place);
        EXPECT_LE(offset.y, 0.005 + 1e-6);
        EXPECT_LE(std::max(offset.x, offset.z), 0.5 + 1e-6);
        if (is_valid(volume.states[slot])) {
            EXPECT_LT(depth_in(crate.box, gather_position(volume, slot)), 0);
        }
    });
}

TEST(Placement, GridsSpanTheirBoxesWithTheSpacingAskedFor) {
    Scene scene;
    scene.bounds = box_of({-1, 0, -2}, {5, 3, 2.05});
    PlacementOptions options;
    options.spacing = 0.5;
    const GridChoice choice = choose_grids(scene, options);
    ASSERT_EQ(choice.grids.size(), 1U);
    const Grid& grid = choice.grids[0];
    EXPECT_EQ(grid.origin, scene.bounds.min);
    EXPECT_EQ(grid.counts, glm::ivec3(13, 7, 10));
    EXPECT_LT(glm::distance(grid.position(grid.counts - 1), scene.bounds.max), 1e-12);
    EXPECT_LE(std::max({grid.spacing.x, grid.spacing.y, grid.spacing.z}), 0.5 + 1e-9);
    EXPECT_EQ(choice.why, "0.5 m as asked, over the level's bounds");
}

Box within_walls(const Scene& scene, double reach, std::uint64_t* rays = nullptr) {
    std::uint64_t counted = 0;
    const Box within = within_outer_walls(Tracer(scene), reach, counted);
    if (rays != nullptr) *rays = counted;
    return within;
}

TEST(Placement, WhatIsBehindOuterWallsIsNotOfTheGrid) {
    Scene scene;
    const int wall = add_grey(scene, 0.5F);
    add_box(scene, wall, {-3, 0, -2}, {3, 2.5F, 2}, Facing::inward);
    add_box(scene, wall, {-1, 1, -2.2F}, {1, 1.1F, -1.9F}, Facing::outward);  // a sill that stands out
    ASSERT_FLOAT_EQ(static_cast<float>(scene.bounds.min.z), -2.2F);
    std::uint64_t rays = 0;
    const Box within = within_walls(scene, 0.4, &rays);
    EXPECT_GT(rays, 0U);
    EXPECT_GT(within.min.z, -2) << "inside the wall, which is thin";
    EXPECT_NEAR(within.min.z, -2, 0.01);
    EXPECT_EQ(within.max, scene.bounds.max) << "where the wall is at the bounds they stay as they are";
    EXPECT_EQ(within.min.x, scene.bounds.min.x);
    EXPECT_EQ(within.min.y, scene.bounds.min.y);
    EXPECT_EQ(within_walls(scene, 0.15).min, scene.bounds.min) << "the wall is further away than reaches";

    const GridChoice choice = choose_grids(scene, {}, within);
    EXPECT_EQ(choice.grids[0].origin.z, within.min.z);
    EXPECT_NE(choice.why.find("over the level's bounds but up to 0.21 m behind outer walls"), std::string::npos)
        << choice.why;
    PlacementOptions boxes;
    boxes.boxes = {scene.bounds};
    EXPECT_EQ(choose_grids(scene, boxes, within).grids[0].origin, scene.bounds.min) << "a box that was asked for";
}

TEST(Placement, SidesThatAreOpenOrUnevenStay) {
    Scene scene;
    const int ground = add_grey(scene, 0.5F);
    // Hills from 0 to 0.5 m below a tower, and a fence along a third of one side.
    for (int i = 0; i < 20; ++i) {
        const auto x = static_cast<float>(i - 10);
        add_quad(scene, ground, {x, 0.25F + 0.25F * std::sin(x), -10}, {1, 0.25F * (std::sin(x + 1) - std::sin(x)), 0},
                 {0, 0, 20});
    }
    add_box(scene, ground, {-1, 0, -1}, {1, 8, 1}, Facing::outward);
    add_quad(scene, ground, {-9.8F, 0, -10}, {0, 8, 0}, {0, 0, 6});
    const Box within = within_walls(scene, 0.6);
    EXPECT_EQ(within.min.x, scene.bounds.min.x);
    EXPECT_EQ(within.max, scene.bounds.max);
    EXPECT_LT(within.min.y, 0.05) << "hardly any of the ground is cut off";
}

/// y of the ground for a headroom of 2 m; NaN where there is none.
double open_ground(const Scene& scene) {
    std::uint64_t rays = 0;
    return top_of_open_ground(Tracer(scene), 2, rays).value_or(std::numeric_limits<double>::quiet_NaN());
}

TEST(Headroom, IsAboveTheHighestGroundUnderTheSky) {
    Scene scene;
    const int grey = add_grey(scene, 0.5F);
    add_quad(scene, grey, {-10, 0, 10}, {20, 0, 0}, {0, 0, -20});
    EXPECT_NEAR(open_ground(scene), 0, 1e-4);
    add_box(scene, grey, {3, 0, 3}, {3.1F, 7, 3.1F}, Facing::outward);     // a post
    add_box(scene, grey, {-10, 0, -10}, {10, 4, -9.7F}, Facing::outward);  // a wall
    EXPECT_NEAR(open_ground(scene), 0, 1e-4) << "nobody stands on walls and posts";
    add_box(scene, grey, {-6, 0, -6}, {-2, 3, -2}, Facing::outward);
    EXPECT_NEAR(open_ground(scene), 3, 1e-4) << "a solid block is ground";
    add_quad(scene, grey, {2, 6, -2}, {6, 0, 0}, {0, 0, -6});
    EXPECT_NEAR(open_ground(scene), 6, 1e-4) << "and so is a deck without walls below";
}

TEST(Headroom, RoofsOfRoomsAreNoGround) {
    Scene room;
    const int grey = add_grey(room, 0.5F);
    add_box(room, grey, {-3, 0, -3}, {3, 3, 3}, Facing::inward);
    EXPECT_TRUE(std::isnan(open_ground(room)));
    // Thick walls, a crate inside, and a window on one side.
    Scene house;
    add_grey(house, 0.5F);
    add_box(house, 0, {-3.3F, -0.3F, -3.3F}, {3.3F, 3.3F, 3.3F}, Facing::outward);
    add_box(house, 0, {-3, 0, -3}, {3, 3, 3}, Facing::inward);
    add_box(house, 0, {-1, 0, -1}, {0, 1, 0}, Facing::outward);
    EXPECT_TRUE(std::isnan(open_ground(house)));
    // A yard around it.
    add_quad(house, 0, {-10, 0, 10}, {20, 0, 0}, {0, 0, -20});
    EXPECT_NEAR(open_ground(house), 0, 1e-4);
    EXPECT_TRUE(std::isnan(open_ground(Scene{})));
}

TEST(Headroom, HillsAreGroundAndSoIsATerrainThatIsClosedBelow) {
    Scene scene;
    const int grey = add_grey(scene, 0.5F);
    for (int i = -10; i < 10; ++i) {
        const auto height = [](int x) { return 5 * std::cos(0.3F * static_cast<float>(x)); };
        add_quad(scene, grey, {i, height(i), 10}, {1, height(i + 1) - height(i), 0}, {0, 0, -20});
    }
    EXPECT_NEAR(open_ground(scene), 5, 0.2);
    add_box(scene, grey, {-10, -20, -10}, {10, -5.1F, 10}, Facing::outward);
    EXPECT_NEAR(open_ground(scene), 5, 0.2);
}

TEST(Placement, AWholeNumberOfSpacingsGetsNoCellMore) {
    Scene scene;
    PlacementOptions options;
    options.spacing = 0.1;
    for (const int cells : {1, 3, 7, 10, 49}) {
        options.boxes = {box_of(glm::dvec3(0), glm::dvec3(0.1 * cells, 0.1 * cells, 0.3))};
        EXPECT_EQ(choose_grids(scene, options).grids[0].counts, glm::ivec3(cells + 1, cells + 1, 4)) << cells;
    }
}

TEST(Placement, BoxesComeBeforeMarkersAndMarkersBeforeBounds) {
    Scene scene;
    scene.bounds = box_of(glm::dvec3(0), glm::dvec3(10));
    PlacementOptions options;
    options.spacing = 1;
    EXPECT_EQ(choose_grids(scene, options).grids[0].counts, glm::ivec3(11));
    scene.volume_markers = {box_of(glm::dvec3(1), glm::dvec3(3)), box_of(glm::dvec3(5), glm::dvec3(9))};
    ASSERT_EQ(choose_grids(scene, options).grids.size(), 2U);
    EXPECT_EQ(choose_grids(scene, options).grids[1].counts, glm::ivec3(5));
    EXPECT_EQ(choose_grids(scene, options).why, "1 m as asked, over the boxes marked in the level");
    options.boxes = {box_of(glm::dvec3(0), glm::dvec3(1))};
    ASSERT_EQ(choose_grids(scene, options).grids.size(), 1U);
    EXPECT_EQ(choose_grids(scene, options).grids[0].counts, glm::ivec3(2));
    EXPECT_TRUE(choose_grids(Scene{}, {}).grids.empty());
}

TEST(Placement, AutomaticSpacingMakesACountThatIsQuickAndWithinTheLimit) {
    for (const glm::dvec3 size : {glm::dvec3(1), glm::dvec3(1e-4), glm::dvec3(1e5), glm::dvec3(100, 3, 100),
                                  glm::dvec3(1000, 1, 1), glm::dvec3(10, 0, 10), glm::dvec3(10, 0, 0)}) {
        Scene scene;
        scene.bounds = box_of(-0.5 * size, 0.5 * size);
        for (const std::int64_t most : {65536, 1000, 64}) {
            PlacementOptions options;
            options.max_probes = most;
            const Grid grid = choose_grids(scene, options).grids[0];
            const std::int64_t count = std::int64_t{grid.counts.x} * grid.counts.y * grid.counts.z;
            EXPECT_LE(count, most);
            EXPECT_GE(count, 8);
            if (most == 65536 && std::min({size.x, size.y, size.z}) > 0) {
                EXPECT_GT(count, 1000);
                EXPECT_LT(count, 16000);
            }
        }
    }
}

TEST(Placement, AFlatBoxGetsProbesOnBothSides) {
    Scene scene;
    scene.bounds = box_of({-5, 0, -5}, {5, 0, 5});
    PlacementOptions options;
    options.spacing = 1;
    const Grid grid = choose_grids(scene, options).grids[0];
    EXPECT_EQ(grid.counts, glm::ivec3(11, 2, 11));
    EXPECT_EQ(grid.origin.y, -0.5);
    EXPECT_EQ(grid.spacing.y, 1);
}

TEST(Placement, MetresAreThoseOfTheLevelsUnits) {
    Scene metres;
    metres.bounds = box_of({-1, 0, -2}, {5, 3, 2.05});
    Scene centimetres;
    centimetres.metres_per_unit = 0.01;
    centimetres.bounds = box_of(100.0 * metres.bounds.min, 100.0 * metres.bounds.max);
    const auto expect_the_same = [&](const PlacementOptions& options, Box within = {}) {
        const GridChoice wanted = choose_grids(metres, options, within);
        if (!within.empty()) within = box_of(100.0 * within.min, 100.0 * within.max);
        const GridChoice choice = choose_grids(centimetres, options, within);
        EXPECT_EQ(choice.why, wanted.why);
        ASSERT_EQ(choice.grids.size(), 1U);
        EXPECT_EQ(choice.grids[0].counts, wanted.grids[0].counts);
        EXPECT_LT(glm::distance(choice.grids[0].origin, 100.0 * wanted.grids[0].origin), 1e-9);
        EXPECT_LT(glm::distance(choice.grids[0].spacing, 100.0 * wanted.grids[0].spacing), 1e-9);
    };
    PlacementOptions options;
    expect_the_same(options);
    expect_the_same(options, box_of({-0.75, 0, -2}, {5, 4.5, 2}));
    options.max_probes = 100;
    expect_the_same(options);
    options.spacing = 2;
    expect_the_same(options);
    options.spacing = 0.1;
    const auto refusal = [&](const Scene& scene) {
        try {
            static_cast<void>(choose_grids(scene, options));
        } catch (const Error& error) {
            return std::string(error.what());
        }
        return std::string();
    };
    EXPECT_NE(refusal(metres), "");
    EXPECT_EQ(refusal(centimetres), refusal(metres));

    metres.bounds = centimetres.bounds = box_of(glm::dvec3(3), glm::dvec3(3));
    options = {};
    EXPECT_EQ(choose_grids(metres, options).grids[0].spacing, glm::dvec3(1));
    EXPECT_EQ(choose_grids(centimetres, options).grids[0].spacing, glm::dvec3(100)) << "a metre about a point";
}

TEST(Placement, RefusesMoreProbesThanAllowedAndSaysWhatWouldDo) {
    Scene scene;
    scene.bounds = box_of(glm::dvec3(0), glm::dvec3(100, 1, 37));
    for (const double spacing : {1e-6, 0.01, 0.2}) {
        PlacementOptions options;
        options.spacing = spacing;
        options.max_probes = 5000;
        try {
            (void)choose_grids(scene, options);
            FAIL() << "accepted " << spacing;
        } catch (const Error& error) {
            EXPECT_EQ(error.where(), "--spacing");
            EXPECT_NE(error.problem().find("more than --max-probes 5000"), std::string::npos);
            options.spacing = std::stod(error.remedy().substr(error.remedy().find("--spacing ") + 10));
            const Grid grid = choose_grids(scene, options).grids[0];
            EXPECT_GT(grid.counts.x * grid.counts.y * grid.counts.z, 3500) << "the advice is not wasteful";
        }
    }
    PlacementOptions options;
    options.max_probes = 7;
    EXPECT_THROW((void)choose_grids(scene, options), Error);
}

}  // namespace
}  // namespace lightgrid
