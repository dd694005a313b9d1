// Errors are values: a code that is also the program's exit code, and one sentence for the user. Messages
// quote paths and words of files as they are, which need not be UTF-8.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "overtet/certificate.h"

namespace overtet {

enum class ErrorCode {
  usage = 2,         // the options contradict each other or are out of range
  bad_input = 3,     // the input is not a surface that can be meshed; the message names the element
  unsolved = 4,      // no mesh was found, and nothing proves that there is none
  infeasible = 5,    // no such mesh exists; the certificate says why
  limit = 6,         // the time or memory limit was reached
  io = 7,            // a file could not be read or written
  internal = 70,     // a bug
  interrupted = 130  // the program ends with 143 or 129 where SIGTERM or SIGHUP did it
};

// What more is known of an error, where that decides what is tried or advised next.
enum class ErrorReason {
  none,
  exhausted,    // of `unsolved`: every gluing has been tried, of crossings rounded to doubles
  endless,      // of `unsolved`: the work allowed was used up; more work might have found a mesh
  time_limit,   // of `limit`: the context's deadline
  memory_limit  // of `limit`: the context's memory_limit_bytes
};

struct Error {
  ErrorCode code = ErrorCode::internal;
  std::string message;  // for the user, on one line: what is wrong, where, and what to do about it
  // Where, if it is in one place: in the coordinates of the geometry that the function was given.
  std::optional<std::array<double, 3>> place = std::nullopt;
  ErrorReason reason = ErrorReason::none;
  // Of `infeasible`: the proof. (None where a repair gave up, or a part of the surface is what has no mesh.)
  // Shared, so that errors are small.
  std::shared_ptr<const Certificate> certificate = nullptr;
  int face = -1;  // of `bad_input`, if one face of the given surface is at fault: its number, from 0
};

// A value or an error. Check ok() before value(); taking the wrong one is a bug.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : state_(std::in_place_index<0>, std::move(value)) {}
  Result(Error error) : state_(std::in_place_index<1>, std::move(error)) {}

  bool ok() const { return state_.index() == 0; }
  explicit operator bool() const { return ok(); }
  T& value() & { return std::get<0>(state_); }
  const T& value() const& { return std::get<0>(state_); }
  T&& value() && { return std::get<0>(std::move(state_)); }
  const Error& error() const { return std::get<1>(state_); }

 private:
  std::variant<T, Error> state_;
};

// Success without a value, or an error.
using Status = Result<std::monostate>;
inline Status success() { return Status(std::monostate{}); }

// The exception that is being handled, as an error: `limit` where memory or threads ran out, `internal`
// otherwise. For catch blocks around code that may throw.
Error error_of_exception();

}  // namespace overtet
