#include <limits>

#include "overtet/io.h"
#include "src/io/file.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet {

Result<std::vector<double>> read_sizes(const std::string& path) {
  const Result<std::string> bytes = read_file(path);
  return bytes ? io_detail::parse_sizes(path, bytes.value()) : Result<std::vector<double>>(bytes.error());
}

Result<std::vector<double>> io_detail::parse_sizes(std::string_view name, std::string_view bytes) {
  if (const std::int64_t line = line_of_nul(bytes))
    return Error{ErrorCode::bad_input,
                 std::string(name) + ", line " + std::to_string(line) + ": a file of sizes is text."};
  TextCursor cursor(name, bytes, true);
  std::vector<double> sizes;
  while (cursor.to_token()) {
    const auto what = [&] { return "size of vertex " + std::to_string(sizes.size()); };
    double size = 0;
    if (!cursor.real(size, what)) return cursor.error();
    if (size < 0) {
      cursor.fail("a size must be positive, or 0 for any (" + what() + ")");
      return cursor.error();
    }
    sizes.push_back(size > 0 ? size : std::numeric_limits<double>::infinity());
  }
  return sizes;
}

}  // namespace overtet
