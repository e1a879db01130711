#pragma once

#include "core/environment.h"
#include "core/scene.h"
#include "core/tracer.h"
#include "probes/paths.h"

#include <utility>

namespace lightgrid {

/// A level made in memory with all that it takes to trace paths in it.
struct TracedLevel {
    Scene scene;
    Environment sky;
    Tracer tracer;
    PathTracer paths;

    explicit TracedLevel(Scene&& made, const Environment& under = {})
        : scene(std::move(made)), sky(under), tracer(scene), paths(tracer, sky) {}
};

}  // namespace lightgrid
