// Whole files in, whole files out.
//
// Reading: one read of the whole file. Writing: AtomicFile writes to a file without a name (where the
// file system allows it; a hidden neighbour otherwise) and gives it its name with one rename after
// fsync. So a file of that name is either the old one or the complete new one, whatever ends the program.
#pragma once

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "overtet/io.h"
#include "overtet/result.h"
#include "src/io/gzip.h"
#include "src/io/tuning.h"

namespace overtet {

// The bytes of a file, or of standard input ("-"); what is compressed by gzip is unpacked. Directories and
// unreadable files are ErrorCode::io, and so are files that change while they are read; damaged gzip files
// are ErrorCode::bad_input.
Result<std::string> read_file(const std::string& path);

bool file_exists(const std::string& path);
// Whether another file can be written beside this one: not for standard output, pipes and devices.
bool has_neighbours(const std::string& path);

// Destroyed without commit(): nothing is left behind. A path that names something else than a regular
// file (a pipe, /dev/null), and standard output ("-"), is written to directly. Where the path ends in .gz,
// what is written is compressed. A named pipe that nothing reads from is an error after two seconds; one
// whose reader goes away is an error, too, and no signal. Writing waits for a reader that does not read.
class AtomicFile {
 public:
  AtomicFile() = default;
  ~AtomicFile();
  AtomicFile(const AtomicFile&) = delete;
  AtomicFile& operator=(const AtomicFile&) = delete;

  Status open(const std::string& path);
  Status write(std::string_view bytes);
  // Flushes to the disk, so that what can fail has failed before any name changes. Called by commit().
  Status sync();
  Status commit();

 private:
  friend class OutputProbe;
  Status open_directly();
  Status write_plain(std::string_view bytes);
  Status end_compression();
  Error error(const char* what, int code) const;
  Error error_of_name(int code) const;
  void abandon();

  std::string path_;       // as the user wrote it
  std::string target_;     // with symbolic links followed
  std::string temporary_;  // empty: the file has no name yet
  int fd_ = -1;
  bool direct_ = false;
  bool synced_ = false;
  std::unique_ptr<io_detail::Gzip> gzip_;
};

// Text being put together. Numbers are written in the shortest form that reads back as the same double, so
// that a file holds exactly what was checked.
class TextBuffer {
 public:
  TextBuffer& text(std::string_view s) {
    bytes_.append(s);
    return *this;
  }
  TextBuffer& character(char c) {
    bytes_.push_back(c);
    return *this;
  }
  TextBuffer& number(double x) { return put(x); }
  TextBuffer& number(std::int64_t x) { return put(x); }
  TextBuffer& number(std::int32_t x) { return put(x); }
  TextBuffer& end_line() { return character('\n'); }
  std::string_view view() const { return bytes_; }

 private:
  friend class TextWriter;

  template <class T>
  TextBuffer& put(T x) {
    char digits[32];
    const auto end = std::to_chars(digits, digits + sizeof digits, x).ptr;
    bytes_.append(digits, static_cast<std::size_t>(end - digits));
    return *this;
  }

  std::string bytes_;
};

// Text for an AtomicFile, or for a string.
class TextWriter {
 public:
  explicit TextWriter(AtomicFile& file) : file_(&file) {}
  explicit TextWriter(std::string& memory) : memory_(&memory) {}

  TextWriter& text(std::string_view s) {
    buffer_.text(s);
    return spill();
  }
  TextWriter& character(char c) {
    buffer_.character(c);
    return *this;
  }
  TextWriter& number(double x) { return put(x); }
  TextWriter& number(std::int64_t x) { return put(x); }
  TextWriter& number(std::int32_t x) { return put(x); }
  TextWriter& end_line() { return character('\n').spill(); }

  // line(TextBuffer&, i) for i = 0 .. n-1, in that order in the file, but put together by all threads.
  template <class Line>
  TextWriter& lines(std::int64_t n, Line&& line) {
    flush();
    std::vector<TextBuffer> blocks(kTextBlocks);
    for (std::int64_t done = 0; done < n && status_.ok(); done += kLightGrain * kTextBlocks) {
      parallel_for(std::min(n - done, kLightGrain * kTextBlocks), kLightGrain,
                   [&](std::int64_t begin, std::int64_t end) {
                     TextBuffer& block = blocks[begin / kLightGrain];
                     for (std::int64_t i = begin; i < end; ++i) line(block, done + i);
                   });
      for (TextBuffer& block : blocks) {
        pass_on(block);
      }
    }
    return *this;
  }

  // Writes what is buffered; the first error of all writes.
  Status finish();

 private:
  template <class T>
  TextWriter& put(T x) {
    buffer_.number(x);
    return *this;
  }
  TextWriter& spill() {
    if (buffer_.bytes_.size() >= kBuffer) flush();
    return *this;
  }
  void flush() { pass_on(buffer_); }
  void pass_on(TextBuffer& block);

  AtomicFile* file_ = nullptr;
  std::string* memory_ = nullptr;
  TextBuffer buffer_;
  Status status_ = success();
};

}  // namespace overtet
