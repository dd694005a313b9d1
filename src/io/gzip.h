// Compressed data, by zlib. The only file that names it is gzip.cpp. Internal to src/io.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace overtet::io_detail {

// Whether bytes begin as gzip's do.
bool is_gzip(std::string_view bytes);
// What a gzip file holds (all its members); none where it is damaged or cut short.
std::optional<std::string> gunzip(std::string_view bytes);

// Appends what a zlib stream holds, `size` bytes exactly; false where it does not.
bool inflate_zlib(std::string_view bytes, std::uint64_t size, std::string& out);

// The zlib stream that holds bytes: the same whenever and wherever. And the checksum CRC-32 of bytes.
std::string deflate_zlib(std::string_view bytes);
std::uint32_t crc32_of(std::string_view bytes);

// Makes a gzip file: the same bytes whenever and wherever.
class Gzip {
 public:
  Gzip();
  ~Gzip();
  Gzip(const Gzip&) = delete;
  Gzip& operator=(const Gzip&) = delete;

  // The next bytes of the file, which may be none as yet; `last`: there are no more.
  std::string add(std::string_view bytes, bool last);

 private:
  struct Stream;
  std::unique_ptr<Stream> stream_;
};

}  // namespace overtet::io_detail
