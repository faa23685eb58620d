#include "app/commands.h"
#include "app/files.h"
#include "app/scene_json.h"
#include "app/yaml.h"

#include <fmt/format.h>

#include <map>

namespace firn {

std::map<std::string, std::string> scene_sources();

static std::string without_extension(const std::string& file) { return file.substr(0, file.rfind('.')); }

static std::string title_of(const std::string& yaml) {
    const Yaml scene = parse_yaml(yaml, std::make_shared<Source>(Source{"scene", ""}));
    const Yaml* title = scene.find("title");
    return title ? title->text : "";
}

static std::string list() {
    std::string text;
    for (const auto& [file, yaml] : scene_sources())
        text += fmt::format("{:<20} {}\n", without_extension(file), title_of(yaml));
    return text;
}

static std::string source_of(const std::string& name) {
    std::vector<std::string> names;
    for (const auto& [file, yaml] : scene_sources()) {
        names.push_back(without_extension(file));
        if (name == names.back() || name == file) return yaml;
    }
    throw UsageError(fmt::format("no scene {} comes with firn; there are: {}{}", name, join(names),
                                 did_you_mean(name, names)));
}

int scenes_command(const std::string& name, bool schema) {
    if (schema) print_result(scene_schema().dump(2) + "\n");
    else print_result(name.empty() ? list() : source_of(name));
    return 0;
}

}  // namespace firn
