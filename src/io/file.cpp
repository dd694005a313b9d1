#include "src/io/file.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <chrono>
#include <climits>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <optional>
#include <set>
#include <thread>

#include "kernels/core/tuning.h"
#include "src/io/names.h"
#include "src/io/tuning.h"

namespace overtet {

namespace {

std::string directory_of(const std::string& path) {
  const auto slash = path.rfind('/');
  if (slash == std::string::npos) return ".";
  return slash == 0 ? "/" : path.substr(0, slash);
}

// What the names of its hidden neighbours begin with: with what follows not longer than the longest of names.
std::string neighbour_of(const std::string& path) {
  const auto slash = path.rfind('/');
  const std::string name = slash == std::string::npos ? path : path.substr(slash + 1);
  return directory_of(path) + "/." + name.substr(0, NAME_MAX - kNameEnding);
}

// The permissions that a plain open(O_CREAT) would give.
mode_t default_mode() {
  const mode_t mask = umask(0);
  umask(mask);
  return 0666 & ~mask;
}

// Writing to a pipe that nothing reads from any more, or more than `ulimit -f` allows, sends a signal that
// ends the program, unless that has arranged for it. It is held back from the thread that writes, and taken
// away.
class NoWriteSignals {
 public:
  NoWriteSignals() {
    sigset_t pending;
    sigpending(&pending);
    sigemptyset(&ours_);
    for (const int signal : {SIGPIPE, SIGXFSZ})
      if (sigismember(&pending, signal) != 1) sigaddset(&ours_, signal);
    pthread_sigmask(SIG_BLOCK, &ours_, &before_);
  }
  ~NoWriteSignals() {
    constexpr timespec at_once{};
    int taken;
    do taken = sigtimedwait(&ours_, nullptr, &at_once);
    while (taken > 0 || (taken < 0 && errno == EINTR));
    pthread_sigmask(SIG_SETMASK, &before_, nullptr);
  }
  NoWriteSignals(const NoWriteSignals&) = delete;
  NoWriteSignals& operator=(const NoWriteSignals&) = delete;

 private:
  sigset_t ours_, before_;
};

// The hidden neighbours of all files that are being written. Never destroyed: threads may outlive what is
// static.
struct Neighbours {
  std::mutex mutex;
  std::set<std::string> names;
};
Neighbours& neighbours() {
  static Neighbours* const all = new Neighbours;
  return *all;
}
void remember(const std::string& name) {
  const std::lock_guard lock(neighbours().mutex);
  neighbours().names.insert(name);
}
void forget(const std::string& name) {
  const std::lock_guard lock(neighbours().mutex);
  neighbours().names.erase(name);
}

}  // namespace

void remove_unfinished_files() {
  const std::lock_guard lock(neighbours().mutex);
  for (const std::string& name : neighbours().names) ::unlink(name.c_str());
  neighbours().names.clear();
}

namespace {

// Whether a file that was `read` bytes long is not the one that it was before: others write to it. (What the
// kernel makes up has no size, and what it says of times is made up, too.)
bool differs(const struct stat& before, const struct stat& after, std::size_t read) {
  if (before.st_size == 0 && after.st_size == 0) return false;
  return after.st_size != before.st_size || static_cast<std::size_t>(after.st_size) != read ||
         after.st_mtim.tv_sec != before.st_mtim.tv_sec || after.st_mtim.tv_nsec != before.st_mtim.tv_nsec;
}

Result<std::string> read_stored(const std::string& path) {
  const auto fail = [&](int code) {
    const std::string what = path == "-" ? "standard input" : path;
    return Error{ErrorCode::io, "Cannot read " + what + ": " + std::strerror(code) + "."};
  };
  const int fd = path == "-" ? ::dup(STDIN_FILENO) : ::open(path.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) return fail(errno);
  struct stat info;
  if (fstat(fd, &info) != 0 || S_ISDIR(info.st_mode)) {
    const int code = S_ISDIR(info.st_mode) ? EISDIR : errno;
    ::close(fd);
    return fail(code);
  }
  const struct stat before = info;
  std::string bytes;
  // One byte more than expected, so that the end of the file is seen by the same loop as a pipe's end.
  bytes.resize(S_ISREG(info.st_mode) ? static_cast<std::size_t>(info.st_size) + 1 : 1 << 16);
  std::size_t used = 0;
  for (;;) {
    if (used == bytes.size()) bytes.resize(2 * bytes.size());
    const ssize_t got = ::read(fd, bytes.data() + used, bytes.size() - used);
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) {
      const int code = errno;
      ::close(fd);
      return fail(code);
    }
    if (got == 0) break;
    used += static_cast<std::size_t>(got);
  }
  const bool changed = S_ISREG(before.st_mode) && fstat(fd, &info) == 0 && differs(before, info, used);
  ::close(fd);
  if (changed)
    return Error{ErrorCode::io,
                 io_detail::file_name(path) +
                     " was changed while it was read; try again when whoever writes it is done."};
  bytes.resize(used);
  return bytes;
}

}  // namespace

Result<std::string> read_file(const std::string& path) {
  Result<std::string> stored = read_stored(path);
  if (!stored || !io_detail::is_gzip(stored.value())) return stored;
  std::optional<std::string> unpacked = io_detail::gunzip(stored.value());
  if (!unpacked)
    return Error{ErrorCode::bad_input,
                 io_detail::file_name(path) + ": the compressed file is damaged or cut short."};
  return *std::move(unpacked);
}

bool file_exists(const std::string& path) {
  struct stat info;
  return ::stat(path.c_str(), &info) == 0;
}

bool has_neighbours(const std::string& path) {
  struct stat info;
  return path != "-" && (::stat(path.c_str(), &info) != 0 || S_ISREG(info.st_mode));
}

AtomicFile::~AtomicFile() { abandon(); }

void AtomicFile::abandon() {
  if (fd_ >= 0) ::close(fd_);
  fd_ = -1;
  if (!temporary_.empty()) {
    ::unlink(temporary_.c_str());
    forget(temporary_);
  }
  temporary_.clear();
  direct_ = synced_ = false;
  gzip_.reset();
}

Error AtomicFile::error(const char* what, int code) const {
  return Error{ErrorCode::io, "Cannot " + std::string(what) + " " + path_ + ": " + std::strerror(code) + "."};
}

Error AtomicFile::error_of_name(int code) const {
  const std::string directory = directory_of(target_);
  if (code != ENOENT || file_exists(directory)) return error("write", code);
  return Error{ErrorCode::io,
               "Cannot write " + path_ + ": the folder " + directory + " has gone since the run began."};
}

Status AtomicFile::open(const std::string& path) {
  abandon();
  path_ = path;
  target_ = path;
  if (path == "-") {
    path_ = "standard output";
    direct_ = true;
    fd_ = ::dup(STDOUT_FILENO);
    return fd_ >= 0 ? success() : Status(error("write", errno));
  }
  if (io_detail::is_gzip_name(path)) gzip_ = std::make_unique<io_detail::Gzip>();
  if (char* real = ::realpath(path.c_str(), nullptr)) {
    target_ = real;
    std::free(real);
  }
  struct stat info;
  if (::stat(target_.c_str(), &info) == 0) {
    if (S_ISDIR(info.st_mode)) return error("write", EISDIR);
    direct_ = !S_ISREG(info.st_mode);
    // A rename would also replace a file that the user has made read-only.
    if (!direct_ && ::access(target_.c_str(), W_OK) != 0) return error("write", errno);
  }
  if (direct_) return open_directly();
  const std::string directory = directory_of(target_);
  fd_ = ::open(directory.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
  if (fd_ < 0 && !file_exists(directory))
    return Error{ErrorCode::io, "Cannot write " + path_ + ": there is no folder " + directory + "."};
  if (fd_ < 0) {
    std::string name = neighbour_of(target_) + ".XXXXXX";
    fd_ = ::mkostemp(name.data(), O_CLOEXEC);
    if (fd_ < 0) return error("write", errno);
    temporary_ = name;
    remember(temporary_);
  }
  if (::fchmod(fd_, default_mode()) != 0) { /* the file stays private to its owner */
  }
  return success();
}

// Opening a pipe waits for a reader for ever, unless it is told not to wait at all.
Status AtomicFile::open_directly() {
  const auto end = std::chrono::steady_clock::now() + kReaderWait;
  for (;;) {
    fd_ = ::open(target_.c_str(), O_WRONLY | O_CLOEXEC | O_NONBLOCK);
    if (fd_ >= 0) break;
    if (errno == EINTR) continue;
    struct stat info;
    const int code = errno;
    if (code != ENXIO || ::stat(target_.c_str(), &info) != 0 || !S_ISFIFO(info.st_mode))
      return error("write", code);
    if (std::chrono::steady_clock::now() > end)
      return Error{ErrorCode::io, "Cannot write " + path_ + ": it is a pipe that nothing reads from."};
    std::this_thread::sleep_for(kLookPeriod);
  }
  // Only opening must not wait: writes do, for who reads slowly.
  const int flags = ::fcntl(fd_, F_GETFL);
  if (flags < 0 || ::fcntl(fd_, F_SETFL, flags & ~O_NONBLOCK) != 0) return error("write", errno);
  return success();
}

Status AtomicFile::write(std::string_view bytes) {
  return gzip_ ? write_plain(gzip_->add(bytes, false)) : write_plain(bytes);
}

Status AtomicFile::end_compression() {
  if (!gzip_) return success();
  const std::string rest = gzip_->add({}, true);
  gzip_.reset();
  return write_plain(rest);
}

Status AtomicFile::write_plain(std::string_view bytes) {
  const NoWriteSignals no_signals;
  while (!bytes.empty()) {
    const ssize_t done = ::write(fd_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) return error("write", errno);
    bytes.remove_prefix(static_cast<std::size_t>(done));
  }
  return success();
}

Status AtomicFile::sync() {
  if (Status s = end_compression(); !s) return s;
  if (synced_ || direct_) return success();
  if (::fsync(fd_) != 0) return error("write", errno);
  synced_ = true;
  return success();
}

Status AtomicFile::commit() {
  if (Status s = sync(); !s) return s;
  if (!direct_) {
    if (temporary_.empty()) {
      // linkat cannot replace a file, so the name goes through a neighbour that exists for an instant.
      const std::string self = "/proc/self/fd/" + std::to_string(fd_);
      const std::string stem = neighbour_of(target_) + "." + std::to_string(::getpid()) + ".";
      for (int attempt = 0; attempt < 100; ++attempt) {
        const std::string name = stem + std::to_string(attempt);
        if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, name.c_str(), AT_SYMLINK_FOLLOW) == 0) {
          temporary_ = name;
          remember(temporary_);
          break;
        }
        if (errno != EEXIST) return error_of_name(errno);
      }
      if (temporary_.empty()) return error("write", EEXIST);
    }
    if (::rename(temporary_.c_str(), target_.c_str()) != 0) return error_of_name(errno);
    forget(temporary_);
    temporary_.clear();
  }
  const int fd = fd_;
  fd_ = -1;
  return ::close(fd) == 0 ? success() : Status(error("write", errno));
}

OutputProbe::OutputProbe() : file_(std::make_unique<AtomicFile>()) {}
OutputProbe::~OutputProbe() = default;

Status OutputProbe::open(const std::string& path) {
  Status opened = file_->open(path);
  if (!file_->direct_) file_->abandon();
  return opened;
}

void TextWriter::pass_on(TextBuffer& block) {
  if (memory_)
    memory_->append(block.bytes_);
  else if (status_.ok())
    status_ = file_->write(block.bytes_);
  block.bytes_.clear();
}

Status TextWriter::finish() {
  flush();
  return status_;
}

}  // namespace overtet
