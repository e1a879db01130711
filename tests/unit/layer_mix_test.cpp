#include "viewer/layer_mix.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace lightgrid {
namespace {

/// One band of a kind for each layer.
Volume layered() {
    Volume volume = make_volume({{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}}}, 3);
    std::vector<std::string> names{"lamps"};
    for (int i = 0; i < 9; ++i) names.push_back(sky_layer(i));
    names.emplace_back("other");
    for (std::size_t k = 0; k < names.size(); ++k) {
        Layer layer{names[k], volume.coefficients, 0};
        for (std::size_t i = 0; i < layer.coefficients.size(); ++i) {
            // A sky comes as it is.
            layer.coefficients[i] =
                k == 0 || k == 10 ? glm::vec3(static_cast<float>(k + i % 9)) : glm::vec3(i % 9 == k - 1 ? 1.0F : 0.0F);
        }
        volume.layers.push_back(layer);
    }
    volume.errors.assign(volume.errors.size(), glm::vec3(0.25F));
    volume.axis_errors.assign(volume.axis_errors.size(), glm::vec3(0.5F));
    volume.offsets.assign(volume.slots(), glm::vec3(0.125F));
    volume.settings = {{"level", "room.glb"}};
    return volume;
}

TEST(LayerMix, HasAKnobForEachLayerAndOneForTheSky) {
    const LayerMix lit = mix_of(layered(), true);
    ASSERT_EQ(lit.knobs.size(), 3U);
    EXPECT_EQ(lit.knobs[0].name, "lamps");
    EXPECT_EQ(lit.knobs[1].name, "other");
    EXPECT_EQ(lit.knobs[2].name, sky_knob);
    EXPECT_EQ(lit.knobs[2].weight, 1);
    EXPECT_EQ(lit.sky, SkyShown::given);
    const LayerMix dark = mix_of(layered(), false);
    EXPECT_EQ(dark.knobs[2].weight, 0);
    EXPECT_EQ(dark.sky, SkyShown::uniform);
    EXPECT_TRUE(mix_of(make_volume({{{0, 0, 0}, {1, 1, 1}, {4, 4, 4}}}, 3), true).knobs.empty());
}

TEST(LayerMix, MixesByWeightAndColour) {
    const Volume volume = layered();
    LayerMix mix = mix_of(volume, true);
    mix.knobs[0].weight = 2;
    mix.knobs[0].color = {1, 0.5F, 0};
    mix.knobs[1].weight = 0;
    mix.knobs[2].weight = 3;
    Sh36 sky{};
    sky[0] = {1, 2, 3};
    sky[3] = {0, 1, 0};
    const Volume mixed = mixed_volume(volume, weights_of(mix, volume, sky));
    check_volume(mixed);
    EXPECT_TRUE(mixed.layers.empty());
    EXPECT_EQ(mixed.errors, volume.errors);
    EXPECT_EQ(mixed.axis_errors, volume.axis_errors);
    EXPECT_EQ(mixed.offsets, volume.offsets);
    EXPECT_EQ(mixed.states, volume.states);
    EXPECT_EQ(mixed.settings, volume.settings);
    for (std::size_t i = 0; i < 9; ++i) {
        EXPECT_EQ(mixed.sh(1)[i], static_cast<float>(i) * glm::vec3(2, 1, 0) + 3.0F * sky[i]) << i;
    }
}

TEST(LayerMix, WhatASurfaceEmitsFollowsItsLayer) {
    LayerMix mix = mix_of(layered(), true);
    mix.knobs[0].weight = 2;
    mix.knobs[0].color = {1, 0.5F, 0};
    mix.knobs[1].weight = 0.25F;
    EXPECT_EQ(emission_weight(mix, "lamps"), glm::vec3(2, 1, 0));
    EXPECT_EQ(emission_weight(mix, ""), glm::vec3(0.25F)) << "of no group";
    EXPECT_EQ(emission_weight(mix, "signs"), glm::vec3(0.25F)) << "of a group that has no layer";
    EXPECT_EQ(emission_weight({}, "lamps"), glm::vec3(1)) << "a volume without layers";
}

TEST(LayerMix, TurnsTheSkyAboutTheVertical) {
    const Volume volume = layered();
    LayerMix mix = mix_of(volume, true);
    mix.knobs[0].weight = mix.knobs[1].weight = 0;
    Sh36 sky{};
    sky[3] = glm::vec3(1);  // towards +X
    mix.sky_turned_deg = 90;
    const Volume mixed = mixed_volume(volume, weights_of(mix, volume, sky));
    EXPECT_NEAR(mixed.sh(0)[3].g, 0, 1e-6);
    EXPECT_NEAR(mixed.sh(0)[2].g, -1, 1e-6);  // towards -Z
}

}  // namespace
}  // namespace lightgrid
