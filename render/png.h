#pragma once
#include "render/image.h"

#include <map>
#include <string>

namespace firn {

/// PNG bytes of the picture: 8-bit RGB, tagged sRGB, with the texts as tEXt chunks (Latin-1) or iTXt (else).
/// Texts are UTF-8; their keys are ASCII, 1 to 79 characters.
std::vector<std::uint8_t> encode_png(const Image&, const std::map<std::string, std::string>& texts);

/// Reads any 8- or 16-bit PNG as 8-bit RGB. Throws std::runtime_error that names the file and what is wrong.
Image read_png(const std::string& path);

/// The tEXt and uncompressed iTXt chunks of a PNG, as UTF-8. Throws std::runtime_error where the bytes are no
/// whole PNG.
std::map<std::string, std::string> png_texts(const std::vector<std::uint8_t>& bytes);

/// Whether the file is a PNG to its last chunk, with every checksum right. Does not throw.
bool is_whole_png(const std::string& path);

}  // namespace firn
