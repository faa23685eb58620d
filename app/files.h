#pragma once
#include <filesystem>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

namespace firn {

/// A file or folder could not be read or written: what() names it and says why.
struct FileError : std::runtime_error { using runtime_error::runtime_error; };

/// The bytes of a regular file of at most `most` bytes; never waits for a pipe or a device. Throws FileError.
std::string read_file(const std::filesystem::path&, std::size_t most);

/// Writes the pieces, one after the other, beside the path and renames them into it once they are on disk:
/// what is at the path is whole at any time. Throws FileError and leaves nothing behind where that fails.
void write_file(const std::filesystem::path&, const std::vector<std::string_view>& pieces);

/// Writes a result to standard output. Throws FileError if that fails, unless nobody reads it any more.
void print_result(const std::string& text);

/// Makes the folder and those above it. Throws FileError.
void make_folder(const std::filesystem::path&);

/// Whether the name is one that write_file gives to what it has not finished.
bool is_unfinished(const std::filesystem::path&);

/// A write to a closed pipe or past a size limit must fail as a write, not end the program.
void ignore_write_signals();

/// Holds a folder for one run at a time, until it is destroyed. Throws FileError that names the process that
/// has it.
class FolderLock {
public:
    explicit FolderLock(const std::filesystem::path& folder);
    ~FolderLock();
    FolderLock(const FolderLock&) = delete;
    FolderLock& operator=(const FolderLock&) = delete;

private:
    int descriptor_;
};

}  // namespace firn
