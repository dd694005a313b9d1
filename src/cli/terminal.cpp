#include "src/cli/terminal.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>

#include "src/cli/tuning.h"

namespace overtet {

namespace {

bool is_set(const char* variable) {
  const char* value = std::getenv(variable);
  return value && *value;
}

std::size_t columns() {
  winsize size{};
  return ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 20 ? size.ws_col : 80;
}

// A message is one line, whatever it quotes.
std::string one_line(std::string_view text) {
  std::string s(text);
  std::replace_if(
      s.begin(), s.end(), [](unsigned char c) { return c < ' ' || c == 127; }, ' ');
  return s;
}

void put(const std::string& text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

}  // namespace

Terminal::Terminal(LogLevel level, Talk talk) : level_(level), quiet_(talk == Talk::errors_only) {
  const char* term = std::getenv("TERM");
  const bool terminal = isatty(STDERR_FILENO) && term && std::string_view(term) != "dumb";
  bar_ = terminal && !quiet_;
  colours_ = terminal && !is_set("NO_COLOR");
}

void Terminal::clear_locked() {
  if (shown_ == 0) return;
  std::string blank(shown_ + 2, ' ');
  blank.front() = blank.back() = '\r';
  put(blank);
  shown_ = 0;
}

void Terminal::clear() {
  const std::lock_guard lock(mutex_);
  clear_locked();
}

void Terminal::progress(std::string_view stage, double fraction, std::string_view detail) {
  if (!bar_) return;
  const std::lock_guard lock(mutex_);
  if (ended_) return;
  const auto now = std::chrono::steady_clock::now();
  if (stage == stage_ && now - last_ < kWatchPeriod) return;
  stage_ = stage;
  last_ = now;
  const double f = std::isfinite(fraction) ? std::clamp(fraction, 0.0, 1.0) : 0;
  std::string bar(24, '.');
  std::fill_n(bar.begin(), std::lround(f * static_cast<double>(bar.size())), '#');
  std::string text = std::string(stage);
  text.resize(std::max<std::size_t>(text.size(), 13), ' ');
  text += " [" + bar + "] ";
  text += std::to_string(static_cast<int>(100 * f)) + " % ";
  text += detail;
  text = one_line(text).substr(0, columns() - 1);
  std::string padded = text;
  if (padded.size() < shown_) padded.resize(shown_, ' ');
  shown_ = text.size();
  if (colours_) padded = "\x1b[36m" + padded + "\x1b[0m";
  put("\r" + padded);
}

void Terminal::line(const char* colour, std::string_view label, std::string_view message) {
  const std::lock_guard lock(mutex_);
  line_locked(colour, label, message);
}

void Terminal::line_locked(const char* colour, std::string_view label, std::string_view message) {
  if (ended_) return;
  clear_locked();
  std::string text;
  if (!label.empty())
    text = colours_ ? std::string(colour) + std::string(label) + "\x1b[0m: " : std::string(label) + ": ";
  put(text + one_line(message) + "\n");
}

void Terminal::log(LogLevel level, std::string_view message) {
  if (level > level_) return;
  switch (level) {
    case LogLevel::error:
      return line("\x1b[31m", "error", message);
    case LogLevel::warning:
      return line("\x1b[33m", "warning", message);
    case LogLevel::info:
      return line("\x1b[36m", "info", message);
    case LogLevel::debug:
      return line("\x1b[2m", "debug", message);
  }
}

void Terminal::say(std::string_view message) {
  if (!quiet_) line("", "", message);
}

void Terminal::error(std::string_view message) { line("\x1b[31m", "overtet", message); }

void Terminal::last_words(std::string_view message) {
  const std::lock_guard lock(mutex_);
  line_locked("\x1b[31m", "overtet", message);
  ended_ = true;
}

}  // namespace overtet
