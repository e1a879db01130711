#include "core/environment.h"

#include "core/error.h"
#include "core/hash.h"
#include "core/sampling.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

namespace lightgrid {
namespace {

constexpr float pi = std::numbers::pi_v<float>;
constexpr float uniform_pdf = 1 / (4 * pi);
constexpr double brightest_power = 1e25;  // cd/m^2 sr; keeps sums over a row of pixels at a pole finite in float
constexpr double faintest_power = 1e-25;  // far below, 1 / power would overflow: taken as black

bool is_valid(glm::vec3 radiance) {
    for (int i = 0; i < 3; ++i)
        if (!(std::isfinite(radiance[i]) && radiance[i] >= 0)) return false;
    return true;
}

Error bad_radiance(glm::vec3 radiance, const std::string& where) {
    return Error(fmt::format("radiance is {}, {}, {}", radiance.r, radiance.g, radiance.b), where,
                 "It has to be finite and not negative.");
}

/// Draws from the density (1 - x) a + x b on [0, 1], up to scale; a, b >= 0, not both 0. Written so that it neither
/// cancels nor overflows.
float sample_linear(float a, float b, float u) {
    const float p = a / (a + b);
    const float q = b / (a + b);
    const float denominator = p + std::sqrt(p * p * (1 - u) + q * q * u);
    return denominator > 0 ? std::min(u / denominator, 1.0F) : 0;
}

/// A quarter as many buckets as intervals leaves a few neighbours to search, which share a cache line.
int bucket_count(int intervals) {
    return (intervals + 3) / 4;
}

/// Cut points of a distribution function (Chen and Asau, "On Generating Random Variates from an Empirical
/// Distribution", 1974): guide[b] is the last interval that begins at or below b / bucket_count of the total, and the
/// last entry is the last interval, so that the interval of a share within bucket b lies between guide[b] and guide[b +
/// 1].
///
/// cumulative  of i in [0, intervals]: non-decreasing, 0 at 0
template <typename Cumulative>
void make_guide(int intervals, Cumulative cumulative, std::uint32_t* guide) {
    const int buckets = bucket_count(intervals);
    const double total = cumulative(intervals);
    int interval = 0;
    for (int b = 0; b < buckets; ++b) {
        while (interval + 1 < intervals && cumulative(interval + 1) <= total * b / buckets) ++interval;
        guide[b] = static_cast<std::uint32_t>(interval);
    }
    guide[buckets] = static_cast<std::uint32_t>(intervals - 1);
}

/// Bounds of an interval, both within reach.
struct Bracket {
    int first = 0;
    int last = 0;
};

Bracket look_up_guide(const std::uint32_t* guide, int intervals, float u) {
    const int buckets = bucket_count(intervals);
    const int b = std::min(static_cast<int>(u * static_cast<float>(buckets)), buckets - 1);
    return {static_cast<int>(guide[b]), static_cast<int>(guide[b + 1])};
}

struct Interval {
    int index = 0;
    float fraction = 0;  // in [0, 1]
};

/// The interval that holds the share u in [0, 1) of the total, and where in it; known to within rounding by `bracket`.
template <typename Cumulative>
Interval find_interval(int intervals, float u, Cumulative cumulative, Bracket bracket) {
    const float x = std::min(u, 0x1.fffffcp-1F) * cumulative(intervals);  // below the total: in an interval not empty
    int i = bracket.first;
    for (int count = bracket.last - bracket.first + 1; count > 1;) {
        const int half = count / 2;
        if (cumulative(i + half) <= x) i += half;
        count -= half;
    }
    while (i > 0 && cumulative(i) > x) --i;
    while (i + 1 < intervals && cumulative(i + 1) <= x) ++i;
    const float length = cumulative(i + 1) - cumulative(i);
    return {i, length > 0 ? (x - cumulative(i)) / length : 0};  // 0 only where the total is
}

/// atan2 within 4e-7 rad, several times as fast as the exact one; 0 at the origin. Polynomial of degree 15 on [0, 1] by
/// Remez' algorithm, summed pairwise for short dependency chains.
float fast_atan2(float y, float x) {
    const float ax = std::abs(x);
    const float ay = std::abs(y);
    const float larger = std::max(ax, ay);
    const float a = larger > 0 ? std::min(ax, ay) / larger : 0;
    const float s = a * a;
    const float s2 = s * s;
    const float low = (0.99999959F + s * -0.33330508F) + s2 * (0.19952198F + s * -0.13931889F);
    const float high = (0.09693543F + s * -0.05653477F) + s2 * (0.02225369F + s * -0.00415384F);
    float angle = a * (low + s2 * s2 * high);
    if (ay > ax) angle = 0.5F * pi - angle;
    if (x < 0) angle = pi - angle;
    return std::copysign(angle, y);
}

/// The sun of an environment that is turned (radians, as from_image) and scaled.
SunDisc placed(SunDisc sun, double rotation, float scale) {
    if (!is_valid(sun.radiance)) throw bad_radiance(sun.radiance, "environment, sun");
    if (!(sun.angular_radius > 0 && sun.angular_radius <= pi / 2))
        throw Error(fmt::format("the angular radius is {} rad", sun.angular_radius), "environment, sun",
                    "It has to be above 0 and at most pi/2.");
    const glm::dvec3 d = glm::normalize(glm::dvec3(sun.direction));
    const double cosine = std::cos(rotation);
    const double sine = std::sin(rotation);
    sun.direction = glm::vec3(cosine * d.x + sine * d.z, d.y, cosine * d.z - sine * d.x);
    sun.radiance *= scale;
    return sun;
}

/// Not 0, which is that of what is uniform.
std::uint64_t shape_of(const RadianceImage& image, float rotation_deg, const std::optional<SunDisc>& sun) {
    const std::array<int, 2> size{image.width, image.height};
    std::uint64_t shape = hash_bytes(std::as_bytes(std::span(size)), 1);
    shape = hash_bytes(std::as_bytes(std::span(image.pixels)), shape);
    shape = hash_bytes(std::as_bytes(std::span(&rotation_deg, 1)), shape);
    if (sun) {
        const std::array<float, 7> disc{sun->direction.x, sun->direction.y, sun->direction.z, sun->angular_radius,
                                        sun->radiance.x,  sun->radiance.y,  sun->radiance.z};
        shape = hash_bytes(std::as_bytes(std::span(disc)), shape);
    }
    return shape | 1U;
}

float mix(float a, float b, float t) {
    return a * (1 - t) + b * t;
}

}  // namespace

double SunDisc::solid_angle() const {
    const double sine = std::sin(0.5 * angular_radius);
    return 4 * std::numbers::pi * sine * sine;
}

Environment Environment::uniform(glm::vec3 radiance) {
    if (!is_valid(radiance)) throw bad_radiance(radiance, "sky");
    Environment environment;
    environment.uniform_ = radiance;
    environment.scale_ = radiance;
    return environment;
}

Environment Environment::from_image(RadianceImage image, float rotation_deg, float scale, std::optional<SunDisc> sun) {
    if (image.width < 1 || image.height < 1 ||
        image.pixels.size() != static_cast<std::size_t>(image.width) * image.height)
        throw Error(fmt::format("an image of {} x {} with {} pixels", image.width, image.height, image.pixels.size()),
                    "environment");
    if (!(std::isfinite(scale) && scale >= 0))
        throw Error(fmt::format("the intensity is {}", scale), "environment", "It has to be finite and not negative.");
    if (!std::isfinite(rotation_deg))
        throw Error(fmt::format("the rotation is {} degrees", rotation_deg), "environment", "It has to be finite.");
    const std::uint64_t shape = shape_of(image, rotation_deg, sun);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            glm::vec3& pixel = image.at(x, y);
            if (!is_valid(pixel)) throw bad_radiance(pixel, fmt::format("environment, pixel {}, {}", x, y));
            pixel *= scale;
        }
    }
    const double rotation = std::remainder(static_cast<double>(rotation_deg), 360.0) * std::numbers::pi / 180;
    if (sun) *sun = placed(*sun, rotation, scale);
    const double sun_power = sun ? luminance(sun->radiance) * sun->solid_angle() : 0;
    if (sun_power == 0 && std::all_of(image.pixels.begin(), image.pixels.end(),
                                      [&](glm::vec3 pixel) { return pixel == image.pixels.front(); }))
        return uniform(image.pixels.front());

    Environment environment;
    environment.shape_ = shape;
    environment.scale_ = glm::vec3(scale);
    environment.image_ = std::move(image);
    const double image_power = environment.tabulate();
    const double power = image_power + sun_power;
    if (!(power <= brightest_power))
        throw Error(fmt::format("its radiance adds up to {:g} cd/m^2 sr", power), "environment",
                    fmt::format("Scale it down: at most {:g} can be computed with.", brightest_power));
    if (power < faintest_power) return {};

    const int width = environment.image_.width;
    environment.inverse_power_ = static_cast<float>(1 / power);
    environment.columns_per_radian_ = static_cast<float>(width / (2 * std::numbers::pi));
    environment.first_column_ = static_cast<float>(0.5 * width - 0.5 + width * rotation / (2 * std::numbers::pi));
    if (sun_power > 0) {
        environment.sun_ = *sun;
        environment.sun_chord_squared_ = static_cast<float>(sun->solid_angle() / std::numbers::pi);
        environment.sun_share_ = static_cast<float>(sun_power / power);
    }
    return environment;
}

double Environment::tabulate() {
    const int width = image_.width;
    const int height = image_.height;

    // Integrals along the rows of pixels, from centre to centre.
    std::vector<double> row_sums(height);
    column_sums_.reserve(static_cast<std::size_t>(width + 1) * height);
    column_guides_.resize(static_cast<std::size_t>(bucket_count(width) + 1) * height);
    for (int y = 0; y < height; ++y) {
        const std::size_t first = column_sums_.size();
        double sum = 0;
        column_sums_.push_back(0);
        for (int x = 0; x < width; ++x) {
            const int right = x + 1 == width ? 0 : x + 1;
            sum += 0.5 * (static_cast<double>(luminance(image_.at(x, y))) + luminance(image_.at(right, y)));
            column_sums_.push_back(static_cast<float>(sum));
        }
        row_sums[y] = sum;
        make_guide(
            width, [&](int i) { return column_sums_[first + i]; },
            column_guides_.data() + static_cast<std::size_t>(bucket_count(width) + 1) * y);
    }

    // Rows of cells, between the centres of pixel row - 1 and row, or a pole.
    double power = 0;
    rows_.reserve(height + 1);
    for (int row = 0; row <= height; ++row) {
        const auto depth_of = [&](double pixels_from_top) {
            const double angle =
                std::numbers::pi * std::clamp(pixels_from_top, 0.0, static_cast<double>(height)) / height;
            const double sine = std::sin(0.5 * (2 * row <= height ? angle : std::numbers::pi - angle));
            return 2 * sine * sine;
        };
        const double depth_above = depth_of(row - 0.5);
        const double depth_below = depth_of(row + 0.5);
        const double sum_above = row_sums[std::max(row - 1, 0)];
        const double sum_below = row_sums[std::min(row, height - 1)];
        rows_.push_back({static_cast<float>(depth_above), static_cast<float>(depth_below), static_cast<float>(power),
                         static_cast<float>(sum_above), static_cast<float>(sum_below)});
        const double cell_size = 2 * std::numbers::pi / width * std::abs(depth_below - depth_above);
        power += cell_size * 0.5 * (sum_above + sum_below);
    }
    image_power_ = static_cast<float>(power);
    row_guide_.resize(bucket_count(height + 1) + 1);
    make_guide(
        height + 1, [&](int i) { return i > height ? image_power_ : rows_[i].cumulative; }, row_guide_.data());
    return power;
}

bool Environment::is_black() const noexcept {
    return rows_.empty() && uniform_ == glm::vec3(0);
}

bool Environment::is_uniform() const noexcept {
    return rows_.empty();
}

bool Environment::in_sun(glm::vec3 direction) const noexcept {
    // By chord, not by cosine: the cosine of half a degree has only 17 bits left that differ from 1.
    const glm::vec3 chord = direction - sun_.direction;
    return glm::dot(chord, chord) <= sun_chord_squared_;
}

Environment::Place Environment::place_of(glm::vec3 direction) const noexcept {
    const int width = image_.width;
    const int height = image_.height;
    const float from_axis_squared = direction.x * direction.x + direction.z * direction.z;
    const float from_axis = std::sqrt(from_axis_squared);

    Place place;
    float column = fast_atan2(direction.z, direction.x) * columns_per_radian_ + first_column_;
    const float columns = static_cast<float>(width);
    column += column < 0 ? columns : column >= columns ? -columns : 0.0F;  // the rotation is at most half a turn
    place.left = std::clamp(static_cast<int>(column), 0, width - 1);       // rounding can reach the width
    place.right = place.left + 1 == width ? 0 : place.left + 1;
    place.x = std::min(column - static_cast<float>(place.left), 1.0F);

    const float row_coordinate = fast_atan2(from_axis, direction.y) * (static_cast<float>(height) / pi) + 0.5F;
    const int row = std::clamp(static_cast<int>(row_coordinate), 0, height);
    place.above = std::max(row - 1, 0);
    place.below = std::min(row, height - 1);
    place.y = std::clamp(row_coordinate - static_cast<float>(row), 0.0F, 1.0F);

    const CellRow& cells = rows_[row];
    const float height_above_equator = 2 * row <= height ? direction.y : -direction.y;
    const float depth =
        height_above_equator > 0 ? from_axis_squared / (1 + height_above_equator) : 1 - height_above_equator;
    place.depth = std::clamp((depth - cells.depth_above) / (cells.depth_below - cells.depth_above), 0.0F, 1.0F);
    return place;
}

Environment::Sample Environment::look_up(glm::vec3 direction) const noexcept {
    if (is_uniform()) return {direction, uniform_, is_black() ? 0 : uniform_pdf};
    const Place place = place_of(direction);
    const auto in_row = [&](int row) {
        return glm::mix(image_.at(place.left, row), image_.at(place.right, row), place.x);
    };
    const glm::vec3 above = in_row(place.above);
    const glm::vec3 below = in_row(place.below);
    Sample sample{direction, glm::mix(above, below, place.y),
                  mix(luminance(above), luminance(below), place.depth) * inverse_power_};
    if (in_sun(direction)) {
        sample.radiance += sun_.radiance;
        sample.pdf += luminance(sun_.radiance) * inverse_power_;
    }
    return sample;
}

glm::vec3 Environment::radiance(glm::vec3 direction) const noexcept {
    return look_up(direction).radiance;
}

float Environment::pdf(glm::vec3 direction) const noexcept {
    return look_up(direction).pdf;
}

/// Inverts the distribution function of the bilinear luminance, first from row to row, then along the row: what lies
/// between two rows of pixels at depth t is their mixture, and has the mixture of their sums as distribution function.
glm::vec3 Environment::image_direction(glm::vec2 u) const noexcept {
    const int width = image_.width;
    const int height = image_.height;

    const auto power_above = [&](int i) { return i > height ? image_power_ : rows_[i].cumulative; };
    const Interval in_rows =
        find_interval(height + 1, u.x, power_above, look_up_guide(row_guide_.data(), height + 1, u.x));
    const CellRow& cells = rows_[in_rows.index];
    const int above = std::max(in_rows.index - 1, 0);
    const int below = std::min(in_rows.index, height - 1);
    const float t = sample_linear(cells.sum_above, cells.sum_below, in_rows.fraction);

    const auto sums = [&](int row) { return column_sums_.data() + static_cast<std::size_t>(row) * (width + 1); };
    const auto guide = [&](int row) {
        return look_up_guide(column_guides_.data() + static_cast<std::size_t>(row) * (bucket_count(width) + 1), width,
                             u.y);
    };
    const auto sum_left_of = [&, sums_above = sums(above), sums_below = sums(below)](int i) {
        return mix(sums_above[i], sums_below[i], t);
    };
    // A quantile of a mixture lies between those of its parts.
    const Bracket a = guide(above);
    const Bracket b = guide(below);
    const Interval in_columns =
        find_interval(width, u.y, sum_left_of, {std::min(a.first, b.first), std::max(a.last, b.last)});
    const int left = in_columns.index;
    const int right = left + 1 == width ? 0 : left + 1;
    const auto luminance_at = [&](int x) {
        return mix(luminance(image_.at(x, above)), luminance(image_.at(x, below)), t);
    };
    const float x = sample_linear(luminance_at(left), luminance_at(right), in_columns.fraction);

    const float depth = mix(cells.depth_above, cells.depth_below, t);
    const float y = 2 * in_rows.index <= height ? 1 - depth : depth - 1;
    const float from_axis = std::sqrt(std::max(depth * (2 - depth), 0.0F));
    const float azimuth = (static_cast<float>(left) + x - first_column_) / columns_per_radian_;
    return {from_axis * std::cos(azimuth), y, from_axis * std::sin(azimuth)};
}

/// Uniform over the disc by solid angle.
glm::vec3 Environment::sun_direction(glm::vec2 u) const noexcept {
    const float depth = 0.5F * sun_chord_squared_ * u.x;  // 1 - cosine
    const float from_axis = std::sqrt(depth * (2 - depth));
    const float azimuth = 2 * pi * u.y;
    // An orthonormal basis without a seam (Duff et al., "Building an Orthonormal Basis, Revisited", 2017).
    const glm::vec3 n = sun_.direction;
    const float sign = std::copysign(1.0F, n.z);
    const float a = -1 / (sign + n.z);
    const float b = n.x * n.y * a;
    const glm::vec3 tangent(1 + sign * n.x * n.x * a, sign * b, -sign * n.x);
    const glm::vec3 bitangent(b, sign + n.y * n.y * a, -n.y);
    return (1 - depth) * n + from_axis * (std::cos(azimuth) * tangent + std::sin(azimuth) * bitangent);
}

Environment::Sample Environment::sample(glm::vec3 u) const noexcept {
    if (is_black()) return {};
    const glm::vec2 place(u.y, u.z);
    if (is_uniform()) return look_up(sphere_direction(place));
    return look_up(u.x < sun_share_ ? sun_direction(place) : image_direction(place));
}

}  // namespace lightgrid
