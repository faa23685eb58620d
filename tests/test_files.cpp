#include "app/files.h"
#include "app/machine.h"
#include "app/output_folder.h"
#include "app/queue.h"
#include "tests/temp_folder.h"

#include <catch2/catch.hpp>
#include <sys/resource.h>
#include <sys/stat.h>

#include <thread>

using namespace firn;

namespace fs = std::filesystem;

static std::vector<std::string> names_in(const fs::path& folder) {
    std::vector<std::string> names;
    for (const auto& file : fs::directory_iterator(folder)) names.push_back(file.path().filename().string());
    return names;
}

TEST_CASE("A file is written whole, over what was there", "[files]") {
    const TempFolder folder;
    write_file(folder / "a", {"one", "", "two"});
    CHECK(bytes_of_file(folder / "a") == "onetwo");
    write_file(folder / "a", {"3"});
    CHECK(bytes_of_file(folder / "a") == "3");
    CHECK(names_in(folder.path()) == std::vector<std::string>{"a"});
}

TEST_CASE("A write that fails keeps the old file, leaves nothing behind and names the path", "[files]") {
    const TempFolder folder;
    const std::string old = folder.write("a", "old");
    ignore_write_signals();
    rlimit before{};
    getrlimit(RLIMIT_FSIZE, &before);
    const rlimit small{1000, before.rlim_max};
    setrlimit(RLIMIT_FSIZE, &small);
    const std::string large(2000, 'x');
    std::string told;
    try { write_file(old, {large}); } catch (const FileError& e) { told = e.what(); }
    setrlimit(RLIMIT_FSIZE, &before);
    CHECK(told == "cannot write " + old + ": File too large");
    CHECK(bytes_of_file(old) == "old");
    CHECK(names_in(folder.path()) == std::vector<std::string>{"a"});

    CHECK_THROWS_WITH(write_file(folder / "none/a", {"x"}),
                      Catch::EndsWith("none/a: No such file or directory"));
    fs::create_directory(folder / "folder");
    CHECK_THROWS_WITH(write_file(folder / "folder", {"x"}), Catch::EndsWith("folder: Is a directory"));
    CHECK(names_in(folder.path()).size() == 2);
}

TEST_CASE("Only regular files up to a size are read, and pipes are not waited for", "[files]") {
    const TempFolder folder;
    const std::string file = folder.write("a", std::string("\0abc", 4));
    CHECK(read_file(file, 4) == std::string("\0abc", 4));
    CHECK_THROWS_WITH(read_file(file, 3), Catch::Contains("it has 4 bytes, more than the 3"));
    CHECK_THROWS_WITH(read_file(folder / "b", 3), Catch::EndsWith("b: No such file or directory"));
    CHECK_THROWS_WITH(read_file(folder.path(), 3), Catch::EndsWith("Is a directory"));
    REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
    CHECK_THROWS_WITH(read_file(folder / "pipe", 3), Catch::EndsWith("not a regular file"));
}

TEST_CASE("A folder is held by one at a time, who is named", "[files]") {
    const TempFolder folder;
    {
        const FolderLock lock(folder.path());
        CHECK_THROWS_WITH(FolderLock(folder.path()),
                          Catch::Contains("is in use: process " + std::to_string(::getpid())));
    }
    CHECK_NOTHROW(FolderLock(folder.path()));
    CHECK_THROWS_AS(FolderLock(folder / "none"), FileError);
}

TEST_CASE("A folder that cannot be made is told", "[files]") {
    const TempFolder folder;
    make_folder(folder / "a/b/c");
    CHECK(fs::is_directory(folder / "a/b/c"));
    folder.write("file", "");
    CHECK_THROWS_AS(make_folder(folder / "file"), FileError);
    CHECK_THROWS_AS(make_folder(folder / "file/b"), FileError);
}

TEST_CASE("Only a run's own files are found and removed", "[files]") {
    const TempFolder folder;
    const OutputFolder out{folder.path()};
    CHECK_FALSE(out.has_results());
    fs::create_directories(folder / "frames");
    fs::create_directories(folder / "particles");
    const std::vector<std::string> own{"frames/frame_0000.png",    "frames/frame_12345.png",
                                       "particles/frame_0002.ply", "run.json",
                                       "checkpoint.firn",          "frames/.frame_0001.png.77.unfinished"};
    const std::vector<std::string> others{"frames/frame_1.png",    "frames/frame_00002.png",
                                          "frames/frame_0001.jpg", "frames/notes.txt",
                                          "frame_0000.png",        "frames/frame_-001.png"};
    for (const auto& name : others) folder.write(name, "mine");
    CHECK_FALSE(out.has_results());
    for (const auto& name : own) folder.write(name, "firn's");
    CHECK(out.has_results());
    CHECK(out.pictures_there() == std::vector<int>{0, 12345});
    CHECK(out.particles_there() == std::vector<int>{2});
    CHECK(out.picture(12345).filename() == "frame_12345.png");
    out.remove_results();
    for (const auto& name : own) CHECK_FALSE(fs::exists(folder / name));
    for (const auto& name : others) CHECK(fs::exists(folder / name));
}

TEST_CASE("A queue keeps the order, waits at its bound and hands out what is in it after closing",
          "[files]") {
    Queue<int> queue(2);
    std::vector<int> got;
    std::thread reader([&] { while (auto item = queue.pop()) got.push_back(*item); });
    for (int i = 0; i < 1000; ++i) CHECK(queue.push(int(i)));
    queue.close();
    reader.join();
    REQUIRE(got.size() == 1000);
    CHECK(std::is_sorted(got.begin(), got.end()));
    CHECK_FALSE(queue.push(1));
    Queue<int> dropped(2);
    CHECK(dropped.push(1));
    dropped.cancel();
    CHECK_FALSE(dropped.pop());
}

TEST_CASE("Memory, disk and cores are found", "[files]") {
    const TempFolder folder;
    CHECK(available_memory() > 1'000'000);
    CHECK(available_disk(folder / "not/there/yet") == available_disk(folder.path()));
    CHECK(this_machine().cores >= 1);
    CHECK(this_machine().memory >= available_memory());
}
