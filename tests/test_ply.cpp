#include "app/files.h"
#include "app/ply.h"
#include "app/scene_load.h"
#include "tests/temp_folder.h"

#include <catch2/catch.hpp>

#include <cmath>
#include <cstring>

using namespace firn;

static const std::string xyz = "property float x\nproperty float y\nproperty float z\n";

static std::string ascii(const std::string& properties, int count, const std::string& rows) {
    return "ply\nformat ascii 1.0\nelement vertex " + std::to_string(count) + "\n" + properties +
           "end_header\n" + rows;
}

template <class T> static std::string bytes(T value, bool big) {
    std::string b(sizeof value, '\0');
    std::memcpy(b.data(), &value, sizeof value);
    if (big) std::reverse(b.begin(), b.end());
    return b;
}

static std::string refusal(const std::string& file) {
    try {
        read_ply(file);
        return "";
    } catch (const PlyError& e) {
        return e.what();
    }
}

TEST_CASE("A PLY that was written reads back to the bit, in float and double, plain and full", "[ply]") {
    const bool twofold = GENERATE(false, true), full = GENERATE(false, true);
    ParticleRows rows;
    rows.twofold = twofold;
    rows.columns = {"x", "y", "z", "vx", "vy", "vz"};
    if (full)
        for (const char* name : {"mass", "volume", "Jp", "Fe_00", "Fe_01", "Fe_02", "Fe_10", "Fe_11", "Fe_12",
                                 "Fe_20", "Fe_21", "Fe_22"})
            rows.columns.push_back(name);
    rows.count = 3;
    std::vector<double> values;
    for (std::size_t i = 0; i < rows.count * rows.columns.size(); ++i) {
        const double value = std::sqrt(static_cast<double>(i + 2));
        values.push_back(twofold ? value : static_cast<float>(value));
        const std::string b = twofold ? bytes(value, false) : bytes(static_cast<float>(value), false);
        for (const char c : b) rows.data.push_back(static_cast<std::byte>(c));
    }
    const std::string header = ply_header(rows);
    CHECK(header.starts_with("ply\nformat binary_little_endian 1.0\n"));
    CHECK(header.find("element vertex 3\n") != std::string::npos);
    CHECK(header.find(twofold ? "property double x\n" : "property float x\n") != std::string::npos);

    const auto read =
        read_ply(header + std::string(reinterpret_cast<const char*>(rows.data.data()), rows.data.size()));
    REQUIRE(read.x.size() == 3);
    for (std::size_t p = 0; p < 3; ++p) {
        const double* row = values.data() + p * rows.columns.size();
        CHECK(read.x[p] == Vec3d(row[0], row[1], row[2]));
        CHECK(read.v[p] == Vec3d(row[3], row[4], row[5]));
        if (!full) continue;
        CHECK(read.mass[p] == row[6]);
        CHECK(read.volume[p] == row[7]);
        CHECK(read.Jp[p] == row[8]);
        CHECK(read.Fe[p](0, 1) == row[10]);  // row by row
        CHECK(read.Fe[p](2, 0) == row[15]);
    }
    CHECK(read.mass.empty() == !full);
    CHECK(read.Fe.empty() == !full);
}

TEST_CASE("Any type, order and extra property is read, in either byte order", "[ply]") {
    const bool big = GENERATE(false, true);
    const std::string file =
        std::string("ply\r\nformat ") + (big ? "binary_big_endian" : "binary_little_endian") + " 1.0\r\n" +
        "comment made elsewhere\r\nobj_info nothing\r\n"
        "element face 2\r\nproperty list uchar int vertex_indices\r\nproperty short material\r\n"
        "element nothing 1000000\r\n"
        "element vertex 2\r\nproperty uchar red\r\nproperty double z\r\nproperty int x\r\nproperty list uint "
        "short neighbours\r\n"
        "property float64 y\r\nproperty uint16 mass\r\nproperty float vx\r\nend_header\r\n";
    std::string data;
    for (int face = 0; face < 2; ++face) {
        data += bytes<std::uint8_t>(3, big);
        for (int i = 0; i < 3; ++i) data += bytes<std::int32_t>(i, big);
        data += bytes<std::int16_t>(-7, big);
    }
    for (int p = 0; p < 2; ++p) {
        data += bytes<std::uint8_t>(255, big) + bytes(3.5 + p, big) + bytes<std::int32_t>(-2 - p, big);
        data += bytes<std::uint32_t>(static_cast<std::uint32_t>(p), big);
        for (int i = 0; i < p; ++i) data += bytes<std::int16_t>(9, big);
        data += bytes(0.25, big) + bytes<std::uint16_t>(40000, big) + bytes(1.0f, big);
    }
    const auto read = read_ply(file + data);
    REQUIRE(read.x.size() == 2);
    CHECK(read.x[0] == Vec3d(-2, 0.25, 3.5));
    CHECK(read.x[1] == Vec3d(-3, 0.25, 4.5));
    CHECK(read.mass[1] == 40000);
    CHECK(read.v.empty());  // vx without vy and vz is no velocity
}

TEST_CASE("An ascii PLY is read", "[ply]") {
    const auto read = read_ply(ascii(xyz + "property list uchar int n\nproperty double Jp\n", 2,
                                     "1 2e-3 -3 2 7 8 0.5\n+4\t5 .6 0 1\n"));
    REQUIRE(read.x.size() == 2);
    CHECK(read.x[0] == Vec3d(1, 2e-3, -3));
    CHECK(read.x[1] == Vec3d(4, 5, 0.6));
    CHECK(read.Jp == std::vector{0.5, 1.0});
}

TEST_CASE("A PLY that cannot be right is refused with what is wrong", "[ply]") {
    struct Bad { std::string file, says; };
    const std::vector<Bad> table{
        {"", "not a PLY file"},
        {"\x89PNG\r\n\x1A\n....", "not a PLY file"},
        {"plyx\nformat ascii 1.0\n", "not a PLY file"},
        {"ply\nformat ascii 1.0\nelement vertex 1\n", "no end"},
        {"ply\nformat ascii 1.0\nend_header\n", "no element vertex"},
        {"ply\nformat binary 1.0\nend_header\n", "unknown format 'binary'"},
        {"ply\nelement vertex 1\n" + xyz + "end_header\n0 0 0\n", "names no format"},
        {"ply\nformat ascii 1.0\nelement vertex -1\n" + xyz + "end_header\n", "'-1' is no count"},
        {"ply\nformat ascii 1.0\nelement vertex 99999999999999999999999\n" + xyz + "end_header\n",
         "is no count"},
        {"ply\nformat ascii 1.0\nelement vertex 4294967295\n" + xyz + "end_header\n0 0 0\n",
         "promises 4294967295"},
        {"ply\nformat binary_little_endian 1.0\nelement vertex 18446744073709551615\n" + xyz +
             "end_header\n0 0 0\n",
         "promises"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nelement vertex 1\nend_header\n", "no property x"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nend_header\n0 0\n",
         "no property z"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty real x\nend_header\n", "unknown type 'real'"},
        {"ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float x\nend_header\n",
         "property x is given twice"},
        {"ply\nformat ascii 1.0\nproperty float x\nend_header\n", "line 3 of the header"},
        {ascii(xyz, 1, "0 0\n"), "promises"},
        {ascii(xyz, 1, "0    0   \n"), "ends within its data"},
        {ascii(xyz, 1, "0 zero 0\n"), "'zero' is not a number"},
        {ascii(xyz, 1, "0 nan 0\n"), "y of particle 0 is nan"},
        {ascii(xyz, 2, "0 0 0\n0 0 inf\n"), "z of particle 1 is inf"},
        {ascii(xyz, 1, "0 0 1e999\n"), "is not a number"},
        {ascii(xyz + "property float mass\n", 1, "0 0 0 0\n"), "mass of particle 0 is 0"},
        {ascii(xyz + "property float Jp\n", 1, "0 0 0 -1\n"), "Jp of particle 0 is -1"},
        {ascii(xyz + "property float volume\n", 1, "0 0 0 -1\n"), "volume of particle 0"},
        {ascii(xyz + "property list char int n\n", 1, "0 0 0 -1\n"), "whole number of entries"},
        {ascii(xyz + "property list uint int n\n", 1, "0 0 0 4000000000\n"), "ends within its data"},
        {"ply\nformat binary_little_endian 1.0\nelement vertex 2\n" + xyz + "end_header\n" +
             std::string(23, '\0'),
         "promises 2 of vertex"},
    };
    for (const auto& bad : table) {
        const std::string told = refusal(bad.file);
        CAPTURE(bad.file, told);
        CHECK(told.find(bad.says) != std::string::npos);
    }
}

TEST_CASE("A PLY cut anywhere is refused", "[ply]") {
    const std::string whole = "ply\nformat binary_little_endian 1.0\nelement vertex 4\n" + xyz +
                              "end_header\n" + std::string(48, '\1');
    CHECK(refusal(whole) == "");
    for (std::size_t size = 0; size < whole.size(); ++size) CHECK(refusal(whole.substr(0, size)) != "");
}

TEST_CASE("A scene names the particle file that it cannot use", "[ply][scene]") {
    const TempFolder folder;
    folder.write("bad.ply", "not a ply\n");
    const auto told = [&](const std::string& name) -> std::string {
        try {
            load_scene_text("grid_spacing: 0.1\nbodies: [{particles: " + name + "}]\n", folder / "s.yaml");
            return "";
        } catch (const SceneError& e) {
            return e.what();
        }
    };
    CHECK(told("bad.ply").find("s.yaml:2:22: bodies.0.particles: " + folder / "bad.ply" +
                               ": not a PLY file") != std::string::npos);
    CHECK(told("none.ply").find("No such file or directory (paths are relative to the scene)") !=
          std::string::npos);
    CHECK(told(".").find("Is a directory") != std::string::npos);
    CHECK(told("/dev/zero").find("not a regular file") != std::string::npos);
}
