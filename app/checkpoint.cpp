#include "app/checkpoint.h"

#include "app/files.h"
#include "app/hash.h"

#include <fmt/format.h>
#include <zstd.h>

#include <array>
#include <cstring>
#include <istream>
#include <memory>
#include <ostream>
#include <streambuf>

namespace firn {

using Json = nlohmann::ordered_json;

// The file: magic, size of the header (8 bytes, little-endian), header (JSON), compressed state, and the hash
// of everything before it (32 digits).
constexpr std::string_view magic = "firn checkpoint 3\n";
constexpr std::size_t hash_size = 32;
constexpr int compression_level = 1;

static void need(std::size_t zstd_code) {
    if (ZSTD_isError(zstd_code)) throw FileError(fmt::format("zstd: {}", ZSTD_getErrorName(zstd_code)));
}

// Compresses what is written to it.
class CompressingBuffer : public std::streambuf {
public:
    CompressingBuffer() : context_(ZSTD_createCCtx(), ZSTD_freeCCtx), input_(ZSTD_CStreamInSize()) {
        need(ZSTD_CCtx_setParameter(context_.get(), ZSTD_c_compressionLevel, compression_level));
        setp(input_.data(), input_.data() + input_.size());
    }

    std::string finish() {
        flush(ZSTD_e_end);
        return std::move(output_);
    }

protected:
    int_type overflow(int_type c) override {
        flush(ZSTD_e_continue);
        return traits_type::eq_int_type(c, traits_type::eof()) ? traits_type::not_eof(c)
                                                               : sputc(traits_type::to_char_type(c));
    }

private:
    void flush(ZSTD_EndDirective directive) {
        ZSTD_inBuffer in{pbase(), static_cast<std::size_t>(pptr() - pbase()), 0};
        std::size_t left = 1;
        while (in.pos < in.size || (directive == ZSTD_e_end && left != 0)) {
            std::array<char, 1 << 16> block;
            ZSTD_outBuffer out{block.data(), block.size(), 0};
            left = ZSTD_compressStream2(context_.get(), &out, &in, directive);
            need(left);
            output_.append(block.data(), out.pos);
        }
        setp(input_.data(), input_.data() + input_.size());
    }

    std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context_;
    std::vector<char> input_;
    std::string output_;
};

// Decompresses what is read from it.
class DecompressingBuffer : public std::streambuf {
public:
    explicit DecompressingBuffer(const std::string& compressed)
        : context_(ZSTD_createDCtx(), ZSTD_freeDCtx), in_{compressed.data(), compressed.size(), 0},
          output_(ZSTD_DStreamOutSize()) {}

protected:
    int_type underflow() override {
        ZSTD_outBuffer out{output_.data(), output_.size(), 0};
        while (out.pos == 0 && in_.pos < in_.size) need(ZSTD_decompressStream(context_.get(), &out, &in_));
        setg(output_.data(), output_.data(), output_.data() + out.pos);
        return out.pos == 0 ? traits_type::eof() : traits_type::to_int_type(output_.front());
    }

private:
    std::unique_ptr<ZSTD_DCtx, decltype(&ZSTD_freeDCtx)> context_;
    ZSTD_inBuffer in_;
    std::vector<char> output_;
};

std::string compressed_state(const Simulation& simulation) {
    CompressingBuffer buffer;
    std::ostream stream(&buffer);
    stream.exceptions(std::ios::badbit);
    simulation.save(stream);
    return buffer.finish();
}

void restore_state(Simulation& simulation, const std::string& compressed) {
    DecompressingBuffer buffer(compressed);
    std::istream stream(&buffer);
    stream.exceptions(std::ios::badbit);
    try {
        simulation.restore(stream);
    } catch (const std::runtime_error& e) {
        throw FileError(fmt::format("the checkpoint's state does not fit the scene: {}", e.what()));
    }
}

void write_checkpoint(const std::filesystem::path& path, const Checkpoint& c) {
    Json frames = Json::array();
    for (const auto& record : c.frames) frames.push_back(to_json(record));
    const std::string header = Json{{"version", c.version}, {"scene", c.scene}, {"scene_hash", c.scene_hash},
                                    {"frame", c.frame}, {"inside", c.inside}, {"running", to_json(c.running)},
                                    {"frames", frames}}.dump();
    std::string start(magic);
    for (int byte = 0; byte < 8; ++byte) start += static_cast<char>(header.size() >> (8 * byte));
    start += header;
    write_file(path, {start, c.state, hash_hex({start, c.state})});
}

Checkpoint read_checkpoint(const std::filesystem::path& path) {
    const auto damaged = [&](const std::string& why) {
        return FileError(
            fmt::format("{} is damaged ({}); remove it and use --resume to begin again, or --overwrite",
                        path.string(), why));
    };
    std::string bytes = read_file(path, available_memory());
    const std::string_view all = bytes;
    if (!all.starts_with(magic.substr(0, 16))) throw damaged("it is no checkpoint");
    if (!all.starts_with(magic)) throw damaged("it is of another version's format");
    if (all.size() < magic.size() + 8 + hash_size) throw damaged("it is too short");
    const std::string_view hashed = all.substr(0, all.size() - hash_size);
    if (hash_hex({hashed}) != all.substr(hashed.size())) throw damaged("its checksum is wrong");
    std::size_t header_size = 0;
    for (std::size_t byte = 0; byte < 8; ++byte)
        header_size |= static_cast<std::size_t>(static_cast<unsigned char>(all[magic.size() + byte]))
                       << (8 * byte);
    const std::size_t header_at = magic.size() + 8;
    if (header_size > hashed.size() - header_at) throw damaged("its header is too long");
    try {
        const Json header = Json::parse(all.substr(header_at, header_size));
        Checkpoint c;
        header.at("version").get_to(c.version);
        c.scene = header.at("scene");
        header.at("scene_hash").get_to(c.scene_hash);
        header.at("frame").get_to(c.frame);
        header.at("inside").get_to(c.inside);
        c.running = frame_record_from(header.at("running"));
        for (const auto& record : header.at("frames")) c.frames.push_back(frame_record_from(record));
        c.state = hashed.substr(header_at + header_size);
        return c;
    } catch (const Json::exception& e) {
        throw damaged(e.what());
    }
}

}  // namespace firn
