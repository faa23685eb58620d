#pragma once
#include "app/record.h"

#include <filesystem>

namespace firn {

/// Where a run is, so that it can go on from there as if it had never stopped.
struct Checkpoint {
    std::string version;                ///< of the program that wrote it.
    nlohmann::ordered_json scene;       ///< resolved.
    std::string scene_hash;
    int frame = 0;                      ///< newest frame that was reached.
    double inside = 0;                  ///< time since then [s].
    FrameRecord running;                ///< of the steps since then.
    std::vector<FrameRecord> frames;    ///< of the frames so far.
    std::string state;                  ///< of the simulation, compressed.
};

/// The simulation's whole state, compressed.
std::string compressed_state(const Simulation&);

/// Puts it back. Throws FileError if it is no such state.
void restore_state(Simulation&, const std::string& compressed);

void write_checkpoint(const std::filesystem::path&, const Checkpoint&);

/// Throws FileError that says what to do if the file is damaged or none of this program's.
Checkpoint read_checkpoint(const std::filesystem::path&);

}  // namespace firn
