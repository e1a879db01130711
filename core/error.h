#pragma once

#include <stdexcept>
#include <string>

namespace lightgrid {

/// Who has to act: decides the exit status of the programs (design: 1 the work failed, 2 the call or an input was
/// wrong).
enum class Fault { work = 1, input = 2 };

/// The one exception of the library. `what()` reads "where: problem. remedy", with empty parts left out.
///
/// problem  what is wrong, with the offending value: "index 912, but only 880 vertices"
/// where    file, then the place inside it: "hall.glb: mesh \"arch\", accessor 7"
/// remedy   what the user can do about it, a full sentence: "Re-export the mesh."
class Error : public std::runtime_error {
  public:
    explicit Error(std::string problem, std::string where = {}, std::string remedy = {}, Fault fault = Fault::input);

    [[nodiscard]] const std::string& problem() const noexcept { return problem_; }
    [[nodiscard]] const std::string& where() const noexcept { return where_; }
    [[nodiscard]] const std::string& remedy() const noexcept { return remedy_; }
    [[nodiscard]] Fault fault() const noexcept { return fault_; }

    /// The same error, seen from further out: `outer` is put before `where`.
    [[nodiscard]] Error inside(const std::string& outer) const;

  private:
    std::string problem_;
    std::string where_;
    std::string remedy_;
    Fault fault_;
};

}  // namespace lightgrid
