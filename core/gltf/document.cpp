#include "core/gltf/document.h"

#include "core/error.h"
#include "core/gltf/compression.h"
#include "core/gltf/links.h"
#include "core/gltf/structure.h"
#include "core/gltf/uris.h"
#include "core/whole_file.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cstring>
#include <optional>
#include <system_error>
#include <utility>

namespace lightgrid::gltf {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;

std::uint32_t little_endian_32(Bytes bytes, std::size_t offset) {
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[offset + i]) << (8 * i);
    return value;
}

bool starts_with(Bytes bytes, std::string_view text) {
    return bytes.size() >= text.size() && std::memcmp(bytes.data(), text.data(), text.size()) == 0;
}

struct Chunks {
    Bytes json;
    Bytes binary;
};

/// The chunks of a .glb file. Source: glTF 2.0, 4.4 "Binary glTF Layout".
Chunks read_chunks(Bytes file, Findings& findings) {
    const char* remedy = "Export or copy the file again.";
    if (file.size() < 12) throw Error("ends within its header", "", remedy);
    if (const std::uint32_t version = little_endian_32(file, 4); version != 2)
        throw Error(fmt::format("is of binary glTF version {}, but only 2 can be read", version), "",
                    "Export the level as glTF 2.0.");
    const std::size_t length = little_endian_32(file, 8);
    if (length > file.size())
        throw Error(fmt::format("has {} bytes, but its header says {}", file.size(), length), "", remedy);
    if (length < file.size())
        findings.push_back({"", "", fmt::format("{} bytes follow the end of the level", file.size() - length)});

    constexpr std::uint32_t json_type = 0x4E4F534A;
    constexpr std::uint32_t binary_type = 0x004E4942;
    Chunks chunks;
    bool has_binary = false;
    std::size_t offset = 12;
    for (int number = 0; offset < length; ++number) {
        const std::string where = fmt::format("chunk {} at byte {}", number, offset);
        if (length - offset < 8) throw Error("the file ends within its header", where, remedy);
        const std::size_t size = little_endian_32(file, offset);
        const std::uint32_t type = little_endian_32(file, offset + 4);
        offset += 8;
        if (size > length - offset)
            throw Error(fmt::format("has {} bytes, but only {} are left", size, length - offset), where, remedy);
        if (size % 4 != 0) throw Error(fmt::format("its size {} is no multiple of 4", size), where, remedy);
        if ((number == 0) != (type == json_type))
            throw Error(number == 0 ? "the first chunk is not JSON" : "is a second JSON chunk", where, remedy);
        if (type == binary_type) {
            if (number != 1) throw Error("binary data that does not follow the JSON chunk", where, remedy);
            has_binary = true;
            chunks.binary = file.subspan(offset, size);
        } else if (type == json_type) {
            chunks.json = file.subspan(offset, size);
        }
        offset += size;
    }
    if (chunks.json.empty()) throw Error("has no JSON", "", remedy);
    if (has_binary && chunks.binary.empty()) findings.push_back({"", "", "the binary chunk is empty"});
    return chunks;
}

json parse_json(Bytes text) {
    try {
        return json::parse(reinterpret_cast<const char*>(text.data()),
                           reinterpret_cast<const char*>(text.data() + text.size()));
    } catch (const json::exception& failure) {
        // The library's messages begin with "[json.exception.parse_error.101] ".
        std::string reason = failure.what();
        reason.erase(0, reason.find("] ") == std::string::npos ? 0 : reason.find("] ") + 2);
        throw Error("is neither binary glTF nor valid JSON: " + reason, "", "Export the level again.");
    }
}

/// Source: RFC 4648, section 4; padding may be missing.
std::optional<std::string> base64_decoded(std::string_view text) {
    static constexpr std::string_view alphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    static constexpr auto values = [] {
        std::array<int, 256> table{};
        table.fill(-1);
        for (std::size_t i = 0; i < alphabet.size(); ++i)
            table[static_cast<unsigned char>(alphabet[i])] = static_cast<int>(i);
        return table;
    }();
    while (!text.empty() && text.back() == '=') text.remove_suffix(1);
    if (text.size() % 4 == 1) return std::nullopt;
    std::string result;
    result.reserve(text.size() / 4 * 3 + 2);
    std::uint32_t bits = 0;
    for (std::size_t i = 0; i < text.size(); ++i) {
        const int value = values[static_cast<unsigned char>(text[i])];
        if (value < 0) return std::nullopt;
        bits = bits << 6 | static_cast<std::uint32_t>(value);
        // A character brings 6 bits: after the second, third and fourth of four, one more byte is whole.
        if (i % 4 != 0) result.push_back(static_cast<char>(bits >> (6 - 2 * (i % 4)) & 0xFF));
    }
    return result;
}

bool is_data_uri(std::string_view uri) {
    return uri.starts_with("data:");
}

std::string data_uri_bytes(std::string_view uri) {
    const std::size_t comma = uri.find(',');
    if (comma == std::string_view::npos) throw Error("the data URI has no comma before its data");
    const std::string_view data = uri.substr(comma + 1);
    if (!uri.substr(0, comma).ends_with(";base64")) return percent_decoded(data);
    std::optional<std::string> bytes = base64_decoded(data);
    if (!bytes) throw Error("the data URI is not valid base64");
    return *std::move(bytes);
}

std::string read_resource(const Resource& resource) {
    try {
        if (resource.file.empty()) return data_uri_bytes(resource.data_uri);
        // A level that names a device or a pipe would be read for ever.
        std::error_code ignored;
        if (fs::exists(resource.file, ignored) && !fs::is_regular_file(resource.file, ignored))
            throw Error("is not a regular file", resource.file.string(), "Name a file.");
        return read_whole_file(resource.file);
    } catch (const Error& error) {
        throw error.inside(resource.name);
    }
}

std::string text_in(const json& object, const char* name) {
    const auto found = object.find(name);
    return found == object.end() ? std::string() : found->get<std::string>();
}

}  // namespace

Document::Document(std::string file, const fs::path& folder)
    : folder_(folder.empty() ? "." : folder), file_(std::move(file)) {
    Bytes text = std::as_bytes(std::span(file_));
    binary_ = starts_with(text, "glTF");
    if (binary_) {
        const Chunks chunks = read_chunks(text, findings_);
        text = chunks.json;
        binary_chunk_ = chunks.binary;
    }
    parse(text);
    for (std::size_t i = 0; i < findings_.size(); ++i)
        if (!findings_[i].thing.empty()) broken_.emplace(findings_[i].thing, i);
}

void Document::parse(Bytes text) {
    if (starts_with(text, "\xEF\xBB\xBF")) findings_.push_back({"", "", "the JSON begins with a byte order mark"});
    json document = parse_json(text);
    const Findings structure = check_structure(document);
    findings_.insert(findings_.end(), structure.begin(), structure.end());

    for (const json& buffer : std::exchange(document["buffers"], json::array())) {
        const auto is_fallback = [&](const char* extension) {
            const json::json_pointer fallback(fmt::format("/extensions/{}/fallback", extension));
            return buffer.contains(fallback) && buffer[fallback] == true;
        };
        buffers_.push_back({resource_of("buffer", buffers_.size(), buffer), buffer["byteLength"],
                            is_fallback("EXT_meshopt_compression") || is_fallback("KHR_meshopt_compression")});
    }
    for (const json& image : std::exchange(document["images"], json::array()))
        images_.push_back({resource_of("image", images_.size(), image), image.value("bufferView", -1)});
    document.erase("cameras");

    const std::string clean = document.dump();
    std::string error;
    std::string warning;
    tinygltf::TinyGLTF parser;
    if (!parser.LoadASCIIFromString(&model_, &error, &warning, clean.data(), static_cast<unsigned>(clean.size()), "",
                                    tinygltf::NO_REQUIRE)) {
        // tinygltf ends every finding with a new line.
        throw Error("cannot be parsed: " + error.substr(0, error.find('\n')), "", "Export the level again.");
    }

    check_links(model_, buffers_, images_, findings_);
    for (std::size_t i = 0; i < buffers_.size(); ++i) buffer_data_.emplace_back();
    for (std::size_t i = 0; i < model_.bufferViews.size(); ++i) unpacked_views_.emplace_back();
    images_read_.resize(images_.size());
}

bool Document::requires_extension(const char* name) const {
    const std::vector<std::string>& names = model_.extensionsRequired;
    return std::find(names.begin(), names.end(), name) != names.end();
}

void Document::require(const std::string& pointer) const {
    const auto found = broken_.find(pointer);
    if (found == broken_.end()) return;
    const Finding& finding = findings_[found->second];
    throw Error(finding.problem, finding.place, "Export the level again, or repair the file.");
}

template <typename T>
const T& Document::get(const std::vector<T>& list, const char* array, int index) const {
    if (!broken_.empty()) require(fmt::format("{}/{}", array, index));
    return list.at(static_cast<std::size_t>(index));
}

const tinygltf::Accessor& Document::accessor(int index) const {
    return get(model_.accessors, "/accessors", index);
}
const tinygltf::BufferView& Document::view(int index) const {
    return get(model_.bufferViews, "/bufferViews", index);
}
const tinygltf::Light& Document::light(int index) const {
    return get(model_.lights, "/extensions/KHR_lights_punctual/lights", index);
}
const tinygltf::Material& Document::material(int index) const {
    return get(model_.materials, "/materials", index);
}
const tinygltf::Mesh& Document::mesh(int index) const {
    return get(model_.meshes, "/meshes", index);
}
const tinygltf::Node& Document::node(int index) const {
    return get(model_.nodes, "/nodes", index);
}
const tinygltf::Sampler& Document::sampler(int index) const {
    return get(model_.samplers, "/samplers", index);
}
const tinygltf::Scene& Document::scene(int index) const {
    return get(model_.scenes, "/scenes", index);
}
const tinygltf::Skin& Document::skin(int index) const {
    return get(model_.skins, "/skins", index);
}
const tinygltf::Texture& Document::texture(int index) const {
    return get(model_.textures, "/textures", index);
}

std::string Document::node_name(int index) const {
    const auto i = static_cast<std::size_t>(index);
    return name_of("node", i, model_.nodes.at(i).name);
}

std::string Document::mesh_name(int index) const {
    const auto i = static_cast<std::size_t>(index);
    return name_of("mesh", i, model_.meshes.at(i).name);
}

int Document::default_scene() const {
    require("/scene");
    return std::max(model_.defaultScene, 0);
}

Resource Document::resource_of(const std::string& kind, std::size_t index, const json& source) {
    Resource resource{name_of(kind, index, text_in(source, "name")), text_in(source, "uri"), {}};
    if (resource.data_uri.empty() || is_data_uri(resource.data_uri)) return resource;
    const std::string uri = std::exchange(resource.data_uri, {});
    const auto find = [&](std::string thing, std::string problem) {
        findings_.push_back({std::move(thing), resource.name, std::move(problem)});
    };
    if (is_remote(uri)) {
        find(fmt::format("/{}s/{}", kind, index), fmt::format("\"{}\" is neither a relative path nor a data URI", uri));
        return resource;
    }
    const NamedFile named = find_named_file(folder_, uri);
    resource.file = named.path;
    if (named.backslashes) find("", "its URI has backslashes, which are read as slashes");
    const std::string read = named.path.lexically_relative(folder_).string();
    if (named.elsewhere) {
        find("", fmt::format("\"{}\" does not exist; \"{}\" beside the level is read instead", uri, read));
    } else if (named.other_case) {
        find("", fmt::format("\"{}\" differs from \"{}\", which is read, in upper and lower case", uri, read));
    }
    return resource;
}

Bytes Document::buffer_bytes(int index) const {
    const BufferSource& source = get(buffers_, "/buffers", index);
    const std::string& where = source.resource.name;
    Bytes bytes;
    if (!source.resource.is_elsewhere()) {
        const auto read = [&] { return read_resource(source.resource); };
        bytes = std::as_bytes(std::span(buffer_data_[static_cast<std::size_t>(index)].get(read)));
    } else if (binary_ && index == 0) {
        bytes = binary_chunk_;
    } else {
        throw Error("has no data", where, "Export the level again.");
    }
    if (bytes.size() < source.byte_length)
        throw Error(fmt::format("has {} bytes of data, but byteLength is {}", bytes.size(), source.byte_length), where,
                    "The file is incomplete: export or copy it again.");
    return bytes.first(source.byte_length);
}

Bytes Document::bytes(int index) const {
    const tinygltf::BufferView& source = view(index);
    if (source.buffer < 0) return {};
    const tinygltf::Value* compression = find_meshopt(source);
    if (compression == nullptr) return buffer_bytes(source.buffer).subspan(source.byteOffset, source.byteLength);
    return unpacked_views_[static_cast<std::size_t>(index)].get([&] {
        const auto number = [&](const char* name) {
            return static_cast<std::size_t>(number_in(*compression, name, 0));
        };
        const Bytes packed =
            buffer_bytes(static_cast<int>(number("buffer"))).subspan(number("byteOffset"), number("byteLength"));
        try {
            return unpack_meshopt(packed, *compression, source.byteLength);
        } catch (const Error& error) {
            throw error.inside(name_of("buffer view", static_cast<std::size_t>(index), source.name));
        }
    });
}

ByteImage Document::image(int index) const {
    const ImageSource& source = get(images_, "/images", index);
    images_read_[static_cast<std::size_t>(index)] = 1;
    const std::string data = source.buffer_view < 0 ? read_resource(source.resource) : std::string();
    try {
        return decode_image(source.buffer_view < 0 ? std::as_bytes(std::span(data)) : bytes(source.buffer_view),
                            source.resource.file.string());
    } catch (const Error& error) {
        throw error.inside(source.resource.name);
    }
}

std::size_t Document::encoded_bytes(const ImageSource& image) const {
    if (image.buffer_view >= 0) return model_.bufferViews[static_cast<std::size_t>(image.buffer_view)].byteLength;
    if (!image.resource.data_uri.empty()) return image.resource.data_uri.size() / 4 * 3;
    std::error_code ignored;
    const std::uintmax_t size = fs::file_size(image.resource.file, ignored);
    return ignored ? 0 : static_cast<std::size_t>(size);
}

Findings Document::check_unread() const {
    Findings findings;
    const auto check = [&](const char* array, std::size_t index, const Resource& resource, auto&& verify) {
        if (broken_.contains(fmt::format("/{}/{}", array, index))) return;  // a finding already
        try {
            std::error_code ignored;
            if (resource.file.empty())
                verify();
            else if (!fs::exists(resource.file, ignored))
                throw Error(fmt::format("\"{}\" does not exist", resource.file.lexically_relative(folder_).string()));
        } catch (const Error& error) {
            findings.push_back({"", resource.name, error.problem()});
        }
    };
    for (std::size_t i = 0; i < buffers_.size(); ++i)
        if (!buffer_data_[i].made() && !buffers_[i].placeholder)
            check("buffers", i, buffers_[i].resource, [&] { static_cast<void>(buffer_bytes(static_cast<int>(i))); });
    for (std::size_t i = 0; i < images_.size(); ++i)
        if (!was_read(i) && images_[i].buffer_view < 0)
            check("images", i, images_[i].resource,
                  [&] { static_cast<void>(data_uri_bytes(images_[i].resource.data_uri)); });
    return findings;
}

double number_in(const tinygltf::Value& object, const char* name, double fallback) {
    return object.Has(name) ? object.Get(name).GetNumberAsDouble() : fallback;
}

const tinygltf::Value* find_extension(const tinygltf::ExtensionMap& extensions, const char* name) {
    const auto found = extensions.find(name);
    return found == extensions.end() ? nullptr : &found->second;
}

const tinygltf::Value* find_meshopt(const tinygltf::BufferView& view) {
    const tinygltf::Value* packed = find_extension(view.extensions, "KHR_meshopt_compression");
    return packed != nullptr ? packed : find_extension(view.extensions, "EXT_meshopt_compression");
}

}  // namespace lightgrid::gltf
