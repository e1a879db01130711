#include "probes/emitter_tree.h"

#include <glm/gtc/constants.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace lightgrid {
namespace {

/// Angles between 0 and pi by cosine and sine.
struct Angle {
    float cosine;
    float sine;
};

/// max(0, a - b).
Angle minus(Angle a, Angle b) {
    if (a.cosine > b.cosine) return {1, 0};
    return {a.cosine * b.cosine + a.sine * b.sine, a.sine * b.cosine - a.cosine * b.sine};
}

float sine_of(float cosine) {
    return std::sqrt(std::max(0.0F, 1 - cosine * cosine));
}

double angle_between(glm::dvec3 a, glm::dvec3 b) {
    return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

/// A cone of directions around `axis`.
struct Cone {
    glm::dvec3 axis{0};
    double spread = -1;  // radians; negative: empty
};

/// The least cone around both.
Cone cone_around(const Cone& a, const Cone& b) {
    if (a.spread < b.spread) return cone_around(b, a);
    if (b.spread < 0) return a;
    const double between = angle_between(a.axis, b.axis);
    if (between + b.spread <= a.spread) return a;
    const double spread = 0.5 * (a.spread + between + b.spread);
    const glm::dvec3 across = b.axis - glm::dot(a.axis, b.axis) * a.axis;
    const double length = glm::length(across);
    if (!(spread < glm::pi<double>()) || !(length > 0)) return {a.axis, glm::pi<double>()};
    const double turn = spread - a.spread;
    return {std::cos(turn) * a.axis + std::sin(turn) / length * across, spread};
}

constexpr double one_below_one = 1 - 0x1p-53;

/// Of nodes that are opened for a receiver.
constexpr std::size_t least_opened = 16;
constexpr std::size_t most_opened = 256;
/// What of a node's light is uncertain where the receiver is in it, in terms of its light.
constexpr float nearest = 4;

}  // namespace

struct EmitterTree::Bounds {
    glm::dvec3 min{std::numeric_limits<double>::infinity()};
    glm::dvec3 max{-std::numeric_limits<double>::infinity()};
    Cone normals;
    bool both_sides = false;
    double power = 0;

    void extend(const Bounds& other) {
        min = glm::min(min, other.min);
        max = glm::max(max, other.max);
        normals = cone_around(normals, other.normals);
        both_sides |= other.both_sides;
        power += other.power;
    }

    /// What it costs to have these emitters in one node: their power, times the area they spread over, times the solid
    /// angle they shine into (Estevez and Kulla 2018, equations 1 and 2; their emission half-angle is pi / 2 here).
    [[nodiscard]] double cost() const {
        if (!(power > 0)) return 0;
        const double o = normals.spread;
        const double w = std::min(o + glm::half_pi<double>(), glm::pi<double>());
        const double solid_angle =
            glm::two_pi<double>() * (1 - std::cos(o)) +
            glm::half_pi<double>() * (2 * w * std::sin(o) - std::cos(o - 2 * w) - 2 * o * std::sin(o) + std::cos(o));
        const glm::dvec3 size = max - min;
        const double area = size.x * size.y + size.y * size.z + size.z * size.x;
        return power * solid_angle * area;
    }
};

class EmitterTree::Builder {
  public:
    Builder(EmitterTree& tree, std::span<const Emitter> emitters) : tree_(tree) {
        for (std::uint32_t i = 0; i < emitters.size(); ++i) {
            const Emitter& e = emitters[i];
            if (!(e.power > 0)) continue;
            items_.push_back({{e.min, e.max, {e.normal, 0}, e.both_sides, e.power}, i});
            total_power_ += e.power;
        }
        tree_.ways_.resize(emitters.size());
    }

    void build() {
        if (!items_.empty()) add(items_, 0, 0);
    }

  private:
    struct Item {
        Bounds bounds;
        std::uint32_t emitter;

        [[nodiscard]] glm::dvec3 center() const { return 0.5 * (bounds.min + bounds.max); }
    };

    void add(std::span<Item> items, int level, std::uint64_t turns) {
        Bounds bounds;
        for (const Item& item : items) bounds.extend(item.bounds);
        const std::size_t index = tree_.nodes_.size();
        Node& node = tree_.nodes_.emplace_back();
        node.center = glm::vec3(0.5 * (bounds.min + bounds.max));
        // Rounded up, so that rounding does not rule out what may bring something.
        const double rounding = 0x1p-22 * glm::length(glm::max(glm::abs(bounds.min), glm::abs(bounds.max)));
        node.radius = static_cast<float>(0.5 * glm::length(bounds.max - bounds.min) + rounding);
        node.axis = glm::vec3(bounds.normals.axis);
        node.cos_spread = static_cast<float>(std::cos(std::min(bounds.normals.spread + 0x1p-20, glm::pi<double>())));
        node.sin_spread = sine_of(node.cos_spread);
        node.power = static_cast<float>(bounds.power / total_power_);
        node.both_sides = bounds.both_sides;
        double largest = 0;
        for (const Item& item : items) largest = std::max(largest, glm::length(item.bounds.max - item.bounds.min));
        const bool together = glm::length(bounds.max - bounds.min) <= most_apart_in_leaf * largest;
        if (items.size() == 1 || (items.size() <= most_in_leaf && node.cos_spread > least_cosine_in_leaf && together)) {
            node.count = static_cast<std::uint8_t>(items.size());
            node.next = static_cast<std::uint32_t>(tree_.leaves_.size());
            for (const Item& item : items) {
                tree_.leaves_.push_back(item.emitter);
                tree_.ways_[item.emitter] = {turns, static_cast<std::uint32_t>(index),
                                             static_cast<float>(item.bounds.power / bounds.power)};
            }
            return;
        }
        const std::size_t middle = divide(items, bounds, level);
        add(items.first(middle), level + 1, turns);
        tree_.nodes_[index].next = static_cast<std::uint32_t>(tree_.nodes_.size());
        add(items.subspan(middle), level + 1, turns | std::uint64_t{1} << level);
    }

    /// Sorts the items into two parts and returns the size of the first.
    static std::size_t divide(std::span<Item> items, const Bounds& bounds, int level) {
        glm::dvec3 least(std::numeric_limits<double>::infinity());
        glm::dvec3 most(-std::numeric_limits<double>::infinity());
        for (const Item& item : items) {
            least = glm::min(least, item.center());
            most = glm::max(most, item.center());
        }
        const auto bucket_of = [&](const Item& item, int axis) {
            const double place = (item.center()[axis] - least[axis]) / (most[axis] - least[axis]);
            return std::min(static_cast<std::size_t>(place * bucket_count), bucket_count - 1);
        };
        const glm::dvec3 size = bounds.max - bounds.min;
        const double longest = std::max({size.x, size.y, size.z});
        double best_cost = std::numeric_limits<double>::infinity();
        int best_axis = 0;
        std::size_t best_end = 0;  // first bucket of the second part
        for (int axis = 0; axis < 3; ++axis) {
            if (!(most[axis] > least[axis])) continue;
            std::array<Bounds, bucket_count> buckets;
            for (const Item& item : items) buckets[bucket_of(item, axis)].extend(item.bounds);
            std::array<double, bucket_count> cost_behind;  // of all buckets from this on
            Bounds behind;
            for (std::size_t i = bucket_count; i-- > 0;) {
                behind.extend(buckets[i]);
                cost_behind[i] = behind.cost();
            }
            Bounds before;
            for (std::size_t end = 1; end < bucket_count; ++end) {
                before.extend(buckets[end - 1]);
                const double cost = (before.cost() + cost_behind[end]) * longest / size[axis];
                if (cost < best_cost) {
                    best_cost = cost;
                    best_axis = axis;
                    best_end = end;
                }
            }
        }
        const std::size_t half = items.size() / 2;
        if (best_end == 0 || level >= most_uneven_levels) return half;  // all in one place, or too deep
        const auto middle = std::partition(items.begin(), items.end(),
                                           [&](const Item& item) { return bucket_of(item, best_axis) < best_end; });
        return static_cast<std::size_t>(middle - items.begin());
    }

    static constexpr std::size_t most_in_leaf = 4;
    static constexpr float least_cosine_in_leaf = 0.9F;  // between their normals and the middle
    static constexpr double most_apart_in_leaf = 2;      // across all, of the largest
    static constexpr std::size_t bucket_count = 12;
    static constexpr int most_uneven_levels = 32;  // then in halves: no path has more turns than a word has bits

    EmitterTree& tree_;
    std::vector<Item> items_;
    double total_power_ = 0;
};

EmitterTree::EmitterTree(std::span<const Emitter> emitters) {
    Builder(*this, emitters).build();
}

float EmitterTree::importance(const Node& node, const Receiver& receiver) noexcept {
    const glm::vec3 way = node.center - receiver.position;
    const float squared = glm::dot(way, way);
    const float radius_squared = node.radius * node.radius;
    if (!(squared > radius_squared)) return node.power / radius_squared;  // within: light may come from anywhere
    const float inverse = 1 / std::sqrt(squared);
    const Angle subtended = {std::sqrt(1 - radius_squared / squared), node.radius * inverse};  // by half of the sphere

    float toward = -glm::dot(node.axis, way) * inverse;
    if (node.both_sides) toward = std::abs(toward);
    const Angle off_cone = minus({toward, sine_of(toward)}, {node.cos_spread, node.sin_spread});
    const float emitted = minus(off_cone, subtended).cosine;
    if (!(emitted > 0)) return 0;

    float received = 1;
    if (receiver.normal != glm::vec3(0)) {
        const float facing = glm::dot(receiver.normal, way) * inverse;
        received = minus({facing, sine_of(facing)}, subtended).cosine;
        if (!(received > 0)) return 0;
    }
    return node.power * emitted * received / squared;
}

float EmitterTree::share_of_first(std::uint32_t node, const Receiver& receiver) const noexcept {
    const float first = importance(nodes_[node + 1], receiver);
    const float second = importance(nodes_[nodes_[node].next], receiver);
    return first + second > 0 ? first / (first + second) : -1.0F;
}

EmitterCut EmitterTree::open(const Receiver& receiver, std::uint32_t draws) const {
    EmitterCut cut;
    if (empty()) return cut;
    struct Candidate {
        float doubt = 0;  // how much of what it brings is uncertain
        float brings = 0;
        std::uint32_t node = 0;
        int level = 0;

        bool operator<(const Candidate& other) const { return doubt < other.doubt; }
    };
    const auto candidate = [&](std::uint32_t index, int level) {
        const Node& node = nodes_[index];
        const float brings = importance(node, receiver);
        if (node.count != 0) return Candidate{0, brings, index, level};
        const glm::vec3 way = node.center - receiver.position;
        const float near = node.radius * node.radius / glm::dot(way, way);
        return Candidate{brings * std::min(near, nearest), brings, index, level};
    };
    std::vector<Candidate> found{candidate(0, 0)};
    const std::size_t most = std::clamp<std::size_t>(draws, least_opened, most_opened);
    while (found.size() < most && found.front().doubt > 0) {
        std::pop_heap(found.begin(), found.end());
        const Candidate opened = found.back();
        found.back() = candidate(opened.node + 1, opened.level + 1);
        std::push_heap(found.begin(), found.end());
        found.push_back(candidate(nodes_[opened.node].next, opened.level + 1));
        std::push_heap(found.begin(), found.end());
    }
    std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.node < b.node; });
    double sum = 0;
    for (const Candidate& c : found) sum += c.brings;
    cut.parts_.reserve(found.size());
    double end = 0;
    for (const Candidate& c : found) {
        const float share = sum > 0 ? static_cast<float>(c.brings / sum) : 0;
        end += share;
        cut.parts_.push_back({c.node, c.level, share, end});
    }
    return cut;
}

EmitterTree::Draw EmitterTree::draw(const Receiver& receiver, double u) const noexcept {
    float probability = 1;
    std::uint32_t node = 0;
    if (receiver.cut != nullptr) {
        const std::vector<EmitterCut::Part>& parts = receiver.cut->parts_;
        u *= parts.back().end;
        const auto part = std::upper_bound(parts.begin(), parts.end(), u,
                                           [](double value, const EmitterCut::Part& p) { return value < p.end; });
        if (part == parts.end()) return {};
        u = std::clamp((u - (part->end - part->share)) / part->share, 0.0, one_below_one);
        probability = part->share;
        node = part->node;
    }
    while (nodes_[node].count == 0) {
        const float share = share_of_first(node, receiver);
        if (share < 0) return {};
        if (u < share) {
            u /= share;
            probability *= share;
            ++node;
        } else {
            u = (u - share) / (1.0 - share);
            probability *= 1 - share;
            node = nodes_[node].next;
        }
    }
    const std::uint32_t* emitter = &leaves_[nodes_[node].next];
    const std::uint32_t* last = emitter + nodes_[node].count - 1;
    while (emitter != last && u >= ways_[*emitter].share) u -= ways_[*emitter++].share;
    return {*emitter, probability * ways_[*emitter].share};
}

float EmitterTree::probability(const Receiver& receiver, std::uint32_t emitter) const noexcept {
    if (!(ways_[emitter].share > 0)) return 0;  // it has no power, and no way leads to it
    float probability = 1;
    std::uint32_t node = 0;
    std::uint64_t turns = ways_[emitter].turns;
    if (receiver.cut != nullptr) {
        const std::vector<EmitterCut::Part>& parts = receiver.cut->parts_;
        const auto behind =
            std::upper_bound(parts.begin(), parts.end(), ways_[emitter].leaf,
                             [](std::uint32_t leaf, const EmitterCut::Part& p) { return leaf < p.node; });
        const EmitterCut::Part& part = *std::prev(behind);
        probability = part.share;
        node = part.node;
        turns >>= part.level;
    }
    for (; nodes_[node].count == 0; turns >>= 1) {
        const float share = share_of_first(node, receiver);
        if (share < 0) return 0;
        const bool second = (turns & 1) != 0;
        probability *= second ? 1 - share : share;
        node = second ? nodes_[node].next : node + 1;
    }
    return probability * ways_[emitter].share;
}

}  // namespace lightgrid
