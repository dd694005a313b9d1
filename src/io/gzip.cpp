#include "src/io/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <new>

#include "src/io/tuning.h"

namespace overtet::io_detail {

namespace {

int gzip_window() { return 16 + MAX_WBITS; }  // zlib's way of asking for gzip's format

// Where what comes out is put first: not larger than it must be for small files. (What does not shrink takes
// a few bytes more when it is compressed.)
std::string block_for(std::size_t bytes) { return std::string(std::min(2 * bytes + 64, kBuffer), '\0'); }

// zlib takes and gives 32-bit counts.
uInt portion(std::size_t bytes) { return static_cast<uInt>(std::min<std::size_t>(bytes, kBuffer)); }

Bytef* pointer(const char* bytes) { return reinterpret_cast<Bytef*>(const_cast<char*>(bytes)); }

}  // namespace

bool is_gzip(std::string_view bytes) { return bytes.substr(0, 3) == "\x1f\x8b\x08"; }

std::optional<std::string> gunzip(std::string_view bytes) {
  std::string out;
  std::string block = block_for(4 * bytes.size());
  while (is_gzip(bytes)) {  // what follows the last member is padding
    z_stream z{};
    if (inflateInit2(&z, gzip_window()) != Z_OK) throw std::bad_alloc();
    int code = Z_OK;
    while (code == Z_OK) {
      z.next_in = pointer(bytes.data());
      z.avail_in = portion(bytes.size());
      const uInt given = z.avail_in;
      z.next_out = pointer(block.data());
      z.avail_out = portion(block.size());
      code = inflate(&z, Z_NO_FLUSH);
      bytes.remove_prefix(given - z.avail_in);
      if (code == Z_OK || code == Z_STREAM_END) out.append(block, 0, block.size() - z.avail_out);
    }
    inflateEnd(&z);
    if (code != Z_STREAM_END) return std::nullopt;
  }
  return out;
}

bool inflate_zlib(std::string_view bytes, std::uint64_t size, std::string& out) {
  // deflate makes nothing smaller than a thousandth: a size beyond that is a lie that must not take memory.
  if (size / 2048 > bytes.size()) return false;
  const std::size_t before = out.size();
  out.resize(before + static_cast<std::size_t>(size));
  uLongf made = static_cast<uLongf>(size);
  return uncompress(pointer(out.data() + before), &made, pointer(bytes.data()),
                    static_cast<uLong>(bytes.size())) == Z_OK &&
         made == size;
}

std::string deflate_zlib(std::string_view bytes) {
  std::string out(compressBound(static_cast<uLong>(bytes.size())), '\0');
  uLongf made = static_cast<uLongf>(out.size());
  if (compress2(pointer(out.data()), &made, pointer(bytes.data()), static_cast<uLong>(bytes.size()), 6) !=
      Z_OK)
    throw std::bad_alloc();
  out.resize(made);
  return out;
}

std::uint32_t crc32_of(std::string_view bytes) {
  return static_cast<std::uint32_t>(crc32_z(0, pointer(bytes.data()), bytes.size()));
}

struct Gzip::Stream {
  z_stream z{};
};

Gzip::Gzip() : stream_(std::make_unique<Stream>()) {
  // Level 6 and 8 are zlib's own choice. The header has no name and no time.
  if (deflateInit2(&stream_->z, 6, Z_DEFLATED, gzip_window(), 8, Z_DEFAULT_STRATEGY) != Z_OK)
    throw std::bad_alloc();
}

Gzip::~Gzip() { deflateEnd(&stream_->z); }

std::string Gzip::add(std::string_view bytes, bool last) {
  std::string out, block = block_for(bytes.size());
  z_stream& z = stream_->z;
  for (;;) {
    z.next_in = pointer(bytes.data());
    z.avail_in = portion(bytes.size());
    const uInt given = z.avail_in;
    z.next_out = pointer(block.data());
    z.avail_out = portion(block.size());
    const bool finish = last && given == bytes.size();
    const int code = deflate(&z, finish ? Z_FINISH : Z_NO_FLUSH);
    bytes.remove_prefix(given - z.avail_in);
    out.append(block, 0, block.size() - z.avail_out);
    if (code == Z_STREAM_END || (!last && bytes.empty() && z.avail_out > 0)) return out;
    if (code == Z_BUF_ERROR && !last && bytes.empty()) return out;
  }
}

}  // namespace overtet::io_detail
