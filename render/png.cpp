#include "render/png.h"

#include "render/latin1.h"

#include <libdeflate.h>
#include <stb_image.h>
#include <stb_image_write.h>

#include <cerrno>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>

// stb_image_write defines this for all, but declares it for itself alone.
extern "C" unsigned char* stbi_write_png_to_mem(const unsigned char* pixels, int stride, int x, int y,
                                                int channels, int* size);

namespace firn {

namespace {

using Bytes = std::vector<std::uint8_t>;

constexpr std::uint8_t signature[8] = {137, 80, 78, 71, 13, 10, 26, 10};
constexpr std::size_t header_end = 8 + 12 + 13;           // signature and IHDR
constexpr std::size_t max_pixels = std::size_t(1) << 28;  // 16384²

std::uint32_t big_endian(const std::uint8_t* b) {
    return std::uint32_t(b[0]) << 24 | std::uint32_t(b[1]) << 16 | std::uint32_t(b[2]) << 8 | b[3];
}

void append_big_endian(Bytes& bytes, std::uint32_t n) {
    for (const int shift : {24, 16, 8, 0}) bytes.push_back(static_cast<std::uint8_t>(n >> shift));
}

/// A chunk is its data's length, its type, the data, and the checksum of type and data.
void append_chunk(Bytes& png, const char* type, const std::string& data) {
    append_big_endian(png, static_cast<std::uint32_t>(data.size()));
    const std::size_t start = png.size();
    png.insert(png.end(), type, type + 4);
    png.insert(png.end(), data.begin(), data.end());
    append_big_endian(png, libdeflate_crc32(0, &png[start], png.size() - start));
}

void append_text(Bytes& png, const std::string& key, const std::string& text) {
    bool fits = !key.empty() && key.size() <= 79 && key.front() != ' ' && key.back() != ' ';
    for (const char c : key) fits = fits && c >= 32 && c < 127;
    if (!fits || text.find('\0') != std::string::npos || text.size() > INT_MAX / 2)
        throw std::invalid_argument("no PNG text can have the key '" + key + "', or its value");
    if (const auto latin1 = latin1_of(text))
        append_chunk(png, "tEXt", key + '\0' + *latin1);
    else  // not compressed, no language, no translated key
        append_chunk(png, "iTXt", key + std::string(5, '\0') + text);
}

struct Chunk {
    std::string type;
    const std::uint8_t* data;
    std::size_t size;
};

/// Every chunk in order, with its checksum checked. Throws std::runtime_error for anything but a whole PNG.
std::vector<Chunk> chunks_of(const Bytes& bytes) {
    const auto truncated = [&] {
        return std::runtime_error("is cut off after " + std::to_string(bytes.size()) + " bytes");
    };
    if (bytes.empty()) throw std::runtime_error("is empty");
    const std::size_t compared = std::min(bytes.size(), sizeof signature);
    if (std::memcmp(bytes.data(), signature, compared) != 0) throw std::runtime_error("is not a PNG");
    if (bytes.size() < header_end) throw truncated();

    std::vector<Chunk> chunks;
    for (std::size_t at = 8;;) {
        if (bytes.size() - at < 12) throw truncated();
        const std::size_t size = big_endian(&bytes[at]);
        if (bytes.size() - at - 12 < size) throw truncated();
        const Chunk chunk{std::string(&bytes[at + 4], &bytes[at + 8]), &bytes[at] + 8, size};
        if (big_endian(chunk.data + size) != libdeflate_crc32(0, &bytes[at + 4], size + 4))
            throw std::runtime_error("is damaged: wrong checksum of the chunk at byte " + std::to_string(at));
        chunks.push_back(chunk);
        at += size + 12;
        if (chunk.type == "IEND") break;
    }
    if (chunks[0].type != "IHDR" || chunks[0].size != 13) throw std::runtime_error("has no header");
    return chunks;
}

Bytes file_bytes(const std::string& path) {
    namespace fs = std::filesystem;
    std::error_code error;
    const fs::file_status status = fs::status(path, error);
    if (!fs::exists(status)) throw std::runtime_error("does not exist");
    if (fs::is_directory(status)) throw std::runtime_error("is a folder");
    if (!fs::is_regular_file(status)) throw std::runtime_error("is not a file");
    const std::uintmax_t size = fs::file_size(path, error);
    if (error) throw std::runtime_error("cannot be read: " + error.message());
    if (size > 8 * max_pixels) throw std::runtime_error("is too large for a picture");
    errno = 0;
    std::ifstream file(path, std::ios::binary);
    if (!file) throw std::runtime_error(std::string("cannot be opened: ") + std::strerror(errno));
    Bytes bytes(size);
    file.read(reinterpret_cast<char*>(bytes.data()), static_cast<std::streamsize>(size));
    if (static_cast<std::uintmax_t>(file.gcount()) != size)
        throw std::runtime_error("cannot be read to its end");
    return bytes;
}

Image decode(const Bytes& bytes) {
    const std::vector<Chunk> chunks = chunks_of(bytes);
    const std::size_t width = big_endian(chunks[0].data), height = big_endian(chunks[0].data + 4);
    if (width == 0 || height == 0) throw std::runtime_error("has no pixels");
    if (width > 65536 || height > 65536 || width * height > max_pixels)
        throw std::runtime_error("is too large: " + std::to_string(width) + "×" + std::to_string(height));
    std::size_t compressed = 0;
    for (const Chunk& chunk : chunks) compressed += chunk.type == "IDAT" ? chunk.size : 0;
    // Pixels have 8 bytes at most, and what does not get smaller grows by little.
    if (compressed > 9 * width * height + height + 65536)
        throw std::runtime_error("holds more data than pixels");

    int w = 0, h = 0, channels = 0;
    const std::unique_ptr<stbi_uc, decltype(&std::free)> pixels(
        stbi_load_from_memory(bytes.data(), static_cast<int>(bytes.size()), &w, &h, &channels, 4), std::free);
    if (!pixels) throw std::runtime_error(std::string("cannot be decoded: ") + stbi_failure_reason());
    Image image{w, h, Bytes(3 * width * height)};
    for (std::size_t i = 0; i < width * height; ++i) {
        if (pixels.get()[4 * i + 3] != 255) throw std::runtime_error("lets through what is behind it: no picture of its own");
        std::copy_n(&pixels.get()[4 * i], 3, &image.pixels[3 * i]);
    }
    return image;
}

}  // namespace

Bytes encode_png(const Image& image, const std::map<std::string, std::string>& texts) {
    const auto width = static_cast<std::size_t>(image.width), height = static_cast<std::size_t>(image.height);
    if (image.width < 1 || image.height < 1 || image.pixels.size() != 3 * width * height)
        throw std::invalid_argument("a picture without pixels cannot be encoded");
    if (width * height > max_pixels) throw std::invalid_argument("a picture of more than 2²⁸ pixels");

    stbi_write_force_png_filter = 1;  // Sub: as small as the best of five for our pictures, and faster
    int size = 0;
    const std::unique_ptr<unsigned char, decltype(&std::free)> encoded(
        stbi_write_png_to_mem(image.pixels.data(), 0, image.width, image.height, 3, &size), std::free);
    if (!encoded) throw std::bad_alloc();

    Bytes png(encoded.get(), encoded.get() + header_end);
    append_chunk(png, "sRGB", std::string(1, '\0'));  // perceptual
    for (const auto& [key, text] : texts) append_text(png, key, text);
    png.insert(png.end(), encoded.get() + header_end, encoded.get() + size);
    return png;
}

Image read_png(const std::string& path) {
    try {
        return decode(file_bytes(path));
    } catch (const std::runtime_error& error) {
        throw std::runtime_error(path + " " + error.what());
    } catch (const std::bad_alloc&) {
        throw std::runtime_error(path + " needs more memory than there is");
    }
}

std::map<std::string, std::string> png_texts(const Bytes& bytes) {
    std::map<std::string, std::string> texts;
    for (const Chunk& chunk : chunks_of(bytes)) {
        const std::string data(chunk.data, chunk.data + chunk.size);
        const std::size_t key_end = data.find('\0');
        if (key_end == std::string::npos) continue;
        const std::string key = data.substr(0, key_end);
        if (chunk.type == "tEXt") texts[key] = utf8_of_latin1(data.substr(key_end + 1));
        if (chunk.type != "iTXt" || data.size() < key_end + 3 || data[key_end + 1] != 0) continue;
        const std::size_t language_end = data.find('\0', key_end + 3);
        if (language_end == std::string::npos) continue;
        const std::size_t translation_end = data.find('\0', language_end + 1);
        if (translation_end != std::string::npos) texts[key] = data.substr(translation_end + 1);
    }
    return texts;
}

bool is_whole_png(const std::string& path) {
    try {
        chunks_of(file_bytes(path));
        return true;
    } catch (const std::exception&) {
        return false;
    }
}

}  // namespace firn
