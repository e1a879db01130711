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
    if (first == std::string_view::npos) return text.substr(0, 0);  // still a part of it
    return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

// Takes one field off the front of `line`, up to its comma; nothing: a quote is not closed, or text follows one. A
// quote within quotes stays doubled: no number or name that anybody asks for has one.
std::optional<std::string_view> take_field(std::string_view& line) {
    const std::size_t first = line.find_first_not_of(" \t");
    const bool quoted = first != std::string_view::npos && line[first] == '"';
    std::size_t closing = first;
    while (quoted) {
        closing = line.find('"', closing + 1);
        if (closing == std::string_view::npos) return std::nullopt;
        if (closing + 1 >= line.size() || line[closing + 1] != '"') break;
        ++closing;  // two of them: a quote in the text
    }
    const std::size_t comma = std::min(line.find(',', quoted ? closing : 0), line.size());
    if (quoted && !trimmed(line.substr(closing + 1, comma - closing - 1)).empty()) return std::nullopt;
    const std::string_view field =
        quoted ? line.substr(first + 1, closing - first - 1) : trimmed(line.substr(0, comma));
    line.remove_prefix(comma);
    return field;
}

std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t most = 12;
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), most); ++i) text += (i == 0 ? "" : ", ") + names[i];
    return names.size() > most ? text + ", ..." : text;
}

}  // namespace

CsvTable::CsvTable(std::string text, std::string name) : text_(std::move(text)), name_(std::move(name)) {
    if (text_.find('\0') != std::string::npos) throw Error("is not a text file", name_, "A CSV file is needed.");
    std::string_view rest = text_;
    if (rest.starts_with("\xEF\xBB\xBF")) rest.remove_prefix(3);
    for (std::size_t number = 1; !rest.empty(); ++number) {
        const std::size_t end = std::min(rest.find('\n'), rest.size());
        const std::string_view line = rest.substr(0, end);
        rest.remove_prefix(std::min(end + 1, rest.size()));
        if (!trimmed(line).empty()) read_line(line, number);
    }
    if (columns_.empty()) throw Error("is empty", name_, "Its first line has to name the columns, as in x,y,z.");
}

void CsvTable::read_line(std::string_view line, std::size_t number) {
    const std::string where = fmt::format("{}: line {}", name_, number);
    std::vector<std::string_view> fields;
    for (bool more = true; more;) {
        const auto field = take_field(line);
        if (!field) throw Error("a quote is not closed or text follows it", where);
        fields.push_back(*field);
        more = !line.empty();
        if (more) line.remove_prefix(1);  // the comma; another field follows, be it empty
    }
    if (columns_.empty()) {
        columns_.assign(fields.begin(), fields.end());
        for (const std::string& column : columns_) {
            if (!column.empty() && std::count(columns_.begin(), columns_.end(), column) > 1) {
                throw Error(fmt::format("column \"{}\" is named twice", column), where);
            }
        }
        return;
    }
    if (fields.size() != columns_.size()) {
        throw Error(fmt::format("{} fields, but the header names {}", fields.size(), columns_.size()), where);
    }
    for (const std::string_view field : fields) {
        fields_.push_back({static_cast<std::size_t>(field.data() - text_.data()), field.size()});
    }
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
    const Field place = fields_[row * columns_.size() + column];
    const std::string_view field = std::string_view(text_).substr(place.first, place.size);
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
        // In braces, the first column that is wrong is the one complained of.
        points.positions.push_back(glm::dvec3{table.number(row, x), table.number(row, y), table.number(row, z)});
        if (!has_normals) continue;
        points.normals.push_back(glm::dvec3{table.number(row, nx), table.number(row, ny), table.number(row, nz)});
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
