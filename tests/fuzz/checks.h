// What must hold of all that is read, whatever the file.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "overtet/io.h"
#include "overtet/result.h"

namespace overtet::fuzz {

// Ends the program with the text.
[[noreturn]] void fail(const std::string& what);
// The same where it does not hold. (No text is put together where it does: these are called millions of
// times.)
inline void require(bool holds, const char* what, std::string_view more = "") {
  if (!holds) fail(std::string(what) + (more.empty() ? "" : ": ") + std::string(more));
}

// One sentence on one line, and a code that reading may have.
void check_error(const Error& error);
void check_line(std::string_view text, const char* what);

// Indices are in range, coordinates are finite, and all lists are as long as they should be.
void check_surface(const Surface& surface, const SurfaceReadInfo& info);
void check_mesh(const LabelledTetMesh& mesh);

// Written in one of the formats and read back it is the same. `choice`: any number, which chooses the format.
void check_round_trip(const Surface& surface, const Labels& labels, std::uint64_t choice);
void check_round_trip(const LabelledTetMesh& mesh, std::uint64_t choice);

// Reads the bytes as a surface, and checks that.
void check_as_surface(const std::string& path, std::string_view bytes);
// The same as a tet mesh.
void check_as_mesh(const std::string& path, std::string_view bytes);

// A number that depends on all bytes.
std::uint64_t mixed(std::string_view bytes);
// The parts of bytes with a line "%" between them: so many, the last ones empty where there are fewer.
std::vector<std::string_view> parts_of(std::string_view bytes, std::size_t count);

// How much memory has been taken at a time since begin(), where a sanitizer counts it; a file may make
// Overtet take some times its size.
class MemoryUse {
 public:
  MemoryUse();
  // Requires that it is at most `each` bytes for each byte of the file, and some for buffers.
  void check(std::size_t file_size, std::size_t each = 4096) const;
};

}  // namespace overtet::fuzz
