#include "render/text.h"

#include <vector>

#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#include <stb_easy_font.h>
#pragma GCC diagnostic pop

namespace firn {

std::string printable(std::string text) {
    for (char& c : text)
        if (c < 32 || c > 126) c = '?';
    return text;
}

void for_each_box(const std::string& text, const std::function<void(double, double, double, double)>& box) {
    struct FontVertex { float x, y, z; unsigned char color[4]; };
    constexpr std::size_t vertices_in_character = 64;   // 17 on average
    std::string copy = printable(text);
    std::vector<FontVertex> vertices(copy.size() * vertices_in_character + 4);
    const int quads = stb_easy_font_print(0, 0, copy.data(), nullptr, vertices.data(),
                                          static_cast<int>(vertices.size() * sizeof(FontVertex)));
    for (int q = 0; q < quads; ++q) {
        const FontVertex &a = vertices[4 * q], &b = vertices[4 * q + 2];
        box(a.x, a.y, b.x, b.y);
    }
}

double text_width(const std::string& text) {
    std::string copy = printable(text);
    return stb_easy_font_width(copy.data());
}

}  // namespace firn
