#pragma once
#include "app/checkpoint.h"
#include "app/commands.h"
#include "app/output_folder.h"

namespace firn {

/// Where a run is.
struct Position {
    int frame = 0;          ///< newest frame that was reached.
    double inside = 0;      ///< time since then [s].
    FrameRecord running;    ///< of the steps since then.
};

/// From where and with what a run goes on.
struct Resumption {
    Position position;
    std::vector<FrameRecord> frames;    ///< so far.
    std::string state;                  ///< of the simulation, compressed; empty: from the start.
    std::vector<int> redraw;            ///< frames whose picture is missing but whose particles are there.
    std::vector<std::string> notes;     ///< for the user.
};

/// Whether the folder holds this frame's picture, to its last byte, as the scene of that hash has it.
bool has_picture(const OutputFolder&, int frame, const std::string& scene_hash);

/// Reads the newest checkpoint and looks at the files of the frames before it. Throws UsageError if it is of
/// another scene or if files are missing that cannot be made again, FileError if it is damaged.
Resumption resume(const LoadedScene&, const OutputFolder&, const RunOptions&, const FrameRange&);

}  // namespace firn
