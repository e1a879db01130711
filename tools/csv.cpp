#include "tools/csv.h"

#include "core/error.h"
#include "core/whole_file.h"
#include "tools/program.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <system_error>

namespace lightgrid {
namespace {

std::string_view trimmed(std::string_view text) {
    const std::size_t first = text.find_first_not_of(" \t\r");
    if (first == std::string_view::npos) return {};
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// Takes one field and its comma off the front of `line`; false: a quote is not closed, or text follows one.
bool take_field(std::string_view& line, std::string& field) {
    field.clear();
    const std::size_t first = line.find_first_not_of(" \t");
    if (first == std::string_view::npos || line[first] != '"') {
        const std::size_t comma = line.find(',');
        field = trimmed(line.substr(0, comma));
        line.remove_prefix(comma == std::string_view::npos ? line.size() : comma);
        return true;
    }
    std::size_t i = first + 1;
    for (;; ++i) {
        if (i >= line.size()) return false;
        if (line[i] != '"') {
            field += line[i];
        } else if (i + 1 < line.size() && line[i + 1] == '"') {
            field += line[i++];
        } else {
            break;
        }
    }
    line.remove_prefix(i + 1);
    const std::size_t comma = line.find(',');
    if (!trimmed(line.substr(0, comma)).empty()) return false;
    line.remove_prefix(comma == std::string_view::npos ? line.size() : comma);
    return true;
}

std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t most = 12;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i == 0 ? "" : ", ") + names[i];
    return names.size() > most ? text + ", ..." : text;
}

}  // namespace

CsvTable::CsvTable(std::string text, std::string name) : name_(std::move(name)) {
    if (text.find('\0') != std::string::npos) throw Error("is not a text file", name_, "A CSV file is needed.");
    std::string_view rest = text;
    if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
    for (std::size_t number = 1; !rest.empty(); ++number) {
        const std::size_t end = rest.find('\n');
        std::string_view line = rest.substr(0, end);
        rest.remove_prefix(end == std::string_view::npos ? rest.size() : end + 1);
        if (line.ends_with('\r')) line.remove_suffix(1);
        if (!trimmed(line).empty()) read_line(line, number);
    }
    if (columns_.empty()) throw Error("is empty", name_, "Its first line has to name the columns, as in x,y,z.");
}

void CsvTable::read_line(std::string_view line, std::size_t number) {
    const std::string where = fmt::format("{}: line {}", name_, number);
    std::vector<std::string> fields;
    for (bool more = true; more;) {
        if (!take_field(line, fields.emplace_back())) throw Error("a quote is not closed or text follows it", where);
        more = !line.empty();
        if (more) line.remove_prefix(1);  // the comma; another field follows, be it empty
    }
    if (columns_.empty()) {
        for (const std::string& field : fields) {
            if (!field.empty() && std::count(fields.begin(), fields.end(), field) > 1) {
                throw Error(fmt::format("column \"{}\" is named twice", field), where);
            }
        }
        columns_ = std::move(fields);
        return;
    }
    if (fields.size() != columns_.size()) {
        throw Error(fmt::format("{} fields, but the header names {}", fields.size(), columns_.size()), where);
    }
    std::move(fields.begin(), fields.end(), std::back_inserter(fields_));
    lines_.push_back(number);
}

std::optional<std::size_t> CsvTable::find_column(std::string_view name) const {
    const auto found = std::find(columns_.begin(), columns_.end(), name);
    if (found == columns_.end()) return std::nullopt;
    return static_cast<std::size_t>(found - columns_.begin());
}

std::size_t CsvTable::column(std::string_view name) const {
    const auto found = find_column(name);
    if (found) return *found;
    throw Error(fmt::format("has no column \"{}\", only {}", name, listed(columns_)), name_,
                "The first line has to name the columns, separated by commas.");
}

double CsvTable::number(std::size_t row, std::size_t column) const {
    const std::string& field = fields_[row * columns_.size() + column];
    const char* first = field.data();
    const char* last = first + field.size();
    if (field.size() > 1 && *first == '+' && field[1] != '-') ++first;  // from_chars knows no plus sign
    double value = 0;
    const auto [end, error] = std::from_chars(first, last, value);
    const auto fail = [&](std::string_view what) {
        return Error(fmt::format("column {}: \"{}\" {}", columns_[column], field, what), where(row));
    };
    if (error == std::errc::invalid_argument || end != last) throw fail("is not a number");
    if (error == std::errc::result_out_of_range) throw fail("is out of range");
    if (!std::isfinite(value)) throw fail("is not finite");
    return value;
}

std::string CsvTable::where(std::size_t row) const {
    return fmt::format("{}: line {}", name_, lines_[row]);
}

CsvTable read_csv(const std::string& path) {
    if (path == "-") return CsvTable(read_whole_file("/dev/stdin"), "standard input");
    return CsvTable(read_whole_file(path), path);
}

Points to_points(const CsvTable& table) {
    Points points;
    const std::size_t x = table.column("x");
    const std::size_t y = table.column("y");
    const std::size_t z = table.column("z");
    const bool has_normals = table.find_column("nx") || table.find_column("ny") || table.find_column("nz");
    const std::size_t nx = has_normals ? table.column("nx") : 0;
    const std::size_t ny = has_normals ? table.column("ny") : 0;
    const std::size_t nz = has_normals ? table.column("nz") : 0;
    for (std::size_t row = 0; row < table.rows(); ++row) {
        points.positions.emplace_back(table.number(row, x), table.number(row, y), table.number(row, z));
        if (!has_normals) continue;
        points.normals.emplace_back(table.number(row, nx), table.number(row, ny), table.number(row, nz));
        if (points.normals.back() == glm::dvec3(0)) throw Error("the normal is zero", table.where(row));
    }
    return points;
}

glm::vec3 unit_normal(glm::dvec3 normal) {
    // By the largest component first: squares of very long or short ones would not fit.
    const glm::dvec3 size = glm::abs(normal);
    return glm::normalize(normal / std::max({size.x, size.y, size.z}));
}

Points read_points(const std::string& path) {
    return to_points(read_csv(path));
}

CsvWriter::CsvWriter(const std::vector<std::string>& columns) {
    for (const std::string& column : columns) *this << column;
    end_row();
}

void CsvWriter::end_row() {
    constexpr std::size_t block = 1U << 16;
    text_ += '\n';
    row_has_field_ = false;
    if (text_.size() >= block) finish();
}

void CsvWriter::finish() {
    print(text_);
    text_.clear();
}

void add_sh_columns(std::vector<std::string>& columns, char prefix, int bands) {
    for (int i = 0; i < bands * bands; ++i) {
        for (const char c : {'r', 'g', 'b'}) columns.push_back(fmt::format("{}{}{}", prefix, i, c));
    }
}

}  // namespace lightgrid
