#pragma once
#include "app/pipeline.h"

namespace firn {

/// A frame that is drawn from its PLY file. Throws FileError or SceneError that names it.
FrameJob job_from_particles(const OutputFolder&, const RunRecord&, const FrameRecord&, const Scene&);

}  // namespace firn
