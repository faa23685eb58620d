#pragma once
#include <optional>
#include <string>

namespace firn {

/// The first place at which bytes are no text that a scene may hold, counted from 1.
struct TextFault {
    int line = 1, column = 1;
    std::string message;
};

/// Finds what is not UTF-8, control characters other than tab and line ends, and tabs that indent.
std::optional<TextFault> find_text_fault(const std::string& bytes);

/// Whether UTF-8 text holds no control characters but tab and line feed.
bool is_printable(const std::string& text);

}  // namespace firn
