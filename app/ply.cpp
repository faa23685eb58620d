#include "app/ply.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>
#include <optional>
#include <sstream>

namespace firn {

static_assert(std::endian::native == std::endian::little, "rows are written as they lie in memory");

enum class Encoding { ascii, little, big };
enum class Type { int8, uint8, int16, uint16, int32, uint32, float32, float64 };

struct Property { std::string name; Type type; std::optional<Type> list_size; };
struct Element { std::string name; std::size_t count = 0; std::vector<Property> properties; };
struct Header { Encoding encoding = Encoding::ascii; std::vector<Element> elements; std::size_t size = 0; };

static std::size_t size_of(Type type) {
    return std::array<std::size_t, 8>{1, 1, 2, 2, 4, 4, 4, 8}[static_cast<std::size_t>(type)];
}

static Type type_of(const std::string& word) {
    static const std::array<std::array<const char*, 2>, 8> names{{{"char", "int8"}, {"uchar", "uint8"},
        {"short", "int16"}, {"ushort", "uint16"}, {"int", "int32"}, {"uint", "uint32"}, {"float", "float32"},
        {"double", "float64"}}};
    for (std::size_t i = 0; i < names.size(); ++i)
        if (word == names[i][0] || word == names[i][1]) return static_cast<Type>(i);
    throw PlyError("unknown type '" + word.substr(0, 40) + "' in the header");
}

static std::size_t count_of(const std::string& word) {
    std::size_t count = 0;
    const auto result = std::from_chars(word.data(), word.data() + word.size(), count);
    if (result.ec != std::errc() || result.ptr != word.data() + word.size())
        throw PlyError("'" + word.substr(0, 40) + "' is no count of an element");
    return count;
}

static Encoding encoding_of(const std::string& word) {
    if (word == "ascii") return Encoding::ascii;
    if (word == "binary_little_endian") return Encoding::little;
    if (word == "binary_big_endian") return Encoding::big;
    throw PlyError("unknown format '" + word.substr(0, 40) + "'");
}

static void read_property(std::istringstream& words, Element& element) {
    std::string type, size, item, name;
    words >> type;
    if (type == "list") words >> size >> item >> name;
    else words >> name;
    if (name.empty()) throw PlyError("a property without a name in the header");
    for (const auto& other : element.properties)
        if (other.name == name) throw PlyError("property " + name + " is given twice");
    if (type == "list") element.properties.push_back({name, type_of(item), type_of(size)});
    else element.properties.push_back({name, type_of(type), {}});
}

static Header read_header(std::string_view bytes) {
    Header header;
    bool has_format = false;
    for (std::size_t line = 1, from = 0;; ++line) {
        const std::size_t end = bytes.find('\n', from);
        if (end == std::string_view::npos || end > 1'000'000)
            throw PlyError(line == 1 ? "not a PLY file: it does not begin with 'ply'"
                                     : "the header has no end");
        std::istringstream words(std::string(bytes.substr(from, end - from)));
        from = end + 1;
        std::string word, next, count;
        words >> word;
        if (line == 1 && word != "ply") throw PlyError("not a PLY file: it does not begin with 'ply'");
        if (word == "end_header") { header.size = from; break; }
        if (line == 1 || word.empty() || word == "comment" || word == "obj_info") continue;
        if (word == "format") {
            words >> next;
            header.encoding = encoding_of(next);
            has_format = true;
        } else if (word == "element") {
            words >> next >> count;
            header.elements.push_back({next, count_of(count), {}});
        } else if (word == "property" && !header.elements.empty()) {
            read_property(words, header.elements.back());
        } else {
            throw PlyError(fmt::format("line {} of the header is unknown: '{}'", line, word.substr(0, 40)));
        }
    }
    if (!has_format) throw PlyError("the header names no format");
    return header;
}

// The values after the header, one by one.
class Values {
public:
    Values(std::string_view bytes, Encoding encoding) : rest_(bytes), encoding_(encoding) {}

    double next(Type type) { return encoding_ == Encoding::ascii ? word() : binary(type); }

    void skip(const Property& property) {
        if (!property.list_size) { next(property.type); return; }
        const double n = next(*property.list_size);
        if (!(n >= 0) || n != std::floor(n)) throw PlyError("a list has no whole number of entries");
        const double least = encoding_ == Encoding::ascii ? 2 : static_cast<double>(size_of(property.type));
        if (n * least > static_cast<double>(rest_.size()) + 1)
            throw PlyError("the file ends within its data");
        for (double i = 0; i < n; ++i) next(property.type);
    }

    // Whether `count` rows fit into what is left, which must be known before memory is taken for them.
    void check_room(const Element& element) const {
        std::size_t least = 0;
        for (const auto& p : element.properties)
            least += encoding_ == Encoding::ascii ? 2 : size_of(p.list_size.value_or(p.type));
        const std::size_t last = encoding_ == Encoding::ascii ? 1 : 0;  // a line end may be missing
        if (least > 0 && element.count > (rest_.size() + last) / least)
            throw PlyError(
                fmt::format("the header promises {} of {}, at least {} bytes each, but only {} bytes follow",
                            element.count, element.name, least, rest_.size()));
    }

private:
    double word() {
        const std::size_t from = std::min(rest_.find_first_not_of(" \t\r\n"), rest_.size());
        const std::size_t end = std::min(rest_.find_first_of(" \t\r\n", from), rest_.size());
        std::string_view token = rest_.substr(from, end - from);
        if (token.empty()) throw PlyError("the file ends within its data");
        rest_.remove_prefix(end);
        if (token.starts_with('+')) token.remove_prefix(1);
        double value = 0;
        const auto result = std::from_chars(token.data(), token.data() + token.size(), value);
        if (result.ec == std::errc() && result.ptr == token.data() + token.size()) return value;
        throw PlyError(fmt::format("'{}' is not a number", token.substr(0, 40)));
    }

    template <class T> static double as(const std::array<char, 8>& bytes) {
        T value;
        std::memcpy(&value, bytes.data(), sizeof value);
        return static_cast<double>(value);
    }

    double binary(Type type) {
        const std::size_t n = size_of(type);
        if (rest_.size() < n) throw PlyError("the file ends within its data");
        std::array<char, 8> bytes{};
        for (std::size_t i = 0; i < n; ++i) bytes[encoding_ == Encoding::big ? n - 1 - i : i] = rest_[i];
        rest_.remove_prefix(n);
        switch (type) {
            case Type::int8: return as<std::int8_t>(bytes);
            case Type::uint8: return as<std::uint8_t>(bytes);
            case Type::int16: return as<std::int16_t>(bytes);
            case Type::uint16: return as<std::uint16_t>(bytes);
            case Type::int32: return as<std::int32_t>(bytes);
            case Type::uint32: return as<std::uint32_t>(bytes);
            case Type::float32: return as<float>(bytes);
            case Type::float64: break;
        }
        return as<double>(bytes);
    }

    std::string_view rest_;
    Encoding encoding_;
};

// Which column of a particle's row a property goes to: x y z vx vy vz mass volume Jp Fe_00 … Fe_22 asleep.
constexpr std::array<const char*, 19> columns{"x",     "y",     "z",     "vx",    "vy",    "vz",
                                              "mass",  "volume", "Jp",   "Fe_00", "Fe_01", "Fe_02",
                                              "Fe_10", "Fe_11", "Fe_12", "Fe_20", "Fe_21", "Fe_22", "asleep"};

struct Row { std::array<double, columns.size()> value{}; };
using Has = std::array<bool, columns.size()>;

static void append(PlyParticles& all, const Row& row, const Has& has) {
    const auto& a = row.value;
    const auto check = [&](bool good, std::size_t column) {
        if (!good)
            throw PlyError(fmt::format("{} of particle {} is {}", columns[column], all.x.size(), a[column]));
    };
    for (std::size_t c = 0; c < columns.size(); ++c) check(std::isfinite(a[c]), c);
    if (has[6]) check(a[6] > 0, 6), all.mass.push_back(a[6]);
    if (has[7]) check(a[7] >= 0, 7), all.volume.push_back(a[7]);
    if (has[8]) check(a[8] > 0, 8), all.Jp.push_back(a[8]);
    if (has[3]) all.v.emplace_back(a[3], a[4], a[5]);
    if (has[9]) {
        Mat3d Fe;
        Fe << a[9], a[10], a[11], a[12], a[13], a[14], a[15], a[16], a[17];
        all.Fe.push_back(Fe);
    }
    if (has[18]) all.asleep.push_back(a[18]);
    all.x.emplace_back(a[0], a[1], a[2]);
}

// A group of columns counts only where all of it is there.
static void need_all(Has& has, std::size_t from, std::size_t to) {
    const bool all = std::all_of(has.begin() + from, has.begin() + to, [](bool b) { return b; });
    std::fill(has.begin() + from, has.begin() + to, all);
}

static PlyParticles read_vertices(const Element& element, Values& values) {
    std::vector<std::size_t> target(element.properties.size(), columns.size());
    Has has{};
    for (std::size_t i = 0; i < target.size(); ++i) {
        const auto& property = element.properties[i];
        const auto found = std::find(columns.begin(), columns.end(), property.name);
        if (found == columns.end() || property.list_size) continue;
        target[i] = static_cast<std::size_t>(found - columns.begin());
        has[target[i]] = true;
    }
    for (std::size_t c = 0; c < 3; ++c)
        if (!has[c]) throw PlyError(fmt::format("the vertices have no property {}", columns[c]));
    need_all(has, 3, 6);
    need_all(has, 9, 18);
    PlyParticles all;
    all.x.reserve(element.count);
    if (has[3]) all.v.reserve(element.count);
    for (std::size_t n = 0; n < element.count; ++n) {
        Row row;
        for (std::size_t i = 0; i < target.size(); ++i) {
            if (target[i] == columns.size()) values.skip(element.properties[i]);
            else if (const double value = values.next(element.properties[i].type); has[target[i]])
                row.value[target[i]] = value;
        }
        append(all, row, has);
    }
    return all;
}

PlyParticles read_ply(std::string_view bytes) {
    const Header header = read_header(bytes);
    Values values(bytes.substr(header.size), header.encoding);
    for (const auto& element : header.elements) {
        values.check_room(element);
        if (element.name == "vertex") {
            if (element.properties.empty()) throw PlyError("the vertices have no property x");
            return read_vertices(element, values);
        }
        if (element.properties.empty()) continue;
        for (std::size_t n = 0; n < element.count; ++n)
            for (const auto& property : element.properties) values.skip(property);
    }
    throw PlyError("the file has no element vertex");
}

std::string ply_header(const ParticleRows& rows) {
    std::string header = "ply\nformat binary_little_endian 1.0\ncomment firn, SI units\n";
    header += fmt::format("element vertex {}\n", rows.count);
    for (const auto& column : rows.columns)
        header += fmt::format("property {} {}\n", rows.twofold ? "double" : "float", column);
    return header + "end_header\n";
}

}  // namespace firn
