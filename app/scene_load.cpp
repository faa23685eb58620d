#include "app/scene_load.h"

#include "app/files.h"
#include "app/hash.h"
#include "app/machine.h"
#include "app/utf8.h"
#include "render/renderer.h"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

namespace firn {

std::map<std::string, std::string> scene_sources();

constexpr std::size_t largest_scene = 1 << 20;  // bytes

static std::vector<std::string> names(const std::map<std::string, Snow>& materials) {
    std::vector<std::string> all;
    for (const auto& [name, snow] : materials) all.push_back(name);
    return all;
}

// Gives every body its material.
static void assign_materials(ReadScene& read, Problems& problems) {
    auto& materials = read.scene.materials;
    if (materials.empty()) materials["snow"] = Snow{};
    for (auto& [name, snow] : materials)
        if (read.scene.solver.defaults == Defaults::paper && !read.given(fmt::format("materials.{}.max_density", name)))
            snow.max_density = Snow::endless;
    for (std::size_t i = 0; i < read.scene.bodies.size(); ++i) {
        auto& body = read.scene.bodies[i];
        const std::string path = fmt::format("bodies.{}.material", i), all = join(names(materials));
        if (body.material.empty() && materials.size() == 1) body.material = materials.begin()->first;
        else if (body.material.empty() && !read.given(path))
            problems.add(read.place(path), path, "is missing; there are several materials: " + all);
        else if (!body.material.empty() && !materials.contains(body.material))
            problems.add(read.place(path), path,
                         fmt::format("no such material: {}; there are: {}{}", body.material, all,
                                     did_you_mean(body.material, names(materials))));
    }
}

static void check(ReadScene& read, Problems& problems) {
    assign_materials(read, problems);
    if (read.given("camera.eye") && read.given("camera.target") &&
        read.scene.camera->eye == read.scene.camera->target)
        problems.add(read.place("camera"), "camera", "eye and target are the same point");
    const Picture& picture = read.scene.picture;
    const int longest = longest_picture(picture.quality);
    for (const auto& [path, pixels] : {std::pair("picture.width", picture.width), {"picture.height", picture.height}})
        if (pixels > longest)
            problems.add(read.place(path), path,
                         fmt::format("{} pixels are too many for quality: final, which draws four samples for each: "
                                     "at most {}, or 16384 with quality: preview",
                                     pixels, longest));
}

static ReadScene read_and_check(const Yaml& root, Problems& problems) {
    const std::size_t before = problems.size();
    ReadScene read = read_scene(root, problems);
    if (problems.size() == before) check(read, problems);
    return read;
}

// Reads the scene as written and with each of its presets, so that all errors of a file are told at once; the
// result is what the overrides ask for.
static ReadScene read_all(Yaml root, const Overrides& overrides) {
    Problems problems;
    const auto presets = take_presets(root, problems);
    Yaml chosen = root;
    bool found = overrides.preset.empty();
    read_and_check(root, problems);
    for (const auto& preset : presets) {
        Yaml changed = root;
        override_with(changed, preset.value, "", problems);
        read_and_check(changed, problems);
        if (preset.key == overrides.preset) chosen = changed, found = true;
    }
    if (!found) {
        std::vector<std::string> there;
        for (const auto& preset : presets) there.push_back(preset.key);
        problems.add(root.place, "presets",
                     fmt::format("no preset {} in this scene; it has {}", overrides.preset,
                                 there.empty() ? "none" : join(there)));
    }
    for (const auto& setting : overrides.settings) apply_setting(chosen, setting, problems);
    ReadScene read = read_and_check(chosen, problems);
    problems.throw_if_any();
    return read;
}

// Reads the particles of the bodies that come from files; their bytes count in the scene's hash.
static std::string load_files(LoadedScene& loaded) {
    Problems problems;
    std::string hashes;
    for (std::size_t i = 0; i < loaded.scene.bodies.size(); ++i) {
        const std::string& name = loaded.scene.bodies[i].particles;
        if (name.empty()) continue;
        const std::string path = fmt::format("bodies.{}.particles", i);
        const auto file = std::filesystem::path(loaded.path).parent_path() / name;
        try {
            const std::string bytes = read_file(file, available_memory() / 4);
            hashes += hash_hex({bytes});
            loaded.files[i] = read_ply(bytes);
        } catch (const FileError& e) {
            problems.add(loaded.read.place(path), path,
                         fmt::format("{} (paths are relative to the scene)", e.what()));
        } catch (const PlyError& e) {
            problems.add(loaded.read.place(path), path, fmt::format("{}: {}", file.string(), e.what()));
        }
    }
    problems.throw_if_any();
    return hashes;
}

// Snow falls: with the bodies belongs the ground beneath them, the highest, unless it is far below.
static Bounds with_ground(Bounds box, const std::vector<Solid>& colliders) {
    const Vec3d middle = 0.5 * (box.lower + box.upper);
    const double far = 3 * (box.upper - box.lower).maxCoeff();
    double ground = -INFINITY;
    for (const auto& collider : colliders) {
        const auto* plane = std::get_if<Plane>(&collider.shape);
        if (!plane || plane->normal.y() < 0.5 * plane->normal.norm()) continue;
        const double below = plane->normal.dot(middle - plane->point) / plane->normal.y();
        ground = std::max(ground, middle.y() - below);
    }
    if (ground > box.lower.y() - far) box.lower.y() = std::min(box.lower.y(), ground);
    return box;
}

// The default camera frames the bodies and the ground under them; what a scene gives of it stays.
static void fill_camera(LoadedScene& loaded) {
    Bounds box;
    for (std::size_t i = 0; i < loaded.scene.bodies.size(); ++i) {
        if (!loaded.files.contains(i)) box.extend(bounds(loaded.scene.bodies[i].shape));
        else for (const auto& x : loaded.files[i].x) box.extend(x);
    }
    const auto& picture = loaded.scene.picture;
    const double aspect_ratio = static_cast<double>(picture.width) / picture.height;
    const Camera framed = framing(with_ground(box, loaded.scene.colliders), aspect_ratio);
    const bool given = loaded.scene.camera.has_value();
    Camera& camera = given ? *loaded.scene.camera : loaded.scene.camera.emplace(framed);
    const auto slope = [](double degrees) { return std::tan(degrees * std::numbers::pi / 360); };
    const double nearer = slope(framed.field_of_view) / slope(camera.field_of_view);
    if (given && !loaded.read.given("camera.target")) camera.target = framed.target;
    if (given && !loaded.read.given("camera.eye"))
        camera.eye = camera.target + (framed.eye - framed.target) * nearer;
    if (camera.eye == camera.target)
        fail(loaded.read.place("camera"), "camera", "eye and target are the same point");
}

LoadedScene load_scene_text(const std::string& text, const std::string& path, const Overrides& overrides) {
    LoadedScene loaded;
    loaded.path = path;
    loaded.name = std::filesystem::path(path).stem().string();
    loaded.read = read_all(parse_yaml(text, std::make_shared<Source>(Source{path, ""})), overrides);
    loaded.scene = loaded.read.scene;
    if (loaded.scene.title.empty()) loaded.scene.title = is_printable(loaded.name) ? loaded.name : "untitled";
    const std::string asset_hashes = load_files(loaded);
    fill_camera(loaded);
    loaded.resolved = to_json(loaded.scene);
    auto hashed = loaded.resolved;
    hashed.erase("frames");  // a frame is the same however many follow it
    loaded.hash = hash_hex({hashed.dump(), asset_hashes});
    return loaded;
}

LoadedScene load_scene(const std::string& path, const Overrides& overrides) {
    try {
        return load_scene_text(read_file(path, largest_scene), path, overrides);
    } catch (const FileError& e) {
        const auto shipped = scene_sources();
        const std::string name = std::filesystem::path(path).stem().string();
        const bool hint = !std::filesystem::exists(path) && shipped.contains(name + ".yaml");
        throw SceneError(hint ? fmt::format("{}; firn brings a scene of that name: firn scenes {} > {}.yaml",
                                            e.what(), name, name)
                              : e.what());
    }
}

Scene read_resolved(const nlohmann::ordered_json& resolved, const std::string& path) {
    Problems problems;
    ReadScene read =
        read_and_check(parse_yaml(resolved.dump(), std::make_shared<Source>(Source{path, ""})), problems);
    if (!read.scene.camera && problems.size() == 0)
        problems.add(read.place("camera"), "camera", "is missing; a resolved scene has one");
    problems.throw_if_any();
    return read.scene;
}

}  // namespace firn
