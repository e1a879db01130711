#pragma once

#include "viewer/environment_stage.h"
#include "viewer/level_stage.h"
#include "viewer/object.h"
#include "viewer/settings.h"
#include "viewer/shader.h"

#include <glm/glm.hpp>

#include <optional>
#include <variant>

namespace lightgrid {

/// What is shown in a window.
struct Show {
    std::variant<LevelShow, EnvironmentShow> what;
    std::optional<Flight> flight;      // none: the default one
    std::optional<ObjectMesh> object;  // what --object names, 1 m large
    Session session;                   // to begin with
    ShaderSources shaders;
    glm::ivec2 size{1280, 720};
    bool quiet = false;
};

/// Opens a window and shows it until it is closed. Throws Error: no display, no OpenGL 3.3.
void show_in_window(Show show);

}  // namespace lightgrid
