#include "core/gltf/compression.h"

#include "core/error.h"

#include <draco/compression/decode.h>
#include <fmt/format.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <stdexcept>
#include <type_traits>

namespace lightgrid::gltf {
namespace {

const char* const export_again = "Export the level again, or without compression.";

/// The glTF component type of Draco's, or -1 where glTF has none like it.
int component_type_of(draco::DataType type) {
    switch (type) {
        case draco::DT_INT8:
            return TINYGLTF_COMPONENT_TYPE_BYTE;
        case draco::DT_UINT8:
            return TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE;
        case draco::DT_INT16:
            return TINYGLTF_COMPONENT_TYPE_SHORT;
        case draco::DT_UINT16:
            return TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
        case draco::DT_UINT32:
            return TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
        case draco::DT_FLOAT32:
            return TINYGLTF_COMPONENT_TYPE_FLOAT;
        default:
            return -1;
    }
}

/// RGBA of Y, Co, Cg and alpha with K bits each, in place. K is where the highest bit of alpha's number stands.
///
/// Source: KHR_meshopt_compression, appendix B, filter 4. Unsigned is the type of one component.
template <typename Unsigned>
void decode_colors(OwnedBytes& colors, std::size_t count) {
    using Signed = std::make_signed_t<Unsigned>;
    constexpr float most = std::numeric_limits<Unsigned>::max();
    for (std::size_t i = 0; i < count; ++i) {
        std::array<Unsigned, 4> packed;
        std::memcpy(packed.data(), colors.data() + i * sizeof(packed), sizeof(packed));
        const int y = packed[0];
        const int co = static_cast<Signed>(packed[1]);
        const int cg = static_cast<Signed>(packed[2]);
        const int full = (1 << std::bit_width(packed[3])) - 1;
        const int alpha = packed[3] & (full >> 1);
        const std::array<int, 4> rgba{y + co - cg, y + cg, y - co - cg, alpha << 1 | (alpha & 1)};
        std::array<Unsigned, 4> decoded;
        for (std::size_t k = 0; k < 4; ++k) {
            const float value = full == 0 ? 0 : static_cast<float>(rgba[k]) * most / static_cast<float>(full);
            decoded[k] = static_cast<Unsigned>(std::lround(std::clamp(value, 0.0F, most)));
        }
        std::memcpy(colors.data() + i * sizeof(decoded), decoded.data(), sizeof(decoded));
    }
}

std::unique_ptr<draco::Mesh> decode_draco(Bytes packed) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(packed.data()), packed.size());
    draco::Decoder decoder;
    try {
        auto decoded = decoder.DecodeMeshFromBuffer(&buffer);
        if (!decoded.ok())
            throw Error(fmt::format("Draco data is broken: {}", decoded.status().error_msg_string()), "", export_again);
        return std::move(decoded).value();
    } catch (const std::bad_alloc&) {
        throw Error("Draco data is broken: it asks for more memory than there is", "", export_again);
    } catch (const std::length_error&) {
        throw Error("Draco data is broken: it asks for more memory than there can be", "", export_again);
    }
}

DracoMesh::Attribute read_attribute(const draco::Mesh& mesh, const std::string& name, int id) {
    const draco::PointAttribute* source = mesh.GetAttributeByUniqueId(static_cast<std::uint32_t>(id));
    if (source == nullptr) throw Error(fmt::format("Draco data has no attribute {}", id), name, export_again);
    DracoMesh::Attribute attribute;
    attribute.component_type = component_type_of(source->data_type());
    attribute.components = source->num_components();
    if (attribute.component_type < 0)
        throw Error("Draco data is of a type that glTF does not have", name, export_again);
    const auto size = static_cast<std::size_t>(draco::DataTypeLength(source->data_type())) *
                      static_cast<std::size_t>(source->num_components());
    attribute.data.resize(mesh.num_points() * size);
    for (draco::PointIndex point(0); point < mesh.num_points(); ++point) {
        const draco::AttributeValueIndex value = source->mapped_index(point);
        if (value.value() >= source->size())
            throw Error("Draco data is broken: a vertex has no value", name, export_again);
        std::memcpy(attribute.data.data() + point.value() * size, source->GetAddress(value), size);
    }
    return attribute;
}

}  // namespace

OwnedBytes unpack_meshopt(Bytes packed, const tinygltf::Value& extension, std::size_t size) {
    const auto count = static_cast<std::size_t>(number_in(extension, "count", 0));
    const auto stride = static_cast<std::size_t>(number_in(extension, "byteStride", 0));
    const auto text = [&](const char* name) {
        return extension.Has(name) ? extension.Get(name).Get<std::string>() : std::string();
    };
    const std::string mode = text("mode");
    const std::string filter = text("filter");
    const auto refuse = [&](const std::string& problem) {
        throw Error("meshopt compression: " + problem, "", export_again);
    };
    // The tightest encoding spends 2 bits on 16 bytes: more cannot be in it, whatever the file says.
    if (size / 64 > packed.size()) refuse(fmt::format("{} bytes cannot hold {}", packed.size(), size));

    const auto* source = reinterpret_cast<const unsigned char*>(packed.data());
    OwnedBytes result(size);
    int status = 0;
    if (mode == "ATTRIBUTES") {
        if (stride % 4 != 0) refuse(fmt::format("a stride of {} bytes is no multiple of 4", stride));
        status = meshopt_decodeVertexBuffer(result.data(), count, stride, source, packed.size());
    } else {
        if (stride != 2 && stride != 4) refuse(fmt::format("indices cannot have {} bytes", stride));
        if (mode == "TRIANGLES" && count % 3 != 0) refuse(fmt::format("{} indices are no triangles", count));
        status = mode == "TRIANGLES" ? meshopt_decodeIndexBuffer(result.data(), count, stride, source, packed.size())
                                     : meshopt_decodeIndexSequence(result.data(), count, stride, source, packed.size());
    }
    constexpr std::byte version_1{0xa1};
    if (status != 0 && mode == "ATTRIBUTES" && packed[0] == version_1)
        throw Error(fmt::format("KHR_meshopt_compression: its attributes are packed by version 1 of the format, which "
                                "meshoptimizer {}.{} cannot read",
                                MESHOPTIMIZER_VERSION / 1000, MESHOPTIMIZER_VERSION / 10 % 100),
                    "", "Pack the level by EXT_meshopt_compression (gltfpack -cc), or not at all.");
    if (status != 0) refuse(fmt::format("its data is broken ({})", status));

    if (filter == "OCTAHEDRAL") {
        if (stride != 4 && stride != 8) refuse(fmt::format("the octahedral filter cannot have {} bytes", stride));
        meshopt_decodeFilterOct(result.data(), count, stride);
    } else if (filter == "QUATERNION") {
        if (stride != 8) refuse(fmt::format("the quaternion filter cannot have {} bytes", stride));
        meshopt_decodeFilterQuat(result.data(), count, stride);
    } else if (filter == "EXPONENTIAL") {
        if (stride % 4 != 0) refuse(fmt::format("the exponential filter cannot have {} bytes", stride));
        meshopt_decodeFilterExp(result.data(), count, stride);
    } else if (filter == "COLOR") {
        if (stride != 4 && stride != 8) refuse(fmt::format("the colour filter cannot have {} bytes", stride));
        stride == 4 ? decode_colors<std::uint8_t>(result, count) : decode_colors<std::uint16_t>(result, count);
    }
    return result;
}

DracoMesh unpack_draco(Bytes packed, const std::map<std::string, int>& wanted) {
    const std::unique_ptr<draco::Mesh> mesh = decode_draco(packed);
    DracoMesh result;
    result.vertex_count = mesh->num_points();
    result.indices.reserve(std::size_t{3} * mesh->num_faces());
    for (draco::FaceIndex face(0); face < mesh->num_faces(); ++face)
        for (const draco::PointIndex& corner : mesh->face(face)) result.indices.push_back(corner.value());
    for (const auto& [name, id] : wanted) result.attributes.emplace(name, read_attribute(*mesh, name, id));
    return result;
}

}  // namespace lightgrid::gltf
