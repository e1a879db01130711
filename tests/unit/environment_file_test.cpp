#include "core/environment_file.h"

#include "core/error.h"
#include "core/exr.h"
#include "core/sampling.h"
#include "core/whole_file.h"

#include <ImfChannelList.h>
#include <ImfEnvmap.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfOutputFile.h>
#include <ImfStandardAttributes.h>
#include <gtest/gtest.h>

#include "sphere_projection.h"
#include <cmath>
#include <filesystem>
#include <functional>
#include <numbers>
#include <optional>
#include <string>
#include <unistd.h>
#include <vector>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;
using Imath::Box2i;
constexpr double pi = std::numbers::pi;

/// The direction of a point of a picture, in pixels (the centre of the first is at 1/2, 1/2); none where it shows
/// nothing.
using Mapping = std::function<std::optional<glm::dvec3>(glm::dvec2)>;

struct Picture {
    EnvironmentLayout layout;
    glm::ivec2 size;
    Mapping direction;
};

/// Written from the words of the header, each face by hand: x and y in [-1, 1], right and down.
std::optional<glm::dvec3> vertical_cross(int n, glm::dvec2 p) {
    const glm::ivec2 cell(p / double(n));
    const glm::dvec2 s = 2.0 * (p / double(n) - glm::dvec2(cell)) - 1.0;
    if (cell == glm::ivec2(1, 0)) return glm::dvec3(s.x, 1, -s.y);    // +Y, its lower edge towards -Z
    if (cell == glm::ivec2(0, 1)) return glm::dvec3(-1, -s.y, -s.x);  // -X, its right edge towards -Z
    if (cell == glm::ivec2(1, 1)) return glm::dvec3(s.x, -s.y, -1);   // -Z
    if (cell == glm::ivec2(2, 1)) return glm::dvec3(1, -s.y, s.x);    // +X, its left edge towards -Z
    if (cell == glm::ivec2(1, 2)) return glm::dvec3(s.x, -1, s.y);    // -Y, its upper edge towards -Z
    if (cell == glm::ivec2(1, 3)) return glm::dvec3(s.x, s.y, 1);     // +Z, its upper edge towards -Y
    return {};
}

std::optional<glm::dvec3> horizontal_cross(int n, glm::dvec2 p) {
    const glm::ivec2 cell(p / double(n));
    const glm::dvec2 s = 2.0 * (p / double(n) - glm::dvec2(cell)) - 1.0;
    if (cell == glm::ivec2(3, 1)) return glm::dvec3(-s.x, -s.y, 1);  // +Z, its left edge towards +X
    if (cell == glm::ivec2(1, 3) || cell.y > 2) return {};
    return vertical_cross(n, p);
}

/// OpenGL 4.6 core, table 8.19, solved for the direction: s and t in [-1, 1] grow to the right and down.
glm::dvec3 opengl_face(int face, glm::dvec2 s) {
    switch (face) {
        case 0:
            return {1, -s.y, -s.x};
        case 1:
            return {-1, -s.y, s.x};
        case 2:
            return {s.x, 1, s.y};
        case 3:
            return {s.x, -1, -s.y};
        case 4:
            return {s.x, -s.y, 1};
        default:
            return {-s.x, -s.y, -1};
    }
}

/// Debevec: turn -Z by phi = pi |(u, v)| about +Y, then by theta = atan2(v, u) about -Z.
std::optional<glm::dvec3> angular(int n, glm::dvec2 p) {
    const double u = 2 * p.x / n - 1;
    const double v = 1 - 2 * p.y / n;
    const double phi = pi * std::hypot(u, v);
    if (phi > pi) return {};
    const double theta = std::atan2(v, u);
    return glm::dvec3(std::sin(phi) * std::cos(theta), std::sin(phi) * std::sin(theta), -std::cos(phi));
}

glm::dvec3 to_glm(Imath::V3f v) {
    return {v.x, v.y, v.z};
}

std::vector<Picture> pictures(int n) {
    const Box2i cube({0, 0}, {n - 1, 6 * n - 1});
    const Box2i latlong({0, 0}, {4 * n - 1, 2 * n - 1});
    return {
        {EnvironmentLayout::vertical_cross, {3 * n, 4 * n}, [n](glm::dvec2 p) { return vertical_cross(n, p); }},
        {EnvironmentLayout::horizontal_cross, {4 * n, 3 * n}, [n](glm::dvec2 p) { return horizontal_cross(n, p); }},
        {EnvironmentLayout::strip,
         {6 * n, n},
         [n](glm::dvec2 p) {
             const int face = static_cast<int>(p.x / n);
             return opengl_face(face, 2.0 * (p / double(n) - glm::dvec2(face, 0)) - 1.0);
         }},
        {EnvironmentLayout::strip,
         {n, 6 * n},
         [n](glm::dvec2 p) {
             const int face = static_cast<int>(p.y / n);
             return opengl_face(face, 2.0 * (p / double(n) - glm::dvec2(0, face)) - 1.0);
         }},
        {EnvironmentLayout::angular, {2 * n, 2 * n}, [n](glm::dvec2 p) { return angular(2 * n, p); }},
        {EnvironmentLayout::openexr_cube,
         {n, 6 * n},
         [n, cube](glm::dvec2 p) {  // the library's own mapping, whose pixels have their centres at integers
             const auto face = static_cast<Imf::CubeMapFace>(static_cast<int>(p.y / n));
             const Imath::V2f wanted(static_cast<float>(p.x - 0.5), static_cast<float>(p.y - 0.5));
             // Faces are turned within the picture: find the position in the face that leads to this pixel.
             Imath::V2f best;
             float nearest = 1e9F;
             for (int y = 0; y < n; ++y)
                 for (int x = 0; x < n; ++x) {
                     const Imath::V2f in_face(static_cast<float>(x), static_cast<float>(y));
                     const float distance = (Imf::CubeMap::pixelPosition(face, cube, in_face) - wanted).length();
                     if (distance < nearest) {
                         nearest = distance;
                         best = in_face;
                     }
                 }
             return to_glm(Imf::CubeMap::direction(face, cube, best));
         }},
        {EnvironmentLayout::openexr_latlong,
         {4 * n, 2 * n},
         [latlong](glm::dvec2 p) {
             return to_glm(Imf::LatLongMap::direction(
                 latlong, Imath::V2f(static_cast<float>(p.x - 0.5), static_cast<float>(p.y - 0.5))));
         }},
    };
}

template <typename Sky>
RadianceImage paint(const Picture& picture, const Sky& sky) {
    RadianceImage image{picture.size.x, picture.size.y, {}};
    for (int y = 0; y < picture.size.y; ++y) {
        for (int x = 0; x < picture.size.x; ++x) {
            const std::optional<glm::dvec3> direction = picture.direction({x + 0.5, y + 0.5});
            image.pixels.push_back(direction ? glm::vec3(sky(glm::normalize(*direction))) : glm::vec3(0));
        }
    }
    return image;
}

/// Smooth, without any symmetry, and different in every channel.
glm::dvec3 smooth_sky(glm::dvec3 d) {
    return {std::exp(glm::dot(d, glm::dvec3(0.9, 0.3, -0.5))), 1.5 + d.x * d.y + 0.5 * d.z, 2 + d.z * d.z - d.y};
}

std::string name_and_size(const Picture& picture) {
    return std::string(name_of(picture.layout)) + " " + std::to_string(picture.size.x) + " x " +
           std::to_string(picture.size.y);
}

TEST(EnvironmentLayout, NamesAreReadBack) {
    for (const Picture& picture : pictures(4))
        EXPECT_EQ(parse_environment_layout(name_of(picture.layout)), picture.layout);
    EXPECT_EQ(parse_environment_layout("auto"), EnvironmentLayout::automatic);
    EXPECT_EQ(parse_environment_layout("equirect"), EnvironmentLayout::equirectangular);
    try {
        (void)parse_environment_layout("mirror-ball");
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("mirror-ball"), std::string::npos);
        EXPECT_NE(std::string(error.what()).find("horizontal-cross"), std::string::npos);
    }
}

TEST(EnvironmentLayout, ShapesAreRecognised) {
    EXPECT_EQ(layout_of_shape(1024, 512), EnvironmentLayout::equirectangular);
    EXPECT_EQ(layout_of_shape(1023, 512), EnvironmentLayout::equirectangular);
    EXPECT_EQ(layout_of_shape(768, 1024), EnvironmentLayout::vertical_cross);
    EXPECT_EQ(layout_of_shape(1024, 768), EnvironmentLayout::horizontal_cross);
    EXPECT_EQ(layout_of_shape(1536, 256), EnvironmentLayout::strip);
    EXPECT_EQ(layout_of_shape(256, 1536), EnvironmentLayout::strip);
    EXPECT_EQ(layout_of_shape(1000, 1000), EnvironmentLayout::angular);
    EXPECT_EQ(layout_of_shape(1000, 700), EnvironmentLayout::automatic);
}

TEST(EnvironmentLayout, EveryLayoutShowsTheSameSky) {
    constexpr int n = 64;
    const Sh9 exact = project(512, 256, smooth_sky);
    for (const Picture& picture : pictures(n)) {
        const RadianceImage image = to_equirectangular(paint(picture, smooth_sky), picture.layout);
        ASSERT_EQ(image.width, 2 * image.height) << name_and_size(picture);
        for (int y = 0; y < image.height; y += 5) {
            for (int x = 0; x < image.width; x += 7) {
                const glm::dvec3 direction =
                    equirectangular_direction((x + 0.5) / image.width, (y + 0.5) / image.height);
                const glm::dvec3 wanted = smooth_sky(direction);
                // Constant within half a pixel of a face's edge: half a pixel of 2/64 rad, slopes of up to 2.5.
                for (int c = 0; c < 3; ++c)
                    ASSERT_NEAR(image.at(x, y)[c], wanted[c], 0.04) << name_and_size(picture) << " " << x << " " << y;
            }
        }
        const Environment sky = Environment::from_image(image);
        const Sh9 loaded = project(512, 256, [&](glm::dvec3 d) { return glm::dvec3(sky.radiance(d)); });
        EXPECT_LT(difference(exact, loaded), 0.002) << name_and_size(picture);
    }
}

TEST(EnvironmentLayout, UniformStaysUniform) {
    for (const Picture& picture : pictures(8)) {
        const RadianceImage image =
            to_equirectangular(paint(picture, [](glm::dvec3) { return glm::dvec3(0.3, 1, 7); }), picture.layout);
        for (const glm::vec3 pixel : image.pixels)
            for (int c = 0; c < 3; ++c) ASSERT_NEAR(pixel[c], glm::vec3(0.3F, 1, 7)[c], 1e-6) << name_and_size(picture);
    }
}

TEST(EnvironmentLayout, ABrightPixelKeepsItsDirectionAndEnergy) {
    constexpr int n = 32;
    for (const Picture& picture : pictures(n)) {
        // OpenEXR's pixels share directions at the edges of a face; what they are worth there is not defined.
        if (picture.layout == EnvironmentLayout::openexr_cube || picture.layout == EnvironmentLayout::openexr_latlong)
            continue;
        // The middle of a face, near its corner, and near an edge; of the second face across and down.
        for (const glm::ivec2 in_face : {glm::ivec2(16, 16), glm::ivec2(3, 1), glm::ivec2(30, 17)}) {
            const glm::ivec2 pixel = glm::min(glm::ivec2(n), picture.size - n) + in_face;
            if (!picture.direction(glm::dvec2(pixel)) || !picture.direction(glm::dvec2(pixel + 1))) continue;
            const auto direction = [&](double x, double y) {
                return glm::normalize(picture.direction(glm::dvec2(pixel) + glm::dvec2(x, y)).value());
            };
            const double solid_angle =
                glm::length(glm::cross(direction(1, 0.5) - direction(0, 0.5), direction(0.5, 1) - direction(0.5, 0)));
            RadianceImage image = paint(picture, [](glm::dvec3) { return glm::dvec3(0); });
            image.at(pixel.x, pixel.y) = glm::vec3(1e6F);
            image = to_equirectangular(std::move(image), picture.layout);
            const double target_pixel = pi / image.height;
            const Environment sky = Environment::from_image(std::move(image));
            glm::dvec3 mean(0);
            double energy = 0;
            over_sphere(1024, 512, [&](glm::dvec3 d, double weight) {
                const double light = sky.radiance(d).r * weight;
                energy += light;
                mean += light * d;
            });
            const glm::dvec3 centre = direction(0.5, 0.5);
            // Rows at a pole weigh up to 8 % more than their solid angle in a bilinear image. Averaging over target
            // pixels may move light by half of one.
            const bool at_pole = std::abs(centre.y) > std::cos(3 * target_pixel);
            EXPECT_NEAR(energy, 1e6 * solid_angle, (at_pole ? 0.08 : 0.02) * energy)
                << name_and_size(picture) << ": " << pixel.x << ", " << pixel.y;
            EXPECT_LT(glm::length(glm::normalize(mean) - centre), 0.5 * target_pixel)
                << name_and_size(picture) << ": " << pixel.x << ", " << pixel.y;
        }
    }
}

TEST(EnvironmentLayout, RefusesShapesThatDoNotFit) {
    const auto refused = [](int width, int height, EnvironmentLayout layout) {
        RadianceImage image{width, height, std::vector<glm::vec3>(static_cast<std::size_t>(width) * height)};
        try {
            (void)to_equirectangular(std::move(image), layout);
        } catch (const Error& error) {
            return std::string(error.what()).find(name_of(layout)) != std::string::npos;
        }
        return false;
    };
    EXPECT_TRUE(refused(4, 3, EnvironmentLayout::vertical_cross));
    EXPECT_TRUE(refused(3, 4, EnvironmentLayout::horizontal_cross));
    EXPECT_TRUE(refused(7, 1, EnvironmentLayout::strip));
    EXPECT_TRUE(refused(5, 4, EnvironmentLayout::angular));
    EXPECT_TRUE(refused(6, 1, EnvironmentLayout::openexr_cube));
    EXPECT_TRUE(refused(2, 1, EnvironmentLayout::vertical_cross));
}

// ---- Files

class Folder {
  public:
    Folder() : path_(fs::temp_directory_path() / ("lightgrid_environment_test_" + std::to_string(::getpid()))) {
        fs::create_directories(path_);
    }
    ~Folder() { fs::remove_all(path_); }
    [[nodiscard]] fs::path operator/(const std::string& name) const { return path_ / name; }

  private:
    fs::path path_;
};

TEST(LoadEnvironment, GoesByShapeThenByTheNamedLayout) {
    const Folder folder;
    const auto sky = [](glm::dvec3 d) { return smooth_sky(d); };
    const Picture cross = pictures(16)[0];
    write_exr(paint(cross, sky), folder / "cross.exr");
    const LoadedEnvironment loaded = load_environment(folder / "cross.exr");
    EXPECT_EQ(loaded.layout, EnvironmentLayout::vertical_cross);
    ASSERT_EQ(loaded.notices.size(), 1U);
    EXPECT_NE(loaded.notices[0].find("vertical-cross"), std::string::npos);
    EXPECT_NEAR(loaded.environment.radiance({1, 0, 0}).r, smooth_sky({1, 0, 0}).x, 0.05);

    const LoadedEnvironment turned = load_environment(folder / "cross.exr", {EnvironmentLayout::automatic, 90, 2});
    EXPECT_NEAR(turned.environment.radiance({0, 0, -1}).r, 2 * smooth_sky({1, 0, 0}).x, 0.1);

    const LoadedEnvironment named = load_environment(folder / "cross.exr", {EnvironmentLayout::equirectangular, 0, 1});
    EXPECT_EQ(named.layout, EnvironmentLayout::equirectangular);
    EXPECT_TRUE(named.notices.empty());
    EXPECT_THROW((void)load_environment(folder / "cross.exr", {EnvironmentLayout::strip, 0, 1}), Error);
}

TEST(LoadEnvironment, SetsNegativePixelsToZeroAndSaysSo) {
    const Folder folder;
    RadianceImage image{4, 2, std::vector<glm::vec3>(8, glm::vec3(1))};
    image.at(1, 0) = {-0.5F, 1, 1};
    image.at(2, 1) = {1, 1, -2};
    write_exr(image, folder / "sky.exr");
    const LoadedEnvironment loaded = load_environment(folder / "sky.exr");
    ASSERT_EQ(loaded.notices.size(), 1U);
    EXPECT_EQ(loaded.notices[0], "2 negative pixels, down to -2, set to 0");
}

TEST(LoadEnvironment, ErrorsNameTheFile) {
    const Folder folder;
    write_exr({3, 2, std::vector<glm::vec3>(6, glm::vec3(1))}, folder / "odd.exr");
    write_whole_file(folder / "text.hdr", "hello");
    for (const char* name : {"odd.exr", "text.hdr", "missing.exr"}) {
        try {
            (void)load_environment(folder / name);
            ADD_FAILURE() << name;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
            EXPECT_EQ(error.fault(), Fault::input);
        }
    }
}

// ---- Real files

class SharedEnvironments : public testing::Test {
  protected:
    void SetUp() override {
        if (!fs::exists(data_)) GTEST_SKIP() << "no shared data at " << data_;
    }
    [[nodiscard]] static Sh9 projected(const Environment& sky) {
        return project(1024, 512, [&](glm::dvec3 d) { return glm::dvec3(sky.radiance(d)); });
    }
    const fs::path data_ = fs::path(LIGHTGRID_SHARED) / "data";
};

TEST_F(SharedEnvironments, CrossesKeepTheirSphericalHarmonics) {
    for (const char* name : {"beach_cross.hdr", "rnl_cross.hdr"}) {
        const fs::path path = data_ / "env-debevec-cross" / name;
        const RadianceFile file = read_radiance(path);
        const int n = file.image.width / 3;
        Sh9 direct{};  // pixel by pixel, with the exact solid angle of each
        const auto corner = [](double x, double y) { return std::atan2(x * y, std::sqrt(x * x + y * y + 1)); };
        for (int y = 0; y < file.image.height; ++y) {
            for (int x = 0; x < file.image.width; ++x) {
                const std::optional<glm::dvec3> direction = vertical_cross(n, {x + 0.5, y + 0.5});
                if (!direction) continue;
                const double left = 2.0 * (x % n) / n - 1, top = 2.0 * (y % n) / n - 1, step = 2.0 / n;
                const double angle = corner(left + step, top + step) - corner(left, top + step) -
                                     corner(left + step, top) + corner(left, top);
                const std::array<double, 9> basis = sh9_basis(glm::normalize(*direction));
                for (int i = 0; i < 9; ++i) direct[i] += glm::dvec3(file.image.at(x, y)) * (basis[i] * angle);
            }
        }
        const LoadedEnvironment loaded = load_environment(path);
        EXPECT_EQ(loaded.layout, EnvironmentLayout::vertical_cross);
        const double error = difference(direct, projected(loaded.environment));
        EXPECT_LT(error, 0.005) << name;
        RecordProperty(name, std::to_string(error));
    }
}

TEST_F(SharedEnvironments, OpenExrCubeAndLatLongShowTheSame) {
    struct Pair {
        const char* name;
        double tolerance;  // of SH coefficients, relative to the mean
    };
    // Both of a pair were rendered apart: Kerner's two come from one panorama with different filters.
    for (const Pair& pair : {Pair{"Orientation", 0.01}, Pair{"Kerner Env", 0.02}, Pair{"WavyLines", 0.01}}) {
        std::string stem = pair.name;
        std::erase(stem, ' ');
        const LoadedEnvironment cube = load_environment(data_ / "env-openexr" / (stem + "Cube.exr"));
        const LoadedEnvironment latlong = load_environment(data_ / "env-openexr" / (stem + "LatLong.exr"));
        EXPECT_EQ(cube.layout, EnvironmentLayout::openexr_cube);
        EXPECT_EQ(latlong.layout, EnvironmentLayout::openexr_latlong);
        const double error = difference(projected(cube.environment), projected(latlong.environment));
        EXPECT_LT(error, pair.tolerance) << stem;
        RecordProperty(stem, std::to_string(error));
    }
}

TEST_F(SharedEnvironments, EveryOneLoadsAndSamples) {
    int count = 0;
    for (const char* folder : {"env-debevec-cross", "env-polyhaven-1k", "env-polyhaven-exr-dwab", "env-openexr"}) {
        for (const fs::directory_entry& entry : fs::directory_iterator(data_ / folder)) {
            const std::string extension = entry.path().extension().string();
            if (extension != ".hdr" && extension != ".exr") continue;
            const LoadedEnvironment loaded = load_environment(entry.path());
            const Sh9 exact = projected(loaded.environment);
            constexpr int samples = 4096;
            Sh9 sum{};
            for (std::uint32_t i = 0; i < samples; ++i) {
                const Environment::Sample sample = loaded.environment.sample({0.5F, sobol_point(i, 12345)});
                ASSERT_GT(sample.pdf, 0);
                const std::array<double, 9> basis = sh9_basis(sample.direction);
                for (int k = 0; k < 9; ++k) sum[k] += glm::dvec3(sample.radiance) * (basis[k] / sample.pdf / samples);
            }
            // Random points would be off by 1.6 % in one standard error of each; these are a net.
            EXPECT_LT(difference(exact, sum), 0.01) << entry.path();
            ++count;
        }
    }
    EXPECT_EQ(count, 18);
}

}  // namespace
}  // namespace lightgrid
