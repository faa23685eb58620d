#include "app/overrides.h"

#include "app/scene_names.h"
#include "app/scene_read.h"

#include <fmt/format.h>

#include <algorithm>

namespace firn {

// Whether one shape is to take the place of another: keys of both kinds in one mapping would be an error.
static bool changes_kind(const Yaml& base, const Yaml& over) {
    const auto kinds = shape_kinds(ShapeUse::cut);
    return base.entries.size() == 1 && over.entries.size() == 1 && contains(kinds, base.entries[0].key) &&
           contains(kinds, over.entries[0].key) && base.entries[0].key != over.entries[0].key;
}

static Yaml* entry_of_list(Yaml& list, const std::string& index, const Place& place, const std::string& path,
                           Problems& problems) {
    const bool digits = !index.empty() && index.size() < 7 &&
                        std::all_of(index.begin(), index.end(), [](char c) { return c >= '0' && c <= '9'; });
    if (digits && std::stoul(index) < list.items.size()) return &list.items[std::stoul(index)];
    problems.add(place, child_path(path, index),
                 fmt::format("no such entry; {} has {}, counted from 0", path, list.items.size()));
    return nullptr;
}

// The value at a dotted path, made where it is not there yet; none if the path leads through a plain value.
static Yaml* find_or_make(Yaml& root, const std::string& dotted, const Place& place, const std::string& start,
                          Problems& problems) {
    Yaml* value = &root;
    std::string path = start;
    for (std::size_t from = 0; from <= dotted.size();) {
        const std::size_t dot = std::min(dotted.find('.', from), dotted.size());
        const std::string name = dotted.substr(from, dot - from);
        from = dot + 1;
        if (value->kind == Yaml::Kind::missing) value->kind = Yaml::Kind::mapping;
        if (value->kind == Yaml::Kind::list) {
            value = entry_of_list(*value, name, place, path, problems);
            if (!value) return nullptr;
        } else if (value->kind == Yaml::Kind::mapping && !name.empty()) {
            Yaml* found = value->find(name);
            if (!found) {
                value->entries.push_back({name, place, {}});
                found = &value->entries.back().value;
                found->place = place;
            }
            value = found;
        } else {
            problems.add(place, child_path(start, dotted), fmt::format("no such key; {} has no keys", path));
            return nullptr;
        }
        path = child_path(path, name);
    }
    return value;
}

void override_with(Yaml& base, const Yaml& over, const std::string& path, Problems& problems) {
    const bool keys_on_keys = base.kind == Yaml::Kind::mapping && !changes_kind(base, over);
    if (over.kind != Yaml::Kind::mapping || !(keys_on_keys || base.kind == Yaml::Kind::list)) {
        base = over;
        return;
    }
    check_duplicates(over, path, problems);
    for (const auto& entry : over.entries) {
        Yaml* target = find_or_make(base, entry.key, entry.place, path, problems);
        if (target) override_with(*target, entry.value, child_path(path, entry.key), problems);
    }
}

static void relabel(Yaml& value, const std::shared_ptr<const Source>& source) {
    value.place.source = source;
    for (auto& item : value.items) relabel(item, source);
    for (auto& entry : value.entries) entry.place.source = source, relabel(entry.value, source);
}

std::vector<Yaml::Entry> take_presets(Yaml& root, Problems& problems) {
    const std::vector<std::string> names{"draft", "preview", "final"};
    std::vector<Yaml::Entry> presets;
    const Yaml* block = root.find("presets");
    if (!block) return presets;
    if (block->kind != Yaml::Kind::mapping)
        problems.add(block->place, "presets", "must be a mapping with: " + join(names));
    check_duplicates(*block, "presets", problems);
    for (const auto& entry : block->entries) {
        const std::string path = "presets." + entry.key;
        if (std::find(names.begin(), names.end(), entry.key) == names.end())
            problems.add(
                entry.place, path,
                fmt::format("unknown key; allowed: {}{}", join(names), did_you_mean(entry.key, names)));
        else if (entry.value.kind != Yaml::Kind::mapping)
            problems.add(entry.value.place, path, "must be a mapping of the keys that it changes");
        else if (presets.push_back(entry); true)
            relabel(presets.back().value,
                    std::make_shared<Source>(Source{root.place.source->file, path + "."}));
    }
    const auto first =
        std::find_if(root.entries.begin(), root.entries.end(), [](auto& e) { return e.key == "presets"; });
    root.entries.erase(first);
    return presets;
}

void apply_setting(Yaml& root, const std::string& setting, Problems& problems) {
    const auto source = std::make_shared<Source>(Source{"--set", ""});
    const std::size_t equals = setting.find('=');
    const std::string key = setting.substr(0, equals);
    const Place place{source, 1, 1};
    if (equals == std::string::npos || key.empty()) {
        problems.add(place, "", setting + ": must be KEY=VALUE");
        return;
    }
    if (key == "presets" || key.starts_with("presets.")) {
        problems.add(place, key, "cannot be set; choose one with --preset");
        return;
    }
    Yaml value = parse_yaml(setting.substr(equals + 1), source, static_cast<int>(equals) + 2);
    if (Yaml* target = find_or_make(root, key, place, "", problems))
        override_with(*target, value, key, problems);
}

}  // namespace firn
