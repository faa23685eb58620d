#pragma once
#include <filesystem>
#include <vector>

namespace firn {

/// The files of one run.
struct OutputFolder {
    std::filesystem::path path;

    std::filesystem::path picture(int frame) const;    ///< frames/frame_0000.png
    std::filesystem::path particles(int frame) const;  ///< particles/frame_0000.ply
    std::filesystem::path run_json() const { return path / "run.json"; }
    std::filesystem::path checkpoint() const { return path / "checkpoint.firn"; }

    bool has_results() const;                   ///< Whether a run has written here.
    std::vector<int> pictures_there() const;    ///< Numbers of the frames that have a picture, ascending.
    std::vector<int> particles_there() const;   ///< Numbers of the frames that have particles, ascending.
    void remove_results() const;                ///< Removes the files of a run, and nothing else.
    void remove_unfinished() const;             ///< Removes what a killed run left half written.
};

}  // namespace firn
