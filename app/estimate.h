#pragma once
#include "app/files.h"
#include "app/scene_particles.h"

namespace firn {

/// Memory or disk cannot hold the run: says how much is needed, how much is there and how to need less.
struct ResourceError : FileError { using FileError::FileError; };

/// What a run keeps.
struct RunFiles {
    int first_frame = 0, last_frame = 0;    ///< frames that get files.
    bool pictures = true;
    int columns = 0;                        ///< numbers a particle in PLY files; 0: none are written.
};

/// What a run needs [bytes].
struct Needs {
    double particles = 0, nodes = 0;
    double pictures = 0;    ///< of memory, whatever the particles.
    double memory = 0;      ///< at the peak.
    double disk = 0;        ///< when all is written; pictures are estimated from their size.
};
Needs needs_of(const LoadedScene&, double particles, double nodes, const RunFiles&);

/// Throws ResourceError if memory or the disk of the output folder cannot hold it.
void require_resources(const LoadedScene&, const Needs&, const std::filesystem::path& output);

/// Throws ResourceError if memory, with so much for all else (of which half counts at most), is too little for drawing
/// such pictures. `path` is the scene's.
void require_picture_memory(const Picture&, const std::string& path, double rest);

/// A first look, before anything is sampled: throws ResourceError where the particles alone are too many.
void require_resources_for_count(const LoadedScene&, const RunFiles&, const std::filesystem::path& output);

/// What `firn check` tells of a scene.
struct Estimate {
    Needs needs;
    double steps = 0;
    double seconds = 0;     ///< of simulating and drawing, from a short probe.
    std::vector<std::string> warnings;
};
Estimate estimate(const LoadedScene&, const std::filesystem::path& output);

/// "1.5 GB"
std::string bytes_text(double bytes);

}  // namespace firn
