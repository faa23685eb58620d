#include "tests/temp_folder.h"

#include <catch2/catch.hpp>

#include <filesystem>
#include <regex>
#include <sstream>

namespace fs = std::filesystem;

namespace {

const fs::path source_dir = FIRN_SOURCE_DIR;

/// The names of all test cases.
std::vector<std::string> test_names() {
    std::vector<std::string> names;
    const std::regex test_case("TEST_CASE\\(\"([^\"]*)\"");
    for (const auto& file : fs::directory_iterator(source_dir / "tests")) {
        if (file.path().extension() != ".cpp") continue;
        const std::string text = bytes_of_file(file.path());
        for (std::sregex_iterator it(text.begin(), text.end(), test_case), end; it != end; ++it)
            names.push_back((*it)[1]);
    }
    return names;
}

/// What matches the expression's first group, all of it.
std::vector<std::string> all_matches(const std::string& text, const std::string& expression) {
    const std::regex re(expression);
    std::vector<std::string> found;
    for (std::sregex_iterator it(text.begin(), text.end(), re), end; it != end; ++it) found.push_back((*it)[1]);
    return found;
}

}  // namespace

TEST_CASE("docs/method.md names functions, files and tests that exist", "[document]") {
    std::istringstream document(bytes_of_file(source_dir / "docs/method.md"));
    const std::vector<std::string> tests = test_names();
    int rows = 0;
    for (std::string line; std::getline(document, line);) {
        const auto files = all_matches(line, "\\]\\(\\.\\./((?:sim|tests)/[^)]*\\.h)\\)");
        if (!line.starts_with("| ") || files.empty()) continue;
        CAPTURE(line);
        REQUIRE(files.size() == 1);
        const std::string code = bytes_of_file(source_dir / files[0]);
        CHECK(code != "");
        const auto functions = all_matches(line, "`([A-Za-z_]+)`");
        CHECK_FALSE(functions.empty());
        for (const auto& function : functions) {
            CAPTURE(function);
            CHECK(std::regex_search(code, std::regex("\\b" + function + "\\b")));
        }
        const auto named = all_matches(line, "\"([^\"]*)\" \\|$");
        REQUIRE(named.size() == 1);
        CHECK(std::find(tests.begin(), tests.end(), named[0]) != tests.end());
        ++rows;
    }
    CHECK(rows > 25);
}
