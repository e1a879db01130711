#include "core/image.h"

#include "core/error.h"
#include "core/whole_file.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <string>
#include <unistd.h>
#include <vector>
#include <zlib.h>

namespace lightgrid {
namespace {

namespace fs = std::filesystem;

std::span<const std::byte> bytes_of(const std::string& text) {
    return std::as_bytes(std::span(text));
}

std::string from_hex(std::string_view hex) {
    std::string bytes;
    for (std::size_t i = 0; i + 1 < hex.size(); i += 2)
        bytes.push_back(static_cast<char>(std::stoi(std::string(hex.substr(i, 2)), nullptr, 16)));
    return bytes;
}

std::string big_endian(std::uint32_t value) {
    return {static_cast<char>(value >> 24), static_cast<char>(value >> 16), static_cast<char>(value >> 8),
            static_cast<char>(value)};
}

std::string png_chunk(const std::string& type, const std::string& data) {
    const std::string body = type + data;
    const uLong checksum = crc32(0, reinterpret_cast<const Bytef*>(body.data()), static_cast<uInt>(body.size()));
    return big_endian(static_cast<std::uint32_t>(data.size())) + body +
           big_endian(static_cast<std::uint32_t>(checksum));
}

/// rows  each led by its filter byte
std::string png(int width, int height, int bits, int color_type, const std::string& rows) {
    std::string packed(compressBound(rows.size()), '\0');
    uLongf size = packed.size();
    compress(reinterpret_cast<Bytef*>(packed.data()), &size, reinterpret_cast<const Bytef*>(rows.data()), rows.size());
    packed.resize(size);
    const std::string header = big_endian(width) + big_endian(height) + static_cast<char>(bits) +
                               static_cast<char>(color_type) + std::string(3, '\0');
    return "\x89PNG\r\n\x1a\n" + png_chunk("IHDR", header) + png_chunk("IDAT", packed) + png_chunk("IEND", "");
}

/// 8 x 8 of grey 200: the quantisation is 1, so that the one coefficient is (200 - 128) * 8 = 576, ten bits.
std::string grey_jpeg() {
    return from_hex("ffd8ffdb004300") + std::string(64, '\1') + from_hex("ffc0000b080008000801011100") +
           from_hex("ffc4001400") + from_hex("01") + std::string(15, '\0') + from_hex("0a") + from_hex("ffc4001410") +
           from_hex("01") + std::string(15, '\0') + from_hex("00") + from_hex("ffda0008010100003f00480fffd9");
}

/// Lossless 2 x 2: red, green / half transparent blue, (10, 20, 30).
std::string webp() {
    return from_hex(
        "5249464636000000574542505650384c290000002f014000101f20102078f0bf6a43484050fdff4b209064b23fe50212c273592ec60ebc"
        "4a"
        "ac4344ff4300");
}

std::string message_of(const std::string& bytes) {
    try {
        (void)decode_image(bytes_of(bytes), "wall.png");
    } catch (const Error& error) {
        return error.what();
    }
    return "";
}

class Folder {
  public:
    Folder() : path_(fs::temp_directory_path() / ("lightgrid_image_test_" + std::to_string(::getpid()))) {
        fs::create_directories(path_);
    }
    ~Folder() { fs::remove_all(path_); }
    [[nodiscard]] fs::path operator/(const char* name) const { return path_ / name; }
    [[nodiscard]] std::size_t files() const {
        return static_cast<std::size_t>(std::distance(fs::directory_iterator(path_), fs::directory_iterator()));
    }

  private:
    fs::path path_;
};

TEST(DecodeImage, ReadsPngGreyAndColour) {
    const ByteImage grey = decode_image(bytes_of(png(2, 1, 8, 0, {"\0\7\xff", 3})), "");
    EXPECT_EQ(grey.at(0, 0), glm::u8vec4(7, 7, 7, 255));
    EXPECT_EQ(grey.at(1, 0), glm::u8vec4(255, 255, 255, 255));
    const ByteImage color = decode_image(bytes_of(png(1, 2, 8, 6, {"\0\1\2\3\4\0\5\6\7\x8", 10})), "");
    EXPECT_EQ(color.at(0, 0), glm::u8vec4(1, 2, 3, 4));
    EXPECT_EQ(color.at(0, 1), glm::u8vec4(5, 6, 7, 8));
}

TEST(DecodeImage, RoundsSixteenBitsToEight) {
    // 65535 / 255 = 257: 128 * 257 + 128 is nearest to 128, one more to 129.
    const std::string row{"\0\x80\x80\x81\x00\x81\x01\xff\xff", 9};
    const ByteImage image = decode_image(bytes_of(png(4, 1, 16, 0, row)), "");
    EXPECT_EQ(image.at(0, 0).r, 128);
    EXPECT_EQ(image.at(1, 0).r, 128);
    EXPECT_EQ(image.at(2, 0).r, 129);
    EXPECT_EQ(image.at(3, 0), glm::u8vec4(255));
}

TEST(DecodeImage, ReadsJpeg) {
    const ByteImage image = decode_image(bytes_of(grey_jpeg()), "");
    ASSERT_EQ(glm::ivec2(image.width, image.height), glm::ivec2(8));
    for (const glm::u8vec4 pixel : image.pixels) EXPECT_EQ(pixel, glm::u8vec4(200, 200, 200, 255));
}

TEST(DecodeImage, ReadsWebp) {
    const ByteImage image = decode_image(bytes_of(webp()), "");
    ASSERT_EQ(image.pixels.size(), 4U);
    EXPECT_EQ(image.at(0, 0), glm::u8vec4(255, 0, 0, 255));
    EXPECT_EQ(image.at(1, 0), glm::u8vec4(0, 255, 0, 255));
    EXPECT_EQ(image.at(0, 1), glm::u8vec4(0, 0, 255, 128));
    EXPECT_EQ(image.at(1, 1), glm::u8vec4(10, 20, 30, 255));
}

TEST(DecodeImage, SizeComesFromTheHeaderAlone) {
    EXPECT_EQ(image_size(bytes_of(grey_jpeg()), ""), glm::ivec2(8, 8));
    EXPECT_EQ(image_size(bytes_of(webp()), ""), glm::ivec2(2, 2));
    // Signature, IHDR, and where the pixels begin: newer stb_image looks at all chunks before IDAT.
    const std::string header = png(3, 5, 8, 0, std::string(20, '\0')).substr(0, 8 + 25 + 8);
    EXPECT_EQ(image_size(bytes_of(header), ""), glm::ivec2(3, 5));
}

TEST(DecodeImage, NamesFormatsThatItDoesNotRead) {
    const std::string ktx2 = message_of(std::string("\xabKTX 20\xbb\r\n\x1a\n", 12) + std::string(100, 'x'));
    EXPECT_NE(ktx2.find("wall.png: the image is KTX2"), std::string::npos) << ktx2;
    EXPECT_NE(message_of("GIF89a......").find("GIF"), std::string::npos);
    EXPECT_NE(message_of("nonsense").find("neither PNG, JPEG nor WebP"), std::string::npos);
    EXPECT_NE(message_of("").find("empty"), std::string::npos);
}

TEST(DecodeImage, EveryPrefixIsAnError) {
    for (const std::string& whole : {png(2, 2, 8, 2, std::string(14, '\0')), grey_jpeg(), webp()}) {
        for (std::size_t size = 0; size < whole.size(); ++size)
            EXPECT_NE(message_of(whole.substr(0, size)), "") << size << " of " << whole.size();
        EXPECT_EQ(message_of(whole), "");
    }
}

TEST(DecodeImage, FlippedBytesGiveAnErrorOrAnImage) {
    for (const std::string& whole : {png(2, 2, 8, 2, std::string(14, '\0')), grey_jpeg(), webp()}) {
        for (std::size_t i = 0; i < whole.size(); ++i) {
            for (const int mask : {0x01, 0x80, 0xff}) {
                std::string damaged = whole;
                damaged[i] = static_cast<char>(damaged[i] ^ mask);
                (void)message_of(damaged);
            }
        }
    }
}

TEST(DecodeImage, RefusesHuffmanTablesThatAreTooLarge) {
    std::string jpeg = grey_jpeg();
    const std::size_t table = jpeg.find("\xff\xc4");
    ASSERT_NE(table, std::string::npos);
    for (std::size_t length = 0; length < 16; ++length) jpeg[table + 5 + length] = '\xff';
    EXPECT_NE(message_of(jpeg).find("Huffman table"), std::string::npos) << message_of(jpeg);
}

TEST(DecodeImage, NoticesEveryDamagedByteOfAPng) {
    const std::string whole = png(2, 2, 8, 2, std::string(14, '\0'));
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ 0x10);
        EXPECT_NE(message_of(damaged), "") << "byte " << i;
    }
}

TEST(DecodeSrgb, FollowsTheStandard) {
    EXPECT_EQ(decode_srgb(0), 0);
    EXPECT_EQ(decode_srgb(255), 1);
    EXPECT_FLOAT_EQ(decode_srgb(10), 10.0F / 255 / 12.92F);
    EXPECT_NEAR(decode_srgb(188), 0.5028864, 1e-6);  // ((188 / 255 + 0.055) / 1.055)^2.4
}

TEST(WritePng, ReadsBackTheSame) {
    const Folder folder;
    ByteImage image{3, 2, {}};
    for (int i = 0; i < 6; ++i) image.pixels.emplace_back(i, 40 * i, 255 - i, 255);
    write_png(image, folder / "opaque.png");
    const std::string opaque = read_whole_file(folder / "opaque.png");
    EXPECT_EQ(decode_image(bytes_of(opaque), "").pixels, image.pixels);
    image.at(1, 1).a = 3;
    write_png(image, folder / "clear.png");
    EXPECT_EQ(decode_image(bytes_of(read_whole_file(folder / "clear.png")), "").pixels, image.pixels);
    EXPECT_EQ(folder.files(), 2U);
}

TEST(WriteExr, ReadsBackTheSameBits) {
    const Folder folder;
    RadianceImage image{5, 3, {}};
    for (int i = 0; i < 15; ++i) image.pixels.emplace_back(1e-30F * i, -0.1F * i, 1e30F * i);
    write_exr(image, folder / "image.exr");
    const RadianceFile file = read_radiance(folder / "image.exr");
    EXPECT_EQ(file.image.width, 5);
    EXPECT_EQ(file.image.height, 3);
    EXPECT_EQ(file.image.pixels, image.pixels);
    EXPECT_TRUE(file.notices.empty());
    EXPECT_EQ(folder.files(), 1U);
}

TEST(WriteExr, AFolderThatIsMissingIsAnErrorOfTheWork) {
    const RadianceImage image{1, 1, {glm::vec3(1)}};
    try {
        write_exr(image, "/nonexistent/folder/image.exr");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.fault(), Fault::work);
        EXPECT_NE(std::string(error.what()).find("/nonexistent/folder/image.exr"), std::string::npos) << error.what();
    }
}

// ---- Radiance HDR

std::string hdr(const std::string& header, const std::string& size, const std::string& data) {
    return "#?RADIANCE\n" + header + "FORMAT=32-bit_rle_rgbe\n\n" + size + "\n" + data;
}

/// One pixel: mantissas 128, 64, 0 with exponent e are 2^(e - 129), 2^(e - 130), 0.
std::string rgbe(int exponent) {
    return {'\x80', '\x40', '\0', static_cast<char>(exponent)};
}

RadianceFile decode(const std::string& bytes) {
    return decode_radiance(bytes_of(bytes), "sky.hdr");
}

TEST(RadianceHdr, DecodesSharedExponents) {
    const RadianceFile file = decode(hdr("", "-Y 1 +X 3", rgbe(129) + rgbe(139) + std::string(4, '\0')));
    EXPECT_EQ(file.image.at(0, 0), glm::vec3(1, 0.5F, 0));
    EXPECT_EQ(file.image.at(1, 0), glm::vec3(1024, 512, 0));
    EXPECT_EQ(file.image.at(2, 0), glm::vec3(0));
    EXPECT_TRUE(file.notices.empty());
}

TEST(RadianceHdr, DecodesBothRunLengthCodes) {
    // By component: ten times 128, ten times 64, ten single zeros, nine times 129 and one 139.
    const std::string coded = from_hex(
        "0202000a"
        "8a80"
        "8a40"
        "0a00000000000000000000"
        "8981"
        "018b");
    const RadianceFile file = decode(hdr("", "-Y 1 +X 10", coded));
    for (int x = 0; x < 9; ++x) EXPECT_EQ(file.image.at(x, 0), glm::vec3(1, 0.5F, 0));
    EXPECT_EQ(file.image.at(9, 0), glm::vec3(1024, 512, 0));

    const std::string old = rgbe(129) + from_hex("01010103") + rgbe(130);
    const RadianceFile repeated = decode(hdr("", "-Y 1 +X 5", old));
    for (int x = 0; x < 4; ++x) EXPECT_EQ(repeated.image.at(x, 0), glm::vec3(1, 0.5F, 0));
    EXPECT_EQ(repeated.image.at(4, 0), glm::vec3(2, 1, 0));
}

TEST(RadianceHdr, TurnsRowsThatAreStoredTheOtherWay) {
    const std::string four = rgbe(129) + rgbe(130) + rgbe(131) + rgbe(132);
    EXPECT_EQ(decode(hdr("", "+Y 2 +X 2", four)).image.at(0, 0).r, 4);
    EXPECT_EQ(decode(hdr("", "-Y 2 -X 2", four)).image.at(0, 0).r, 2);
}

TEST(RadianceHdr, DividesByTheExposureAndSaysSo) {
    const RadianceFile file = decode(hdr("EXPOSURE= 2.0\nEXPOSURE=4\n", "-Y 1 +X 1", rgbe(132)));
    EXPECT_EQ(file.image.at(0, 0), glm::vec3(1, 0.5F, 0));
    ASSERT_EQ(file.notices.size(), 1U);
    EXPECT_NE(file.notices[0].find("EXPOSURE"), std::string::npos);
}

TEST(RadianceHdr, RefusesWhatItCannotRead) {
    EXPECT_THROW(decode("#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 1 +X 1\n" + rgbe(129)), Error);
    EXPECT_THROW(decode(hdr("", "+X 1 -Y 1", rgbe(129))), Error);
    EXPECT_THROW(decode(hdr("", "-Y 100000 +X 100000", rgbe(129))), Error);
    EXPECT_THROW(decode(hdr("", "-Y 10000 +X 10000", rgbe(129))), Error);  // refused before memory is taken
}

TEST(RadianceHdr, EveryPrefixIsAnErrorAndNoByteIsFatal) {
    const std::string coded = from_hex(
        "0202000a"
        "8a80"
        "8a40"
        "0a00000000000000000000"
        "8981"
        "018b");
    const std::string whole = hdr("EXPOSURE=1\n", "-Y 2 +X 10", coded + coded);
    for (std::size_t size = 0; size < whole.size(); ++size) EXPECT_THROW(decode(whole.substr(0, size)), Error) << size;
    for (std::size_t i = 0; i < whole.size(); ++i) {
        std::string damaged = whole;
        damaged[i] = static_cast<char>(damaged[i] ^ 0xff);
        try {
            (void)decode(damaged);
        } catch (const Error&) {
        }
    }
}

TEST(DecodeRadiance, ReadsEightBitImagesAsSrgb) {
    const RadianceFile file = decode(png(2, 1, 8, 0, {"\0\0\xff", 3}));
    EXPECT_EQ(file.image.at(0, 0), glm::vec3(0));
    EXPECT_EQ(file.image.at(1, 0), glm::vec3(1));
    EXPECT_EQ(file.notices.size(), 1U);
}

// ---- Real files

TEST(SharedImages, EveryTextureDecodesToItsStatedSize) {
    const fs::path data = fs::path(LIGHTGRID_SHARED) / "data";
    if (!fs::exists(data)) GTEST_SKIP() << "no shared data at " << data;
    int count = 0;
    for (const fs::directory_entry& entry : fs::recursive_directory_iterator(data)) {
        const std::string extension = entry.path().extension().string();
        const bool invalid = entry.path().string().find("invalid") != std::string::npos;
        if (!entry.is_regular_file() || invalid || (extension != ".png" && extension != ".jpg" && extension != ".webp"))
            continue;
        const std::string bytes = read_whole_file(entry.path());
        const glm::ivec2 size = image_size(bytes_of(bytes), entry.path().string());
        const ByteImage image = decode_image(bytes_of(bytes), entry.path().string());
        EXPECT_EQ(size, glm::ivec2(image.width, image.height)) << entry.path();
        ++count;
    }
    EXPECT_GT(count, 30);
}

}  // namespace
}  // namespace lightgrid
