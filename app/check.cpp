#include "app/commands.h"
#include "app/estimate.h"

#include <fmt/format.h>

#include <algorithm>

namespace firn {

static std::string report(const LoadedScene& loaded, const Estimate& e) {
    return fmt::format(
        "{}: good\n"
        "  particles   {:.0f}\n"
        "  grid nodes  {:.0f}\n"
        "  memory      {:.0f} bytes ({})\n"
        "  disk        {:.0f} bytes ({})\n"
        "  steps       {:.0f}\n"
        "  minutes     {:.1f}\n",
        loaded.path, e.needs.particles, e.needs.nodes, e.needs.memory, bytes_text(e.needs.memory),
        e.needs.disk, bytes_text(e.needs.disk), e.steps, e.seconds / 60);
}

// The exit code of one scene.
static int check_one(const std::string& path, const Overrides& overrides) {
    try {
        const LoadedScene loaded = load_scene(path, overrides);
        const Estimate result = estimate(loaded, std::filesystem::path("out") / loaded.name);
        for (const auto& warning : result.warnings) tell(warning + "\n");
        print_result(report(loaded, result));
        return 0;
    } catch (const SceneError& e) {
        tell(fmt::format("{}\n", e.what()));
        return 2;
    } catch (const SimulationError& e) {
        tell(fmt::format("{}: {}\n", path, e.what()));
        return 3;
    } catch (const ResourceError& e) {
        tell(fmt::format("{}\n", e.what()));
        return 4;
    }
}

int check_command(const std::vector<std::string>& scenes, const Overrides& overrides) {
    std::vector<int> codes;
    for (const auto& scene : scenes) codes.push_back(check_one(scene, overrides));
    for (const int code : {2, 3, 4})  // what no retry mends comes first
        if (std::find(codes.begin(), codes.end(), code) != codes.end()) return code;
    return 0;
}

}  // namespace firn
