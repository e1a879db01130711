#include "core/error.h"
#include "core/hash.h"
#include "core/sh.h"
#include "core/whole_file.h"
#include "probes/bake.h"
#include "probes/kept_transport.h"

#include <algorithm>
#include <array>
#include <fstream>
#include <span>
#include <type_traits>

// A file of kept transport: a mark (with the version of this format), the fingerprint, a hash of both, all values in the
// order of `visit`, without padding (vectors as their length, 8 bytes, and their elements), and a hash of everything
// before it. Numbers are as the machine's memory has them: a file is for the machine that made it.

namespace lightgrid {
namespace {

using Mark = std::array<char, 16>;
constexpr Mark mark{'l', 'i', 'g', 'h', 't', 'g', 'r', 'i', 'd', '.', 'k', 'e', 'e', 'p', '.', '1'};

/// Hashes what it writes, piece by piece as Reader reads it.
class Writer {
  public:
    template <class T>
    void value(const T& v) {
        static_assert(std::is_trivially_copyable_v<T>);
        put(&v, sizeof(T));
    }
    template <class T>
    void list(const std::vector<T>& v) {
        static_assert(std::is_trivially_copyable_v<T>);
        value(std::uint64_t{v.size()});
        put(v.data(), v.size() * sizeof(T));
    }
    void text(const std::string& s) {
        value(std::uint64_t{s.size()});
        put(s.data(), s.size());
    }
    template <class T, class Visit>
    void lists(const std::vector<T>& v, Visit visit) {
        value(std::uint64_t{v.size()});
        for (const T& element : v) visit(element);
    }
    void check() { value(std::uint64_t{hash_}); }
    [[nodiscard]] const std::string& bytes() const { return bytes_; }

  private:
    void put(const void* from, std::size_t size) {
        if (size > 0) bytes_.append(static_cast<const char*>(from), size);
        hash_ = hash_bytes(std::span(static_cast<const std::byte*>(from), size), hash_);
    }

    std::string bytes_;
    std::uint64_t hash_ = 0;
};

/// Reads into place, and hashes what it reads: files are as large as memory allows.
class Reader {
  public:
    /// Throws Error where the file cannot be read.
    explicit Reader(const std::filesystem::path& path) : file_(path, std::ios::binary | std::ios::ate) {
        if (!file_) throw Error("cannot be read", path.string());
        left_ = static_cast<std::uint64_t>(file_.tellg());
        file_.seekg(0);
    }

    template <class T>
    void value(T& v) {
        take(&v, sizeof(T));
    }
    template <class T>
    void list(std::vector<T>& v) {
        v.resize(count(sizeof(T)));
        take(static_cast<void*>(v.data()), v.size() * sizeof(T));
    }
    void text(std::string& s) {
        s.resize(count(1));
        take(s.data(), s.size());
    }
    template <class T, class Visit>
    void lists(std::vector<T>& v, Visit visit) {
        v.resize(count(sizeof(std::uint64_t)));
        for (T& element : v) visit(element);
    }
    /// A hash of all before it is next.
    void check() {
        const std::uint64_t expected = hash_;
        std::uint64_t hash = 0;
        value(hash);
        if (hash != expected) throw Error("another hash");
    }
    [[nodiscard]] bool at_end() const { return left_ == 0; }

  private:
    void take(void* to, std::size_t size) {
        if (size > left_ || !file_.read(static_cast<char*>(to), static_cast<std::streamsize>(size))) {
            throw Error("ends too early");
        }
        left_ -= size;
        hash_ = hash_bytes(std::span(static_cast<const std::byte*>(to), size), hash_);
    }
    /// Of elements that take at least so many bytes each: nothing is allocated for what cannot be there.
    std::size_t count(std::size_t least_size) {
        std::uint64_t n = 0;
        value(n);
        if (n > left_ / least_size) throw Error("ends too early");
        return n;
    }

    std::ifstream file_;
    std::uint64_t left_ = 0;  // bytes
    std::uint64_t hash_ = 0;
};

// Structures are taken apart below into all of their fields: one that is added does not compile until it is named here.

/// Everything but the fingerprint, in the file's order: one function, so that reading and writing cannot differ.
/// Kept: KeptTransport, const or not, as the archive asks.
template <class Archive, class Kept>
void visit(Archive& archive, Kept& kept) {
    const auto of_lists = [&](auto& lists) { archive.lists(lists, [&](auto& list) { archive.list(list); }); };
    auto& [fingerprint, light, options, transport, places, direct, made, gathers, volume, samples, placement,
           why_spacing, why_samples] = kept;
    auto& [sources, emission, lights, sky_shape, sky_scale] = light;
    auto& [count, of_material, of_light, of_sky] = sources;
    archive.value(count);
    archive.list(of_material);
    archive.list(of_light);
    archive.value(of_sky);
    archive.list(emission);
    archive.lists(lights, [&](auto& l) {
        auto& [name, kind, intensity, position, direction, range, cos_inner, cos_outer, group] = l;
        archive.value(kind);
        archive.value(intensity);
        archive.value(position);
        archive.value(direction);
        archive.value(range);
        archive.value(cos_inner);
        archive.value(cos_outer);
    });
    archive.value(sky_shape);
    archive.value(sky_scale);

    auto& [width, rays_per_probe, rays_per_sample, light_samples, accuracy, seed] = options;
    archive.value(width);
    archive.value(rays_per_probe);
    archive.value(rays_per_sample);
    archive.value(light_samples);
    archive.value(accuracy);
    archive.value(seed);
    auto& [rays, first_sample, weights, landed, passed] = transport;
    archive.value(rays);
    archive.list(first_sample);
    archive.list(weights);
    archive.list(landed);
    archive.list(passed);
    archive.list(places);
    of_lists(direct);
    // What solving brings comes anew.
    auto& [made_width, made_samples, patches, cut_cubes, generations, sweeps, residual, counts] = made;
    archive.value(made_width);
    archive.value(made_samples);
    archive.value(patches);
    archive.value(cut_cubes);
    archive.value(generations);
    archive.lists(gathers, [&](auto& gather) {
        auto& [slots, rays_each, gather_seed, landed_at, ends, first_end, aimed] = gather;
        archive.list(slots);
        archive.value(rays_each);
        archive.value(gather_seed);
        archive.list(landed_at);
        archive.list(ends);
        archive.list(first_end);
        of_lists(aimed);
    });

    // Places and states: its light comes anew.
    auto& [bands, grids, bricks, list, states, coefficients, errors, axis_errors, offsets, layers, half, settings] =
        volume;
    archive.value(bands);
    archive.lists(grids, [&](auto& grid) {
        auto& [origin, spacing, counts_along] = grid;
        archive.value(origin);
        archive.value(spacing);
        archive.value(counts_along);
    });
    archive.list(bricks);
    archive.list(list);
    archive.list(states);
    archive.list(offsets);
    archive.value(samples);
    archive.value(placement);
    archive.text(why_spacing);
    archive.text(why_samples);
}

/// Joins the bytes of values to a hash.
class Hasher {
  public:
    template <class T>
    void add(const T& v) {
        static_assert(std::has_unique_object_representations_v<T> || std::is_floating_point_v<T>);
        hash_ = hash_bytes(std::as_bytes(std::span(&v, 1)), hash_);
    }
    void add(const std::string& s) { add_all(s); }
    void add(glm::vec3 v) { add_all(std::array{v.x, v.y, v.z}); }
    void add(glm::dvec3 v) { add_all(std::array{v.x, v.y, v.z}); }
    void add(const Box& box) {
        const auto& [min, max] = box;
        add(min);
        add(max);
    }
    void add(const TextureUse& use) {
        const auto& [texture, uv_set, transform] = use;
        add(texture);
        add(uv_set);
        for (int column = 0; column < 3; ++column) {
            add(transform[column].x);
            add(transform[column].y);
        }
    }
    void add(const Texture& texture) {
        const auto& [image, wrap_u, wrap_v, nearest] = texture;
        const auto& [width, height, pixels] = image;
        add(width);
        add(height);
        add_all(pixels);
        add(wrap_u);
        add(wrap_v);
        add(nearest);
    }
    /// But for what shines: the colour of its emission, and the group that this is in.
    void add(const Material& material) {
        const auto& [name, base_color, base_color_texture, alpha_mode, alpha, alpha_cutoff, transmission,
                     transmission_texture, emission, emission_texture, double_sided, group] = material;
        add(base_color);
        add(base_color_texture);
        add(alpha_mode);
        add(alpha);
        add(alpha_cutoff);
        add(transmission);
        add(transmission_texture);
        add(emission_texture);
        add(double_sided);
    }
    void add(const Mesh& mesh) {
        const auto& [name, positions, triangles, uv_sets, colors, material, node] = mesh;
        add(material);
        add_all(positions);
        add_all(triangles);
        add_all(colors);
        add(uv_sets.size());
        for (const std::vector<glm::vec2>& uv : uv_sets) add_all(uv);
    }
    void add(const Model& model) {
        const auto& [meshes] = model;
        each(meshes);
    }
    void add(const Instance& instance) {
        const auto& [model, to_level, mirrored, node] = instance;
        add(model);
        for (int column = 0; column < 4; ++column) add(to_level[column]);
        add(mirrored);
    }
    template <class T>
    void add(const std::optional<T>& v) {
        add(v.has_value() ? 1 : 0);
        if (v) add(*v);
    }
    template <class T>
    void each(const std::vector<T>& values) {
        add(values.size());
        for (const T& v : values) add(v);
    }
    /// Of elements without padding.
    template <class List>
    void add_all(const List& values) {
        hash_ = hash_bytes(std::as_bytes(std::span(values)), hash_);
    }
    [[nodiscard]] std::uint64_t hash() const { return hash_; }

  private:
    std::uint64_t hash_ = 0;
};

/// What cannot be without a fault in the program that wrote it; nothing is read out of bounds even so.
bool is_sound(const KeptTransport& kept) {
    const Transport& transport = kept.transport;
    const std::size_t patches = transport.patches();
    const std::size_t samples = kept.places.size();
    const std::uint32_t sources = kept.light.sources.count;
    const auto place = [&](std::uint32_t at) { return at < patches || at >= Transport::sky; };
    const auto source = [&](std::uint32_t s) { return s < sources || s == LightSources::off; };
    const auto all = [](const auto& values, const auto& test) {
        return std::all_of(values.begin(), values.end(), test);
    };
    const std::vector<std::uint32_t>& first = transport.first_sample;
    bool sound = !first.empty() && first.front() == 0 && first.back() == samples &&
                 std::is_sorted(first.begin(), first.end()) && transport.weights.size() == samples &&
                 transport.landed.size() == samples * transport.rays && all(transport.landed, place) &&
                 all(transport.passed, [&](const Transport::PassedRay& ray) {
                     return ray.from < samples && ray.ray < transport.rays && place(ray.patch);
                 });
    sound = sound && sources >= 1 && sources <= LightSources::most && kept.direct.size() == sources &&
            all(kept.light.sources.of_material, source) && all(kept.light.sources.of_light, source) &&
            source(kept.light.sources.of_sky) && kept.light.emission.size() == kept.light.sources.of_material.size() &&
            kept.light.lights.size() == kept.light.sources.of_light.size() &&
            all(kept.direct, [&](const auto& direct) { return direct.size() == patches; });
    const std::size_t values = kept.volume.sh_size() + axis_normals.size();
    for (const KeptGather& gather : kept.gathers) {
        const std::size_t sets = gather.slots.size() * GatherOptions{}.replicates;
        sound = sound && gather.rays > 0 && gather.landed.size() == sets * gather.rays && all(gather.landed, place) &&
                all(gather.slots, [&](std::uint64_t slot) { return slot < kept.volume.slots(); }) &&
                gather.first_end.size() == sets + 1 && gather.first_end.front() == 0 &&
                gather.first_end.back() == gather.ends.size() &&
                std::is_sorted(gather.first_end.begin(), gather.first_end.end()) &&
                all(gather.ends, [&](const RayEnd& end) {
                    const bool emitter = end.at >= RayEnd::emitter && end.at - RayEnd::emitter < sources;
                    return end.ray < gather.rays && (emitter || place(end.at));
                });
        sound = sound && gather.aimed.size() == sources &&
                all(gather.aimed, [&](const auto& aimed) { return aimed.size() == gather.slots.size() * values; });
    }
    return sound;
}

}  // namespace

std::uint64_t transport_fingerprint(const Scene& scene, const BakeOptions& options, const std::string& version) {
    Hasher hash;
    hash.add(version);
    const auto& [name, metres_per_unit, origin, bounds, meshes, placed, models, instances, materials, textures, lights,
                 groups, volume_markers, probe_markers, node_names, missing_textures, notices, left_out] = scene;
    hash.add(metres_per_unit);
    hash.add(origin);
    hash.each(meshes);
    hash.each(placed);
    hash.each(models);
    hash.each(instances);
    hash.each(materials);
    hash.each(textures);
    hash.each(volume_markers);
    hash.each(probe_markers);

    // Layers and time budgets do not go with it; what is measured, and the sky's name, change nothing that is kept.
    const auto& [placement, probes, bands, target, clock, method, seed, measure_error, compare_look_ups, keep_transport,
                 layers, environment] = options;
    const auto& [spacing, boxes, max_probes, headroom] = placement;
    hash.add(spacing);
    hash.each(boxes);
    hash.add(max_probes);
    hash.add(headroom);
    hash.add(probes.has_value());
    if (probes) hash.each(*probes);
    hash.add(bands);
    const auto& [samples, error, seconds] = target;
    hash.add(samples);
    hash.add(error);
    hash.add(method);
    hash.add(seed);
    return hash.hash();
}

void save_transport(const KeptTransport& kept, const std::filesystem::path& path) {
    Writer writer;
    writer.value(mark);
    writer.value(kept.fingerprint);
    writer.check();
    visit(writer, kept);
    writer.check();
    write_whole_file(path, writer.bytes());
}

std::optional<KeptTransport> load_transport(const std::filesystem::path& path, std::uint64_t fingerprint) {
    const auto wrong = [&](const char* what) {
        return Error(what, path.string(), "Delete it, or name another file: a bake writes it anew.");
    };
    Reader reader(path);
    Mark found{};
    try {
        reader.value(found);
    } catch (const Error&) {
        throw wrong("holds no transport");
    }
    // Up to its version, so that files of other versions are taken for what they are.
    if (!std::equal(mark.begin(), mark.end() - 1, found.begin())) throw wrong("holds no transport");
    if (found != mark) return {};
    KeptTransport kept;
    try {
        reader.value(kept.fingerprint);
        reader.check();
        if (kept.fingerprint != fingerprint) return {};
        visit(reader, kept);
        reader.check();
        Volume& volume = kept.volume;
        if (!reader.at_end() || volume.bands < 1 || volume.bands > max_sh_bands) throw Error("other contents");
        volume.coefficients.assign(volume.slots() * volume.sh_size(), glm::vec3(0));
        volume.errors.assign(volume.coefficients.size(), glm::vec3(0));
        volume.axis_errors.assign(volume.slots() * axis_normals.size(), glm::vec3(0));
        check_volume(volume);
    } catch (const Error&) {
        throw wrong("is damaged");
    }
    if (!is_sound(kept)) throw wrong("is damaged");
    return kept;
}

}  // namespace lightgrid
