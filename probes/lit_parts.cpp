#include "probes/lit_parts.h"

#include "core/parallel.h"
#include "core/sampling.h"
#include "core/texel_bounds.h"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

namespace lightgrid {
namespace {

/// Points of a part at which its emission is looked at, and of one of many texels.
constexpr std::uint32_t few_points = 16;
constexpr std::uint32_t many_points = 64;
constexpr double many_texels = 1024;

/// Light on a part is uneven by the mean of its square over the square of its mean: samples that are even on it bring so
/// much more noise. A part is halved in any case beyond the first of these, or where its brightest texel, which may be
/// where no point is, is brighter than its mean by the second. After so many parts of one triangle more is let pass.
constexpr double most_uneven = 4;
constexpr double most_above_mean = 16;
constexpr std::size_t more_uneven_after = std::size_t{1} << 14;
constexpr std::size_t uneven_after = std::size_t{1} << 16;
/// Less uneven ones are halved while all of a triangle is more uneven than this, on the mean of its light.
constexpr double least_uneven = 1.05;
/// Parts that are tried for that, all triangles together.
constexpr std::size_t most_tried_to_even = std::size_t{1} << 16;
/// Texels along the longest side of parts that are not halved any more; their area, of the triangle's.
constexpr double least_texels = 1.0 / 16;
constexpr double least_area = 0x1p-40;
/// Of alpha from vertices: as if it were a texture with these steps.
constexpr double vertex_alpha_steps = 256;
/// Times a texture goes into a part whose mean is that of the texture.
constexpr double many_repeats = 4;
/// How bright a part is on the mean on which no point was found lit, of its brightest texel.
constexpr double unseen = 1.0 / many_points;
/// Rounding of look-ups in float: of a coordinate; of alpha.
constexpr double coordinate_rounding = 0x1p-21;
constexpr double alpha_rounding = 0x1p-16;

/// Of emission and alpha, how a texture lies on a triangle.
struct TextureOnTriangle {
    const TexelBounds* bounds = nullptr;
    std::array<glm::dvec2, 3> texels{};  // at the corners
    glm::dvec2 slack{0};                 // see TexelBounds::most_over

    TextureOnTriangle() = default;
    TextureOnTriangle(const TexelBounds& of, const TextureUse& use, const Mesh& mesh, glm::uvec3 vertices)
        : bounds(&of) {
        const std::vector<glm::vec2>& set = mesh.uv_sets[static_cast<std::size_t>(use.uv_set)];
        const glm::dmat3x2 transform(use.transform);
        const glm::dmat3x2 largest_terms(glm::abs(transform[0]), glm::abs(transform[1]), glm::abs(transform[2]));
        glm::dvec2 largest(0);
        for (int i = 0; i < 3; ++i) {
            const glm::dvec2 uv(set[vertices[i]]);
            texels[i] = transform * glm::dvec3(uv, 1) * of.size();
            largest = glm::max(largest, largest_terms * glm::dvec3(glm::abs(uv), 1));
        }
        slack = largest * of.size() * coordinate_rounding;
    }
};

bool is_even(const Material& material, const Mesh& mesh) {
    if (material.emission_texture.used()) return false;
    return material.alpha_mode == AlphaMode::opaque || (!material.base_color_texture.used() && mesh.colors.empty());
}

float emission_at(const Scene& scene, const Mesh& mesh, std::uint32_t triangle, glm::vec2 barycentric) {
    const SurfacePoint point = surface_at(scene, mesh, triangle, barycentric);
    return luminance(point.alpha * point.emission);
}

}  // namespace

/// Divides one triangle, in steps.
class LitParts::Divider {
  public:
    /// emission, alpha  of their textures; null: there is none, or it does not count
    Divider(const Scene& scene, const Mesh& mesh, std::uint32_t triangle, const TexelBounds* emission,
            const TexelBounds* alpha)
        : scene_(&scene), mesh_(&mesh), material_(&scene.materials[mesh.material]), triangle_(triangle) {
        const glm::uvec3 vertices = mesh.triangles[triangle];
        if (emission != nullptr) emission_ = {*emission, material_->emission_texture, mesh, vertices};
        if (alpha != nullptr) alpha_ = {*alpha, material_->base_color_texture, mesh, vertices};
        Piece all;
        for (int i = 0; i < 3; ++i) {
            Corner& corner = all.corners[i];
            corner.barycentric = {i == 1 ? 1 : 0, i == 2 ? 1 : 0};
            corner.emission = emission_.texels[i];
            corner.alpha = alpha_.texels[i];
            if (material_->alpha_mode != AlphaMode::opaque && !mesh.colors.empty())
                corner.vertex_alpha = mesh.colors[vertices[i]].a / 65535.0;
        }
        nodes_.emplace_back();
        take(all);
    }

    /// What parts are halved for: that light is found at all, and that it is even.
    enum class Aim { found, even };
    [[nodiscard]] bool is_done(Aim aim) const {
        if (left_.empty()) return true;
        return !is_too_uneven(left_.front()) && (aim == Aim::found || excess_ <= (least_uneven - 1) * power_);
    }

    /// Tries as many parts, or one more, or all that there are; returns how many it were.
    std::size_t refine(Aim aim, std::size_t most) {
        std::size_t tried = 0;
        for (; tried < most && !is_done(aim); tried += 2) {
            std::pop_heap(left_.begin(), left_.end());
            const Piece piece = left_.back();
            left_.pop_back();
            excess_ -= piece.excess();
            power_ -= piece.power();
            halve(piece);
        }
        return tried;
    }

    /// Whatever is left is taken as it is. Nodes and parts go behind those that there are.
    Division finish(std::vector<Node>& nodes, std::vector<Part>& parts) {
        for (const Piece& piece : left_) keep(piece);
        Division division;
        for (const Part& part : parts_) division.emission += part.area * part.emission;
        if (nodes_.size() == 1 || parts_.empty()) return division;
        division.root = static_cast<std::uint32_t>(nodes.size());
        division.first_part = static_cast<std::uint32_t>(parts.size());
        division.parts = static_cast<std::uint32_t>(parts_.size());
        for (Node& node : nodes_) {
            if (node.side != Node::whole) node.next += division.root;
        }
        nodes.insert(nodes.end(), nodes_.begin(), nodes_.end());
        parts.insert(parts.end(), parts_.begin(), parts_.end());
        return division;
    }

  private:
    struct Corner {
        glm::dvec2 barycentric{0};
        glm::dvec2 emission{0};  // texels
        glm::dvec2 alpha{0};     // texels
        double vertex_alpha = 1;
    };
    struct Piece {
        std::array<Corner, 3> corners;
        std::uint32_t node = 0;
        double area = 1;  // of the triangle's
        double most = 0;  // luminance of what leaves it
        double mean = 0;
        double uneven = 1;  // mean of squares over mean^2

        [[nodiscard]] bool is_too_uneven(double pass) const {
            return uneven > pass * most_uneven || most > pass * most_above_mean * mean;
        }
        [[nodiscard]] double power() const { return area * mean; }
        [[nodiscard]] double excess() const { return power() * (uneven - 1); }
        bool operator<(const Piece& other) const {
            const bool too_uneven = is_too_uneven(1);
            if (too_uneven != other.is_too_uneven(1)) return !too_uneven;
            return too_uneven ? area * most < other.area * other.most : excess() < other.excess();
        }
    };

    [[nodiscard]] bool is_too_uneven(const Piece& piece) const {
        return piece.is_too_uneven(nodes_.size() > uneven_after ? 16 : nodes_.size() > more_uneven_after ? 4 : 1);
    }

    static Corner middle(const Corner& a, const Corner& b) {
        return {0.5 * (a.barycentric + b.barycentric), 0.5 * (a.emission + b.emission), 0.5 * (a.alpha + b.alpha),
                0.5 * (a.vertex_alpha + b.vertex_alpha)};
    }

    static double texels_between(const Corner& a, const Corner& b) {
        return std::max({glm::distance(a.emission, b.emission), glm::distance(a.alpha, b.alpha),
                         vertex_alpha_steps * std::abs(a.vertex_alpha - b.vertex_alpha)});
    }

    static std::pair<std::uint32_t, double> longest_side(const Piece& piece) {
        std::pair<std::uint32_t, double> longest{0, -1};
        for (std::uint32_t i = 0; i < 3; ++i) {
            const double texels = texels_between(piece.corners[i], piece.corners[(i + 1) % 3]);
            if (texels > longest.second) longest = {i, texels};
        }
        return longest;
    }

    /// Its light, and whether that is known well enough.
    void take(Piece piece) {
        piece.most = most_over(piece);
        if (!(piece.most > 0)) return;  // its node says dark
        look_at(piece);
        power_ += piece.power();
        const bool is_small = piece.area <= least_area || longest_side(piece).second <= least_texels;
        if (is_small || (piece.uneven <= least_uneven && !piece.is_too_uneven(1))) {
            keep(piece);
        } else {
            excess_ += piece.excess();
            left_.push_back(piece);
            std::push_heap(left_.begin(), left_.end());
        }
    }

    void keep(const Piece& piece) {
        nodes_[piece.node].next = static_cast<std::uint32_t>(parts_.size());
        Part& part = parts_.emplace_back();
        for (int i = 0; i < 3; ++i) part.corners[i] = glm::vec2(piece.corners[i].barycentric);
        part.area = static_cast<float>(piece.area);
        part.emission = static_cast<float>(piece.mean > 0 ? piece.mean : unseen * piece.most);
    }

    void halve(const Piece& piece) {
        const std::uint32_t side = longest_side(piece).first;
        const std::uint32_t other = (side + 1) % 3;
        const auto next = static_cast<std::uint32_t>(nodes_.size());
        nodes_[piece.node].side = side;
        nodes_[piece.node].next = next;
        nodes_.resize(nodes_.size() + 2);
        const Corner cut = middle(piece.corners[side], piece.corners[other]);
        Piece half = piece;
        half.area *= 0.5;
        half.node = next;
        half.corners[other] = cut;
        take(half);
        half.node = next + 1;
        half.corners[other] = piece.corners[other];
        half.corners[side] = cut;
        take(half);
    }

    [[nodiscard]] double most_over(const Piece& piece) const {
        const auto& [a, b, c] = piece.corners;
        glm::dvec3 emission(material_->emission);
        if (emission_.bounds != nullptr) {
            const glm::u8vec4 texel =
                emission_.bounds->most_over({a.emission, b.emission, c.emission}, emission_.slack);
            emission *= glm::dvec3(decode_srgb(texel.r), decode_srgb(texel.g), decode_srgb(texel.b));
        }
        const double most = luminance(glm::vec3(emission));
        if (material_->alpha_mode == AlphaMode::opaque || !(most > 0)) return most;
        double alpha = material_->alpha * std::max({a.vertex_alpha, b.vertex_alpha, c.vertex_alpha});
        if (alpha_.bounds != nullptr)
            alpha *= alpha_.bounds->most_over({a.alpha, b.alpha, c.alpha}, alpha_.slack).a / 255.0;
        if (material_->alpha_mode == AlphaMode::mask)
            return alpha * (1 + alpha_rounding) >= material_->alpha_cutoff ? most : 0;
        return most * std::min(alpha, 1.0);
    }

    /// Its light on the mean, and how uneven that is, by points on it.
    void look_at(Piece& piece) const {
        const auto& [a, b, c] = piece.corners;
        const auto area_of = [](glm::dvec2 u, glm::dvec2 v) { return 0.5 * std::abs(u.x * v.y - u.y * v.x); };
        const double texels = std::max(area_of(b.emission - a.emission, c.emission - a.emission),
                                       area_of(b.alpha - a.alpha, c.alpha - a.alpha));
        const std::uint32_t points = texels > many_texels ? many_points : few_points;
        double sum = 0;
        double squares = 0;
        for (std::uint32_t i = 0; i < points; ++i) {
            const glm::dvec2 where(triangle_point(sobol_point(i, 0)));
            const glm::dvec2 barycentric =
                a.barycentric + where.x * (b.barycentric - a.barycentric) + where.y * (c.barycentric - a.barycentric);
            const double emission = emission_at(*scene_, *mesh_, triangle_, glm::vec2(barycentric));
            sum += emission;
            squares += emission * emission;
        }
        piece.mean = sum / points;
        piece.uneven = sum > 0 ? squares * points / (sum * sum) : points;
        if (emission_.bounds == nullptr || material_->alpha_mode != AlphaMode::opaque) return;
        const glm::dvec2 size = emission_.bounds->size();
        const Texture& texture = scene_->textures[material_->emission_texture.texture];
        const bool repeats = texture.wrap_u != Wrap::clamp && texture.wrap_v != Wrap::clamp;
        if (!repeats || !(texels > many_repeats * size.x * size.y)) return;
        piece.mean = luminance(material_->emission * glm::vec3(emission_.bounds->mean()));
    }

    const Scene* scene_;
    const Mesh* mesh_;
    const Material* material_;
    std::uint32_t triangle_;
    TextureOnTriangle emission_;
    TextureOnTriangle alpha_;
    std::vector<Node> nodes_;
    std::vector<Part> parts_;
    std::vector<Piece> left_;  // uneven, a heap: the one that it pays most to halve first
    double power_ = 0;         // of all that is lit
    double excess_ = 0;        // of those left: what they are uneven by, times their power
};

LitParts::LitParts(const Scene& scene, std::span<const std::uint32_t> uses) : first_(scene.meshes.size()) {
    struct Uneven {
        int mesh;
        std::uint32_t triangle;
        std::uint32_t division;
    };
    std::vector<Uneven> uneven;
    std::vector<std::optional<TexelBounds>> bounds(scene.textures.size());
    const auto make_bounds = [&](const TextureUse& use) {
        if (use.used() && !bounds[use.texture]) bounds[use.texture].emplace(scene.textures[use.texture]);
    };
    for (std::size_t m = 0; m < scene.meshes.size(); ++m) {
        first_[m] = static_cast<std::uint32_t>(divisions_.size());
        if (uses[m] == 0) continue;
        const Mesh& mesh = scene.meshes[m];
        const Material& material = scene.materials[mesh.material];
        const bool even = is_even(material, mesh);
        if (!even) {
            make_bounds(material.emission_texture);
            if (material.alpha_mode != AlphaMode::opaque) make_bounds(material.base_color_texture);
        }
        for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
            if (!even) uneven.push_back({static_cast<int>(m), t, static_cast<std::uint32_t>(divisions_.size())});
            divisions_.emplace_back();
            if (even) divisions_.back().emission = emission_at(scene, mesh, t, glm::vec2(1.0F / 3));
        }
    }

    struct Unfinished {
        Uneven of;
        Divider divider;
    };
    std::vector<Unfinished> unfinished;
    // So many at once, because most are done at first sight.
    constexpr std::size_t at_once = std::size_t{1} << 14;
    for (std::size_t begin = 0; begin < uneven.size(); begin += at_once) {
        std::vector<std::optional<Divider>> dividers(std::min(at_once, uneven.size() - begin));
        for_each_index(dividers.size(), [&](std::size_t i) {
            const Uneven& of = uneven[begin + i];
            const Mesh& mesh = scene.meshes[of.mesh];
            const Material& material = scene.materials[mesh.material];
            const auto bounds_of = [&](const TextureUse& use) { return use.used() ? &*bounds[use.texture] : nullptr; };
            const bool is_opaque = material.alpha_mode == AlphaMode::opaque;
            dividers[i].emplace(scene, mesh, of.triangle, bounds_of(material.emission_texture),
                                is_opaque ? nullptr : bounds_of(material.base_color_texture));
        });
        for (std::size_t i = 0; i < dividers.size(); ++i) {
            const Uneven& of = uneven[begin + i];
            if (dividers[i]->is_done(Divider::Aim::even)) {
                divisions_[of.division] = dividers[i]->finish(nodes_, parts_);
            } else {
                unfinished.push_back({of, std::move(*dividers[i])});
            }
        }
    }
    // All get the same, and what some do not need goes to the others.
    const auto refine = [&](Divider::Aim aim, std::size_t left) {
        for (;;) {
            std::vector<Unfinished*> open;
            std::size_t all_uses = 0;
            for (Unfinished& u : unfinished) {
                if (u.divider.is_done(aim)) continue;
                open.push_back(&u);
                all_uses += uses[u.of.mesh];
            }
            const std::size_t share = open.empty() ? 0 : left / all_uses;
            if (share == 0) return;
            std::vector<std::size_t> tried(open.size());
            for_each_index(open.size(), [&](std::size_t i) { tried[i] = open[i]->divider.refine(aim, share); });
            for (std::size_t i = 0; i < open.size(); ++i) left -= std::min(left, tried[i] * uses[open[i]->of.mesh]);
        }
    };
    refine(Divider::Aim::found, most_tried);
    refine(Divider::Aim::even, most_tried_to_even);
    for (Unfinished& u : unfinished) divisions_[u.of.division] = u.divider.finish(nodes_, parts_);
}

std::uint32_t LitParts::find(std::uint32_t root, glm::vec2 barycentric) const noexcept {
    glm::dvec3 weights(1.0 - barycentric.x - barycentric.y, barycentric);
    const Node* node = &nodes_[root];
    while (node->side != Node::whole) {
        double& kept = weights[node->side];
        double& other = weights[(node->side + 1) % 3];
        const bool second = other > kept;
        // From the middle of the side on: p = a A + b B + ... = (a - b) A + 2 b (A + B) / 2 + ...
        if (second) {
            other -= kept;
            kept *= 2;
        } else {
            kept -= other;
            other *= 2;
        }
        node = &nodes_[node->next + (second ? 1 : 0)];
    }
    return node->next == Node::dark ? none : node->next;
}

}  // namespace lightgrid
