#include "core/exr.h"

#include "core/error.h"
#include "core/whole_file.h"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfMultiPartOutputFile.h>
#include <ImfOutputFile.h>
#include <ImfOutputPart.h>
#include <ImfPartType.h>
#include <ImfRgbaFile.h>
#include <ImfStandardAttributes.h>
#include <ImfStdIO.h>
#include <ImfTiledOutputFile.h>
#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <limits>
#include <map>
#include <string>
#include <vector>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;
using Imath::Box2i;

RadianceFile decode(const std::string& bytes) {
    return decode_exr(std::as_bytes(std::span(bytes)), "sky.exr");
}

std::string message_of(const std::string& bytes) {
    try {
        (void)decode(bytes);
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

bool any_notice_has(const RadianceFile& file, const std::string& text) {
    for (const std::string& notice : file.notices)
        if (notice.find(text) != std::string::npos) return true;
    return false;
}

/// Integers below 2048, so that half holds them: distinct at every pixel and channel.
float value_at(int x, int y, int channel) {
    return static_cast<float>(8 * x + 64 * y + channel + 1);
}

constexpr int width = 7;
constexpr int height = 5;

void expect_values(const RadianceImage& image) {
    ASSERT_EQ(glm::ivec2(image.width, image.height), glm::ivec2(width, height));
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x)
            EXPECT_EQ(image.at(x, y), glm::vec3(value_at(x, y, 0), value_at(x, y, 1), value_at(x, y, 2)))
                << x << ", " << y;
}

/// Channel values of a data window, in any pixel type, for writing.
class Pixels {
  public:
    Pixels(const std::vector<std::string>& names, Imf::PixelType type,
           Box2i window = Box2i({0, 0}, {width - 1, height - 1}))
        : type_(type), window_(window), columns_(window.max.x - window.min.x + 1) {
        const int rows = window.max.y - window.min.y + 1;
        for (std::size_t c = 0; c < names.size(); ++c) {
            std::vector<char>& bytes = channels_[names[c]];
            for (int y = 0; y < rows; ++y) {
                for (int x = 0; x < columns_; ++x) {
                    const float value = value_at(x, y, static_cast<int>(c));
                    if (type == Imf::HALF) append(bytes, Imath::half(value));
                    if (type == Imf::FLOAT) append(bytes, value);
                    if (type == Imf::UINT) append(bytes, static_cast<unsigned>(value));
                }
            }
        }
    }

    void add_to(Imf::Header& header) const {
        for (const auto& [name, bytes] : channels_) header.channels().insert(name, Imf::Channel(type_));
    }
    [[nodiscard]] Imf::FrameBuffer buffer() {
        const std::size_t size = type_ == Imf::HALF ? 2 : 4;
        Imf::FrameBuffer frame;
        for (auto& [name, bytes] : channels_)
            frame.insert(name, Imf::Slice::Make(type_, bytes.data(), window_, size, size * columns_));
        return frame;
    }
    template <typename T>
    void set(const std::string& name, int x, int y, T value) {
        std::memcpy(channels_[name].data() + sizeof(T) * (static_cast<std::size_t>(y) * columns_ + x), &value,
                    sizeof(T));
    }

  private:
    template <typename T>
    static void append(std::vector<char>& bytes, T value) {
        bytes.insert(bytes.end(), reinterpret_cast<const char*>(&value),
                     reinterpret_cast<const char*>(&value) + sizeof(T));
    }
    Imf::PixelType type_;
    Box2i window_;
    int columns_;
    std::map<std::string, std::vector<char>> channels_;
};

std::string write_scanlines(Imf::Header header, Pixels pixels) {
    pixels.add_to(header);
    Imf::StdOSStream stream;
    {
        Imf::OutputFile file(stream, header);
        file.setFrameBuffer(pixels.buffer());
        file.writePixels(header.dataWindow().max.y - header.dataWindow().min.y + 1);
    }
    return stream.str();
}

std::string write_tiles(Imf::LevelMode mode, Imf::PixelType type) {
    Imf::Header header(width, height);
    header.setTileDescription(Imf::TileDescription(4, 2, mode));
    Pixels pixels({"R", "G", "B"}, type);
    Pixels black({"R", "G", "B"}, type);  // coarser levels must not be mistaken for level 0
    for (const char* name : {"R", "G", "B"})
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                type == Imf::HALF ? black.set(name, x, y, Imath::half(0)) : black.set(name, x, y, 0.0F);
    pixels.add_to(header);
    Imf::StdOSStream stream;
    {
        Imf::TiledOutputFile file(stream, header);
        for (int ly = 0; ly < file.numYLevels(); ++ly) {
            for (int lx = 0; lx < file.numXLevels(); ++lx) {
                if (!file.isValidLevel(lx, ly)) continue;
                file.setFrameBuffer(lx + ly == 0 ? pixels.buffer() : black.buffer());
                file.writeTiles(0, file.numXTiles(lx) - 1, 0, file.numYTiles(ly) - 1, lx, ly);
            }
        }
    }
    return stream.str();
}

TEST(DecodeExr, ReadsEveryPixelType) {
    for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT, Imf::UINT})
        expect_values(decode(write_scanlines(Imf::Header(width, height), Pixels({"R", "G", "B"}, type))).image);
}

TEST(DecodeExr, ReadsEveryLosslessCompression) {
    for (const Imf::Compression compression : {Imf::NO_COMPRESSION, Imf::RLE_COMPRESSION, Imf::ZIPS_COMPRESSION,
                                               Imf::ZIP_COMPRESSION, Imf::PIZ_COMPRESSION, Imf::PXR24_COMPRESSION}) {
        Imf::Header header(width, height);
        header.compression() = compression;
        expect_values(decode(write_scanlines(header, Pixels({"R", "G", "B"}, Imf::HALF))).image);
    }
}

TEST(DecodeExr, ReadsLevelZeroOfTiles) {
    for (const Imf::LevelMode mode : {Imf::ONE_LEVEL, Imf::MIPMAP_LEVELS, Imf::RIPMAP_LEVELS})
        for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT}) expect_values(decode(write_tiles(mode, type)).image);
}

TEST(DecodeExr, PartsAreLayersByTheirNames) {
    Imf::StdOSStream stream;
    {
        std::vector<Imf::Header> headers(3, Imf::Header(width, height));
        Pixels depth({"Z"}, Imf::FLOAT);
        Pixels color({"R", "G", "B"}, Imf::FLOAT);
        const char* const names[] = {"depth", "beauty", "other"};
        for (int i = 0; i < 3; ++i) {
            headers[i].setName(names[i]);
            headers[i].setType(Imf::SCANLINEIMAGE);
            (i == 0 ? depth : color).add_to(headers[i]);
        }
        Imf::MultiPartOutputFile file(stream, headers.data(), 3);
        for (int i = 0; i < 3; ++i) {
            Imf::OutputPart part(file, i);
            part.setFrameBuffer((i == 0 ? depth : color).buffer());
            part.writePixels(height);
        }
    }
    const RadianceFile file = decode(stream.str());
    expect_values(file.image);
    EXPECT_TRUE(any_notice_has(file, "layer \"beauty\" was read, of beauty, other"));
}

TEST(DecodeExr, SpreadsLuminance) {
    const RadianceFile file = decode(write_scanlines(Imf::Header(width, height), Pixels({"Y"}, Imf::HALF)));
    EXPECT_EQ(file.image.at(3, 2), glm::vec3(value_at(3, 2, 0)));
}

TEST(DecodeExr, ReadsLuminanceWithChroma) {
    // Smooth colour survives the halved chroma; 1 % covers its filter and 8 bits of chroma mantissa.
    const int size = 32;
    std::vector<Imf::Rgba> pixels;
    for (int y = 0; y < size; ++y)
        for (int x = 0; x < size; ++x) pixels.emplace_back(1.0F + 0.01F * x, 2.0F, 0.5F + 0.01F * y, 1.0F);
    Imf::StdOSStream stream;
    {
        Imf::RgbaOutputFile file(stream, Imf::Header(size, size), Imf::WRITE_YC);
        file.setFrameBuffer(pixels.data(), 1, size);
        file.writePixels(size);
    }
    const RadianceFile file = decode(stream.str());
    for (const glm::ivec2 p : {glm::ivec2(0, 0), glm::ivec2(16, 9), glm::ivec2(31, 31)}) {
        EXPECT_NEAR(file.image.at(p.x, p.y).r, 1 + 0.01F * p.x, 0.02F);
        EXPECT_NEAR(file.image.at(p.x, p.y).g, 2, 0.02F);
        EXPECT_NEAR(file.image.at(p.x, p.y).b, 0.5F + 0.01F * p.y, 0.01F);
    }
}

TEST(DecodeExr, FindsColourInLayersAndByName) {
    const RadianceFile layer = decode(
        write_scanlines(Imf::Header(width, height),
                        Pixels({"sky.R", "sky.G", "sky.B", "Z", "normal.X", "normal.Y", "normal.Z"}, Imf::FLOAT)));
    expect_values(layer.image);
    EXPECT_TRUE(any_notice_has(layer, "\"sky\""));
    expect_values(
        decode(write_scanlines(Imf::Header(width, height), Pixels({"red", "green", "blue"}, Imf::HALF))).image);
    // The part's own channels come before those of its layers.
    const RadianceFile both =
        decode(write_scanlines(Imf::Header(width, height), Pixels({"R", "G", "B", "a.R", "a.G", "a.B"}, Imf::FLOAT)));
    expect_values(both.image);
    EXPECT_TRUE(any_notice_has(both, "the unnamed layer was read, of (unnamed), a"));
}

/// Layers of these names in one part: all pixels of the i-th are i + 1, i + 1.25, i + 1.5.
std::string write_layers(const std::vector<std::string>& layers) {
    std::vector<std::string> names;
    for (const std::string& layer : layers)
        for (const char* channel : {"R", "G", "B"}) names.push_back(layer + (layer.empty() ? "" : ".") + channel);
    Pixels pixels(names, Imf::FLOAT);
    for (std::size_t c = 0; c < names.size(); ++c)
        for (int y = 0; y < height; ++y)
            for (int x = 0; x < width; ++x)
                pixels.set(names[c], x, y, static_cast<float>(c / 3 + 1) + 0.25F * static_cast<float>(c % 3));
    return write_scanlines(Imf::Header(width, height), pixels);
}

TEST(DecodeExr, OfManyLayersTheWholePictureIsRead) {
    // The last of each is the one that is meant.
    const std::vector<std::vector<std::string>> cases = {
        {"ViewLayer.AO", "ViewLayer.DiffDir", "ViewLayer.Combined"},
        {"ViewLayer.Denoising Albedo", "ViewLayer.Noisy Image", "ViewLayer.Combined"},
        {"AO", "diffuse", "Beauty"},
        {"albedo", "indirect", "rgba_main"},
        {"RenderLayer.Combined.left", ""},
        {"AO", "shadow", "sky"},
        {"N", "Z", "C"},
        {"emission", "Image"},
    };
    for (const std::vector<std::string>& layers : cases) {
        const RadianceFile file = decode(write_layers(layers));
        const auto n = static_cast<float>(layers.size());
        EXPECT_EQ(file.image.at(1, 2), glm::vec3(n, n + 0.25F, n + 0.5F)) << layers.back();
        EXPECT_TRUE(any_notice_has(
            file, layers.back().empty() ? "the unnamed layer" : "layer \"" + layers.back() + "\" was read, of"))
            << layers.back();
    }
}

TEST(DecodeExr, ALayerIsReadByItsNameOrTheEndOfIt) {
    const std::string bytes = write_layers({"ViewLayer.AO", "ViewLayer.Combined", "Other.AO", "ao"});
    const auto read = [&](const std::string& layer) {
        return decode_exr(std::as_bytes(std::span(bytes)), "sky.exr", layer).image.at(0, 0).r;
    };
    EXPECT_EQ(read("ViewLayer.AO"), 1);
    EXPECT_EQ(read("viewlayer.ao"), 1);
    EXPECT_EQ(read("combined"), 2);
    EXPECT_EQ(read("ao"), 4);
    for (const char* wrong : {"AO", "diffuse"}) {
        try {
            static_cast<void>(read(wrong));
            FAIL() << wrong;
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("Name one of: "), std::string::npos) << error.what();
            EXPECT_NE(std::string(error.what()).find("ViewLayer.AO"), std::string::npos) << error.what();
        }
    }
}

TEST(DecodeExr, RefusesPicturesWithoutColour) {
    using Names = std::vector<std::string>;
    for (const Names& names : {Names{"Z"}, Names{"R", "G"}, Names{"normal.X", "normal.Y", "normal.Z"}, Names{"A"}}) {
        const std::string message = message_of(write_scanlines(Imf::Header(width, height), Pixels(names, Imf::FLOAT)));
        EXPECT_NE(message.find("sky.exr: the OpenEXR image has no colour"), std::string::npos) << message;
        EXPECT_NE(message.find(names[0]), std::string::npos) << message;
    }
}

TEST(DecodeExr, ThePictureIsTheDisplayWindow) {
    // Data 7 x 5 at (2, 1) .. (8, 5) in a display window of 10 x 4 at (0, 0): black around, the last rows cut off.
    const Box2i data({2, 1}, {8, 5});
    const Imf::Header header(Box2i({0, 0}, {9, 3}), data);
    const RadianceFile file = decode(write_scanlines(header, Pixels({"R", "G", "B"}, Imf::FLOAT, data)));
    ASSERT_EQ(glm::ivec2(file.image.width, file.image.height), glm::ivec2(10, 4));
    EXPECT_FALSE(file.notices.empty());
    for (int y = 0; y < 4; ++y) {
        for (int x = 0; x < 10; ++x) {
            const bool inside = x >= 2 && x <= 8 && y >= 1;
            EXPECT_EQ(file.image.at(x, y).g, inside ? value_at(x - 2, y - 1, 1) : 0) << x << ", " << y;
        }
    }
}

TEST(DecodeExr, OverscanIsCutOff) {
    const Box2i data({-3, -2}, {3, 2});
    const Imf::Header header(Box2i({-1, -1}, {1, 1}), data);
    const RadianceFile file = decode(write_scanlines(header, Pixels({"R", "G", "B"}, Imf::HALF, data)));
    ASSERT_EQ(glm::ivec2(file.image.width, file.image.height), glm::ivec2(3, 3));
    EXPECT_EQ(file.image.at(0, 0).r, value_at(2, 1, 0));
    EXPECT_EQ(file.image.at(2, 2).b, value_at(4, 3, 2));
}

TEST(DecodeExr, AnEnvironmentMapIsItsDataWindow) {
    const Box2i data({100, -50}, {106, -46});
    Imf::Header header(Box2i({0, 0}, {9, 9}), data);
    Imf::addEnvmap(header, Imf::ENVMAP_LATLONG);
    const RadianceFile file = decode(write_scanlines(header, Pixels({"R", "G", "B"}, Imf::FLOAT, data)));
    EXPECT_EQ(file.envmap, Envmap::latlong);
    expect_values(file.image);
}

TEST(DecodeExr, ConvertsOtherPrimaries) {
    // Rec.2020 white is Rec.709 white; its green is outside of Rec.709 (ITU-R BT.2087: -0.5876, 1.1329, -0.1006).
    Imf::Header header(2, 1);
    Imf::addChromaticities(
        header, Imf::Chromaticities({0.708F, 0.292F}, {0.170F, 0.797F}, {0.131F, 0.046F}, {0.3127F, 0.3290F}));
    Pixels pixels({"R", "G", "B"}, Imf::FLOAT, Box2i({0, 0}, {1, 0}));
    for (const char* name : {"R", "G", "B"}) {
        pixels.set(name, 0, 0, 1.0F);
        pixels.set(name, 1, 0, *name == 'G' ? 1.0F : 0.0F);
    }
    const RadianceFile file = decode(write_scanlines(header, pixels));
    const auto expect_near = [](glm::vec3 got, glm::vec3 wanted) {
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[i], wanted[i], 2e-4F);
    };
    expect_near(file.image.at(0, 0), glm::vec3(1));
    expect_near(file.image.at(1, 0), {-0.5876F, 1.1329F, -0.1006F});
    EXPECT_TRUE(any_notice_has(file, "Rec.709"));
}

TEST(DecodeExr, NamesThePixelThatIsNotFinite) {
    Pixels pixels({"R", "G", "B"}, Imf::FLOAT);
    pixels.set("G", 4, 3, std::numeric_limits<float>::quiet_NaN());
    const std::string nan = message_of(write_scanlines(Imf::Header(width, height), pixels));
    EXPECT_NE(nan.find("pixel 4, 3"), std::string::npos) << nan;
    pixels.set("G", 4, 3, 1.0F);
    pixels.set("B", 0, 1, std::numeric_limits<float>::infinity());
    const std::string infinite = message_of(write_scanlines(Imf::Header(width, height), pixels));
    EXPECT_NE(infinite.find("pixel 0, 1"), std::string::npos) << infinite;
}

TEST(DecodeExr, EveryPrefixIsAnError) {
    const std::string whole = write_scanlines(Imf::Header(width, height), Pixels({"R", "G", "B"}, Imf::HALF));
    for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_NE(message_of(whole.substr(0, size)), "") << size;
}

TEST(DecodeExr, OnlyCoarserLevelsMayBeMissing) {
    const std::string whole = write_tiles(Imf::MIPMAP_LEVELS, Imf::FLOAT);
    int read = 0;
    for (std::size_t size = 0; size < whole.size(); ++size) {
        const std::string cut = whole.substr(0, size);
        if (!message_of(cut).empty()) continue;
        expect_values(decode(cut).image);
        ++read;
    }
    EXPECT_LT(read, static_cast<int>(whole.size() / 2));
}

TEST(DecodeExr, NoDamagedByteIsFatal) {
    for (const std::string& whole : {write_scanlines(Imf::Header(width, height), Pixels({"R", "G", "B"}, Imf::HALF)),
                                     write_tiles(Imf::MIPMAP_LEVELS, Imf::FLOAT)}) {
        for (std::size_t i = 0; i < whole.size(); ++i) {
            for (const int mask : {0x01, 0x80, 0xff}) {
                std::string damaged = whole;
                damaged[i] = static_cast<char>(damaged[i] ^ mask);
                (void)message_of(damaged);
            }
        }
    }
}

// ---- Real files

TEST(SharedExr, EveryFileIsReadOrSaysWhyNot) {
    const fs::path data = fs::path(LIGHTGRID_SHARED) / "data";
    if (!fs::exists(data)) GTEST_SKIP() << "no shared data at " << data;
    // Files with R, G, B; all others there have one or two channels, or X, Y, Z.
    int read = 0;
    int refused = 0;
    for (const char* folder : {"env-openexr", "env-polyhaven-exr-dwab", "exr-magnum-tiny"}) {
        for (const fs::directory_entry& entry : fs::directory_iterator(data / folder)) {
            if (entry.path().extension() != ".exr") continue;
            const std::string name = entry.path().filename().string();
            const bool color = name.find("rgb") == 0 && name.find("custom-channels") == std::string::npos;
            try {
                const RadianceFile file = read_radiance(entry.path());
                EXPECT_TRUE(color || std::string(folder) != "exr-magnum-tiny") << name;
                EXPECT_EQ(file.image.pixels.size(), static_cast<std::size_t>(file.image.width) * file.image.height);
                ++read;
            } catch (const Error& error) {
                EXPECT_FALSE(color) << error.what();
                EXPECT_NE(std::string(error.what()).find("no colour"), std::string::npos) << error.what();
                ++refused;
            }
        }
    }
    EXPECT_EQ(read, 18);
    EXPECT_EQ(refused, 19);
}

}  // namespace
}  // namespace lightgrid
