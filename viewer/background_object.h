#pragma once

#include "viewer/object.h"

#include <condition_variable>
#include <cstdint>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

namespace lightgrid {

/// What there is anew of an object: at first it alone, and later, or at once where that is quick, its shadows on itself.
struct ObjectNews {
    std::optional<ObjectMesh> mesh;              // to be shown from now on
    std::optional<std::vector<float>> transfer;  // self_shadowed_transfer of this mesh, or of the last that there was
};

/// Loads one object at a time beside the frame loop, and traces how it shadows itself.
class BackgroundObject {
  public:
    using Load = std::function<ObjectMesh()>;

    BackgroundObject();
    /// Stops and waits: for an object that is being loaded, to its end.
    ~BackgroundObject();
    BackgroundObject(const BackgroundObject&) = delete;
    BackgroundObject& operator=(const BackgroundObject&) = delete;

    /// Asks for an object; what was asked before is given up, and nothing of it comes any more. Does not wait.
    ///
    /// load  called from another thread
    void ask(Load load);

    /// What has come of the latest question, once; nothing where all of it was taken before. Throws, once, what loading
    /// or tracing threw. Never waits for them.
    [[nodiscard]] std::optional<ObjectNews> take();

  private:
    struct Question {
        Load load;
        std::uint64_t number = 0;
    };
    void work(const std::stop_token& stop);
    void answer(const std::stop_token& stop, const Question& question);
    /// Calls `change` unless something else has been asked for.
    void tell(const Question& question, const std::function<void()>& change);

    std::mutex mutex_;  // of all below; held for a move at most
    std::condition_variable_any asked_;
    Question question_;  // the latest; number 0: none yet
    std::optional<ObjectNews> news_;
    std::exception_ptr failure_;
    std::jthread thread_;  // last: the others must be there while it runs
};

}  // namespace lightgrid
