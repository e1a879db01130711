#pragma once

#include "core/embree.h"
#include "core/scene.h"

#include <limits>
#include <vector>

namespace lightgrid {

/// A level as Embree alone builds and traces it: robust scenes of medium quality, as the tracer's, and nothing besides.
class RawScene {
  public:
    /// The scene must outlive it.
    explicit RawScene(const Scene& scene) : device_(rtcNewDevice(nullptr)) {
        for (const Model& model : scene.models) models_.push_back(scene_of(scene, model.meshes));
        root_ = scene_of(scene, scene.placed);
        for (const Instance& instance : scene.instances) {
            RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
            rtcSetGeometryInstancedScene(geometry, models_[static_cast<std::size_t>(instance.model)]);
            rtcSetGeometryTransform(geometry, 0, RTC_FORMAT_FLOAT3X4_COLUMN_MAJOR, &instance.to_level);
            attach(root_, geometry);
        }
        for (RTCScene model : models_) rtcCommitScene(model);
        rtcCommitScene(root_);
    }
    ~RawScene() {
        for (RTCScene model : models_) rtcReleaseScene(model);
        rtcReleaseScene(root_);
        rtcReleaseDevice(device_);
    }
    RawScene(const RawScene&) = delete;
    RawScene& operator=(const RawScene&) = delete;

    [[nodiscard]] bool hits(glm::vec3 origin, glm::vec3 direction) const {
        constexpr float infinity = std::numeric_limits<float>::infinity();
        RTCRayHit query;
        query.ray = {origin.x, origin.y, origin.z, 0, direction.x, direction.y, direction.z, 0, infinity, ~0U, 0, 0};
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        embree::QueryContext context;
        embree::init(context);
        embree::intersect(root_, context, query);
        return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }

  private:
    static void attach(RTCScene target, RTCGeometry geometry) {
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(target, geometry);
        rtcReleaseGeometry(geometry);
    }

    RTCScene scene_of(const Scene& scene, const std::vector<int>& meshes) {
        RTCScene result = rtcNewScene(device_);
        rtcSetSceneFlags(result, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(result, RTC_BUILD_QUALITY_MEDIUM);
        for (const int index : meshes) {
            const Mesh& mesh = scene.meshes[static_cast<std::size_t>(index)];
            RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.positions.data(), 0,
                                       sizeof(glm::vec3), mesh.positions.size());
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                                       sizeof(glm::uvec3), mesh.triangles.size());
            attach(result, geometry);
        }
        return result;
    }

    RTCDevice device_;
    std::vector<RTCScene> models_;
    RTCScene root_ = nullptr;
};

}  // namespace lightgrid
