#include "tests/support/process.h"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <fstream>
#include <stdexcept>
#include <thread>

namespace overtet::test {

Process::Process(const std::vector<std::string>& command, const std::string& folder) {
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const std::string out = folder + "/out", err = folder + "/err";
  id_ = fork();
  if (id_ < 0) throw std::runtime_error("cannot start a process");
  if (id_ > 0) return;
  const int o = ::open(out.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int e = ::open(err.c_str(), O_WRONLY | O_CREAT | O_TRUNC, 0600);
  const int i = ::open("/dev/null", O_RDONLY);
  dup2(i, 0);
  dup2(o, 1);
  dup2(e, 2);
  execv(arguments[0], arguments.data());
  _exit(127);
}

Process::~Process() {
  if (ended_) return;
  ::kill(id_, SIGKILL);
  waitpid(id_, nullptr, 0);
}

std::vector<pid_t> Process::children() const {
  std::vector<pid_t> list;
  const std::string tasks = "/proc/" + std::to_string(id_) + "/task";
  if (DIR* directory = opendir(tasks.c_str())) {
    while (const dirent* entry = readdir(directory)) {
      std::ifstream in(tasks + "/" + entry->d_name + "/children");
      for (pid_t child; in >> child;) list.push_back(child);
    }
    closedir(directory);
  }
  return list;
}

void Process::signal(int number) { ::kill(id_, number); }

std::optional<int> Process::wait(double seconds) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
  for (;;) {
    int status = 0;
    if (waitpid(id_, &status, WNOHANG) == id_) {
      ended_ = true;
      return WIFEXITED(status) ? WEXITSTATUS(status) : -WTERMSIG(status);
    }
    if (std::chrono::steady_clock::now() > end) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
}

bool is_running(pid_t process) {
  std::ifstream in("/proc/" + std::to_string(process) + "/stat");
  std::string text((std::istreambuf_iterator<char>(in)), {});
  const auto close = text.rfind(')');
  return close != std::string::npos && close + 2 < text.size() && text[close + 2] != 'Z';
}

}  // namespace overtet::test
