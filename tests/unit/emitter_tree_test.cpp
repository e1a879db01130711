#include "probes/emitter_tree.h"

#include "core/sampling.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace lightgrid {
namespace {

EmitterTree::Emitter small_emitter(glm::dvec3 place, glm::dvec3 normal, double power = 1) {
    return {place - 0.01, place + 0.01, glm::normalize(normal), false, power};
}

glm::vec3 random_place(RandomStream& random, float size) {
    const glm::vec2 xy = random.next2();
    return size * (glm::vec3(xy, random.next()) - 0.5F);
}

/// In a room of 10 m, of powers over three decades, facing anywhere; every tenth from both sides.
std::vector<EmitterTree::Emitter> many_emitters(std::size_t count) {
    RandomStream random(5);
    std::vector<EmitterTree::Emitter> emitters;
    for (std::size_t i = 0; i < count; ++i) {
        const glm::vec3 place = random_place(random, 10);
        const glm::vec3 normal = sphere_direction(random.next2());
        emitters.push_back(small_emitter(place, normal, std::pow(10.0, 3.0 * random.next())));
        emitters.back().both_sides = i % 10 == 0;
    }
    return emitters;
}

double sum_of_probabilities(const EmitterTree& tree, const Receiver& receiver, std::size_t count) {
    double sum = 0;
    for (std::uint32_t i = 0; i < count; ++i) sum += tree.probability(receiver, i);
    return sum;
}

/// What an emitter brings to a receiver that sees it, but for a constant.
double brought(const EmitterTree::Emitter& emitter, const Receiver& receiver) {
    const glm::dvec3 way = 0.5 * (emitter.min + emitter.max) - glm::dvec3(receiver.position);
    const double distance = glm::length(way);
    double emitted = -glm::dot(emitter.normal, way) / distance;
    if (emitter.both_sides) emitted = std::abs(emitted);
    const bool everywhere = receiver.normal == glm::vec3(0);
    const double received = everywhere ? 1 : glm::dot(glm::dvec3(receiver.normal), way) / distance;
    return emitter.power * std::max(emitted, 0.0) * std::max(received, 0.0) / (distance * distance);
}

std::vector<Receiver> some_receivers() {
    RandomStream random(6);
    std::vector<Receiver> receivers;
    for (int i = 0; i < 20; ++i) {
        const glm::vec3 place = random_place(random, 12);
        receivers.push_back({place, i % 2 == 0 ? glm::vec3(0) : sphere_direction(random.next2())});
    }
    return receivers;
}

/// Calls `check` with all receivers, as they are and with the tree opened for few draws and for many.
template <class Check>
void check_receivers(const EmitterTree& tree, Check&& check) {
    for (Receiver receiver : some_receivers()) {
        check(receiver);
        for (const std::uint32_t draws : {1U, 1024U}) {
            const EmitterCut cut = tree.open(receiver, draws);
            receiver.cut = &cut;
            check(receiver);
        }
    }
}

/// Second moment of one draw's estimate of what all bring, relative to the square of that; 0 where nothing does.
double relative_moment(const EmitterTree& tree, const std::vector<EmitterTree::Emitter>& emitters,
                       const Receiver& receiver) {
    double sum = 0;
    double moment = 0;
    for (std::uint32_t i = 0; i < emitters.size(); ++i) {
        const double value = brought(emitters[i], receiver);
        if (!(value > 0)) continue;
        sum += value;
        moment += value * value / tree.probability(receiver, i);
    }
    return sum > 0 ? moment / (sum * sum) : 0;
}

TEST(EmitterTree, ProbabilitiesAddUpToOne) {
    for (const std::size_t count : {1, 2, 3, 10, 1000}) {
        const EmitterTree tree(many_emitters(count));
        check_receivers(tree, [&](const Receiver& receiver) {
            const double sum = sum_of_probabilities(tree, receiver, count);
            // Nothing is drawn where a draw has gone down to two that cannot bring anything.
            EXPECT_LE(sum, 1 + 1e-5) << count;
            double lost = 0;
            constexpr int draws = 4096;
            for (int i = 0; i < draws; ++i) lost += tree.draw(receiver, (i + 0.5) / draws).probability > 0 ? 0 : 1;
            EXPECT_NEAR(sum, 1 - lost / draws, 2e-2) << count;
        });
    }
}

TEST(EmitterTree, DrawsAsOftenAsItSaysAndSaysTheSameAgain) {
    const std::vector<EmitterTree::Emitter> emitters = many_emitters(40);
    const EmitterTree tree(emitters);
    constexpr int draws = 1 << 16;
    check_receivers(tree, [&](const Receiver& receiver) {
        std::vector<double> counts(emitters.size());
        for (int i = 0; i < draws; ++i) {
            const EmitterTree::Draw draw = tree.draw(receiver, (i + 0.5) / draws);
            if (!(draw.probability > 0)) continue;
            EXPECT_EQ(draw.probability, tree.probability(receiver, draw.emitter));
            ++counts[draw.emitter];
        }
        // Evenly spaced numbers: an emitter's share of [0, 1) is one interval.
        for (std::uint32_t i = 0; i < emitters.size(); ++i)
            EXPECT_NEAR(counts[i], draws * double(tree.probability(receiver, i)), 1.01) << i;
    });
}

TEST(EmitterTree, NothingThatBringsLightIsLeftOut) {
    const std::vector<EmitterTree::Emitter> emitters = many_emitters(1000);
    const EmitterTree tree(emitters);
    int bringing = 0;
    check_receivers(tree, [&](const Receiver& receiver) {
        for (std::uint32_t i = 0; i < emitters.size(); ++i) {
            if (!(brought(emitters[i], receiver) > 0)) continue;
            ++bringing;
            EXPECT_GT(tree.probability(receiver, i), 0) << i;
        }
    });
    EXPECT_GT(bringing, 1000);
}

TEST(EmitterTree, FollowsWhatEmittersBringBetterThanPowerDoes) {
    const std::vector<EmitterTree::Emitter> emitters = many_emitters(1000);
    const EmitterTree tree(emitters);
    double all_power = 0;
    for (const EmitterTree::Emitter& emitter : emitters) all_power += emitter.power;
    double by_tree = 0;
    double by_power = 0;
    for (const Receiver& receiver : some_receivers()) {
        double sum = 0;
        double moment = 0;
        for (const EmitterTree::Emitter& emitter : emitters) {
            const double value = brought(emitter, receiver);
            sum += value;
            moment += value * value / (emitter.power / all_power);
        }
        if (sum == 0) continue;  // it looks away from all
        const double tree_moment = relative_moment(tree, emitters, receiver);
        EXPECT_LT(tree_moment, moment / (sum * sum));
        by_tree += tree_moment;
        by_power += moment / (sum * sum);
    }
    EXPECT_LT(by_tree, 0.3 * by_power);  // normals anywhere are the hardest case
}

TEST(EmitterTree, OpenedItFollowsWhatEmittersBringMoreClosely) {
    // A ceiling of lamps that face down, seen from near below: bounds of what is close tell least.
    RandomStream random(8);
    std::vector<EmitterTree::Emitter> lamps;
    for (int i = 0; i < 10000; ++i) {
        const glm::vec2 place = 10.0F * random.next2();
        lamps.push_back(small_emitter({place.x, 3, place.y}, {0, -1, 0}));
    }
    const EmitterTree tree(lamps);
    for (const float below : {0.3F, 1.0F, 2.5F}) {
        Receiver receiver{{5, 3 - below, 4}, {}};
        const double as_it_is = relative_moment(tree, lamps, receiver) - 1;
        const EmitterCut few = tree.open(receiver, 16);
        receiver.cut = &few;
        const double with_few = relative_moment(tree, lamps, receiver) - 1;
        const EmitterCut many = tree.open(receiver, 1024);
        receiver.cut = &many;
        const double with_many = relative_moment(tree, lamps, receiver) - 1;
        EXPECT_LT(with_few, 0.9 * as_it_is) << below;
        EXPECT_LT(with_many, 0.3 * as_it_is) << below;
    }
}

TEST(EmitterTree, TheNearOneOfTwoIsDrawnByInverseSquares) {
    const std::vector<EmitterTree::Emitter> emitters = {small_emitter({10, 0, 0}, {-1, 0, 0}),
                                                        small_emitter({0, 1, 0}, {0, -1, 0})};
    const EmitterTree tree(emitters);
    const Receiver receiver{glm::vec3(0), {}};
    EXPECT_NEAR(tree.probability(receiver, 0), 1 / 101.0, 1e-6);
    EXPECT_NEAR(tree.probability(receiver, 1), 100 / 101.0, 1e-6);
}

TEST(EmitterTree, BehindAnEmitterAndBelowASurfaceNothingIsDrawn) {
    const std::vector<EmitterTree::Emitter> emitters = {small_emitter({0, 2, 0}, {0, 1, 0}),
                                                        small_emitter({3, 2, 0}, {0, 1, 0}),
                                                        small_emitter({5, -1, 0}, {-1, 0, 0})};
    const EmitterTree tree(emitters);
    const Receiver probe{glm::vec3(0), {}};
    EXPECT_EQ(tree.probability(probe, 0), 0);
    EXPECT_EQ(tree.probability(probe, 1), 0);
    EXPECT_EQ(tree.probability(probe, 2), 1);
    const Receiver floor{glm::vec3(0), {0, 1, 0}};
    EXPECT_EQ(tree.draw(floor, 0.5).probability, 0);
}

TEST(EmitterTree, PowerDecidesInOnePlace) {
    // More than a leaf holds, all in one place, their powers 1 to 1000.
    std::vector<EmitterTree::Emitter> emitters;
    double sum = 0;
    for (int i = 1; i <= 1000; ++i) {
        emitters.push_back(small_emitter({1, 2, 3}, {0, 1, 0}, i));
        sum += i;
    }
    const EmitterTree tree(emitters);
    const Receiver receiver{{1, 9, 3}, {}};
    for (std::uint32_t i = 0; i < 1000; ++i)
        EXPECT_NEAR(tree.probability(receiver, i), (i + 1) / sum, 1e-6 * (i + 1) / sum) << i;
}

TEST(EmitterTree, PlacesThatDoubleMakeNoTreeTooDeep) {
    // Every split puts the farthest apart: without a limit as many levels as emitters.
    std::vector<EmitterTree::Emitter> emitters;
    for (int i = 0; i < 900; ++i) {
        const double far = std::pow(1.02, i) * (i % 2 == 0 ? 1 : -1);
        emitters.push_back(small_emitter({far, 0, 0}, {0, 0, 1}, 1 + far * far));
        emitters.back().both_sides = true;
    }
    const EmitterTree tree(emitters);
    for (const float height : {1.0F, -1.0F}) {
        const Receiver receiver{{0, 0, height}, {}};
        EXPECT_NEAR(sum_of_probabilities(tree, receiver, emitters.size()), 1, 1e-4);
        for (int i = 0; i < 100; ++i) {
            const EmitterTree::Draw draw = tree.draw(receiver, (i + 0.5) / 100);
            EXPECT_GT(draw.probability, 0);
            EXPECT_EQ(draw.probability, tree.probability(receiver, draw.emitter));
        }
    }
}

TEST(EmitterTree, WithoutPowerThereIsNoTree) {
    EXPECT_TRUE(EmitterTree().empty());
    std::vector<EmitterTree::Emitter> emitters = {small_emitter({0, 0, 0}, {0, 1, 0}, 0)};
    EXPECT_TRUE(EmitterTree(emitters).empty());
    emitters.push_back(small_emitter({1, 0, 0}, {0, 1, 0}, 2));
    const EmitterTree tree(emitters);
    const Receiver receiver{{0, 1, 0}, {}};
    EXPECT_EQ(tree.probability(receiver, 0), 0);
    EXPECT_EQ(tree.draw(receiver, 0).emitter, 1U);
    EXPECT_EQ(tree.draw(receiver, 0.999999).emitter, 1U);
}

TEST(EmitterTree, WhatHasNoPowerHasNoProbability) {
    std::vector<EmitterTree::Emitter> emitters = many_emitters(100);
    emitters[7].power = 0;
    const EmitterTree tree(emitters);
    check_receivers(tree, [&](const Receiver& receiver) { EXPECT_EQ(tree.probability(receiver, 7), 0); });
}

}  // namespace
}  // namespace lightgrid
