#include "app/output_folder.h"

#include "app/files.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

namespace firn {

namespace fs = std::filesystem;

fs::path OutputFolder::picture(int frame) const {
    return path / "frames" / fmt::format("frame_{:04}.png", frame);
}

fs::path OutputFolder::particles(int frame) const {
    return path / "particles" / fmt::format("frame_{:04}.ply", frame);
}

// What lies in a folder, nothing if it is not there.
static std::vector<fs::path> files_in(const fs::path& folder) {
    std::vector<fs::path> files;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
        files.push_back(it->path());
    return files;
}

// The numbers of files named frame_NUMBER.EXTENSION.
static std::vector<int> numbers(const fs::path& folder, const std::string& extension) {
    std::vector<int> all;
    for (const auto& file : files_in(folder)) {
        const std::string stem = file.stem().string();
        if (file.extension() != extension || !stem.starts_with("frame_")) continue;
        int number = 0;
        const auto result = std::from_chars(stem.data() + 6, stem.data() + stem.size(), number);
        if (result.ec == std::errc() && number >= 0 && stem == fmt::format("frame_{:04}", number))
            all.push_back(number);
    }
    std::sort(all.begin(), all.end());
    return all;
}

std::vector<int> OutputFolder::pictures_there() const { return numbers(path / "frames", ".png"); }

std::vector<int> OutputFolder::particles_there() const { return numbers(path / "particles", ".ply"); }

bool OutputFolder::has_results() const {
    return fs::exists(run_json()) || fs::exists(checkpoint()) || !pictures_there().empty() ||
           !particles_there().empty();
}

static void remove_file(const fs::path& file) {
    std::error_code error;
    fs::remove(file, error);
    if (error) throw FileError(fmt::format("cannot remove {}: {}", file.string(), error.message()));
}

void OutputFolder::remove_results() const {
    remove_file(checkpoint());
    remove_file(run_json());
    for (const int frame : pictures_there()) remove_file(picture(frame));
    for (const int frame : particles_there()) remove_file(particles(frame));
    remove_unfinished();
}

void OutputFolder::remove_unfinished() const {
    for (const auto& folder : {path, path / "frames", path / "particles"})
        for (const auto& file : files_in(folder))
            if (is_unfinished(file)) remove_file(file);
}

}  // namespace firn
