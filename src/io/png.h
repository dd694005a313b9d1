// Pictures as PNG files (ISO/IEC 15948). For src/view.
#pragma once

#include <cstdint>
#include <span>
#include <string>

namespace overtet::io_detail {

// 3 bytes a pixel (red, green, blue), row by row from the top. The same bytes for the same pixels.
// pre: rgb.size() == 3 * width * height, width and height > 0.
std::string encode_png(int width, int height, std::span<const std::uint8_t> rgb);

}  // namespace overtet::io_detail
