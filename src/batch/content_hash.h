// The contents of a file as a name for it.
#pragma once

#include <sys/stat.h>

#include <cstdint>
#include <string>

#include "overtet/result.h"

namespace overtet {

// A file as it was at some time: what its contents were, and what shows that it has been written to since.
struct FileState {
  std::string sha256;  // 64 hexadecimal digits
  std::int64_t bytes = 0;
  std::int64_t modified_ns = 0, changed_ns = 0;  // of the file system's clock
  std::uint64_t inode = 0, device = 0;
};

// Reads the whole file. Pipes, devices and folders have no state. Errors: io.
Result<FileState> state_of(const std::string& path);

// Whether the file is the very one, not written to since. (Looks at the file system only, not at the
// contents.)
bool unchanged_since(const FileState& state, const std::string& path);

// SHA-256 of a text, in hexadecimal digits.
std::string sha256_of(const std::string& text);

}  // namespace overtet
