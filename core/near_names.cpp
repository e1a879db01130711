#include "core/near_names.h"

#include <algorithm>
#include <utility>

namespace lightgrid {

std::string lower_case(std::string text) {
    for (char& c : text)
        if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
    return text;
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
    std::vector<std::vector<std::size_t>> edits(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) {
        for (std::size_t j = 0; j <= b.size(); ++j) {
            if (i == 0 || j == 0) {
                edits[i][j] = i + j;
                continue;
            }
            const std::size_t replaced = edits[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1);
            edits[i][j] = std::min({edits[i - 1][j] + 1, edits[i][j - 1] + 1, replaced});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                edits[i][j] = std::min(edits[i][j], edits[i - 2][j - 2] + 1);
        }
    }
    return edits.back().back();
}

std::vector<std::string> nearest_names(const std::string& wrong, std::vector<std::string> known, std::size_t count) {
    std::sort(known.begin(), known.end());
    known.erase(std::unique(known.begin(), known.end()), known.end());
    const std::string wanted = lower_case(wrong);
    std::vector<std::pair<std::size_t, std::string>> by_distance;
    by_distance.reserve(known.size());
    for (std::string& name : known) {
        const std::size_t distance = edit_distance(wanted, lower_case(name));
        by_distance.emplace_back(distance, std::move(name));
    }
    const std::size_t kept = std::min(count, by_distance.size());
    std::partial_sort(by_distance.begin(), by_distance.begin() + static_cast<std::ptrdiff_t>(kept), by_distance.end());
    std::vector<std::string> nearest;
    for (std::size_t i = 0; i < kept; ++i) nearest.push_back(std::move(by_distance[i].second));
    return nearest;
}

}  // namespace lightgrid
