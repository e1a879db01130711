#pragma once

#include <glm/glm.hpp>

#include <cstdint>
#include <span>
#include <vector>

namespace lightgrid {

class EmitterCut;

/// A point that light is collected at: from all sides, or from the half space that a normal points to.
struct Receiver {
    glm::vec3 position{0};
    glm::vec3 normal{0};              // unit length; 0: from all sides
    const EmitterCut* cut = nullptr;  // made for this place, or none
};

/// Draws one of many small emitters in proportion to about what each may bring to a receiver, by power, distance and
/// directions, not knowing what is in between. O(log n) a draw.
///
/// A binary tree whose nodes bound the places (by a sphere) and the normals (by a cone) of the emitters below; a draw
/// goes down by the nodes' importance. A leaf holds a few that lie together and face the same way, such as the
/// triangles of one lamp: among them power decides. Emitters that cannot bring anything may have probability 0.
///
/// Where many draws are for one receiver, the tree is opened for it once: what lies near is told apart before the first
/// draw, not by bounds that are too wide to tell.
///
/// Source: Estevez, Kulla, "Importance Sampling of Many Lights with Adaptive Tree Splitting", 2018.
class EmitterTree {
  public:
    struct Emitter {
        glm::dvec3 min{0}, max{0};  // bounds
        glm::dvec3 normal{0};       // unit length, of the side that emits
        bool both_sides = false;
        double power = 0;  // finite, not negative; 0: never drawn
    };

    EmitterTree() = default;
    explicit EmitterTree(std::span<const Emitter> emitters);

    [[nodiscard]] bool empty() const noexcept { return nodes_.empty(); }

    struct Draw {
        std::uint32_t emitter = 0;
        float probability = 0;  // 0: none can bring anything
    };
    /// Nodes that hold all emitters once, as many as pay where `draws` follow, the ones that may mislead most opened
    /// first. Draws of receivers with it start there.
    [[nodiscard]] EmitterCut open(const Receiver& receiver, std::uint32_t draws) const;

    /// u  in [0, 1), double: each level of the tree takes some of its bits. Not of an empty tree.
    [[nodiscard]] Draw draw(const Receiver& receiver, double u) const noexcept;
    /// Of drawing this emitter there: bit for bit what `draw` returns with it.
    [[nodiscard]] float probability(const Receiver& receiver, std::uint32_t emitter) const noexcept;

  private:
    struct Node {
        glm::vec3 center{0};  // of a sphere around all below
        float radius = 0;
        glm::vec3 axis{0};  // of a cone around all normals
        float cos_spread = 1;
        float sin_spread = 0;
        float power = 0;  // of all, 1 at the root
        bool both_sides = false;
        std::uint8_t count = 0;  // of a leaf: its emitters; else 0
        std::uint32_t next = 0;  // of a leaf: the first of them in leaves_; else the second child; the first follows it
    };
    /// The way down to an emitter.
    struct Way {
        std::uint64_t turns = 0;  // bit k: at level k to the second child
        std::uint32_t leaf = 0;   // index in nodes_
        float share = 0;          // of its leaf's power
    };
    struct Bounds;
    class Builder;

    [[nodiscard]] static float importance(const Node& node, const Receiver& receiver) noexcept;
    /// Probability of going on with the first child; negative: neither can bring anything.
    [[nodiscard]] float share_of_first(std::uint32_t node, const Receiver& receiver) const noexcept;

    std::vector<Node> nodes_;            // the root first
    std::vector<std::uint32_t> leaves_;  // emitters, leaf by leaf
    std::vector<Way> ways_;              // by emitter
};

/// A tree as one receiver sees it; see EmitterTree::open.
class EmitterCut {
  private:
    friend EmitterTree;

    struct Part {
        std::uint32_t node = 0;  // in their order: what is below a node lies behind it and before the next
        int level = 0;           // of the node
        float share = 0;         // of all draws
        double end = 0;          // sum of the shares up to its own
    };
    std::vector<Part> parts_;
};

}  // namespace lightgrid
