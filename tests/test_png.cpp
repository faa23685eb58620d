#include "render/png.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <fstream>
#include <random>

using namespace firn;

namespace {

using Bytes = std::vector<std::uint8_t>;

/// A folder that is gone with the test.
struct Folder {
    std::filesystem::path path =
        std::filesystem::temp_directory_path() / ("firn_png_" + std::to_string(std::random_device()()));
    Folder() { std::filesystem::create_directory(path); }
    ~Folder() { std::filesystem::remove_all(path); }
    std::string write(const std::string& name, const Bytes& bytes) const {
        const std::string file = (path / name).string();
        std::ofstream(file, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
        return file;
    }
};

Image random_image(int width, int height, unsigned seed) {
    std::mt19937 random(seed);
    Image image{width, height, {}};
    for (int i = 0; i < 3 * width * height; ++i)
        image.pixels.push_back(static_cast<std::uint8_t>(random() >> 24));
    return image;
}

/// CRC-32 bit by bit, as the PNG specification defines it.
std::uint32_t checksum(const std::uint8_t* data, std::size_t size) {
    std::uint32_t crc = 0xffffffffu;
    for (std::size_t i = 0; i < size; ++i) {
        crc ^= data[i];
        for (int bit = 0; bit < 8; ++bit) crc = crc & 1 ? (crc >> 1) ^ 0xedb88320u : crc >> 1;
    }
    return ~crc;
}

void put_big_endian(Bytes& bytes, std::size_t at, std::uint32_t n) {
    for (int i = 0; i < 4; ++i) bytes[at + i] = static_cast<std::uint8_t>(n >> (24 - 8 * i));
}

std::string message_of(const std::string& path) {
    try {
        read_png(path);
    } catch (const std::runtime_error& error) {
        return error.what();
    }
    return "no error";
}

}  // namespace

TEST_CASE("a picture comes back from PNG as it was", "[png]") {
    const Folder folder;
    for (const auto& [width, height] : {std::pair(1, 1), {7, 5}, {64, 33}, {1, 300}, {300, 1}}) {
        CAPTURE(width, height);
        const Image image = random_image(width, height, 7);
        const Image back = read_png(folder.write("a.png", encode_png(image, {})));
        CHECK(back.width == width);
        CHECK(back.height == height);
        CHECK(back.pixels == image.pixels);
    }
}

TEST_CASE("texts come back from PNG, in every script", "[png]") {
    const std::map<std::string, std::string> texts = {{"Title", "Snowball against a wall"},
                                                      {"Author", "Dvořák"},
                                                      {"Place", "Zürich"},
                                                      {"Comment", "雪 ❄\nline 2"},
                                                      {"Empty", ""}};
    CHECK(png_texts(encode_png(random_image(3, 2, 1), texts)) == texts);
    CHECK_THROWS_AS(encode_png(random_image(3, 2, 1), {{"", "x"}}), std::invalid_argument);
    CHECK_THROWS_AS(encode_png(random_image(3, 2, 1), {{std::string(80, 'k'), "x"}}), std::invalid_argument);
    CHECK_THROWS_AS(encode_png(random_image(3, 2, 1), {{"Key", std::string("a\0b", 3)}}),
                    std::invalid_argument);
}

TEST_CASE("a PNG is tagged sRGB before its pixels, with right checksums", "[png]") {
    const Bytes png = encode_png(random_image(5, 4, 2), {{"Title", "x"}});
    std::vector<std::string> types;
    for (std::size_t at = 8; at < png.size();) {
        const std::size_t size = png[at] << 24 | png[at + 1] << 16 | png[at + 2] << 8 | png[at + 3];
        types.emplace_back(&png[at + 4], &png[at + 8]);
        Bytes expected(4);
        put_big_endian(expected, 0, checksum(&png[at + 4], size + 4));
        CHECK(Bytes(&png[at + 8 + size], &png[at + 8 + size] + 4) == expected);
        at += size + 12;
    }
    CHECK(types == std::vector<std::string>{"IHDR", "sRGB", "tEXt", "IDAT", "IEND"});
}

TEST_CASE("the same picture gives the same PNG", "[png]") {
    const Image image = random_image(50, 40, 3);
    CHECK(encode_png(image, {{"Title", "x"}}) == encode_png(image, {{"Title", "x"}}));
}

TEST_CASE("a picture whose size does not fit its pixels is not encoded", "[png]") {
    CHECK_THROWS_AS(encode_png({0, 0, {}}, {}), std::invalid_argument);
    CHECK_THROWS_AS(encode_png({2, 2, Bytes(11)}, {}), std::invalid_argument);
    CHECK_THROWS_AS(encode_png({-1, 2, Bytes(6)}, {}), std::invalid_argument);
}

TEST_CASE("PNGs of palettes and of 16 bits are read as 8-bit RGB", "[png]") {
    const Folder folder;
    const Bytes palette = {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
                           0x44, 0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x02, 0x03, 0x00, 0x00,
                           0x00, 0x0f, 0xd8, 0xe5, 0xb7, 0x00, 0x00, 0x00, 0x0c, 0x50, 0x4c, 0x54, 0x45, 0xff,
                           0x00, 0x00, 0x00, 0xff, 0x00, 0x00, 0x00, 0xff, 0x0a, 0x14, 0x1e, 0x22, 0x88, 0x29,
                           0x04, 0x00, 0x00, 0x00, 0x0c, 0x49, 0x44, 0x41, 0x54, 0x78, 0x9c, 0x63, 0x10, 0x60,
                           0xd8, 0x00, 0x00, 0x00, 0xe4, 0x00, 0xc1, 0x27, 0xa8, 0xe8, 0x57, 0x00, 0x00, 0x00,
                           0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
    const Bytes grey16 = {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49,
                          0x48, 0x44, 0x52, 0x00, 0x00, 0x00, 0x02, 0x00, 0x00, 0x00, 0x02, 0x10, 0x00,
                          0x00, 0x00, 0x00, 0x07, 0x4d, 0x8e, 0xbb, 0x00, 0x00, 0x00, 0x12, 0x49, 0x44,
                          0x41, 0x54, 0x78, 0x9c, 0x63, 0x60, 0x60, 0x68, 0xf8, 0xcf, 0xf0, 0xff, 0xbf,
                          0x90, 0x09, 0x00, 0x10, 0xd5, 0x03, 0xc4, 0x23, 0x72, 0xf4, 0x6e, 0x00, 0x00,
                          0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
    CHECK(read_png(folder.write("palette.png", palette)).pixels ==
          Bytes{255, 0, 0, 0, 255, 0, 0, 0, 255, 10, 20, 30});
    CHECK(read_png(folder.write("grey16.png", grey16)).pixels ==
          Bytes{0, 0, 0, 0x80, 0x80, 0x80, 255, 255, 255, 0x12, 0x12, 0x12});
}

TEST_CASE("a PNG that lets something through is refused", "[png]") {
    const Folder folder;
    const Bytes half = {0x89, 0x50, 0x4e, 0x47, 0x0d, 0x0a, 0x1a, 0x0a, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x48,
                        0x44, 0x52, 0x00, 0x00, 0x00, 0x01, 0x00, 0x00, 0x00, 0x01, 0x08, 0x06, 0x00, 0x00,
                        0x00, 0x1f, 0x15, 0xc4, 0x89, 0x00, 0x00, 0x00, 0x0d, 0x49, 0x44, 0x41, 0x54, 0x78,
                        0x9c, 0x63, 0xe0, 0x12, 0x91, 0x6b, 0x00, 0x00, 0x01, 0x25, 0x00, 0xbd, 0xee, 0x46,
                        0x39, 0x1e, 0x00, 0x00, 0x00, 0x00, 0x49, 0x45, 0x4e, 0x44, 0xae, 0x42, 0x60, 0x82};
    CHECK_THROWS_WITH(read_png(folder.write("half.png", half)),
                      Catch::Contains("half.png lets through what is behind it"));
}

TEST_CASE("a PNG that is cut off or damaged anywhere is refused, by name", "[png]") {
    const Folder folder;
    const Bytes whole = encode_png(random_image(6, 5, 4), {{"Title", "x"}});
    const std::string file = folder.write("a.png", whole);
    CHECK(is_whole_png(file));
    for (std::size_t size = 0; size < whole.size(); ++size) {
        CAPTURE(size);
        folder.write("a.png", Bytes(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size)));
        CHECK_FALSE(is_whole_png(file));
        CHECK(message_of(file).find(file) == 0);
    }
    for (std::size_t at = 0; at < whole.size(); ++at) {
        CAPTURE(at);
        Bytes damaged = whole;
        damaged[at] ^= 0x10;
        folder.write("a.png", damaged);
        CHECK_FALSE(is_whole_png(file));
        CHECK(message_of(file).find(file) == 0);
    }
}

TEST_CASE("what cannot be a picture is refused, with the reason", "[png]") {
    const Folder folder;
    CHECK(message_of(folder.write("empty.png", {})).find("is empty") != std::string::npos);
    CHECK(message_of(folder.path.string()).find("is a folder") != std::string::npos);
    CHECK(message_of((folder.path / "none.png").string()).find("does not exist") != std::string::npos);
    CHECK(message_of(folder.write("text.png", {'h', 'e', 'l', 'l', 'o'})).find("is not a PNG") !=
          std::string::npos);
    CHECK_FALSE(is_whole_png(folder.path.string()));

    Bytes huge = encode_png(random_image(2, 2, 5), {});
    put_big_endian(huge, 16, 60000), put_big_endian(huge, 20, 60000);
    put_big_endian(huge, 29, checksum(&huge[12], 17));
    CHECK(message_of(folder.write("huge.png", huge)).find("is too large: 60000×60000") != std::string::npos);

    Bytes garbled = encode_png(random_image(2, 2, 5), {});
    const std::size_t pixels = garbled.size() - 12 - 8;  // the compressed data's last bytes
    garbled[pixels - 8] ^= 0xff;
    const std::size_t start = 33 + 13 + 4;  // of the type IDAT
    put_big_endian(garbled, garbled.size() - 16, checksum(&garbled[start], garbled.size() - 16 - start));
    CHECK(is_whole_png(folder.write("garbled.png", garbled)));
    CHECK_NOTHROW(message_of(folder.write("garbled.png", garbled)));
}
