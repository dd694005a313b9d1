// What the user sees on standard error: messages, and a progress bar where that is a terminal.
#pragma once

#include <chrono>
#include <mutex>
#include <string>
#include <string_view>

#include "overtet/run_context.h"

namespace overtet {

class Terminal {
 public:
  enum class Talk { all, errors_only };
  Terminal(LogLevel level, Talk talk);
  ~Terminal() { clear(); }

  void progress(std::string_view stage, double fraction, std::string_view detail);
  void log(LogLevel level, std::string_view message);
  void say(std::string_view message);    // not with --quiet
  void error(std::string_view message);  // always; one line
  // The same by who ends the program meanwhile: nothing that others say follows.
  void last_words(std::string_view message);
  void clear();                          // takes the bar away
  bool has_bar() const { return bar_; }  // else progress() shows nothing

 private:
  void clear_locked();
  void line_locked(const char* colour, std::string_view label, std::string_view message);
  void line(const char* colour, std::string_view label, std::string_view message);

  LogLevel level_;
  bool quiet_, bar_, colours_, ended_ = false;
  std::mutex mutex_;
  std::size_t shown_ = 0;  // width of the bar on the screen
  std::string stage_;
  std::chrono::steady_clock::time_point last_{};
};

}  // namespace overtet
