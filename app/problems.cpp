#include "app/problems.h"

#include <fmt/format.h>

#include <algorithm>
#include <numeric>
#include <tuple>

namespace firn {

static std::string told(const Place& place, const std::string& path, const std::string& message) {
    const std::string key = path.empty() ? "" : place.source->prefix + path + ": ";
    return fmt::format("{}:{}:{}: {}{}", place.source->file, place.line, place.column, key, message);
}

void fail(const Place& place, const std::string& path, const std::string& message) {
    throw SceneError(told(place, path, message));
}

void Problems::add(const Place& place, const std::string& path, const std::string& message) {
    const std::string text = told(place, path, message);
    const bool known =
        std::any_of(problems_.begin(), problems_.end(), [&](auto& p) { return p.text == text; });
    if (!known) problems_.push_back({place, text});
}

void Problems::throw_if_any() const {
    if (problems_.empty()) return;
    auto sorted = problems_;
    const auto order = [](const Problem& p) {
        return std::make_tuple(p.place.source->file == "--set", p.place.line, p.place.column);
    };
    std::stable_sort(sorted.begin(), sorted.end(),
                     [&](const Problem& a, const Problem& b) { return order(a) < order(b); });
    std::string all;
    for (const Problem& p : sorted) all += (all.empty() ? "" : "\n") + p.text;
    throw SceneError(all);
}

// Optimal string alignment distance: insertions, deletions, replacements and swaps of neighbours cost 1 each.
static std::size_t edit_distance(const std::string& a, const std::string& b) {
    std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
    for (std::size_t i = 0; i <= a.size(); ++i) d[i][0] = i;
    for (std::size_t j = 0; j <= b.size(); ++j) d[0][j] = j;
    for (std::size_t i = 1; i <= a.size(); ++i)
        for (std::size_t j = 1; j <= b.size(); ++j) {
            const std::size_t replaced = d[i - 1][j - 1] + (a[i - 1] != b[j - 1]);
            d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, replaced});
            if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
                d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
        }
    return d[a.size()][b.size()];
}

std::string nearest(const std::string& word, const std::vector<std::string>& candidates) {
    if (word.size() > 64) return "";
    std::string best;
    std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
    for (const auto& candidate : candidates) {
        const std::size_t distance = edit_distance(word, candidate);
        if (distance < least && distance < candidate.size()) least = distance, best = candidate;
    }
    return best;
}

std::string did_you_mean(const std::string& word, const std::vector<std::string>& candidates) {
    const std::string best = nearest(word, candidates);
    return best.empty() ? "" : fmt::format(" (did you mean {}?)", best);
}

std::string join(const std::vector<std::string>& words) {
    std::string all;
    for (const auto& word : words) all += (all.empty() ? "" : ", ") + word;
    return all;
}

}  // namespace firn
