#pragma once

// Embree, of either version that distributions ship: 3 and 4 differ in where their headers are and in how a query is
// passed its context. Private to the libraries; everything else of Embree that is used here is the same in both.

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace lightgrid::embree {

/// What a query hands to the filters of the geometries that it meets (RTCFilterFunctionNArguments::context). A type
/// that begins with it has the same address, and so its filters can know more.
#if RTC_VERSION_MAJOR >= 4
using QueryContext = RTCRayQueryContext;

inline void init(QueryContext& context) {
    rtcInitRayQueryContext(&context);
}

template <typename Arguments>
[[nodiscard]] Arguments with(QueryContext& context, void (*init_arguments)(Arguments*)) {
    Arguments arguments;
    init_arguments(&arguments);
    arguments.context = &context;
    return arguments;
}

inline void intersect(RTCScene scene, QueryContext& context, RTCRayHit& ray) {
    RTCIntersectArguments arguments = with(context, rtcInitIntersectArguments);
    rtcIntersect1(scene, &ray, &arguments);
}

inline void intersect(const int* valid, RTCScene scene, QueryContext& context, RTCRayHit8& rays) {
    RTCIntersectArguments arguments = with(context, rtcInitIntersectArguments);
    rtcIntersect8(valid, scene, &rays, &arguments);
}

inline void occluded(RTCScene scene, QueryContext& context, RTCRay& ray) {
    RTCOccludedArguments arguments = with(context, rtcInitOccludedArguments);
    rtcOccluded1(scene, &ray, &arguments);
}

inline void occluded(const int* valid, RTCScene scene, QueryContext& context, RTCRay8& rays) {
    RTCOccludedArguments arguments = with(context, rtcInitOccludedArguments);
    rtcOccluded8(valid, scene, &rays, &arguments);
}
#else
using QueryContext = RTCIntersectContext;

inline void init(QueryContext& context) {
    rtcInitIntersectContext(&context);
}

inline void intersect(RTCScene scene, QueryContext& context, RTCRayHit& ray) {
    rtcIntersect1(scene, &context, &ray);
}

inline void intersect(const int* valid, RTCScene scene, QueryContext& context, RTCRayHit8& rays) {
    rtcIntersect8(valid, scene, &context, &rays);
}

inline void occluded(RTCScene scene, QueryContext& context, RTCRay& ray) {
    rtcOccluded1(scene, &context, &ray);
}

inline void occluded(const int* valid, RTCScene scene, QueryContext& context, RTCRay8& rays) {
    rtcOccluded8(valid, scene, &context, &rays);
}
#endif

}  // namespace lightgrid::embree
