#include "src/batch/journal.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

namespace overtet {

namespace {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

constexpr int kFormat = 1;

template <class T>
Json or_null(const std::optional<T>& x) {
  return x ? Json(*x) : Json();
}

// Takes values of the right kind only.
class Reader {
 public:
  explicit Reader(const Json& json) : json_(json) {}
  bool failed() const { return failed_; }

  void read(const char* key, std::string& to) {
    if (const Json* j = at(key, &Json::is_string)) to = j->get<std::string>();
  }
  void read(const char* key, double& to) {
    if (const Json* j = at(key, &Json::is_number)) to = j->get<double>();
  }
  void read(const char* key, std::int64_t& to) {
    if (const Json* j = at(key, &Json::is_number_integer)) to = j->get<std::int64_t>();
  }
  void read(const char* key, int& to) {
    std::int64_t wide = to;
    read(key, wide);
    if (wide < -(1ll << 31) || wide >= (1ll << 31))
      failed_ = true;
    else
      to = static_cast<int>(wide);
  }
  template <class T>
  void read(const char* key, std::optional<T>& to) {
    const auto found = json_.find(key);
    if (found == json_.end() || found->is_null()) return;
    T value{};
    read(key, value);
    to = value;
  }
  void read(const char* key, std::vector<std::string>& to) {
    const Json* list = at(key, &Json::is_array);
    if (!list) return;
    for (const Json& word : *list) {
      if (!word.is_string())
        failed_ = true;
      else
        to.push_back(word.get<std::string>());
    }
  }
  void read(const char* key, std::vector<std::pair<std::string, std::int64_t>>& to) {
    const Json* list = at(key, &Json::is_array);
    if (!list) return;
    for (const Json& file : *list) {
      std::pair<std::string, std::int64_t> one;
      if (!file.is_object()) {
        failed_ = true;
        return;
      }
      Reader inner(file);
      inner.read("file", one.first);
      inner.read("bytes", one.second);
      failed_ = failed_ || inner.failed();
      to.push_back(std::move(one));
    }
  }

 private:
  const Json* at(const char* key, bool (Json::*right)() const noexcept) {
    const auto found = json_.find(key);
    if (found != json_.end() && ((*found).*right)()) return &*found;
    failed_ = true;
    return nullptr;
  }
  const Json& json_;
  bool failed_ = false;
};

// One field after the other, for both ways.
template <class Entry, class Visit>
void each_field(Entry& e, Visit&& visit) {
  visit("name", e.name);
  visit("sha256", e.sha256);
  visit("options", e.options);
  visit("version", e.version);
  visit("input", e.input);
  visit("input_bytes", e.input_bytes);
  visit("status", e.status);
  visit("exit_code", e.exit_code);
  visit("message", e.message);
  visit("outputs", e.outputs);
  visit("seconds", e.seconds);
  visit("cpu_seconds", e.cpu_seconds);
  visit("peak_rss_bytes", e.peak_rss_bytes);
  visit("threads", e.threads);
  visit("tries", e.tries);
  visit("time_limit", e.time_limit);
  visit("memory_limit_bytes", e.memory_limit_bytes);
  visit("vertices", e.vertices);
  visit("faces", e.faces);
  visit("tets", e.tets);
  visit("dihedral_min", e.dihedral_min);
  visit("dihedral_p01", e.dihedral_p01);
  visit("result_hash", e.result_hash);
  visit("host", e.host);
  visit("shard", e.shard);
  visit("ended", e.ended);
}

template <class T>
Json json_of(const T& x) {
  return Json(x);
}
template <class T>
Json json_of(const std::optional<T>& x) {
  return or_null(x);
}
Json json_of(const std::vector<std::pair<std::string, std::int64_t>>& files) {
  Json j = Json::array();
  for (const auto& [file, bytes] : files) j.push_back({{"file", file}, {"bytes", bytes}});
  return j;
}

Error cannot(const char* what, const std::string& path, int code) {
  return {ErrorCode::io, "Cannot " + std::string(what) + " " + path + ": " + std::strerror(code) + "."};
}

}  // namespace

std::string to_line(const JournalEntry& entry) {
  Json j;
  j["journal"] = kFormat;
  each_field(entry, [&](const char* key, const auto& value) { j[key] = json_of(value); });
  return j.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::optional<JournalEntry> entry_of(const std::string& line) {
  const Json j = Json::parse(line, nullptr, false);
  if (!j.is_object()) return std::nullopt;
  const auto format = j.find("journal");
  if (format == j.end() || !format->is_number_integer() || *format != kFormat) return std::nullopt;
  JournalEntry e;
  Reader reader(j);
  each_field(e, [&](const char* key, auto& value) { reader.read(key, value); });
  if (reader.failed()) return std::nullopt;
  return e;
}

JournalContents journal_of(const std::string& text) {
  JournalContents contents;
  std::int64_t number = 0;
  for (std::size_t at = 0; at < text.size();) {
    ++number;
    const std::size_t end = std::min(text.find('\n', at), text.size());
    const std::string line = text.substr(at, end - at);
    at = end + 1;
    if (line.empty()) continue;
    std::optional<JournalEntry> entry = entry_of(line);
    if (entry)
      contents.entries.push_back(*std::move(entry));
    else
      contents.wrong_lines.push_back(number);
  }
  return contents;
}

Result<JournalContents> read_journal(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  if (!in) return cannot("read", path, errno);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (in.bad()) return cannot("read", path, EIO);
  return journal_of(text);
}

void add_last(JournalContents contents, std::map<std::string, JournalEntry>& last) {
  std::map<std::string, JournalEntry> own;
  for (JournalEntry& e : contents.entries) own[e.name] = std::move(e);
  for (auto& [name, entry] : own) {
    const auto [at, is_new] = last.try_emplace(name);
    if (is_new || entry.ended >= at->second.ended) at->second = std::move(entry);
  }
}

std::string journal_name(int shard, int shards) {
  return shards <= 1 ? "journal.jsonl"
                     : "journal-" + std::to_string(shard) + "-of-" + std::to_string(shards) + ".jsonl";
}

Result<std::vector<std::string>> journals_in(const std::string& folder) {
  std::error_code code;
  std::vector<std::string> found;
  for (fs::directory_iterator at(folder, code), end; !code && at != end; at.increment(code)) {
    const std::string name = at->path().filename();
    if (name.starts_with("journal") && name.ends_with(".jsonl")) found.push_back(at->path());
  }
  if (code) return Error{ErrorCode::io, "Cannot read the folder " + folder + ": " + code.message() + "."};
  std::sort(found.begin(), found.end());
  return found;
}

bool settled(const JournalEntry& entry, const std::map<std::string, std::string>& files, double time_limit,
             std::int64_t memory_limit_bytes) {
  static const char* const final_answers[] = {"exact",    "repaired",   "refined",  "branched",
                                              "unsolved", "infeasible", "bad-input"};
  const auto no_higher = [](auto now, auto then) { return now > 0 && then > 0 && now <= then; };
  if (entry.status == "limit") {
    // Which limit it was does not matter: with neither of them raised it would be reached again.
    const bool same_time = entry.time_limit == time_limit || no_higher(time_limit, entry.time_limit);
    const bool same_memory = entry.memory_limit_bytes == memory_limit_bytes ||
                             no_higher(memory_limit_bytes, entry.memory_limit_bytes);
    if (!same_time || !same_memory) return false;
  } else if (std::none_of(std::begin(final_answers), std::end(final_answers),
                          [&](const char* s) { return entry.status == s; })) {
    return false;
  }
  return std::all_of(entry.outputs.begin(), entry.outputs.end(), [&](const auto& output) {
    std::error_code none;
    const auto file = files.find(output.first);
    return file != files.end() && fs::is_regular_file(file->second, none) &&
           static_cast<std::int64_t>(fs::file_size(file->second, none)) == output.second && !none;
  });
}

Journal::~Journal() {
  for (const int fd : {fd_, whole_fd_})
    if (fd >= 0) ::close(fd);
}

Status Journal::lock(const std::string& path, int how, int& fd) {
  fd = ::open(path.c_str(), O_RDWR | O_CREAT | O_APPEND | O_CLOEXEC, 0666);
  if (fd < 0) return cannot("write", path, errno);
  if (::flock(fd, how | LOCK_NB) == 0) return success();
  if (errno != EWOULDBLOCK) return cannot("lock", path, errno);
  return Error{ErrorCode::io, "Another batch is at work with " + path +
                                  "; wait for its end, or choose another folder for the results."};
}

Status Journal::open(const std::string& folder, int shard, int shards) {
  const std::string whole = folder + "/" + journal_name(1, 1);
  path_ = folder + "/" + journal_name(shard, shards);
  if (shards > 1)
    if (Status s = lock(whole, LOCK_SH, whole_fd_); !s) return s;
  if (Status s = lock(path_, LOCK_EX, fd_); !s) return s;
  const off_t size = ::lseek(fd_, 0, SEEK_END);
  char last = '\n';
  if (size > 0 && ::pread(fd_, &last, 1, size - 1) != 1) return cannot("read", path_, errno);
  if (last != '\n' && ::write(fd_, "\n", 1) != 1) return cannot("write", path_, errno);
  // The name of a new file is on the disk when its folder is. Some file systems cannot say so; theirs is
  // then.
  if (const int at = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC); at >= 0) {
    (void)!::fsync(at);
    ::close(at);
  }
  return success();
}

Status Journal::append(const JournalEntry& entry) {
  const std::string line = to_line(entry);
  const off_t before = ::lseek(fd_, 0, SEEK_END);
  std::size_t done = 0;
  int code = 0;
  while (done < line.size() && code == 0) {
    const ssize_t put = ::write(fd_, line.data() + done, line.size() - done);
    if (put >= 0)
      done += static_cast<std::size_t>(put);
    else if (errno != EINTR)
      code = errno;
  }
  if (code == 0 && ::fsync(fd_) != 0) code = errno;
  // A file that was removed or renamed meanwhile takes lines that nobody will find.
  struct stat open_file, named;
  if (code == 0 && (::fstat(fd_, &open_file) != 0 || ::stat(path_.c_str(), &named) != 0 ||
                    open_file.st_ino != named.st_ino || open_file.st_dev != named.st_dev))
    return Error{ErrorCode::io, "Cannot write " + path_ + ": it was removed or renamed."};
  if (code == 0) return success();
  if (before >= 0 && ::ftruncate(fd_, before) != 0) { /* the next batch skips a line that was cut off */
  }
  return cannot("write", path_, code);
}

}  // namespace overtet
