#pragma once

#include <cstddef>
#include <map>
#include <string>
#include <vector>

namespace lightgrid::gltf {

/// Something in a file that is not as glTF 2.0 prescribes. It becomes an error when a light path reads the thing that
/// it is in, and a notice when nothing does.
struct Finding {
    std::string thing;  // JSON pointer of the thing it is in, "/meshes/3"; empty: no light path reads the place at all
    std::string place;  // for people: `mesh "arch" (/meshes/3/primitives/0/indices)`
    std::string problem;  // "refers to accessor 9, but there are 7"
};

using Findings = std::vector<Finding>;

/// `mesh "arch"`, or `mesh 3` where it has no name.
[[nodiscard]] std::string name_of(const std::string& kind, std::size_t index, const std::string& name);

/// Messages for the user, one for each problem however often it occurs:
/// `mesh "arch", mesh "door" and 5 more: has no area`.
class Notices {
  public:
    void add(const std::string& place, const std::string& problem);
    /// In the order in which the problems first came up.
    [[nodiscard]] std::vector<std::string> lines() const;

  private:
    std::vector<std::string> problems_;
    std::map<std::string, std::vector<std::string>> places_;  // by problem
};

}  // namespace lightgrid::gltf
