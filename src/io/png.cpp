#include "src/io/png.h"

#include "kernels/core/assertions.h"
#include "src/io/gzip.h"

namespace overtet::io_detail {

namespace {

void add_number(std::string& out, std::uint32_t n) {  // the most significant byte first
  for (int shift = 24; shift >= 0; shift -= 8) out += static_cast<char>(n >> shift & 255);
}

void add_chunk(std::string& out, const char* type, const std::string& data) {
  add_number(out, static_cast<std::uint32_t>(data.size()));
  const std::string checked = type + data;
  out += checked;
  add_number(out, crc32_of(checked));
}

}  // namespace

std::string encode_png(int width, int height, std::span<const std::uint8_t> rgb) {
  OVERTET_EXPECTS(width > 0 && height > 0);
  const std::size_t row = 3 * static_cast<std::size_t>(width), rows = static_cast<std::size_t>(height);
  OVERTET_EXPECTS(rgb.size() == row * rows);
  // Each row begins with its filter: 1 (differences to the pixel on the left), which suits flat faces.
  std::string lines;
  lines.reserve((row + 1) * rows);
  for (std::size_t y = 0; y < rows; ++y) {
    lines += '\1';
    for (std::size_t x = 0; x < row; ++x) {
      const std::uint8_t left = x < 3 ? std::uint8_t{0} : rgb[y * row + x - 3];
      lines += static_cast<char>(rgb[y * row + x] - left);
    }
  }
  std::string header;
  add_number(header, static_cast<std::uint32_t>(width));
  add_number(header, static_cast<std::uint32_t>(height));
  header += {8, 2, 0, 0, 0};  // 8 bits a colour, no palette, no transparency, not interlaced
  std::string out = "\x89PNG\r\n\x1a\n";
  add_chunk(out, "IHDR", header);
  add_chunk(out, "IDAT", deflate_zlib(lines));
  add_chunk(out, "IEND", "");
  return out;
}

}  // namespace overtet::io_detail
