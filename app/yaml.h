#pragma once
#include "app/problems.h"

#include <map>
#include <string>
#include <vector>

namespace firn {

/// A YAML document as a plain tree: every value knows its place, nothing is converted, aliases are copies.
struct Yaml {
    enum class Kind { missing, scalar, list, mapping };
    struct Entry;

    Kind kind = Kind::missing;   ///< missing: written as nothing, ~ or null.
    Place place;
    std::string text;            ///< of a scalar.
    bool quoted = false;         ///< a scalar in quotes or as a block: always a text.
    std::vector<Yaml> items;     ///< of a list.
    std::vector<Entry> entries;  ///< of a mapping, in the order of the file; a key may be there twice.

    const Yaml* find(const std::string& key) const;  ///< The first value of that key, or none.
    Yaml* find(const std::string& key);
};

struct Yaml::Entry {
    std::string key;
    Place place;  ///< of the key.
    Yaml value;
};

/// Parses exactly one YAML document of UTF-8 text. Stricter than YAML where the language invites mistakes: no
/// tags, no merge keys, at most 64 levels and 100 000 values after aliases are copied. Throws SceneError.
/// The text's first character counts as column `first_column`.
Yaml parse_yaml(const std::string& text, const std::shared_ptr<const Source>&, int first_column = 1);

}  // namespace firn
