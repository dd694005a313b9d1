// A TextCursor for formats whose numbers may stand on any lines. Internal to src/io.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet::io_detail {

// Reads over line ends, and counts that the file can hold.
class Tokens {
 public:
  Tokens(std::string_view name, std::string_view text, bool hash_comments = true)
      : name_(name), in_(name, text, hash_comments) {}

  bool word(std::string_view& w) {
    if (!in_.to_token()) return false;
    w = in_.token();
    return true;
  }
  bool real(double& x, const char* what) {
    return in_.to_token() ? in_.real(x, [&] { return what; })
                          : in_.fail("the file ends where a number should be");
  }
  bool integer(std::int64_t& x, const char* what) {
    return in_.to_token() ? in_.integer(x, [&] { return what; })
                          : in_.fail("the file ends where a number should be");
  }
  // One that an Index can hold: labels, references.
  bool label(Index& x, const char* what) {
    std::int64_t wide = 0;
    if (!integer(wide, what)) return false;
    if (wide < -kMaxCount || wide > kMaxCount)
      return fail(std::to_string(wide) + " is too large (" + what + ")");
    x = static_cast<Index>(wide);
    return true;
  }
  // A number of items that take at least `bytes_each` each.
  bool count(std::int64_t& n, std::int64_t bytes_each, const char* what) {
    if (!integer(n, what)) return false;
    if (n < 0 || n > kMaxCount || n > static_cast<std::int64_t>(in_.bytes_left() + 1) / bytes_each)
      return fail("the file is too short for " + std::to_string(n) + " (" + what + ")");
    return true;
  }
  bool skip(std::int64_t numbers) {
    std::string_view w;
    for (; numbers > 0; --numbers)
      if (!word(w)) return fail("the file ends too early");
    return true;
  }
  // A number of a vertex, counted from `first`.
  bool vertex(Index& out, std::int64_t vertices, std::int64_t first, const char* what) {
    std::int64_t v = 0;
    if (!integer(v, what)) return false;
    if (v < first || v >= first + vertices) return fail("there is no vertex " + std::to_string(v));
    out = static_cast<Index>(v - first);
    return true;
  }
  // What is left of the line, without the blanks around it.
  std::string_view rest_of_line() {
    std::string_view first, last;
    while (!in_.at_line_end()) {
      last = in_.token();
      if (first.empty()) first = last;
    }
    if (first.empty()) return {};
    return {first.data(), static_cast<std::size_t>(last.data() + last.size() - first.data())};
  }
  void next_line() { in_.next_line(); }
  bool at_line_end() { return in_.at_line_end(); }
  bool fail(const std::string& what) { return in_.fail(what); }
  const Error& error() const { return in_.error(); }
  std::string_view name() const { return name_; }

 private:
  std::string_view name_;
  TextCursor in_;
};

}  // namespace overtet::io_detail
