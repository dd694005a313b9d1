// Checks of what must hold if the program has no bug. A release build leaves them out, and does not evaluate
// what they would look at; debug builds and those with sanitizers have them (OVERTET_ASSERTIONS in
// CMakeLists.txt). One that fails writes file, line and text to standard error and aborts: going on would
// hide the place, and a bug is nothing a caller could handle.
//
//   OVERTET_EXPECTS(condition)  what a function's header asks of its caller ("pre:")
//   OVERTET_ENSURES(condition)  what it promises; also a Status or Result, whose message is then written
//   OVERTET_ASSERT(condition)   what holds in between
//
// The same with _COSTLY for checks that take longer than the work itself: they need OVERTET_ASSERTIONS=2.
//
// Conditions without side effects, please. What a user or a file can cause is an Error, not an assertion.
#pragma once

#include <string_view>

#include "overtet/result.h"

#ifndef OVERTET_ASSERTIONS
#define OVERTET_ASSERTIONS 0
#endif

namespace overtet::assertion {

[[noreturn]] void fail(const char* kind, const char* text, const char* file, int line,
                       std::string_view message = {});

inline void check(bool holds, const char* kind, const char* text, const char* file, int line) {
  if (!holds) fail(kind, text, file, line);
}

template <class T>
void check(const Result<T>& result, const char* kind, const char* text, const char* file, int line) {
  if (!result.ok()) fail(kind, text, file, line, result.error().message);
}

}  // namespace overtet::assertion

#define OVERTET_CHECKED(kind, ...) \
  ::overtet::assertion::check((__VA_ARGS__), kind, #__VA_ARGS__, __FILE__, __LINE__)
#define OVERTET_UNCHECKED(...) static_cast<void>(sizeof((__VA_ARGS__)))

#if OVERTET_ASSERTIONS >= 1
#define OVERTET_EXPECTS(...) OVERTET_CHECKED("precondition", __VA_ARGS__)
#define OVERTET_ENSURES(...) OVERTET_CHECKED("postcondition", __VA_ARGS__)
#define OVERTET_ASSERT(...) OVERTET_CHECKED("assertion", __VA_ARGS__)
#else
#define OVERTET_EXPECTS(...) OVERTET_UNCHECKED(__VA_ARGS__)
#define OVERTET_ENSURES(...) OVERTET_UNCHECKED(__VA_ARGS__)
#define OVERTET_ASSERT(...) OVERTET_UNCHECKED(__VA_ARGS__)
#endif

#if OVERTET_ASSERTIONS >= 2
#define OVERTET_EXPECTS_COSTLY(...) OVERTET_EXPECTS(__VA_ARGS__)
#define OVERTET_ENSURES_COSTLY(...) OVERTET_ENSURES(__VA_ARGS__)
#else
#define OVERTET_EXPECTS_COSTLY(...) OVERTET_UNCHECKED(__VA_ARGS__)
#define OVERTET_ENSURES_COSTLY(...) OVERTET_UNCHECKED(__VA_ARGS__)
#endif
