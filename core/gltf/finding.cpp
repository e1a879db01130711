#include "core/gltf/finding.h"

#include <fmt/format.h>

namespace lightgrid::gltf {

std::string name_of(const std::string& kind, std::size_t index, const std::string& name) {
    return name.empty() ? fmt::format("{} {}", kind, index) : fmt::format("{} \"{}\"", kind, name);
}

void Notices::add(const std::string& place, const std::string& problem) {
    std::vector<std::string>& places = places_[problem];
    if (places.empty()) problems_.push_back(problem);
    places.push_back(place);
}

std::vector<std::string> Notices::lines() const {
    constexpr std::size_t most_names = 3;
    std::vector<std::string> result;
    for (const std::string& problem : problems_) {
        const std::vector<std::string>& places = places_.at(problem);
        std::string names;
        for (std::size_t i = 0; i < places.size() && i < most_names; ++i)
            names.append(i == 0 || places[i].empty() ? "" : ", ").append(places[i]);
        if (places.size() > most_names) names += fmt::format(" and {} more", places.size() - most_names);
        result.push_back(names.empty() ? problem : fmt::format("{}: {}", names, problem));
    }
    return result;
}

}  // namespace lightgrid::gltf
