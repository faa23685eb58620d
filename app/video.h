#pragma once
#include "app/output_folder.h"

#include <string>

namespace firn {

/// Throws std::invalid_argument if ffmpeg is not installed.
void require_ffmpeg();

/// Makes a film of the pictures `first` to `last` with ffmpeg. Throws FileError if a picture is missing or
/// not whole, or ffmpeg fails; the film appears under its name only when it is whole.
void make_video(const OutputFolder&, int first, int last, double fps, const std::filesystem::path& film);

}  // namespace firn
