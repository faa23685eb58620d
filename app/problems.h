#pragma once
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

namespace firn {

/// The scene, one of its assets or an option is wrong: what() says where and what is allowed, one problem a
/// line.
struct SceneError : std::runtime_error { using runtime_error::runtime_error; };

/// Where text comes from: a file, or `--set`.
struct Source {
    std::string file;    ///< as the user named it.
    std::string prefix;  ///< stands before the key paths of what is read here: "presets.draft." in a preset.
};

/// A position in the source; lines and columns count from 1, columns in characters.
struct Place {
    std::shared_ptr<const Source> source;
    int line = 1, column = 1;
};

/// Everything that is wrong with a scene, told at once.
class Problems {
public:
    /// `FILE:LINE:COLUMN: key.path: message`; the same one is kept once.
    void add(const Place&, const std::string& path, const std::string& message);
    bool empty() const { return problems_.empty(); }
    std::size_t size() const { return problems_.size(); }
    void throw_if_any() const;  ///< Throws SceneError, sorted by position.

private:
    struct Problem { Place place; std::string text; };
    std::vector<Problem> problems_;
};

/// Throws this problem alone.
[[noreturn]] void fail(const Place&, const std::string& path, const std::string& message);

/// The candidate nearest to `word` by edit distance (swapped neighbours count once); empty if none is near.
std::string nearest(const std::string& word, const std::vector<std::string>& candidates);

/// " (did you mean X?)" for the nearest candidate, or nothing.
std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates);

/// "a, b, c"
std::string join(const std::vector<std::string>& words);

}  // namespace firn
