#include "core/gltf/structure.h"

#include "core/error.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <functional>
#include <initializer_list>
#include <limits>
#include <map>
#include <set>
#include <string_view>
#include <utility>

namespace lightgrid::gltf {
namespace {

using nlohmann::json;

constexpr double largest = std::numeric_limits<float>::max();
constexpr double largest_size = 9007199254740992;  // 2^53: what a JSON number holds exactly

/// What all checks of one document share.
struct Report {
    Findings findings;
    std::map<std::string, std::size_t> counts;  // elements of the document's arrays, by name
    std::set<std::string> extensions_used;
    bool read = true;  // whether light paths read the part being checked
};

std::string escaped(const std::string& key) {
    std::string result;
    for (const char c : key) result += c == '~' ? "~0" : c == '/' ? "~1" : std::string(1, c);
    return result;
}

/// One JSON object under check. Each call moves the named property over to the clean object if it is absent or as it
/// should be, and adds a finding if it is not; what is never named does not survive.
class Check {
  public:
    using Body = std::function<void(Check&)>;

    Check(Report& report, json& source, const Check* outer, std::string key)
        : report_(report), source_(source), outer_(outer), key_(std::move(key)) {}

    [[nodiscard]] bool has(const char* name) const { return source_.contains(name); }
    [[nodiscard]] bool has_object(const char* name) const { return has(name) && source_[name].is_object(); }
    [[nodiscard]] const json& clean() const { return clean_; }
    [[nodiscard]] json take() { return std::move(clean_); }
    /// No finding that a light path would meet.
    [[nodiscard]] bool sound() const { return sound_; }

    void bad(const std::string& name, const std::string& problem) {
        std::string place = pointer();
        if (!name.empty()) place += "/" + escaped(name);
        const Check* thing = this;
        while (thing != nullptr && thing->kind_ == nullptr) thing = thing->outer_;
        if (thing != nullptr) place = fmt::format("{} ({})", thing->thing_name(), place);
        report_.findings.push_back({report_.read && thing != nullptr ? thing->pointer() : "", place, problem});
        sound_ = sound_ && !report_.read;
    }

    /// Checks what changes no light, or only a little: findings are notices.
    void leniently(const Body& body) { leniently(*this, body); }
    /// Checks what no light path reads: findings are notices, and nothing of it is kept.
    void unread(const Body& body) {
        Check apart(report_, source_, outer_, key_);
        leniently(apart, body);
    }
    void harmless(const std::string& name, const std::string& problem) {
        leniently([&](Check& check) { check.bad(name, problem); });
    }

    void boolean(const char* name) {
        if (const json* value = find(name); value && expect(value->is_boolean(), name, "is not true or false"))
            clean_[name] = *value;
    }
    /// problem_of  what is wrong with a string; empty: nothing
    void text(const char* name, const std::function<std::string(const std::string&)>& problem_of = {}) {
        json* value = find(name);
        if (!value || !expect(value->is_string(), name, "is not a string")) return;
        const std::string problem = problem_of ? problem_of(*value) : "";
        if (!problem.empty()) return bad(name, fmt::format("{} {}", value->dump(), problem));
        clean_[name] = std::move(*value);  // may be a buffer's data
    }
    void one_of(const char* name, std::initializer_list<const char*> allowed) {
        const json* value = find(name);
        if (!value || !expect(value->is_string(), name, "is not a string")) return;
        for (const char* candidate : allowed)
            if (*value == candidate) {
                clean_[name] = *value;
                return;
            }
        bad(name, fmt::format("is {}, which glTF does not know", value->dump()));
    }
    void one_of(const char* name, std::initializer_list<int> allowed) {
        const json* value = find(name);
        if (!value || !expect(whole(*value), name, "is not an integer")) return;
        for (const int candidate : allowed)
            if (value->get<double>() == candidate) {
                clean_[name] = candidate;
                return;
            }
        bad(name, fmt::format("is {}, which glTF does not know", value->dump()));
    }
    void number(const char* name, double least = -largest, double most = largest) {
        if (const json* value = find(name); value && is_number(*value, name, least, most))
            clean_[name] = value->get<double>();
    }
    void integer(const char* name, double least, double most) {
        const json* value = find(name);
        if (value && is_number(*value, name, least, most) && expect(whole(*value), name, "is not an integer"))
            clean_[name] = static_cast<std::int64_t>(value->get<double>());
    }
    /// An array of numbers; `size` 0: any number of them but none.
    void numbers(const char* name, std::size_t size, double least = -largest, double most = largest) {
        json* value = find(name);
        if (!value || !expect(value->is_array(), name, "is not an array") || !not_empty(*value, name)) return;
        if (size != 0 &&
            !expect(value->size() == size, name, fmt::format("has {} numbers, not {}", value->size(), size)))
            return;
        for (const json& element : *value)
            if (!is_number(element, name, least, most)) return;
        clean_[name] = std::move(*value);
    }
    /// A reference to an element of one of the document's arrays.
    void index(const char* name, const char* array) {
        if (const json* value = find(name); value && is_index(*value, name, array))
            clean_[name] = static_cast<int>(value->get<double>());
    }
    void indices(const char* name, const char* array) {
        const json* value = find(name);
        if (!value || !expect(value->is_array(), name, "is not an array") || !not_empty(*value, name)) return;
        std::set<double> seen;
        for (const json& element : *value) {
            if (!is_index(element, name, array)) return;
            if (!expect(seen.insert(element.get<double>()).second, name, fmt::format("names {} twice", element.dump())))
                return;
        }
        clean_[name] = value->get<std::vector<int>>();
    }
    /// Every property is a reference: {"POSITION": 0, ...}.
    void all_indices(const char* array) {
        for (const auto& entry : source_.items()) index(entry.key().c_str(), array);
        not_empty(source_, "");
    }
    /// Every property is a whole number.
    void all_integers(double least, double most) {
        for (const auto& entry : source_.items()) integer(entry.key().c_str(), least, most);
    }

    void object(const char* name, const Body& body) {
        json* value = find(name);
        if (!value || !expect(value->is_object(), name, "is not an object")) return;
        Check inner(report_, *value, this, name);
        body(inner);
        if (inner.sound()) clean_[name] = inner.take();
        sound_ = sound_ && inner.sound();
    }
    void objects(const char* name, const Body& body) {
        json* value = find(name);
        if (!value || !expect(value->is_array(), name, "is not an array") || !not_empty(*value, name)) return;
        json kept = json::array();
        Check array(report_, *value, this, name);
        for (std::size_t i = 0; i < value->size(); ++i) {
            json& element = (*value)[i];
            if (!element.is_object()) {
                array.bad(std::to_string(i), "is not an object");
                continue;
            }
            Check inner(report_, element, &array, std::to_string(i));
            body(inner);
            array.sound_ = array.sound_ && inner.sound();
            kept.push_back(inner.take());
        }
        if (array.sound()) clean_[name] = std::move(kept);
        sound_ = sound_ && array.sound();
    }

    /// The extensions of this object that light paths know.
    void extensions(std::initializer_list<std::pair<const char*, Body>> known = {}) {
        object("extensions", [&](Check& list) {
            for (const auto& entry : list.source_.items()) {
                if (!report_.extensions_used.contains(entry.key()))
                    list.harmless(entry.key(), "is not declared in extensionsUsed");
                const auto is_it = [&](const auto& extension) { return entry.key() == extension.first; };
                const bool is_known = std::any_of(known.begin(), known.end(), is_it);
                if (!entry.value().is_object() && !is_known) list.harmless(entry.key(), "is not an object");
            }
            for (const auto& [name, body] : known) list.object(name, body);
        });
    }

    /// A property that the object cannot do without; `fallback` stands in for it where it is missing or wrong.
    void required(const char* name, json fallback) {
        if (!has(name)) bad("", fmt::format("has no {}", name));
        if (!clean_.contains(name)) clean_[name] = std::move(fallback);
    }

    /// An array of the document: each element is a thing of its own.
    void things(const char* name, const char* kind, const Body& body) {
        json* value = find(name);
        if (!value) return;
        if (!value->is_array()) return bad(name, "is not an array");
        if (value->empty()) return harmless(name, "is empty");
        json kept = json::array();
        Check array(report_, *value, this, name);
        for (std::size_t i = 0; i < value->size(); ++i) {
            json& element = (*value)[i];
            const bool is_object = element.is_object();
            if (!is_object) element = json::object();
            Check inner(report_, element, &array, std::to_string(i));
            inner.kind_ = kind;
            inner.index_ = i;
            inner.leniently([](Check& check) { check.text("name"); });
            if (!is_object) inner.bad("", "is not an object");
            body(inner);
            kept.push_back(inner.take());
        }
        clean_[name] = std::move(kept);
    }

  private:
    [[nodiscard]] std::string thing_name() const {
        return name_of(kind_, index_, clean_.contains("name") ? clean_["name"].get<std::string>() : "");
    }
    void leniently(Check& check, const Body& body) {
        const bool before = std::exchange(report_.read, false);
        body(check);
        report_.read = before;
    }
    [[nodiscard]] std::string pointer() const {
        if (outer_ == nullptr) return "";
        return outer_->pointer() + "/" + escaped(key_);
    }
    json* find(const char* name) {
        const auto found = source_.find(name);
        return found == source_.end() ? nullptr : &*found;
    }
    bool expect(bool holds, const char* name, const std::string& problem) {
        if (!holds) bad(name, problem);
        return holds;
    }
    bool not_empty(const json& array, const char* name) {
        if (array.empty()) harmless(name, "is empty");
        return !array.empty();
    }
    static bool whole(const json& value) {
        return value.is_number() && value.get<double>() == std::floor(value.get<double>());
    }
    bool is_number(const json& value, const char* name, double least, double most) {
        if (!expect(value.is_number(), name, "is not a number")) return false;
        const double number = value.get<double>();
        if (number < least) return expect(false, name, fmt::format("is {}, but must be at least {}", number, least));
        return expect(number <= most, name, fmt::format("is {}, but must be at most {}", number, most));
    }
    bool is_index(const json& value, const char* name, const char* array) {
        const std::size_t count = report_.counts[array];
        if (!expect(whole(value) && value.get<double>() >= 0, name, fmt::format("is {}, not an index", value.dump())))
            return false;
        return expect(value.get<double>() < static_cast<double>(count), name,
                      fmt::format("refers to element {} of {}, but there are {}", value.dump(), array, count));
    }

    Report& report_;
    json& source_;
    const Check* outer_;
    std::string key_;
    const char* kind_ = nullptr;  // of a thing
    std::size_t index_ = 0;       // of a thing
    json clean_ = json::object();
    bool sound_ = true;
};

void check_asset(const json& document) {
    const auto asset = document.find("asset");
    if (asset == document.end() || !asset->is_object())
        throw Error("is not glTF 2.0: it has no asset object", "", "Export the level as glTF 2.0.");
    const auto check_version = [&](const char* name, std::string_view newest) {
        const auto version = asset->find(name);
        if (version == asset->end()) return false;
        const std::string text = version->is_string() ? version->get<std::string>() : "";
        const std::size_t dot = text.find('.');
        if (dot == 0 || dot + 1 >= text.size() || text.find_first_not_of("0123456789", dot + 1) != std::string::npos ||
            text.find_first_not_of("0123456789") != dot)
            throw Error(fmt::format("asset.{} is {}, not a version number", name, version->dump()));
        if (text.substr(0, dot) != "2" || text > newest)
            throw Error(fmt::format("asset.{} is {}, but only glTF 2.0 can be read", name, text), "",
                        "Export the level as glTF 2.0.");
        return true;
    };
    check_version("minVersion", "2.0");
    if (!check_version("version", "2.999"))
        throw Error("asset.version is missing", "", "Export the level as glTF 2.0.");
}

void check_texture_transform(Check& transform) {
    transform.numbers("offset", 2);
    transform.number("rotation");
    transform.numbers("scale", 2);
    transform.integer("texCoord", 0, 1000);
}

void check_texture_use(Check& use) {
    use.index("index", "textures");
    use.required("index", 0);
    use.integer("texCoord", 0, 1000);
    use.extensions({{"KHR_texture_transform", check_texture_transform}});
}

void check_accessor(Check& accessor) {
    accessor.index("bufferView", "bufferViews");
    accessor.integer("byteOffset", 0, largest_size);
    accessor.one_of("componentType", {5120, 5121, 5122, 5123, 5125, 5126});
    accessor.required("componentType", 5126);
    accessor.boolean("normalized");
    accessor.integer("count", 1, largest_size);
    accessor.required("count", 1);
    accessor.one_of("type", {"SCALAR", "VEC2", "VEC3", "VEC4", "MAT2", "MAT3", "MAT4"});
    accessor.required("type", "SCALAR");
    accessor.object("sparse", [](Check& sparse) {
        sparse.integer("count", 1, std::numeric_limits<int>::max());
        sparse.required("count", 1);
        sparse.object("indices", [](Check& indices) {
            indices.index("bufferView", "bufferViews");
            indices.required("bufferView", 0);
            indices.integer("byteOffset", 0, std::numeric_limits<int>::max());
            indices.one_of("componentType", {5121, 5123, 5125});
            indices.required("componentType", 5125);
        });
        sparse.required("indices", json::object());
        sparse.object("values", [](Check& values) {
            values.index("bufferView", "bufferViews");
            values.required("bufferView", 0);
            values.integer("byteOffset", 0, std::numeric_limits<int>::max());
        });
        sparse.required("values", json::object());
    });
    accessor.extensions();
    // Nothing reads the declared bounds, but the specification wants them for positions.
    accessor.numbers("min", 0);
    accessor.numbers("max", 0);
    if (accessor.has("byteOffset") && !accessor.has("bufferView"))
        accessor.harmless("byteOffset", "means nothing without a bufferView");
}

void check_buffer(Check& buffer) {
    buffer.text("uri");
    buffer.integer("byteLength", 1, largest_size);
    buffer.required("byteLength", 1);
    const auto fallback = [](Check& extension) { extension.boolean("fallback"); };
    buffer.extensions({{"EXT_meshopt_compression", fallback}, {"KHR_meshopt_compression", fallback}});
}

void check_meshopt(Check& compression, std::initializer_list<const char*> filters) {
    compression.index("buffer", "buffers");
    compression.required("buffer", 0);
    compression.number("byteOffset", 0, largest_size);
    compression.number("byteLength", 1, largest_size);
    compression.required("byteLength", 1);
    compression.number("byteStride", 2, 256);
    compression.required("byteStride", 4);
    compression.number("count", 1, largest_size);
    compression.required("count", 1);
    compression.one_of("mode", {"ATTRIBUTES", "TRIANGLES", "INDICES"});
    compression.required("mode", "ATTRIBUTES");
    compression.one_of("filter", filters);
}

void check_buffer_view(Check& view) {
    view.index("buffer", "buffers");
    view.required("buffer", -1);
    view.integer("byteOffset", 0, largest_size);
    view.integer("byteLength", 1, largest_size);
    view.required("byteLength", 1);
    view.integer("byteStride", 4, 252);
    if (view.clean().contains("byteStride") && view.clean()["byteStride"].get<int>() % 4 != 0)
        view.bad("byteStride", "is not a multiple of 4");
    view.one_of("target", {34962, 34963});
    view.extensions({
        {"EXT_meshopt_compression",
         [](Check& c) {
             check_meshopt(c, {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL"});
         }},
        {"KHR_meshopt_compression",
         [](Check& c) {
             check_meshopt(c, {"NONE", "OCTAHEDRAL", "QUATERNION", "EXPONENTIAL", "COLOR"});
         }},
    });
}

void check_camera(Check& camera) {
    camera.unread([](Check& c) {
        c.one_of("type", {"perspective", "orthographic"});
        c.required("type", "perspective");
        c.object("perspective", [](Check& lens) {
            lens.number("yfov", std::numeric_limits<double>::min());
            lens.required("yfov", 1);
            lens.number("znear", std::numeric_limits<double>::min());
            lens.required("znear", 1);
            lens.number("zfar", std::numeric_limits<double>::min());
            lens.number("aspectRatio", std::numeric_limits<double>::min());
            const json& clean = lens.clean();
            if (clean.contains("zfar") && clean["zfar"] <= clean["znear"]) lens.bad("", "has zfar below znear");
        });
        c.object("orthographic", [](Check& lens) {
            for (const char* name : {"xmag", "ymag"}) {
                lens.number(name);
                lens.required(name, 1);
                if (lens.clean()[name] == 0.0) lens.bad(name, "is zero");
            }
            for (const char* name : {"znear", "zfar"}) {
                lens.number(name, 0);
                lens.required(name, 1);
            }
            if (lens.clean()["zfar"] <= lens.clean()["znear"]) lens.bad("", "has zfar below znear");
        });
        if (c.has("perspective") == c.has("orthographic")) c.bad("", "needs one of perspective and orthographic");
        c.extensions();
    });
}

void check_image(Check& image) {
    image.text("uri");
    image.index("bufferView", "bufferViews");
    image.text("mimeType");
    image.extensions();
    if (image.has("uri") == image.has("bufferView")) image.bad("", "needs exactly one of uri and bufferView");
    if (image.has("bufferView") && !image.has("mimeType")) image.harmless("bufferView", "comes without a mimeType");
}

void check_material(Check& material) {
    material.object("pbrMetallicRoughness", [](Check& pbr) {
        pbr.numbers("baseColorFactor", 4);
        pbr.object("baseColorTexture", check_texture_use);
        pbr.unread([](Check& c) {
            c.number("metallicFactor", 0, 1);
            c.number("roughnessFactor", 0, 1);
            c.object("metallicRoughnessTexture", check_texture_use);
        });
    });
    material.numbers("emissiveFactor", 3);
    material.object("emissiveTexture", check_texture_use);
    material.one_of("alphaMode", {"OPAQUE", "MASK", "BLEND"});
    material.number("alphaCutoff");
    material.boolean("doubleSided");
    material.unread([](Check& c) {
        c.object("normalTexture", check_texture_use);
        c.object("occlusionTexture", check_texture_use);
    });
    material.extensions({
        {"KHR_materials_emissive_strength", [](Check& c) { c.number("emissiveStrength", 0); }},
        {"KHR_materials_transmission",
         [](Check& c) {
             c.number("transmissionFactor");
             c.object("transmissionTexture", check_texture_use);
         }},
        {"KHR_materials_pbrSpecularGlossiness",
         [](Check& c) {
             c.numbers("diffuseFactor", 4);
             c.object("diffuseTexture", check_texture_use);
         }},
        {"KHR_materials_unlit", [](Check&) {}},
        {"KHR_materials_diffuse_transmission",
         [](Check& c) {
             c.number("diffuseTransmissionFactor", 0, 1);
             c.numbers("diffuseTransmissionColorFactor", 3, 0);
         }},
        {"KHR_materials_volume", [](Check& c) { c.number("thicknessFactor"); }},
    });
}

void check_mesh(Check& mesh) {
    mesh.objects("primitives", [](Check& primitive) {
        primitive.object("attributes", [](Check& attributes) { attributes.all_indices("accessors"); });
        primitive.required("attributes", json::object());
        primitive.index("indices", "accessors");
        primitive.index("material", "materials");
        primitive.integer("mode", 0, 6);
        primitive.objects("targets", [](Check& target) { target.all_indices("accessors"); });
        primitive.extensions(
            {{"KHR_draco_mesh_compression", [](Check& draco) {
                  draco.index("bufferView", "bufferViews");
                  draco.required("bufferView", 0);
                  draco.object("attributes", [](Check& ids) { ids.all_integers(0, std::numeric_limits<int>::max()); });
                  draco.required("attributes", json::object());
              }}});
    });
    mesh.required("primitives", json::array());
    mesh.numbers("weights", 0);
    mesh.extensions();
}

/// What is wrong with the name of a group of lights: it becomes that of a layer, to be written in lists and before "=".
std::string group_name_problem(const std::string& name) {
    constexpr std::size_t longest = 64;
    for (const char* taken : {"combined", "direct", "indirect", "sky", "other", "groups", "index", "list", "validity"})
        if (name == taken) return "stands for something else in volumes: choose another name";
    const bool has_sign = std::any_of(name.begin(), name.end(), [](char c) {
        return c == ',' || c == '.' || c == '=' || static_cast<unsigned char>(c) <= ' ';
    });
    if (name.empty() || name.size() > longest || has_sign)
        return fmt::format("is no name for a group: take 1 to {} bytes without blanks, commas, dots and equals signs",
                           longest);
    return "";
}

/// {"lightgrid": "volume"}, "probe", "ignore", or {"group": "NAME"}
void check_extras(Check& extras) {
    if (!extras.has_object("lightgrid")) {
        extras.one_of("lightgrid", {"volume", "probe", "ignore"});
        return;
    }
    extras.object("lightgrid", [](Check& c) {
        if (!c.has("group")) c.bad("", "has no group");
        c.text("group", group_name_problem);
    });
}

void check_node(Check& node) {
    node.index("mesh", "meshes");
    node.index("skin", "skins");
    node.indices("children", "nodes");
    node.numbers("matrix", 16);
    node.numbers("translation", 3);
    node.numbers("rotation", 4, -1, 1);
    node.numbers("scale", 3);
    node.numbers("weights", 0);
    node.unread([](Check& c) { c.index("camera", "cameras"); });
    if (node.has("matrix") && (node.has("translation") || node.has("rotation") || node.has("scale")))
        node.bad("matrix", "stands beside translation, rotation or scale");
    if (node.has("skin") && !node.has("mesh")) node.harmless("skin", "means nothing without a mesh");
    if (node.has("weights") && !node.has("mesh")) node.harmless("weights", "mean nothing without a mesh");
    if (node.has_object("extras")) node.leniently([](Check& c) { c.object("extras", check_extras); });
    node.extensions({
        {"KHR_lights_punctual",
         [](Check& c) {
             c.index("light", "lights");
             c.required("light", 0);
         }},
        {"KHR_node_visibility", [](Check& c) { c.boolean("visible"); }},
        {"EXT_mesh_gpu_instancing",
         [](Check& c) {
             c.object("attributes", [](Check& attributes) { attributes.all_indices("accessors"); });
             c.required("attributes", json::object());
         }},
    });
}

void check_light(Check& light) {
    light.one_of("type", {"directional", "point", "spot"});
    light.required("type", "point");
    light.numbers("color", 3, 0);
    light.number("intensity", 0);
    light.number("range", std::numeric_limits<double>::min());
    constexpr double right_angle = 1.5707963267948966;
    light.object("spot", [](Check& spot) {
        spot.number("innerConeAngle", 0, right_angle);
        spot.number("outerConeAngle", 0, right_angle + 1e-6);
    });
    if (light.clean()["type"] == "spot") light.leniently([](Check& c) { c.required("spot", json::object()); });
}

void check_sampler(Check& sampler) {
    sampler.one_of("magFilter", {9728, 9729});
    sampler.unread([](Check& c) { c.one_of("minFilter", {9728, 9729, 9984, 9985, 9986, 9987}); });
    for (const char* name : {"wrapS", "wrapT"}) sampler.one_of(name, {33071, 33648, 10497});
    sampler.extensions();
}

void check_skin(Check& skin) {
    skin.indices("joints", "nodes");
    skin.required("joints", json::array());
    skin.index("inverseBindMatrices", "accessors");
    skin.unread([](Check& c) { c.index("skeleton", "nodes"); });
    skin.extensions();
}

void check_texture(Check& texture) {
    texture.index("source", "images");
    texture.index("sampler", "samplers");
    const auto other_source = [](Check& c) { c.index("source", "images"); };
    texture.extensions({{"EXT_texture_webp", other_source},
                        {"EXT_texture_avif", other_source},
                        {"KHR_texture_basisu", other_source},
                        {"MSFT_texture_dds", other_source}});
}

/// extensionsUsed or extensionsRequired: strings, each once.
std::set<std::string> check_names(Check& root, json& document, const char* name) {
    std::set<std::string> names;
    const auto found = document.find(name);
    if (found == document.end()) return names;
    if (!found->is_array()) {
        root.bad(name, "is not an array");
        return names;
    }
    if (found->empty()) root.harmless(name, "is empty");
    for (const json& element : *found) {
        if (!element.is_string())
            root.bad(name, fmt::format("holds {}, not a string", element.dump()));
        else if (!names.insert(element).second)
            root.harmless(name, fmt::format("names {} twice", element.dump()));
    }
    return names;
}

/// An accessor without data stands for zeros (or for what sparse values or a compressed mesh say). tinygltf refuses
/// some uses of it; so all of them read one view more, which has no buffer.
void give_views_to_accessors_without(json& document) {
    if (!document.contains("accessors")) return;
    json& views = document["bufferViews"];
    if (views.is_null()) views = json::array();
    const std::size_t zeros = views.size();
    views.push_back({{"buffer", -1}, {"byteLength", 0}});
    for (json& accessor : document["accessors"])
        if (!accessor.contains("bufferView")) accessor["bufferView"] = zeros;
}

}  // namespace

Findings check_structure(json& document) {
    if (!document.is_object()) throw Error("is not a glTF file: its JSON is not an object");
    check_asset(document);

    Report report;
    for (const auto& entry : document.items())
        if (entry.value().is_array()) report.counts[entry.key()] = entry.value().size();
    const json::json_pointer lights("/extensions/KHR_lights_punctual/lights");
    if (document.contains(lights) && document[lights].is_array()) report.counts["lights"] = document[lights].size();

    Check root(report, document, nullptr, "");
    report.extensions_used = check_names(root, document, "extensionsUsed");
    const std::set<std::string> required = check_names(root, document, "extensionsRequired");
    for (const std::string& name : required)
        if (!report.extensions_used.contains(name))
            root.harmless("extensionsRequired", fmt::format("names {}, which extensionsUsed does not", name));

    root.object("asset", [](Check& asset) {
        asset.text("version");
        asset.unread([](Check& c) {
            for (const char* name : {"generator", "copyright", "minVersion"}) c.text(name);
            c.extensions();
        });
    });
    root.things("accessors", "accessor", check_accessor);
    root.things("buffers", "buffer", check_buffer);
    root.things("bufferViews", "buffer view", check_buffer_view);
    root.things("cameras", "camera", check_camera);
    root.things("images", "image", check_image);
    root.things("materials", "material", check_material);
    root.things("meshes", "mesh", check_mesh);
    root.things("nodes", "node", check_node);
    root.things("samplers", "sampler", check_sampler);
    root.things("scenes", "scene", [](Check& scene) {
        scene.indices("nodes", "nodes");
        scene.extensions();
    });
    root.things("skins", "skin", check_skin);
    root.things("textures", "texture", check_texture);
    root.extensions({{"KHR_lights_punctual", [](Check& c) { c.things("lights", "light", check_light); }}});
    root.index("scene", "scenes");
    if (root.has("scene") && !root.clean().contains("scene")) report.findings.back().thing = "/scene";
    if (root.has("animations")) root.harmless("animations", "are not played: the level is baked as it stands at rest");

    document = root.take();
    document["extensionsUsed"] = report.extensions_used;
    document["extensionsRequired"] = required;
    give_views_to_accessors_without(document);
    return std::move(report.findings);
}

}  // namespace lightgrid::gltf
