#include "scenes/furniture.h"

#include <glm/gtc/constants.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include <array>
#include <cmath>
#include <vector>

namespace lightgrid::scenes {
namespace {

using Profile = std::vector<glm::vec2>;

// Cushions lie this far off what they lie on: from within a solid, another's front would look like free space.
constexpr float hair = 0.001F;

void add_pole(Shape& shape, int material, glm::vec3 foot, float radius, float height, int segments = 12) {
    Shape pole;
    add_lathe(pole, material, Profile{{0, 0}, {radius, 0}, {radius, height}, {0, height}}, segments);
    append(shape, pole, glm::translate(glm::mat4(1), foot));
}

void add_ball(Shape& shape, int material, glm::vec3 center, float radius, int segments = 24) {
    Profile profile;
    const int rings = segments / 2;
    for (int i = 0; i <= rings; ++i) {
        const float latitude = glm::pi<float>() * (static_cast<float>(i) / static_cast<float>(rings) - 0.5F);
        const bool pole = i == 0 || i == rings;
        profile.emplace_back(pole ? 0 : radius * std::cos(latitude), radius * std::sin(latitude));
    }
    Shape ball;
    add_lathe(ball, material, profile, segments);
    append(shape, ball, glm::translate(glm::mat4(1), center));
}

/// Tapered legs at the corners of a rectangle, inset.
void add_legs(Shape& shape, int material, glm::vec2 half, float height, float radius) {
    for (const glm::vec2 corner : {glm::vec2(-1, -1), glm::vec2(1, -1), glm::vec2(-1, 1), glm::vec2(1, 1)}) {
        Shape leg;
        add_lathe(leg, material, Profile{{0, 0}, {0.6F * radius, 0}, {radius, height}, {0, height}}, 10);
        append(shape, leg, glm::translate(glm::mat4(1), glm::vec3(corner.x * half.x, 0, corner.y * half.y)));
    }
}

}  // namespace

Shape chair(int wood, int cushion) {
    Shape shape;
    add_legs(shape, wood, {0.18F, 0.18F}, 0.43F, 0.02F);
    add_rounded_box(shape, wood, {-0.22F, 0.42F, -0.22F}, {0.22F, 0.455F, 0.22F}, 0.015F);
    add_rounded_box(shape, cushion, {-0.2F, 0.45F, -0.19F}, {0.2F, 0.49F, 0.21F}, 0.019F);
    for (const float x : {-0.185F, 0.185F})
        add_box(shape, wood, {x - 0.017F, 0.44F, -0.215F}, {x + 0.017F, 0.86F, -0.185F});
    add_rounded_box(shape, wood, {-0.215F, 0.72F, -0.222F}, {0.215F, 0.89F, -0.178F}, 0.02F);
    add_rounded_box(shape, wood, {-0.19F, 0.57F, -0.212F}, {0.19F, 0.62F, -0.188F}, 0.01F);
    return shape;
}

Shape sofa(int fabric, int cushion, int wood, float width) {
    constexpr float arm = 0.21F;
    const float half = 0.5F * width;
    const float inner = half - arm - hair;
    Shape shape;
    add_legs(shape, wood, {half - 0.1F, 0.36F}, 0.12F, 0.025F);
    add_rounded_box(shape, fabric, {-inner, 0.12F, -0.25F}, {inner, 0.34F, 0.46F}, 0.03F);
    add_rounded_box(shape, fabric, {-inner, 0.12F, -0.47F}, {inner, 0.82F, -0.25F - hair}, 0.08F);
    for (const float side : {-1.0F, 1.0F}) {
        const float middle = side * (half - 0.5F * arm);
        add_rounded_box(shape, fabric, {middle - 0.5F * arm, 0.12F, -0.47F}, {middle + 0.5F * arm, 0.6F, 0.47F},
                        0.075F);
    }
    const int seats = std::max(1, static_cast<int>(std::round((width - 0.4F) / 0.75F)));
    const float seat = 2 * inner / static_cast<float>(seats);
    for (int i = 0; i < seats; ++i) {
        const float left = -inner + seat * static_cast<float>(i);
        add_rounded_box(shape, fabric, {left, 0.34F + hair, -0.25F}, {left + seat - hair, 0.47F, 0.48F}, 0.06F);
        Shape back;
        add_rounded_box(back, fabric, {0.01F, 0, -0.08F}, {seat - 0.01F, 0.46F, 0.09F}, 0.075F);
        const glm::mat4 lean = glm::rotate(glm::translate(glm::mat4(1), {left, 0.48F, -0.08F}), -0.16F, {1, 0, 0});
        append(shape, back, lean);
    }
    for (const float side : {-1.0F, 1.0F}) {
        Shape loose;
        add_rounded_box(loose, cushion, {-0.2F, -0.2F, -0.07F}, {0.2F, 0.2F, 0.07F}, 0.069F);
        glm::mat4 place = glm::translate(glm::mat4(1), {side * (inner - 0.22F), 0.685F, 0.11F});
        place = glm::rotate(place, -side * 0.3F, {0, 1, 0});
        place = glm::rotate(place, -0.25F, {1, 0, 0});
        append(shape, loose, glm::rotate(place, side * 0.12F, {0, 0, 1}));
    }
    return shape;
}

Shape armchair(int fabric, int cushion, int wood) {
    Shape shape;
    add_legs(shape, wood, {0.32F, 0.3F}, 0.16F, 0.022F);
    add_rounded_box(shape, fabric, {-0.27F, 0.16F, -0.26F}, {0.27F, 0.34F, 0.4F}, 0.04F);
    add_rounded_box(shape, cushion, {-0.268F, 0.34F + hair, -0.25F}, {0.268F, 0.46F, 0.42F}, 0.055F);
    for (const float side : {-1.0F, 1.0F}) {
        const float middle = side * (0.34F + hair);
        add_rounded_box(shape, fabric, {middle - 0.07F, 0.16F, -0.26F}, {middle + 0.07F, 0.58F, 0.39F}, 0.065F);
    }
    Shape back;
    add_rounded_box(back, fabric, {-0.41F, 0, -0.09F}, {0.41F, 0.72F, 0.09F}, 0.085F);
    append(shape, back, glm::rotate(glm::translate(glm::mat4(1), {0, 0.22F, -0.35F}), -0.22F, {1, 0, 0}));
    return shape;
}

Shape table(int top, int legs, glm::vec3 size) {
    Shape shape;
    add_rounded_box(shape, top, {-0.5F * size.x, size.y - 0.04F, -0.5F * size.z},
                    {0.5F * size.x, size.y, 0.5F * size.z}, 0.012F);
    add_legs(shape, legs, {0.5F * size.x - 0.09F, 0.5F * size.z - 0.09F}, size.y - 0.02F, 0.035F);
    return shape;
}

Shape round_table(int top, int legs, float radius, float height) {
    Shape shape;
    add_lathe(shape, top,
              Profile{{0, height - 0.035F},
                      {radius - 0.02F, height - 0.035F},
                      {radius, height - 0.018F},
                      {radius - 0.006F, height},
                      {0, height}},
              40);
    for (int i = 0; i < 3; ++i) {
        const float angle = 0.5F + glm::two_pi<float>() * static_cast<float>(i) / 3;
        Shape leg;
        add_lathe(leg, legs, Profile{{0, 0}, {0.014F, 0}, {0.024F, height - 0.02F}, {0, height - 0.02F}}, 10);
        const glm::vec3 foot{0.78F * radius * std::cos(angle), 0, 0.78F * radius * std::sin(angle)};
        append(shape, leg, glm::translate(glm::mat4(1), foot));
    }
    return shape;
}

Shape shelf(int wood, glm::vec3 size, int boards) {
    constexpr float thick = 0.025F;
    // One body: a block with its compartments carved out.
    Blocks body({wood, wood, wood});
    const float half = 0.5F * size.x;
    body.fill({-half, 0, 0}, {half, size.y, size.z});
    const float pitch = (size.y - thick) / static_cast<float>(boards);
    for (int board = 0; board < boards; ++board) {
        const float base = thick + pitch * static_cast<float>(board);
        body.carve({-half + thick, base, thick}, {half - thick, base + pitch - thick, size.z}, {wood, wood, wood});
    }
    Shape shape;
    body.add_to(shape);
    return shape;
}

Shape book(int cover, int paper) {
    Shape shape;
    add_box(shape, cover, {-0.5F, 0, -0.5F}, {0.5F, 1, 0.5F});
    add_box(shape, paper, {-0.4F, 0.03F, -0.51F}, {0.4F, 0.97F, -0.45F});
    return shape;
}

Shape plant(int pot, int soil, int leaf, int leaves, float height) {
    Shape shape;
    const float r = 0.17F;
    add_lathe(shape, pot,
              Profile{{0, 0},
                      {0.78F * r, 0},
                      {r, 0.3F},
                      {1.06F * r, 0.31F},
                      {1.06F * r, 0.34F},
                      {0.96F * r, 0.34F},
                      {0.9F * r, 0.27F},
                      {0, 0.27F}},
              28);
    add_lathe(shape, soil, Profile{{0, 0.265F}, {0.93F * r, 0.265F}, {0.93F * r, 0.295F}, {0, 0.305F}}, 20);
    constexpr float golden_angle = 2.39996323F;
    for (int i = 0; i < leaves; ++i) {
        const float share = (static_cast<float>(i) + 0.5F) / static_cast<float>(leaves);
        const float angle = golden_angle * static_cast<float>(i);
        const glm::vec3 out{std::cos(angle), 0, std::sin(angle)};
        const float rise = height * (0.45F + 0.55F * (1 - share));  // the young ones in the middle stand upright
        const float reach = height * (0.12F + 0.32F * share);
        const float width = height * (0.055F + 0.02F * std::sin(3 * angle));
        constexpr int parts = 7;
        std::vector<glm::vec3> spine;
        for (int k = 0; k <= parts; ++k) {
            const float t = static_cast<float>(k) / parts;
            const float droop = rise * (1.5F * t - (0.5F + 0.45F * share) * t * t * t);
            spine.push_back(0.03F * out + out * (reach * t * t * 0.9F + 0.1F * reach * t) +
                            glm::vec3(0, 0.29F + droop, 0));
        }
        add_strip(shape, leaf, spine, width * glm::normalize(glm::vec3(-out.z, 0.15F, out.x)));
    }
    return shape;
}

Shape floor_lamp(int metal, int shade, float height) {
    Shape shape;
    add_lathe(shape, metal,
              Profile{{0, 0},
                      {0.15F, 0},
                      {0.15F, 0.015F},
                      {0.02F, 0.03F},
                      {0.011F, 0.05F},
                      {0.011F, height - 0.3F},
                      {0, height - 0.3F}},
              24);
    // Paper all round, closed above and below: nothing looks into it.
    add_lathe(shape, shade, Profile{{0, height - 0.32F}, {0.2F, height - 0.32F}, {0.15F, height}, {0, height}}, 36);
    return shape;
}

Shape pendant(int metal, int bulb, float cord, float radius) {
    Shape shape;
    add_pole(shape, metal, {0, -cord, 0}, 0.006F, cord, 8);
    add_lathe(shape, metal, Profile{{0, -0.03F}, {0.05F, -0.03F}, {0.05F, 0}, {0, 0}}, 16);
    add_lathe(shape, metal,
              Profile{{0, -cord - 0.03F}, {0.04F, -cord - 0.03F}, {0.03F, -cord + 0.03F}, {0, -cord + 0.03F}}, 16);
    add_ball(shape, bulb, {0, -cord - radius - 0.015F, 0}, radius);
    return shape;
}

Shape desk_lamp(int metal, int bulb) {
    Shape shape;
    add_lathe(shape, metal, Profile{{0, 0}, {0.08F, 0}, {0.08F, 0.012F}, {0.012F, 0.02F}, {0.01F, 0.36F}, {0, 0.36F}},
              20);
    Shape head;
    add_lathe(head, metal,
              Profile{{0, 0.024F}, {0.026F, 0.024F}, {0.096F, -0.09F}, {0.1F, -0.09F}, {0.03F, 0.03F}, {0, 0.03F}}, 24);
    add_ball(head, bulb, {0, -0.02F, 0}, 0.028F, 14);
    Shape arm;
    add_lathe(arm, metal, Profile{{0, 0}, {0.008F, 0}, {0.008F, 0.24F}, {0, 0.24F}}, 10);
    append(shape, arm, glm::rotate(glm::translate(glm::mat4(1), {0, 0.35F, 0}), -1.2F, {0, 0, 1}));
    append(shape, head, glm::rotate(glm::translate(glm::mat4(1), {0.23F, 0.42F, 0}), 0.25F, {0, 0, 1}));
    return shape;
}

Shape picture_frame(int frame, int picture, glm::vec2 size) {
    constexpr float border = 0.04F;
    constexpr float deep = 0.035F;
    const glm::vec2 half = 0.5F * size;
    Blocks body({frame, frame, frame});
    body.fill({-half.x - border, -half.y - border, 0}, {half.x + border, half.y + border, deep});
    body.carve({-half.x, -half.y, 0.5F * deep}, {half.x, half.y, deep}, {frame, frame, frame});
    Shape shape;
    body.add_to(shape);
    add_quad(shape, picture, {-half.x, -half.y, 0.6F * deep}, {size.x, 0, 0}, {0, size.y, 0});
    return shape;
}

Shape vase(int glaze, float height) {
    Profile profile{{0, 0}};
    constexpr int steps = 12;
    const auto radius = [](float t) {
        return 0.12F + 0.2F * std::sin(glm::pi<float>() * std::pow(t, 0.8F)) - 0.05F * t;
    };
    for (int i = 0; i <= steps; ++i) {
        const float t = static_cast<float>(i) / steps;
        profile.push_back(height * glm::vec2(radius(t), t));
    }
    const float neck = height * radius(1) - 0.012F;
    profile.insert(profile.end(), {{neck, height}, {neck, 0.6F * height}, {0, 0.6F * height}});
    Shape shape;
    add_lathe(shape, glaze, profile, 24);
    return shape;
}

Shape bowl(int glaze, int fruit, float radius) {
    Profile profile{{0, 0}, {0.4F * radius, 0}};
    constexpr int steps = 8;
    for (int i = 0; i <= steps; ++i) {
        const float t = static_cast<float>(i) / steps;
        profile.push_back(radius *
                          glm::vec2(0.42F + 0.58F * std::sin(glm::half_pi<float>() * t), 0.04F + 0.46F * t * t));
    }
    for (int i = steps; i >= 0; --i) {
        const float t = static_cast<float>(i) / steps;
        profile.push_back(radius *
                          glm::vec2(0.36F + 0.58F * std::sin(glm::half_pi<float>() * t), 0.09F + 0.41F * t * t));
    }
    profile.emplace_back(0, 0.09F * radius);
    Shape shape;
    add_lathe(shape, glaze, profile, 32);
    for (int i = 0; i < 5; ++i) {
        const float angle = 1.2566F * static_cast<float>(i);
        add_ball(shape, fruit, {0.5F * radius * std::cos(angle), 0.42F * radius, 0.5F * radius * std::sin(angle)},
                 0.28F * radius, 14);
    }
    add_ball(shape, fruit, {0, 0.68F * radius, 0}, 0.28F * radius, 14);
    return shape;
}

Shape plate(int china) {
    Shape shape;
    add_lathe(shape, china, Profile{{0, 0}, {0.07F, 0}, {0.13F, 0.014F}, {0.13F, 0.019F}, {0.07F, 0.006F}, {0, 0.006F}},
              28);
    return shape;
}

Shape column(int stone, float radius, float height) {
    Shape shape;
    add_lathe(shape, stone,
              Profile{{0, 0},
                      {1.45F * radius, 0},
                      {1.45F * radius, 0.1F},
                      {1.2F * radius, 0.14F},
                      {1.05F * radius, 0.18F},
                      {radius, 0.25F},
                      {0.92F * radius, height - 0.25F},
                      {1.0F * radius, height - 0.18F},
                      {1.25F * radius, height - 0.12F},
                      {1.4F * radius, height - 0.08F},
                      {1.4F * radius, height},
                      {0, height}},
              32);
    return shape;
}

Shape window_frame(int frame, int glass, glm::vec2 size, glm::ivec2 panes) {
    constexpr float bar = 0.05F;
    constexpr float deep = 0.03F;  // to either side of the glass
    const glm::vec2 pane = (size - bar * glm::vec2(panes + 1)) / glm::vec2(panes);
    Blocks body({frame, frame, frame});
    body.fill({0, 0, -deep}, {size.x, size.y, deep});
    Shape shape;
    for (int row = 0; row < panes.y; ++row) {
        for (int column = 0; column < panes.x; ++column) {
            const glm::vec2 low = bar + (pane + bar) * glm::vec2(column, row);
            body.carve({low.x, low.y, -deep}, {low.x + pane.x, low.y + pane.y, deep}, {frame, frame, frame});
            add_quad(shape, glass, {low.x, low.y, 0}, {pane.x, 0, 0}, {0, pane.y, 0});
        }
    }
    body.add_to(shape);
    return shape;
}

Shape curtain(int cloth, float width, float height) {
    constexpr int parts_per_fold = 8;
    constexpr float fold = 0.12F;
    const int parts = parts_per_fold * static_cast<int>(std::round(width / fold));
    std::vector<glm::vec3> spine;
    for (int i = 0; i <= parts; ++i) {
        const float t = static_cast<float>(i) / static_cast<float>(parts);
        const float phase = glm::two_pi<float>() * static_cast<float>(i) / parts_per_fold;
        spine.emplace_back(width * t, 0.5F * height, 0.035F * std::sin(phase));
    }
    Shape shape;
    add_strip(shape, cloth, spine, {0, -0.5F * height, 0});
    return shape;
}

}  // namespace lightgrid::scenes
