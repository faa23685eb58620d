#include "app/commands.h"
#include "app/files.h"
#include "render/compare.h"
#include "render/png.h"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <set>

namespace firn {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr double heat_scale = 0.25;  // channel difference that a heat map shows as white

// One picture and its counterpart.
struct Pair { std::string name; fs::path a, b; };
struct Compared { std::string name; ImageDifference difference; };

static fs::path pictures_of(const fs::path& folder) {
    return fs::is_directory(folder / "frames") ? folder / "frames" : folder;
}

static std::set<std::string> picture_names(const fs::path& folder) {
    std::set<std::string> names;
    for (const auto& file : fs::directory_iterator(folder))
        if (file.path().extension() == ".png") names.insert(file.path().filename().string());
    if (names.empty()) throw UsageError(fmt::format("{} has no pictures (*.png)", folder.string()));
    return names;
}

static std::vector<Pair> pairs_of_folders(const fs::path& a, const fs::path& b) {
    const auto in_a = picture_names(a), in_b = picture_names(b);
    std::vector<std::string> missing;
    for (const auto& name : in_a)
        if (!in_b.contains(name)) missing.push_back((b / name).string());
    for (const auto& name : in_b)
        if (!in_a.contains(name)) missing.push_back((a / name).string());
    if (!missing.empty()) {
        const std::size_t more = missing.size() > 5 ? missing.size() - 5 : 0;
        missing.resize(missing.size() - more);
        throw UsageError(fmt::format("the sequences differ in their frames; missing: {}{}", join(missing),
                                     more ? fmt::format(" and {} more", more) : ""));
    }
    std::vector<Pair> pairs;
    for (const auto& name : in_a) pairs.push_back({name, a / name, b / name});
    return pairs;
}

static std::vector<Pair> pairs_of(const fs::path& a, const fs::path& b) {
    for (const auto& path : {a, b})
        if (!fs::exists(path)) throw UsageError(fmt::format("{}: no such file or folder", path.string()));
    const bool folders = fs::is_directory(a);
    if (folders != fs::is_directory(b))
        throw UsageError(fmt::format("{} is a picture and {} a folder: give two of one kind",
                                     (folders ? b : a).string(), (folders ? a : b).string()));
    if (folders) return pairs_of_folders(pictures_of(a), pictures_of(b));
    return {{a.filename().string(), a, b}};
}

static ImageDifference compare_pair(const Pair& pair, double tolerance, const fs::path& heat) {
    try {
        const Image a = read_png(pair.a.string()), b = read_png(pair.b.string());
        if (a.width != b.width || a.height != b.height)
            throw UsageError(fmt::format(
                "{} has {} x {} pixels, {} has {} x {}: only pictures of one size can be compared",
                pair.a.string(), a.width, a.height, pair.b.string(), b.width, b.height));
        if (!heat.empty()) {
            const auto png = encode_png(heat_map(a, b, heat_scale), {{"Title", "difference, white at 0.25"}});
            write_file(heat, {{reinterpret_cast<const char*>(png.data()), png.size()}});
        }
        return compare_images(a, b, tolerance);
    } catch (const UsageError&) {
        throw;
    } catch (const FileError&) {
        throw;
    } catch (const std::runtime_error& e) {
        throw UsageError(e.what());
    }
}

// Over all frames: means of means, the largest of the largest, PSNR of the mean square.
static ImageDifference total_of(const std::vector<Compared>& all) {
    ImageDifference total;
    double square = 0;
    total.ssim = 0;
    const double n = static_cast<double>(all.size());
    for (const auto& [name, d] : all) {
        total.mean_error += d.mean_error / n, total.ssim += d.ssim / n, total.flip += d.flip / n,
            total.share_above += d.share_above / n;
        total.max_error = std::max(total.max_error, d.max_error);
        square += std::pow(10, -d.psnr / 10) / n;
    }
    total.psnr = square > 0 ? -10 * std::log10(square) : INFINITY;
    return total;
}

static Json to_json(const std::string& name, const ImageDifference& d) {
    return {{"picture", name},          {"mean_error", d.mean_error},
            {"max_error", d.max_error}, {"psnr", std::isfinite(d.psnr) ? Json(d.psnr) : Json()},
            {"ssim", d.ssim},           {"flip", d.flip},
            {"share_above", d.share_above}};
}

static std::string line(const std::string& name, const ImageDifference& d) {
    return fmt::format("{:<20} {:>10.6f} {:>10.6f} {:>9.2f} {:>9.6f} {:>9.6f} {:>11.6f}\n", name, d.mean_error,
                       d.max_error, d.psnr, d.ssim, d.flip, d.share_above);
}

static std::string report(const std::vector<Compared>& all, const ImageDifference& total,
                          const CompareOptions& options) {
    if (options.json) {
        Json json{{"tolerance", options.tolerance},
                  {"pictures", Json::array()},
                  {"total", to_json("total", total)}};
        for (const auto& [name, d] : all) json["pictures"].push_back(to_json(name, d));
        return json.dump(2) + "\n";
    }
    std::string text = fmt::format("{:<20} {:>10} {:>10} {:>9} {:>9} {:>9} {:>11}\n", "picture", "mean",
                                   "max", "PSNR [dB]", "SSIM", "FLIP", fmt::format("above {:g}", options.tolerance));
    for (const auto& [name, d] : all) text += line(name, d);
    if (all.size() > 1) text += line("total", total);
    return text;
}

int compare_command(const CompareOptions& options) {
    const auto pairs = pairs_of(options.a, options.b);
    const bool folders = fs::is_directory(options.a);
    if (folders && !options.heat_map.empty()) make_folder(options.heat_map);
    std::vector<Compared> all;
    for (const auto& pair : pairs) {
        const fs::path heat = options.heat_map.empty() ? fs::path()
                              : folders                ? fs::path(options.heat_map) / pair.name
                                                       : fs::path(options.heat_map);
        all.push_back({pair.name, compare_pair(pair, options.tolerance, heat)});
    }
    const ImageDifference total = total_of(all);
    print_result(report(all, total, options));
    return total.share_above > 0 ? 1 : 0;
}

}  // namespace firn
