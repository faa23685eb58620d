#pragma once
#include "app/scene_keys.h"

#include <string>
#include <vector>

namespace firn {

/// A visitor that collects the names of an object's keys.
struct Names {
    std::vector<std::string> names;
    template <class T, class... Use> void key(const Key& k, T&, Use...) { names.push_back(k.name); }
    void either(const Key& a, double&, const Key& b, std::optional<double>&) {
        names.emplace_back(a.name), names.emplace_back(b.name);
    }
    void either(const Key& a, Shape&, const Key& b, std::string&) {
        names.push_back(a.name);
        names.push_back(b.name);
    }
    template <class Kind> void kind(const char* name, const char*, Kind) { names.push_back(name); }
};

template <class T> std::vector<std::string> names_of() {
    Names visitor;
    T object;
    describe(visitor, object);
    return visitor.names;
}

/// The names of the kinds of shapes that may stand there.
std::vector<std::string> shape_kinds(ShapeUse);

/// Where a key belongs, as words ("in solver"); empty if it is none of a scene's.
std::string home_of(const std::string& key);

bool contains(const std::vector<std::string>& words, const std::string& word);

}  // namespace firn
