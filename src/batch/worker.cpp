#include "src/batch/worker.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "src/batch/tuning.h"

namespace overtet {

namespace {

Error cannot_start(int code) {
  return {ErrorCode::internal, std::string("Cannot start a process: ") + std::strerror(code) + "."};
}

double seconds(const timeval& t) {
  return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
}

// In the child: what is called here must be safe after fork().
[[noreturn]] void become(char* const* words, pid_t parent, int nowhere, int printed) {
  // A batch that is killed takes its workers with it.
  ::prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (::getppid() != parent) ::_exit(127);
  ::dup2(nowhere, STDIN_FILENO);
  ::dup2(nowhere, STDOUT_FILENO);
  ::dup2(printed, STDERR_FILENO);
  sigset_t none;
  sigemptyset(&none);
  ::pthread_sigmask(SIG_SETMASK, &none, nullptr);
  ::execv(words[0], words);
  ::_exit(127);
}

}  // namespace

Worker::~Worker() {
  if (id_ > 0) {
    ::kill(id_, SIGKILL);
    while (::waitpid(id_, nullptr, 0) < 0 && errno == EINTR) {
    }
  }
  for (const int fd : {process_, printed_})
    if (fd >= 0) ::close(fd);
}

void Worker::swap(Worker& other) noexcept {
  std::swap(id_, other.id_);
  std::swap(process_, other.process_);
  std::swap(printed_, other.printed_);
  std::swap(late_, other.late_);
  std::swap(start_, other.start_);
  std::swap(latest_, other.latest_);
  std::swap(text_, other.text_);
}

Status Worker::start(const std::vector<std::string>& words, Clock::time_point latest) {
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) return cannot_start(errno);
  const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC);
  const pid_t parent = ::getpid();
  start_ = Clock::now();
  latest_ = latest;
  id_ = ::fork();
  if (id_ == 0) become(arguments.data(), parent, nowhere, ends[1]);
  const int code = errno;
  ::close(ends[1]);
  if (nowhere >= 0) ::close(nowhere);
  printed_ = ends[0];
  if (id_ < 0) return cannot_start(code);
  ::fcntl(printed_, F_SETFL, O_NONBLOCK);
  process_ =
      static_cast<int>(::syscall(SYS_pidfd_open, id_, 0));  // -1 on old kernels: looks at the clock do, too
  return success();
}

void Worker::read_printed() {
  char block[4096];
  while (printed_ >= 0) {
    const ssize_t got = ::read(printed_, block, sizeof block);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0 && errno == EAGAIN) return;
    if (got <= 0) {
      ::close(printed_);
      printed_ = -1;
      return;
    }
    text_.append(block, static_cast<std::size_t>(got));
    if (text_.size() > 2 * kKeptOutput) text_.erase(0, text_.size() - kKeptOutput);
  }
}

void Worker::interrupt() {
  if (id_ > 0) ::kill(id_, SIGTERM);
}

void Worker::kill() {
  if (id_ > 0) ::kill(id_, SIGKILL);
}

std::optional<WorkerEnd> Worker::ended() {
  if (id_ <= 0) return std::nullopt;
  int status = 0;
  rusage usage{};
  const pid_t got = ::wait4(id_, &status, WNOHANG, &usage);
  if (got == 0 || (got < 0 && errno == EINTR)) {
    if (!late_ && Clock::now() > latest_) {
      late_ = true;
      ::kill(id_, SIGKILL);
    }
    return std::nullopt;
  }
  id_ = -1;
  read_printed();
  WorkerEnd end;
  if (WIFEXITED(status))
    end.exit_code = WEXITSTATUS(status);
  else
    end.signal = WTERMSIG(status);
  end.killed_late = late_;
  end.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  end.cpu_seconds = seconds(usage.ru_utime) + seconds(usage.ru_stime);
  end.peak_rss_bytes = std::int64_t{usage.ru_maxrss} * 1024;
  end.printed = text_.size() > kKeptOutput ? text_.substr(text_.size() - kKeptOutput) : text_;
  return end;
}

void wait_for_any(std::vector<Worker*> workers, std::chrono::milliseconds most) {
  std::vector<pollfd> fds;
  for (const Worker* w : workers)
    for (const int fd : {w->process_fd(), w->printed_fd()})
      if (fd >= 0) fds.push_back({fd, POLLIN, 0});
  ::poll(fds.data(), fds.size(), static_cast<int>(most.count()));
  for (Worker* w : workers) w->read_printed();
}

}  // namespace overtet
