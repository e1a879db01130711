#include "probes/volume_file.h"
#include "tools/csv.h"
#include "tools/verbs.h"

#include <algorithm>
#include <numeric>
#include <tuple>

namespace lightgrid {
namespace {

// A grid's probes with x running fastest, then y, then z, whatever bricks they are stored in; then a list's rows as
// they are.
std::vector<std::size_t> stored_probes(const Volume& volume) {
    std::vector<std::size_t> slots(volume.slots());
    std::iota(slots.begin(), slots.end(), std::size_t{0});
    const auto order = [&](std::size_t slot) {
        const glm::ivec3 probe = lattice_index(volume, slot);
        return std::tuple(volume.bricks[slot / probes_per_brick].grid, probe.z, probe.y, probe.x);
    };
    std::sort(slots.begin(), slots.begin() + static_cast<std::ptrdiff_t>(volume.list_start()),
              [&](std::size_t a, std::size_t b) { return order(a) < order(b); });
    std::erase_if(slots, [&](std::size_t slot) { return volume.states[slot] == ProbeState::absent; });
    return slots;
}

}  // namespace

void run_probes(const std::string& volume_path) {
    const Volume volume = load_volume(volume_path);
    std::vector<std::string> columns{"x", "y", "z", "valid"};
    add_sh_columns(columns, 'c', volume.bands);
    add_sh_columns(columns, 'e', volume.bands);
    CsvWriter out(columns);
    for (const std::size_t slot : stored_probes(volume)) {
        out << gather_position(volume, slot) << (is_valid(volume.states[slot]) ? 1 : 0);
        for (const auto* values : {&volume.coefficients, &volume.errors}) {
            for (std::size_t i = 0; i < volume.sh_size(); ++i) out << (*values)[slot * volume.sh_size() + i];
        }
        out.end_row();
    }
    out.finish();
}

}  // namespace lightgrid
