#include "app/video.h"

#include "app/files.h"
#include "render/png.h"

#include <fmt/format.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <sstream>
#include <stdexcept>
#include <system_error>
#include <vector>

namespace firn {

namespace fs = std::filesystem;

void require_ffmpeg() {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path ? path : "/usr/bin:/bin");
    for (std::string folder; std::getline(folders, folder, ':');)
        if (::access((fs::path(folder) / "ffmpeg").c_str(), X_OK) == 0) return;
    throw std::invalid_argument("--video needs ffmpeg, which is not installed (apt-get install ffmpeg)");
}

// Runs a program found through PATH, without a shell; its exit code, or 128 + the signal that ended it.
static int run_program(const std::vector<std::string>& words) {
    std::vector<char*> arguments;
    for (const auto& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    pid_t child = 0;
    const int error = ::posix_spawnp(&child, arguments[0], nullptr, nullptr, arguments.data(), environ);
    if (error != 0) throw FileError("cannot run " + words[0] + ": " + std::generic_category().message(error));
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {}
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
}

// ffmpeg's arguments: H.264 for every player (even size, 4:2:0), colours tagged as what they are.
static std::vector<std::string> ffmpeg_words(const std::string& pictures, int first, int count, double fps,
                                             const std::string& film) {
    std::vector<std::string> words{"ffmpeg", "-nostdin", "-v", "error", "-y"};
    for (const auto& [option, value] : std::vector<std::array<std::string, 2>>{
             {"-framerate", fmt::format("{}", fps)},
             {"-start_number", std::to_string(first)},
             {"-i", pictures},
             {"-frames:v", std::to_string(count)},
             {"-vf", "pad=ceil(iw/2)*2:ceil(ih/2)*2,scale=out_color_matrix=bt709:out_range=tv"},
             {"-pix_fmt", "yuv420p"},
             {"-colorspace", "bt709"},
             {"-color_primaries", "bt709"},
             {"-color_trc", "bt709"},
             {"-color_range", "tv"},
             {"-movflags", "+faststart"}}) {
        words.push_back(option);
        words.push_back(value);
    }
    words.push_back(film);
    return words;
}

void make_video(const OutputFolder& folder, int first, int last, double fps, const fs::path& film) {
    for (int frame = first; frame <= last; ++frame)  // ffmpeg ends a film at a gap and reports success
        if (const auto picture = folder.picture(frame); !is_whole_png(picture.string()))
            throw FileError(fmt::format("no film: {} is missing or not whole", picture.string()));
    const std::string extension = film.has_extension() ? film.extension().string() : ".mp4";
    const std::string name = fmt::format(".{}.{}{}", film.stem().string(), ::getpid(), extension);
    const fs::path beside = fs::absolute(film).parent_path() / name;  // absolute: no option, no protocol
    std::string pictures;
    for (const char c : fs::absolute(folder.path / "frames").string())
        pictures += c == '%' ? "%%" : std::string(1, c);
    const int code =
        run_program(ffmpeg_words(pictures + "/frame_%04d.png", first, last - first + 1, fps, beside));
    std::error_code error;
    if (code == 0) fs::rename(beside, film, error);
    if (code == 0 && !error) return;
    fs::remove(beside, error);
    throw FileError(fmt::format("cannot write {}: ffmpeg ended with code {}; the pictures are kept",
                                film.string(), code));
}

}  // namespace firn
