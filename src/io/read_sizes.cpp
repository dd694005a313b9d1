#include <limits>

#include "overtet/io.h"
#include "src/io/file.h"
#include "src/io/text.h"

namespace overtet {

Result<std::vector<double>> read_sizes(const std::string& path) {
  const Result<std::string> text = read_file(path);
  if (!text) return text.error();
  if (const std::int64_t line = line_of_nul(text.value()))
    return Error{ErrorCode::bad_input,
                 path + ", line " + std::to_string(line) + ": a file of sizes is text."};
  TextCursor cursor(path, text.value(), true);
  std::vector<double> sizes;
  while (cursor.to_token()) {
    const auto name = [&] { return "size of vertex " + std::to_string(sizes.size()); };
    double size = 0;
    if (!cursor.real(size, name)) return cursor.error();
    if (size < 0) {
      cursor.fail("a size must be positive, or 0 for any (" + name() + ")");
      return cursor.error();
    }
    sizes.push_back(size > 0 ? size : std::numeric_limits<double>::infinity());
  }
  return sizes;
}

}  // namespace overtet
