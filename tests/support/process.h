// A program run beside the test, to be interrupted.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>
#include <vector>

namespace overtet::test {

class Process {
 public:
  // Output and errors go to files in `folder` called out and err.
  Process(const std::vector<std::string>& command, const std::string& folder);
  ~Process();  // kills it if it still runs
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  pid_t id() const { return id_; }
  std::vector<pid_t> children() const;
  void signal(int number);
  // The exit code (minus the signal where one ended it), or none when it still runs after the time.
  std::optional<int> wait(double seconds);

 private:
  pid_t id_ = -1;
  bool ended_ = false;
};

bool is_running(pid_t process);  // zombies do not count

}  // namespace overtet::test
