#pragma once

#include <fmt/format.h>
#include <glm/glm.hpp>

#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lightgrid {

/// A CSV text with a header, its numbers found by column name. Commas separate; fields may stand in double quotes;
/// spaces around fields, CR LF, a byte order mark and blank lines do not matter; there are no comments.
class CsvTable {
  public:
    /// name  what messages call it. Throws Error naming line and column for a row of the wrong length, a quote that is
    /// not closed, a header that names a column twice, or what is no text.
    CsvTable(std::string text, std::string name);

    [[nodiscard]] const std::string& name() const { return name_; }
    [[nodiscard]] std::size_t rows() const { return lines_.size(); }
    [[nodiscard]] std::optional<std::size_t> find_column(std::string_view name) const;
    /// Throws Error that lists the columns there are.
    [[nodiscard]] std::size_t column(std::string_view name) const;
    /// Throws Error with line and column for what is no finite number.
    [[nodiscard]] double number(std::size_t row, std::size_t column) const;
    /// The line in the text, counted from 1.
    [[nodiscard]] std::size_t line(std::size_t row) const { return lines_[row]; }
    /// "points.csv: line 7": for errors about a row.
    [[nodiscard]] std::string where(std::size_t row) const;

  private:
    void read_line(std::string_view line, std::size_t number);

    struct Field {  // in the text, without quotes and spaces around it
        std::size_t first;
        std::size_t size;
    };
    std::string text_;
    std::string name_;
    std::vector<std::string> columns_;
    std::vector<Field> fields_;       // rows * columns
    std::vector<std::size_t> lines_;  // per row
};

/// Reads a CSV file; "-" is standard input.
[[nodiscard]] CsvTable read_csv(const std::string& path);

/// Points to evaluate, in the order of the file. normals: one for each position, not zero, of any length; empty where
/// the file has no columns nx, ny, nz.
struct Points {
    std::vector<glm::dvec3> positions;
    std::vector<glm::dvec3> normals;
};

/// Columns x, y, z and, if they are there, nx, ny, nz; others are ignored. Throws Error naming the line of a number
/// that is not finite or a normal that is zero.
[[nodiscard]] Points to_points(const CsvTable& table);
/// Of unit length; for a normal as Points has them.
[[nodiscard]] glm::vec3 unit_normal(glm::dvec3 normal);
[[nodiscard]] Points read_points(const std::string& path);

/// Writes CSV to standard output. Numbers read back to the same value: the shortest text of their own type that does.
class CsvWriter {
  public:
    explicit CsvWriter(const std::vector<std::string>& columns);

    template <typename Number>
    CsvWriter& operator<<(Number value) {
        fmt::format_to(std::back_inserter(text_), "{}{}", row_has_field_ ? "," : "", value);
        row_has_field_ = true;
        return *this;
    }
    template <glm::length_t N, typename Number, glm::qualifier Q>
    CsvWriter& operator<<(const glm::vec<N, Number, Q>& v) {
        for (glm::length_t i = 0; i < N; ++i) *this << v[i];
        return *this;
    }
    void end_row();
    /// Writes what is left; to be called at the end, because writing may fail.
    void finish();

  private:
    std::string text_;
    bool row_has_field_ = false;
};

/// Appends the names c0r, c0g, c0b, c1r ... of bands^2 colours.
void add_sh_columns(std::vector<std::string>& columns, char prefix, int bands);

}  // namespace lightgrid
