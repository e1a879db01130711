#pragma once

#include "viewer/background_answer.h"
#include "viewer/object.h"

#include <functional>
#include <optional>
#include <vector>

namespace lightgrid {

/// What there is anew of an object: at first it alone, and later, or at once where that is quick, its shadows on itself.
struct ObjectNews {
    std::optional<ObjectMesh> mesh;              // to be shown from now on
    std::optional<std::vector<float>> transfer;  // self_shadowed_transfer of this mesh, or of the last that there was
};

/// Loads one object at a time beside the frame loop, and traces how it shadows itself. Loading is not cut short.
class BackgroundObject {
  public:
    using Load = std::function<ObjectMesh()>;

    BackgroundObject();

    /// Asks for an object; see BackgroundAnswer.
    ///
    /// load  called from another thread
    void ask(Load load) { answer_.ask(std::move(load)); }
    [[nodiscard]] std::optional<ObjectNews> take() { return answer_.take(); }

  private:
    BackgroundAnswer<Load, ObjectNews> answer_;
};

}  // namespace lightgrid
