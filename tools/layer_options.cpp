#include "tools/layer_options.h"

#include "core/environment_file.h"
#include "core/environment_sh.h"
#include "core/error.h"
#include "tools/light_options.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

namespace lightgrid {
namespace {

/// {"lamps", "2"}, {"signs", "1,0.5,0"}: numbers behind a comma belong to the name before them.
std::vector<std::pair<std::string, std::string>> split(const std::string& text) {
    std::vector<std::pair<std::string, std::string>> entries;
    for (std::size_t begin = 0; begin <= text.size();) {
        const std::size_t end = std::min(text.find(',', begin), text.size());
        const std::string piece = text.substr(begin, end - begin);
        begin = end + 1;
        const std::size_t equals = piece.find('=');
        if (equals != std::string::npos) {
            entries.emplace_back(piece.substr(0, equals), piece.substr(equals + 1));
        } else if (!entries.empty()) {
            entries.back().second += "," + piece;
        } else {
            throw Error(fmt::format("\"{}\" is no list of layers and weights, like lamps=2,signs=1,0.5,0", text));
        }
    }
    return entries;
}

std::size_t number_count(const std::string& value) {
    return static_cast<std::size_t>(std::count(value.begin(), value.end(), ',')) + 1;
}

glm::vec3 parse_weight(const std::string& value) {
    const std::vector<double> numbers = parse_numbers(value, number_count(value) == 1 ? 1 : 3, "1,0.5,0");
    return numbers.size() == 1 ? glm::vec3(numbers[0]) : glm::vec3(numbers[0], numbers[1], numbers[2]);
}

Environment parse_sky(const std::string& value) {
    std::error_code not_there;
    if (std::filesystem::exists(value, not_there)) return load_environment(value).environment;
    try {
        return Environment::uniform(parse_weight(value));
    } catch (const Error& error) {
        throw Error(fmt::format("sky={} is neither a file that there is nor radiance: {}", value, error.problem()));
    }
}

std::string names_of(const Volume& volume) {
    std::vector<std::string> names;
    if (has_sky_layers(volume)) names.emplace_back("sky");
    for (const Layer& layer : volume.layers) names.push_back(layer.name);
    return fmt::format("{}", fmt::join(names, ", "));
}

}  // namespace

std::vector<glm::vec3> parse_layer_weights(const std::string& text, const Volume& volume) {
    if (volume.layers.empty()) throw Error("the volume has no layers", "", "Bake it with level-bake --layers.");
    std::vector<glm::vec3> weights(volume.layers.size(), glm::vec3(0));
    std::set<std::string> given;
    for (const auto& [name, value] : split(text)) {
        if (!given.insert(name).second) throw Error(fmt::format("layer {} is given twice", name));
        if (name == "sky" && has_sky_layers(volume)) {
            set_sky(volume, project_environment(parse_sky(value), sky_layer_bands), weights);
        } else if (const std::optional<std::size_t> layer = find_layer(volume, name)) {
            weights[*layer] += parse_weight(value);
        } else {
            throw Error(fmt::format("there is no layer \"{}\"", name), "",
                        fmt::format("Choose among: {}.", names_of(volume)));
        }
    }
    return weights;
}

}  // namespace lightgrid
