#include "src/batch/content_hash.h"

#include <fcntl.h>
#include <nettle/sha2.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <vector>

#include "src/batch/tuning.h"

namespace overtet {

namespace {

std::string hexadecimal(sha256_ctx& hash) {
  std::array<std::uint8_t, SHA256_DIGEST_SIZE> digest;
  sha256_digest(&hash, digest.size(), digest.data());
  std::string text;
  for (const std::uint8_t byte : digest) {
    text.push_back("0123456789abcdef"[byte >> 4]);
    text.push_back("0123456789abcdef"[byte & 15]);
  }
  return text;
}

std::int64_t nanoseconds(const timespec& t) { return std::int64_t{t.tv_sec} * 1'000'000'000 + t.tv_nsec; }

FileState state_from(const struct stat& info) {
  FileState s;
  s.bytes = info.st_size;
  s.modified_ns = nanoseconds(info.st_mtim);
  s.changed_ns = nanoseconds(info.st_ctim);
  s.inode = info.st_ino;
  s.device = info.st_dev;
  return s;
}

}  // namespace

Result<FileState> state_of(const std::string& path) {
  const auto fail = [&](int code) {
    return Error{ErrorCode::io, "Cannot read " + path + ": " + std::strerror(code) + "."};
  };
  // A named pipe would wait for a writer.
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return fail(errno);
  struct stat info;
  if (::fstat(fd, &info) != 0 || !S_ISREG(info.st_mode)) {
    const int code = errno;
    ::close(fd);
    if (S_ISREG(info.st_mode)) return fail(code);
    return Error{ErrorCode::io,
                 "Cannot read " + path + ": a batch takes files only, no folders, pipes or devices."};
  }
  sha256_ctx hash;
  sha256_init(&hash);
  std::vector<std::uint8_t> block(kHashBlock);
  for (;;) {
    const ssize_t got = ::read(fd, block.data(), block.size());
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      const int code = errno;
      ::close(fd);
      return fail(code);
    }
    if (got == 0) break;
    sha256_update(&hash, static_cast<std::size_t>(got), block.data());
  }
  ::close(fd);
  FileState state = state_from(info);
  state.sha256 = hexadecimal(hash);
  return state;
}

bool unchanged_since(const FileState& state, const std::string& path) {
  struct stat info;
  if (::stat(path.c_str(), &info) != 0) return false;
  const FileState now = state_from(info);
  return now.bytes == state.bytes && now.modified_ns == state.modified_ns &&
         now.changed_ns == state.changed_ns && now.inode == state.inode && now.device == state.device;
}

std::string sha256_of(const std::string& text) {
  sha256_ctx hash;
  sha256_init(&hash);
  sha256_update(&hash, text.size(), reinterpret_cast<const std::uint8_t*>(text.data()));
  return hexadecimal(hash);
}

}  // namespace overtet
