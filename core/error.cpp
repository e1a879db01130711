#include "core/error.h"

#include <utility>

namespace lightgrid {
namespace {

std::string compose(const std::string& problem, const std::string& where, const std::string& remedy) {
    std::string text = where.empty() ? problem : where + ": " + problem;
    if (!remedy.empty()) text += ". " + remedy;
    return text;
}

}  // namespace

Error::Error(std::string problem, std::string where, std::string remedy, Fault fault)
    : std::runtime_error(compose(problem, where, remedy)),
      problem_(std::move(problem)),
      where_(std::move(where)),
      remedy_(std::move(remedy)),
      fault_(fault) {}

Error Error::inside(const std::string& outer) const {
    return Error(problem_, where_.empty() ? outer : outer + ": " + where_, remedy_, fault_);
}

}  // namespace lightgrid
