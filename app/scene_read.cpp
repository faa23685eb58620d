#include "app/scene_read.h"

#include "app/scene_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <type_traits>

namespace firn {

// What is wrong with an object whose keys are each right; empty if nothing.
template <class T> static std::string fault(const T&) { return ""; }
static std::string fault(const Plane& p) {
    return p.normal.isZero(0) ? "the normal is 0; it must point out of the solid half space" : "";
}
static std::string fault(const Cylinder& c) { return c.from == c.to ? "from and to are the same point" : ""; }
static std::string fault(const Capsule& c) { return c.from == c.to ? "from and to are the same point" : ""; }

static std::string fault(const Lumps& l) {
    return l.seam < l.core ? "seam is less than core: lumps would be weaker than what holds them together" : "";
}
static std::string fault(const Picture& p) {
    return p.colour_min && p.colour_max && *p.colour_min >= *p.colour_max ? "colour_min must be less than colour_max" : "";
}
static std::string fault(const Camera& c) {
    for (std::size_t i = 0; i < c.keyframes.size(); ++i) {
        if (c.keyframes[i].eye == c.keyframes[i].target) return "a keyframe's eye and target are the same point";
        if (i > 0 && c.keyframes[i].time <= c.keyframes[i - 1].time)
            return "the times of keyframes must grow from each to the next";
    }
    return "";
}

static std::string kind_of(const Yaml& value) {
    switch (value.kind) {
        case Yaml::Kind::list: return "a list";
        case Yaml::Kind::mapping: return "a mapping";
        case Yaml::Kind::scalar:
            return value.text.size() > 40 ? value.text.substr(0, 40) + "..." : value.text;
        case Yaml::Kind::missing: break;
    }
    return "nothing";
}

static std::string allowed(const Key& key) {
    return fmt::format("must be {}{}{}{}", key.range.text(), *key.unit ? " [" : "", key.unit,
                       *key.unit ? "]" : "");
}

class Reader {
public:
    Reader(Problems& problems, std::map<std::string, Place>& places) : problems_(problems), places_(places) {}

    template <class T> void object(const Yaml& node, const std::string& path, T& out);

    void value(const Yaml& v, const std::string& path, const Key& key, double& out) {
        if (const auto number = parsed(v, path, key)) out = number->value;
    }

    void value(const Yaml& v, const std::string& path, const Key&, bool& out) {
        const bool plain = v.kind == Yaml::Kind::scalar && !v.quoted;
        if (plain && (v.text == "true" || v.text == "false")) out = v.text == "true";
        else wrong(v, path, "must be true or false");
    }

    template <class T> requires(std::is_integral_v<T> && !std::is_same_v<T, bool>)
    void value(const Yaml& v, const std::string& path, const Key& key, T& out) {
        const auto number = parsed(v, path, key);
        if (!number) return;
        const auto exact = parse_whole(v.text);
        if (!number->whole)
            problems_.add(v.place, path, fmt::format("{} is not a whole number; {}", v.text, allowed(key)));
        else if (!exact ||
                 *exact > static_cast<std::int64_t>(key.range.upper))  // the double may have been rounded
            problems_.add(v.place, path, fmt::format("{} is out of range; {}", v.text, allowed(key)));
        else out = static_cast<T>(*exact);
    }

    void value(const Yaml& v, const std::string& path, const Key& key, std::optional<double>& out) {
        if (v.kind == Yaml::Kind::scalar && v.text == "auto") { out.reset(); return; }
        const Key numbers{key.name, key.help, key.unit, key.range};
        if (v.kind == Yaml::Kind::scalar && !v.text.empty() &&
            std::isalpha(static_cast<unsigned char>(v.text[0])))
            problems_.add(v.place, path,
                          fmt::format("unknown word {}; allowed: auto, or a number{}", kind_of(v),
                                      did_you_mean(v.text, {"auto"})));
        else if (const auto number = parsed(v, path, numbers)) out = number->value;
    }

    void value(const Yaml& v, const std::string& path, const Key& key, Vec3d& out) {
        const std::string wanted = fmt::format("must be a list of 3 numbers{}{}{}", *key.unit ? " [" : "",
                                               key.unit, *key.unit ? "]" : "");
        if (v.kind != Yaml::Kind::list) { wrong(v, path, wanted); return; }
        if (v.items.size() != 3) {
            problems_.add(v.place, path, fmt::format("has {} entries; {}", v.items.size(), wanted));
            return;
        }
        for (int i = 0; i < 3; ++i) value(v.items[i], child_path(path, std::to_string(i)), key, out[i]);
    }

    void value(const Yaml& v, const std::string& path, const Key&, std::string& out) {
        if (v.kind != Yaml::Kind::scalar) { wrong(v, path, "must be a text"); return; }
        const bool is_text =
            v.quoted || (parse_number(v.text).fault.size() && v.text != "true" && v.text != "false");
        if (!is_text)
            problems_.add(v.place, path,
                          fmt::format("{} is no text; must be a text: write \"{}\"", v.text, v.text));
        else if (v.text.empty() || v.text.size() > 1000)
            problems_.add(v.place, path, fmt::format("has {} bytes; must be 1 to 1000", v.text.size()));
        else out = v.text;
    }

    template <class E> requires std::is_enum_v<E>
    void value(const Yaml& v, const std::string& path, const Key&, E& out) {
        std::vector<std::string> names;
        for (const auto& choice : choices(E{})) names.push_back(choice.name);
        if (v.kind != Yaml::Kind::scalar) { wrong(v, path, "must be one of: " + join(names)); return; }
        for (const auto& choice : choices(E{}))
            if (v.text == choice.name) { out = choice.value; return; }
        problems_.add(v.place, path, fmt::format("unknown word {}; allowed: {}{}", kind_of(v), join(names),
                                                 did_you_mean(v.text, names)));
    }

    template <class T> requires std::is_class_v<T>
    void value(const Yaml& v, const std::string& path, const Key&, T& out) { object(v, path, out); }

    template <class T> void value(const Yaml& v, const std::string& path, const Key&, std::optional<T>& out) {
        object(v, path, out.emplace());
    }

    template <class T>
    void value(const Yaml& v, const std::string& path, const Key& key, std::map<std::string, T>& out) {
        if (v.kind != Yaml::Kind::mapping) { wrong(v, path, "must be a mapping of names"); return; }
        check_duplicates(v, path, problems_);
        for (const auto& entry : v.entries) {
            const bool plain = std::all_of(entry.key.begin(), entry.key.end(), [](unsigned char c) {
                return std::isalnum(c) || c == '_' || c == '-';
            });
            if (entry.key.empty() || entry.key.size() > 64 || !plain)
                problems_.add(entry.place, path, "a name must be 1 to 64 letters, digits, _ or -");
            else if (const Yaml* item = given(entry.value, child_path(path, entry.key)))
                value(*item, child_path(path, entry.key), key, out[entry.key]);
        }
        if (out.size() > 256) problems_.add(v.place, path, "has more than 256 entries");
    }

    template <class T>
    void value(const Yaml& v, const std::string& path, const Key& key, std::vector<T>& out) {
        if (v.kind != Yaml::Kind::list) { wrong(v, path, "must be a list (- ...)"); return; }
        if (v.items.empty() && key.required)
            problems_.add(v.place, path, "is empty; must have at least one entry");
        for (std::size_t i = 0; i < v.items.size(); ++i)
            if (const Yaml* item = given(v.items[i], child_path(path, std::to_string(i))))
                value(*item, child_path(path, std::to_string(i)), key, out.emplace_back());
    }

    void value(const Yaml& v, const std::string& path, const Key&, Shape& out, ShapeUse use);

    /// The value, unless nothing is written there, which is a problem.
    const Yaml* given(const Yaml& v, const std::string& path) {
        places_[path] = v.place;
        if (v.kind != Yaml::Kind::missing) return &v;
        problems_.add(v.place, path, "has no value; write one or leave the key out");
        return nullptr;
    }

    void missing(const Yaml& parent, const std::string& path, const std::string& what) {
        problems_.add(parent.place, path, what);
    }

    void wrong(const Yaml& v, const std::string& path, const std::string& wanted) {
        problems_.add(v.place, path, fmt::format("is {}; {}", kind_of(v), wanted));
    }

    void shapes(const Yaml& v, const std::string& path, std::vector<Shape>& out, ShapeUse first,
                ShapeUse others);

private:
    std::optional<ParsedNumber> parsed(const Yaml& v, const std::string& path, const Key& key) {
        if (v.kind != Yaml::Kind::scalar) {
            wrong(v, path, "must be a number, " + key.range.text());
            return {};
        }
        if (v.quoted) {
            problems_.add(v.place, path,
                          fmt::format("\"{}\" is a text; write the number without quotes", kind_of(v)));
            return {};
        }
        auto number = parse_number(v.text);
        if (!number.fault.empty()) problems_.add(v.place, path, number.fault + "; " + allowed(key));
        else if (!key.range.holds(number.value))
            problems_.add(v.place, path, fmt::format("{} is out of range; {}", v.text, allowed(key)));
        else return number;
        return {};
    }

    Problems& problems_;
    std::map<std::string, Place>& places_;
};

// Reads the keys of one mapping into an object.
struct ObjectReader {
    Reader& reader;
    const Yaml& node;
    const std::string& path;

    template <class T, class... Use> void key(const Key& k, T& member, Use... use) {
        const Yaml* v = node.find(k.name);
        const std::string full = child_path(path, k.name);
        if (!v && k.required)
            reader.missing(node, full, fmt::format("is missing; it must be given: {}", k.help));
        if (v && (v = reader.given(*v, full))) reader.value(*v, full, k, member, use...);
    }

    void either(const Key& a, Shape& shape, const Key& b, std::string& file) {
        key(a, shape, ShapeUse::solid);
        key(b, file);
        const Yaml* second = node.find(b.name);
        if (node.find(a.name) && second)
            reader.missing(*second, child_path(path, b.name),
                           fmt::format("a body has {} or {}, not both", a.name, b.name));
        if (!node.find(a.name) && !second)
            reader.missing(node, child_path(path, a.name),
                           fmt::format("is missing; a body needs {} or {}", a.name, b.name));
    }

    /// Of two numbers that say the same the one that is given; `second` is none where the first is.
    void either(const Key& a, double& first, const Key& b, std::optional<double>& second) {
        const Yaml* given = node.find(b.name);
        if (node.find(a.name)) second.reset();
        key(a, first);
        if (double number = 0; given) key(b, number), second = number;
        if (node.find(a.name) && given)
            reader.missing(*given, child_path(path, b.name), fmt::format("stands beside {}, which says the same; keep one of them", a.name));
    }
};

// Reads the shape of the kind that was asked for.
struct KindReader {
    Reader& reader;
    const Yaml& node;
    const std::string& path;
    const std::string& wanted;
    ShapeUse use;
    Shape& out;

    template <class Kind> void kind(const char* name, const char*, Kind shape) {
        if (name != wanted) return;
        if constexpr (std::is_same_v<Kind, Union>) reader.shapes(node, path, shape.shapes, use, use);
        else if constexpr (std::is_same_v<Kind, Difference>)
            reader.shapes(node, path, shape.shapes, use, ShapeUse::cut);
        else reader.object(node, path, shape);
        out = shape;
    }
};

template <class T> void Reader::object(const Yaml& node, const std::string& path, T& out) {
    if (node.kind != Yaml::Kind::mapping) {
        wrong(node, path, "must be a mapping with: " + join(names_of<T>()));
        return;
    }
    check_duplicates(node, path, problems_);
    const std::size_t before = problems_.size();
    ObjectReader visitor{*this, node, path};
    describe(visitor, out);
    const auto names = names_of<T>();
    for (const auto& entry : node.entries) {
        if (contains(names, entry.key)) continue;
        const std::string home = home_of(entry.key);
        problems_.add(
            entry.place, child_path(path, entry.key),
            fmt::format("unknown key; allowed: {}{}", join(names),
                        home.empty() ? did_you_mean(entry.key, names) : " (it belongs " + home + ")"));
    }
    if (problems_.size() == before && !fault(out).empty()) problems_.add(node.place, path, fault(out));
}

void Reader::value(const Yaml& v, const std::string& path, const Key&, Shape& out, ShapeUse use) {
    const auto names = shape_kinds(use);
    if (v.kind != Yaml::Kind::mapping) {
        wrong(v, path, "must be a mapping with one of: " + join(names));
        return;
    }
    check_duplicates(v, path, problems_);
    if (v.entries.size() != 1)
        problems_.add(v.place, path,
                      fmt::format("has {} kinds; must have exactly one of: {} (join several with union)",
                                  v.entries.size(), join(names)));
    for (const auto& entry : v.entries) {
        const std::string full = child_path(path, entry.key);
        if (!contains(names, entry.key)) {
            const bool elsewhere = contains(shape_kinds(ShapeUse::cut), entry.key);
            problems_.add(
                entry.place, full,
                fmt::format("{}; allowed: {}{}",
                            !elsewhere                  ? "unknown kind of shape"
                            : use == ShapeUse::collider ? "cannot be a collider"
                                                        : "has no end, so it cannot be filled with snow",
                            join(names), elsewhere ? "" : did_you_mean(entry.key, names)));
        } else if (const Yaml* body = given(entry.value, full)) {
            KindReader visitor{*this, *body, full, entry.key, use, out};
            describe_kinds(visitor, use);
        }
    }
}

void Reader::shapes(const Yaml& v, const std::string& path, std::vector<Shape>& out, ShapeUse first,
                    ShapeUse others) {
    if (v.kind != Yaml::Kind::list || v.items.empty()) {
        wrong(v, path, "must be a list of shapes, one at least");
        return;
    }
    for (std::size_t i = 0; i < v.items.size(); ++i) {
        const std::string full = child_path(path, std::to_string(i));
        if (const Yaml* item = given(v.items[i], full))
            value(*item, full, {"shape", ""}, out.emplace_back(), i == 0 ? first : others);
    }
}

std::string child_path(const std::string& parent, const std::string& name) {
    return parent.empty() ? name : parent + "." + name;
}

void check_duplicates(const Yaml& mapping, const std::string& path, Problems& problems) {
    std::map<std::string, int> lines;
    for (const auto& entry : mapping.entries) {
        const auto [first, added] = lines.emplace(entry.key, entry.place.line);
        if (!added)
            problems.add(entry.place, child_path(path, entry.key),
                         fmt::format("is given twice, in line {} and in line {}; keep one", first->second,
                                     entry.place.line));
    }
}

Place ReadScene::place(std::string path) const {
    while (!path.empty() && !places.contains(path)) {
        const auto dot = path.rfind('.');
        path = dot == std::string::npos ? "" : path.substr(0, dot);
    }
    return places.at(path);
}

ReadScene read_scene(const Yaml& root, Problems& problems) {
    ReadScene read;
    read.places[""] = root.place;
    if (root.kind == Yaml::Kind::missing)
        problems.add(root.place, "", "the scene is empty; it needs at least grid_spacing and bodies");
    else if (root.kind != Yaml::Kind::mapping)
        problems.add(root.place, "",
                     fmt::format("the scene is {}; it must be a mapping (key: value)", kind_of(root)));
    else {
        const Yaml* solver = root.find("solver");
        const Yaml* defaults = solver && solver->kind == Yaml::Kind::mapping ? solver->find("defaults") : nullptr;
        if (defaults && defaults->text == name_of(Defaults::paper)) read.scene.solver = Solver::paper();
        Reader(problems, read.places).object(root, "", read.scene);
    }
    return read;
}

}  // namespace firn
