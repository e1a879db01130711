#pragma once

#include "probes/paths.h"
#include "viewer/flight.h"
#include "viewer/object.h"
#include "viewer/shader.h"
#include "viewer/volume_watch.h"

#include <glm/glm.hpp>

#include <memory>
#include <optional>
#include <string>

namespace lightgrid {

struct LitVolume;

/// What is shown in a window.
struct Show {
    const PathTracer& paths;                  // with the level and its environment; must outlive the show
    std::string environment;                  // in words, for the header of what is baked
    std::shared_ptr<const LitVolume> volume;  // none: one is baked while it is shown
    std::optional<VolumeWatch> watch;         // of the file that it came from
    std::optional<Flight> flight;             // none: the default one
    std::optional<ObjectMesh> object;         // what --object names, 1 m large
    ShaderSources shaders;
    glm::ivec2 size{1280, 720};
    bool quiet = false;
};

/// Opens a window and shows it until it is closed. Throws Error: no display, no OpenGL 3.3.
void show_in_window(Show show);

}  // namespace lightgrid
