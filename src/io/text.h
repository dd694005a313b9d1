// Reading numbers out of text, with errors that name the line. Internal to src/io.
#pragma once

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <string>
#include <string_view>

#include "kernels/core/assertions.h"
#include "overtet/result.h"
#include "src/io/tuning.h"

namespace overtet {

// What a token looks like in a message: printable, short, quoted.
inline std::string quoted(std::string_view token) {
  std::string s = "\"";
  for (const char c : token.substr(0, 32)) s += (c >= ' ' && c < 127) ? c : '?';
  if (token.size() > 32) s += "...";
  return s + "\"";
}

// A name that a file gives to a label, an array or a solid, on one line: control characters become blanks,
// and what is beyond the longest name is cut (not inside a character of UTF-8).
inline std::string one_line(std::string_view name) {
  std::size_t size = std::min(name.size(), kLongestName);
  while (size < name.size() && size > 0 && (static_cast<unsigned char>(name[size]) & 0xC0) == 0x80) --size;
  std::string s(name.substr(0, size));
  for (char& c : s)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = ' ';
  return s;
}

// Walks through text token by token. Every reading function returns false and keeps the error after a
// failure. Tokens never reach over the end of a line unless asked to.
class TextCursor {
 public:
  TextCursor(std::string_view file_name, std::string_view text, bool hash_comments,
             std::int64_t first_line = 1)
      : file_(file_name),
        p_(text.data()),
        end_(text.data() + text.size()),
        line_(first_line),
        comments_(hash_comments) {}

  std::int64_t line() const { return line_; }
  bool at_end() const { return p_ == end_; }
  std::size_t bytes_left() const { return static_cast<std::size_t>(end_ - p_); }
  const Error& error() const { return error_; }

  bool fail(const std::string& what) { return fail_at(line_, what); }
  bool fail_at(std::int64_t line, const std::string& what) {
    error_ = {ErrorCode::bad_input,
              std::string(file_) + ", line " + std::to_string(line) + ": " + what + "."};
    return false;
  }

  // Skips blanks and a comment; true at the end of the line.
  bool at_line_end() {
    for (;;) {
      while (p_ != end_ && (*p_ == ' ' || *p_ == '\t' || *p_ == '\r' || *p_ == '\v' || *p_ == '\f')) ++p_;
      if (p_ == end_ || *p_ == '\n') return true;
      if (comments_ && *p_ == '#') {
        skip_rest();
        return true;
      }
      if (*p_ == '\\' && continues_line()) continue;
      return false;
    }
  }

  void next_line() {
    skip_rest();
    if (p_ != end_) {
      ++p_;
      ++line_;
    }
  }

  // Moves to the next line that holds a token; false at the end of the text (no error is set).
  bool to_token() {
    while (at_line_end()) {
      if (p_ == end_) return false;
      next_line();
    }
    return true;
  }

  bool is_at(char c) const { return p_ != end_ && *p_ == c; }

  // pre: !at_line_end(). A token ends at a blank, a line end or a comment.
  std::string_view token() {
    OVERTET_EXPECTS(p_ != end_ && *p_ != '\n');
    const char* begin = p_;
    while (p_ != end_ && static_cast<unsigned char>(*p_) > ' ' && !(comments_ && *p_ == '#')) ++p_;
    if (p_ == begin) ++p_;  // a control character stands for itself
    return {begin, static_cast<std::size_t>(p_ - begin)};
  }

  // `what` names the number in messages, for instance "vertex 12".
  template <class Name>
  bool real(double& x, const Name& what) {
    if (at_line_end()) return fail("a number is missing (" + std::string(what()) + ")");
    const char* begin = p_;
    const char* from = *p_ == '+' && end_ - p_ > 1 && p_[1] != '-' ? p_ + 1 : p_;
    const auto [stop, code] = std::from_chars(from, end_, x);
    if (code == std::errc() && ends_token(stop) && std::isfinite(x)) {
      p_ = stop;
      return true;
    }
    p_ = begin;
    const std::string_view t = token();
    if (code == std::errc::result_out_of_range && stop == t.data() + t.size()) {
      // Too small is a rounding to zero or to a denormal; too large is an error.
      x = std::strtod(std::string(from, stop).c_str(), nullptr);
      if (std::isfinite(x)) return true;
      return fail(quoted(t) + " is too large for a double (" + std::string(what()) + ")");
    }
    if (code == std::errc() && stop == t.data() + t.size())
      return fail(quoted(t) + " is not a finite number (" + std::string(what()) + ")");
    return fail(quoted(t) + " is not a number (" + std::string(what()) + ")");
  }

  template <class Name>
  bool integer(std::int64_t& x, const Name& what) {
    if (at_line_end()) return fail("a number is missing (" + std::string(what()) + ")");
    const char* from = *p_ == '+' && end_ - p_ > 1 && p_[1] != '-' ? p_ + 1 : p_;
    const auto [stop, code] = std::from_chars(from, end_, x);
    if (code == std::errc() && ends_token(stop)) {
      p_ = stop;
      return true;
    }
    const std::string_view t = token();
    return fail(quoted(t) +
                (code == std::errc::result_out_of_range ? " is too large (" : " is not a whole number (") +
                std::string(what()) + ")");
  }

 private:
  bool ends_token(const char* at) const {
    return at == end_ || static_cast<unsigned char>(*at) <= ' ' || (comments_ && *at == '#');
  }
  void skip_rest() {
    const void* at = std::memchr(p_, '\n', static_cast<std::size_t>(end_ - p_));
    p_ = at ? static_cast<const char*>(at) : end_;
  }
  // A backslash at the end of a line joins it with the next one (OBJ).
  bool continues_line() {
    const char* q = p_ + 1;
    if (q != end_ && *q == '\r') ++q;
    if (q == end_ || *q != '\n') return false;
    p_ = q + 1;
    ++line_;
    return true;
  }

  std::string_view file_;
  const char* p_;
  const char* end_;
  std::int64_t line_;
  bool comments_;
  Error error_;
};

// The line of the first NUL byte of a text, 0 if there is none.
inline std::int64_t line_of_nul(std::string_view text) {
  const void* at = text.empty() ? nullptr : std::memchr(text.data(), 0, text.size());
  if (!at) return 0;
  std::int64_t line = 1;
  for (const char* p = text.data(); p != at; ++p) line += *p == '\n';
  return line;
}

}  // namespace overtet
