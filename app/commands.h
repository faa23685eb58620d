#pragma once
#include "app/overrides.h"
#include "app/progress.h"

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn {

/// The command line asks for what cannot be: exit code 2.
struct UsageError : std::runtime_error { using runtime_error::runtime_error; };

/// Frames from `first` to `last`, both included.
struct FrameRange { int first = 0, last = 0; };

/// Options of run, simulate and render.
struct RunOptions {
    std::string scene;              ///< a scene's file; for render also a folder with particles.
    std::string output;             ///< folder; empty: out/<scene>.
    Overrides overrides;
    std::optional<FrameRange> frames;
    bool resume = false, overwrite = false;
    bool pictures = true;           ///< false: simulate.
    bool particles = false;         ///< a PLY a frame.
    bool full_state = false;        ///< with every property.
    std::string video;              ///< film to make; empty: none.
    ProgressStyle progress = ProgressStyle::automatic;
};

struct CompareOptions {
    std::string a, b;               ///< two pictures, or two folders of pictures.
    double tolerance = 0;           ///< largest channel difference that counts as equal, 0 to 1.
    std::string heat_map;           ///< picture, or folder for two sequences; empty: none.
    bool json = false;
};

struct StudyOptions {
    std::string scene;
    std::string output;             ///< folder; empty: out/<scene>_study.
    Overrides overrides;
    std::vector<std::string> axes;  ///< what to vary.
    bool stability = false;         ///< maps of Δt against stiffness and speed instead.
    bool overwrite = false, quiet = false;
};

struct BenchOptions {
    double particles = 0;           ///< 0: 400 000, of pictures 10⁶.
    bool pictures = false;          ///< measure them instead of steps.
    int rounds = 5;
    std::string yardstick;          ///< a program to compare with, run in turns; empty: none.
};

// Each returns the program's exit code.
int run_command(const RunOptions&);
int render_command(const RunOptions&);
int check_command(const std::vector<std::string>& scenes, const Overrides&);
int compare_command(const CompareOptions&);
int study_command(const StudyOptions&);
int bench_command(const BenchOptions&);
int bench_pictures(const BenchOptions&);   // throws GLError
int scenes_command(const std::string& name, bool schema);

}  // namespace firn
