#include "app/scene_json.h"

#include "app/scene_keys.h"

#include <algorithm>
#include <set>
#include <type_traits>

namespace firn {

using Json = nlohmann::ordered_json;

static Json written(double value) { return value; }
static Json written(bool value) { return value; }
static Json written(int value) { return value; }
static Json written(std::uint64_t value) { return value; }
static Json written(const std::string& value) { return value; }
static Json written(const Vec3d& value) { return {value[0], value[1], value[2]}; }
static Json written(const std::optional<double>& value) { return value ? Json(*value) : Json("auto"); }
static Json written(const Shape&);

template <class E> requires std::is_enum_v<E>
static Json written(E value) { return name_of(value); }

template <class T> requires std::is_class_v<T>
static Json written(const T& object);

static Json written(const std::vector<Shape>& shapes) {
    Json list = Json::array();
    for (const auto& shape : shapes) list.push_back(written(shape));
    return list;
}

// Writes the keys of an object.
struct ObjectWriter {
    Json json = Json::object();

    template <class T, class... Use>
    void key(const Key& k, const T& member, Use...) {
        json[k.name] = written(member);
    }
    template <class T> void key(const Key& k, const std::optional<T>& member) {
        if constexpr (std::is_same_v<T, double>) json[k.name] = written(member);
        else if (member) json[k.name] = written(*member);
    }
    template <class T> void key(const Key& k, const std::vector<T>& members) {
        json[k.name] = Json::array();
        for (const auto& member : members) json[k.name].push_back(written(member));
    }
    template <class T> void key(const Key& k, const std::map<std::string, T>& members) {
        json[k.name] = Json::object();
        for (const auto& [name, member] : members) json[k.name][name] = written(member);
    }
    void either(const Key& a, double first, const Key& b, const std::optional<double>& second) {
        if (second) json[b.name] = *second;
        else json[a.name] = first;
    }
    void either(const Key& a, const Shape& shape, const Key& b, const std::string& file) {
        if (file.empty()) json[a.name] = written(shape);
        else json[b.name] = file;
    }
};

template <class T> requires std::is_class_v<T>
static Json written(const T& object) {
    ObjectWriter writer;
    T copy = object;
    describe(writer, copy);
    return writer.json;
}

// Writes a shape under the name of its kind.
struct KindWriter {
    const Shape& shape;
    Json json = Json::object();

    template <class Kind> void kind(const char* name, const char*, Kind) {
        if (const Kind* held = std::get_if<Kind>(&shape.kind())) {
            if constexpr (std::is_same_v<Kind, Union> || std::is_same_v<Kind, Difference>)
                json[name] = written(held->shapes);
            else json[name] = written(*held);
        }
    }
};

static Json written(const Shape& shape) {
    KindWriter writer{shape};
    describe_kinds(writer, ShapeUse::cut);
    return writer.json;
}

Json to_json(const Scene& scene) { return written(scene); }

std::vector<std::string> differing_keys(const Json& a, const Json& b) {
    const Json flat_a = a.flatten(), flat_b = b.flatten();
    std::set<std::string> paths;
    for (const auto& [path, value] : flat_a.items())
        if (!flat_b.contains(path) || flat_b[path] != value) paths.insert(path);
    for (const auto& [path, value] : flat_b.items())
        if (!flat_a.contains(path)) paths.insert(path);
    std::vector<std::string> keys;
    for (std::string path : paths) {
        std::replace(path.begin(), path.end(), '/', '.');
        keys.push_back(path.substr(std::min<std::size_t>(path.size(), 1)));
    }
    return keys;
}

}  // namespace firn
