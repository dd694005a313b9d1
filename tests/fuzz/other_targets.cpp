#include <algorithm>
#include <cmath>
#include <optional>

#include "src/io/gzip.h"
#include "src/io/surface_parts.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/targets.h"

namespace overtet::fuzz {

void sizes(std::string_view bytes) {
  const MemoryUse memory;
  const Result<std::vector<double>> read = io_detail::parse_sizes("sizes.txt", bytes);
  memory.check(bytes.size());
  if (!read) return check_error(read.error());
  require(2 * read.value().size() <= bytes.size() + 1, "there are more sizes than the file has room for");
  for (const double x : read.value()) require(x > 0, "a size is not positive");
}

void gzip(std::string_view bytes) {
  using namespace io_detail;
  const MemoryUse memory;
  const std::optional<std::string> unpacked = gunzip(bytes);
  memory.check(bytes.size());
  if (unpacked && !bytes.empty()) {  // some zlib streams, some garbage
    std::string inflated;
    if (inflate_zlib(bytes.substr(1), static_cast<unsigned char>(bytes[0]), inflated))
      require(inflated.size() == static_cast<unsigned char>(bytes[0]), "a zlib stream has another size");
  }
  // In two pieces, which are put together again.
  const std::size_t half = bytes.size() / 2;
  Gzip packer;
  std::string packed = packer.add(bytes.substr(0, half), false);
  packed += packer.add(bytes.substr(half), true);
  require(is_gzip(packed), "what is compressed does not begin as gzip does");
  const std::optional<std::string> again = gunzip(packed);
  require(again && *again == bytes, "what is compressed is not unpacked again");
  packed.pop_back();
  require(!gunzip(packed), "a file that is cut short is unpacked");
}

}  // namespace overtet::fuzz
