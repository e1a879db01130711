#pragma once

#include "core/scene.h"

#include <glm/glm.hpp>

#include <limits>

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace lightgrid {

/// The level as Embree alone sees it: every placed triangle in one robust scene, as the tracer builds it.
class RawScene {
  public:
    explicit RawScene(const Scene& scene) : device_(rtcNewDevice(nullptr)), scene_(rtcNewScene(device_)) {
        rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
        rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
        for (const int index : scene.placed) {
            const Mesh& mesh = scene.meshes[static_cast<std::size_t>(index)];
            RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, mesh.positions.data(), 0,
                                       sizeof(glm::vec3), mesh.positions.size());
            rtcSetSharedGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, mesh.triangles.data(), 0,
                                       sizeof(glm::uvec3), mesh.triangles.size());
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(scene_, geometry);
            rtcReleaseGeometry(geometry);
        }
        rtcCommitScene(scene_);
    }
    ~RawScene() {
        rtcReleaseScene(scene_);
        rtcReleaseDevice(device_);
    }
    RawScene(const RawScene&) = delete;
    RawScene& operator=(const RawScene&) = delete;

    [[nodiscard]] bool hits(glm::vec3 origin, glm::vec3 direction) const {
        RTCRayHit query;
        query.ray = {origin.x,    origin.y,    origin.z,
                     0,           direction.x, direction.y,
                     direction.z, 0,           std::numeric_limits<float>::infinity(),
                     ~0U,         0,           0};
        query.hit.geomID = RTC_INVALID_GEOMETRY_ID;
#if RTC_VERSION_MAJOR >= 4
        rtcIntersect1(scene_, &query);
#else
        query.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        rtcIntersect1(scene_, &context, &query);
#endif
        return query.hit.geomID != RTC_INVALID_GEOMETRY_ID;
    }

  private:
    RTCDevice device_;
    RTCScene scene_;
};

}  // namespace lightgrid
