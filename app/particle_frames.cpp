#include "app/particle_frames.h"

#include "app/files.h"
#include "app/machine.h"
#include "app/particle_values.h"
#include "app/ply.h"

#include <fmt/format.h>

namespace firn {

static std::vector<float> flat(const std::vector<Vec3d>& vectors) {
    std::vector<float> values;
    values.reserve(3 * vectors.size());
    for (const auto& v : vectors)
        for (int a = 0; a < 3; ++a) values.push_back(static_cast<float>(v[a]));
    return values;
}

FrameJob job_from_particles(const OutputFolder& folder, const RunRecord& run, const FrameRecord& record,
                            const Scene& scene) {
    const auto file = folder.particles(record.frame);
    try {
        const PlyParticles particles = read_ply(read_file(file, available_memory() / 4));
        FrameJob job;
        job.record = record;
        job.picture = true;
        job.x = flat(particles.x), job.v = flat(particles.v);
        job.values = particle_values(particles, scene, run.body_particles);
        return job;
    } catch (const PlyError& e) {
        throw SceneError(fmt::format("{}: {}", file.string(), e.what()));
    }
}

}  // namespace firn
