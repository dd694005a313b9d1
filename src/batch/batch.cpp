#include "src/batch/batch.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <ctime>
#include <deque>
#include <filesystem>
#include <list>
#include <optional>
#include <set>
#include <thread>
#include <utility>

#include "overtet/version.h"
#include "src/batch/content_hash.h"
#include "src/batch/leftovers.h"
#include "src/batch/outcome.h"
#include "src/batch/tuning.h"
#include "src/batch/worker.h"

namespace overtet {

namespace {

namespace fs = std::filesystem;
using Clock = RunContext::Clock;

struct Task {
  Model model;
  FileState state;
  int tries = 0;
};

struct Running {
  Task task;
  Worker worker;
  int threads = 1;
  std::int64_t memory_limit_bytes = 0;
};

std::string host_name() {
  char name[256] = "";
  return ::gethostname(name, sizeof name - 1) == 0 ? name : "";
}

std::string now_utc() {
  const std::time_t now = std::time(nullptr);
  std::tm parts{};
  ::gmtime_r(&now, &parts);
  char text[32];
  return std::strftime(text, sizeof text, "%Y-%m-%dT%H:%M:%SZ", &parts) > 0 ? text : "";
}

// More than 12 members: options, what is waiting, running, done and to be written, and what has been done
// before.
class Batch {
 public:
  Batch(const BatchOptions& options, const RunContext& context)
      : options_(options), context_(context), plan_(options), host_(host_name()) {
    if (options.shards > 1) shard_ = std::to_string(options.shard) + "/" + std::to_string(options.shards);
  }
  Result<BatchCounts> run();

 private:
  Status open();
  Status read_past();
  Status work();
  void start_some();
  bool skip(const Task& task, const std::vector<std::string>& options);
  std::optional<JournalEntry> start(Task task);
  void end(Running& running, const WorkerEnd& how);
  bool try_again(const Running& running, const WorkerEnd& how, const Outcome& outcome);
  void finish(JournalEntry entry, std::int64_t bytes);
  void remove_stale(const JournalEntry& entry);
  JournalEntry entry_of(const Task& task) const;
  void write_pending();
  void interrupt_all();
  void show();

  int threads_running() const;
  std::string output_of(const Model& m) const {
    return options_.folder + "/" + m.name + ending_of(options_.format);
  }
  std::string report_of(const Model& m) const { return options_.folder + "/" + m.name + ".json"; }
  std::string in_folder(const std::string& file) const {
    return fs::path(file).lexically_relative(options_.folder);
  }
  std::int64_t all_memory() const {
    return static_cast<std::int64_t>(kSharedMemory * static_cast<double>(options_.usable_memory_bytes));
  }
  std::int64_t memory_for_one() const {
    if (options_.memory_limit_bytes > 0) return options_.memory_limit_bytes;
    return alone_ ? all_memory() : all_memory() / plan_.jobs;
  }
  // What a model may use in the end, where it has to.
  std::int64_t final_memory() const {
    return options_.memory_limit_bytes > 0 ? options_.memory_limit_bytes : all_memory();
  }

  const BatchOptions& options_;
  const RunContext& context_;
  BatchPlan plan_;
  std::string host_, shard_;
  Journal journal_;
  std::map<std::string, JournalEntry> past_;  // the last entry of each name
  std::deque<Task> waiting_, again_;
  std::int64_t bytes_waiting_ = 0;
  std::list<Running> running_;
  std::vector<JournalEntry> pending_;  // that the journal has not taken
  BatchCounts counts_;
  bool alone_ = false;         // those that are tried again run one at a time
  std::optional<Error> stop_;  // nothing more is started
  Clock::time_point start_ = Clock::now();
};

Status Batch::open() {
  std::error_code code;
  fs::create_directories(options_.folder, code);
  if (code && !fs::is_directory(options_.folder))
    return Error{ErrorCode::io, "Cannot make the folder " + options_.folder + ": " + code.message() + "."};
  if (fs::equivalent(options_.folder, options_.models, code))
    return Error{ErrorCode::usage,
                 "The results need a folder of their own; choose another one than the models'."};
  Result<std::vector<Model>> listed = models_of(options_.models, options_.folder);
  if (!listed) return listed.error();
  if (listed.value().empty())
    return Error{ErrorCode::usage, options_.models + " names no surface (.obj, .off, .ply, .stl, ...)."};
  std::vector<Model> models = shard_of(std::move(listed).value(), options_.shard, options_.shards);
  if (Status s = journal_.open(options_.folder, options_.shard, options_.shards); !s) return s;
  if (Status s = read_past(); !s) return s;

  std::set<std::string> files;
  for (const Model& m : models) {
    for (const std::string& file : tet_files(output_of(m), options_.format)) files.insert(file);
    files.insert(report_of(m));
    counts_.bytes += m.bytes;
  }
  bytes_waiting_ = counts_.bytes;
  remove_leftovers(options_.folder, files);
  counts_.models = std::ssize(models);
  for (Model& m : models) waiting_.push_back({std::move(m), {}, 0});
  return success();
}

Status Batch::read_past() {
  const Result<std::vector<std::string>> journals = journals_in(options_.folder);
  if (!journals) return journals.error();
  for (const std::string& path : journals.value()) {
    Result<JournalContents> read = read_journal(path);
    if (!read) return read.error();
    if (path == journal_.path() && !read.value().entries.empty() && !options_.resume)
      return Error{ErrorCode::usage, options_.folder + " has the journal of a batch, of " +
                                         std::to_string(read.value().entries.size()) +
                                         " models; resume that batch, or choose another folder."};
    for (const std::int64_t line : read.value().wrong_lines)
      context_.note(LogLevel::warning, path + ": line " + std::to_string(line) +
                                           " is no entry (cut off when a batch was killed?); it is skipped.");
    add_last(std::move(read).value(), past_);
  }
  return success();
}

JournalEntry Batch::entry_of(const Task& task) const {
  JournalEntry e;
  e.name = task.model.name;
  e.sha256 = task.state.sha256;
  e.options = options_.options;
  e.options.insert(e.options.end(), task.model.options.begin(), task.model.options.end());
  e.version = version();
  e.input = task.model.path;
  e.input_bytes = task.state.bytes;
  e.tries = std::max(task.tries, 1);
  e.time_limit = options_.time_limit;
  e.memory_limit_bytes = final_memory();
  e.host = host_;
  e.shard = shard_;
  return e;
}

// Whether an earlier batch has done this.
bool Batch::skip(const Task& task, const std::vector<std::string>& options) {
  if (!options_.resume) return false;
  const auto found = past_.find(as_utf8(task.model.name));
  if (found == past_.end()) return false;
  const JournalEntry& e = found->second;
  std::map<std::string, std::string> files;
  for (const std::string& file : tet_files(output_of(task.model), options_.format))
    files[as_utf8(in_folder(file))] = file;
  return e.sha256 == task.state.sha256 && e.options == as_utf8(options) && e.version == version() &&
         settled(e, files, options_.time_limit, final_memory());
}

// Starts a worker, or says what becomes of the model without one.
std::optional<JournalEntry> Batch::start(Task task) {
  const auto failed = [&](const std::string& message) {
    JournalEntry e = entry_of(task);
    e.status = "failed";
    e.message = message;
    return e;
  };
  const Result<FileState> state = state_of(task.model.path);
  if (!state) return failed(state.error().message);
  task.state = state.value();
  if (skip(task, entry_of(task).options)) {
    JournalEntry e = past_.at(as_utf8(task.model.name));
    ++counts_.skipped;
    counts_.bytes_skipped += task.model.bytes;
    return e;
  }
  const std::string output = output_of(task.model), report = report_of(task.model);
  std::error_code code;
  fs::create_directories(fs::path(output).parent_path(), code);
  if (code) return failed("Cannot make the folder of " + output + ": " + code.message() + ".");
  fs::remove(report, code);  // whatever is there later is of this run

  Running r;
  r.memory_limit_bytes = memory_for_one();
  r.threads = alone_ ? options_.cores
                     : plan_.threads_for(task.model.bytes, bytes_waiting_ + task.model.bytes, options_.cores,
                                         options_.cores - threads_running());
  ++task.tries;
  auto latest = Clock::time_point::max();
  if (options_.time_limit > 0 && options_.time_limit < 1e9)
    latest = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(
                                kLateFactor * options_.time_limit + kLateSeconds));
  const BatchJob job{task.model, output, report, r.threads, options_.time_limit, r.memory_limit_bytes};
  if (Status s = r.worker.start(options_.words(job), latest); !s) return failed(s.error().message);
  r.task = std::move(task);
  running_.push_back(std::move(r));
  return std::nullopt;
}

void Batch::start_some() {
  while (!stop_ && !waiting_.empty()) {
    if (std::ssize(running_) >= (alone_ ? 1 : plan_.jobs)) return;
    if (plan_.full && !running_.empty() && threads_running() >= options_.cores) return;
    Task task = std::move(waiting_.front());
    waiting_.pop_front();
    bytes_waiting_ -= task.model.bytes;
    const std::int64_t bytes = task.model.bytes;
    const std::int64_t skipped = counts_.skipped;
    if (std::optional<JournalEntry> entry = start(std::move(task))) {
      if (counts_.skipped == skipped) {
        entry->ended = now_utc();
        finish(*std::move(entry), bytes);
      } else {
        ++counts_.done;
        ++counts_.statuses[entry->status];
      }
    }
    if (context_.stop()) return;
  }
}

bool Batch::try_again(const Running& running, const WorkerEnd& how, const Outcome& outcome) {
  const Task& task = running.task;
  if (how.killed_late || task.tries >= kMostTries) return false;
  const bool changed = !unchanged_since(task.state, task.model.path);
  // Whoever sent the signal, it may have been for want of memory.
  const bool killed = !how.exit_code || outcome.interrupted;
  const bool too_little = outcome.memory_limit && running.memory_limit_bytes < final_memory();
  if (!changed && !killed && !too_little) return false;
  (changed ? waiting_ : again_).push_back(task);
  if (changed) bytes_waiting_ += task.model.bytes;
  return true;
}

void Batch::end(Running& running, const WorkerEnd& how) {
  const Task& task = running.task;
  JournalEntry e = entry_of(task);
  const std::string output = output_of(task.model);
  const Outcome outcome = outcome_of(how, report_of(task.model), e);
  if (context_.stop() && (!how.exit_code || outcome.interrupted)) return;  // it was the interrupt
  if (how.exit_code == static_cast<int>(ErrorCode::usage) && task.model.options.empty()) {
    stop_ = Error{ErrorCode::usage, e.message};
    return;
  }
  if (try_again(running, how, outcome)) return;
  if (how.exit_code == 0 && !unchanged_since(task.state, task.model.path)) {
    e.status = "failed";
    e.message = "The file was written to each time it was read; the mesh is of one of its states.";
  }
  e.threads = running.threads;
  e.ended = now_utc();
  if (how.exit_code == 0)
    for (const std::string& file : tet_files(output, options_.format)) {
      std::error_code none;
      const auto bytes = fs::file_size(file, none);
      if (!none) e.outputs.emplace_back(in_folder(file), static_cast<std::int64_t>(bytes));
    }
  if (outcome.disk_full) stop_ = Error{ErrorCode::io, e.message};
  finish(std::move(e), task.model.bytes);
}

// Results that an earlier batch has made of this name, with other contents or options, are not this one's.
void Batch::remove_stale(const JournalEntry& entry) {
  const auto past = past_.find(as_utf8(entry.name));
  if (past == past_.end()) return;
  for (const auto& [file, bytes] : past->second.outputs) {
    const bool made = std::any_of(entry.outputs.begin(), entry.outputs.end(),
                                  [&, &name = file](const auto& o) { return o.first == name; });
    std::error_code none;
    if (!made) fs::remove(fs::path(options_.folder) / file, none);
  }
}

void Batch::finish(JournalEntry entry, std::int64_t bytes) {
  ++counts_.done;
  ++counts_.statuses[entry.status];
  counts_.bytes_done += bytes;
  counts_.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  remove_stale(entry);
  pending_.push_back(entry);
  write_pending();
  if (options_.finished) options_.finished(entry, counts_);
}

void Batch::write_pending() {
  while (!pending_.empty()) {
    if (Status s = journal_.append(pending_.front()); !s) {
      if (!stop_) stop_ = s.error();
      return;
    }
    pending_.erase(pending_.begin());
  }
}

int Batch::threads_running() const {
  int sum = 0;
  for (const Running& r : running_) sum += r.threads;
  return sum;
}

void Batch::interrupt_all() {
  for (Running& r : running_) r.worker.interrupt();
  const auto latest = Clock::now() + kWorkerGrace;
  while (!running_.empty() && Clock::now() < latest) {
    std::vector<Worker*> workers;
    for (Running& r : running_) workers.push_back(&r.worker);
    wait_for_any(workers, kBatchPeriod);
    for (auto r = running_.begin(); r != running_.end();) {
      const std::optional<WorkerEnd> how = r->worker.ended();
      if (how) end(*r, *how);  // it may have been quicker than the interrupt
      r = how ? running_.erase(r) : std::next(r);
    }
  }
  running_.clear();
}

void Batch::show() {
  const BatchCounts& c = counts_;
  const double seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  std::string text = std::to_string(c.done) + " of " + std::to_string(c.models) + " models";
  if (!c.statuses.empty()) text += " (" + listed(c.statuses) + ")";
  if (const auto worked = c.done - c.skipped; worked > 0 && seconds > 0) {
    char rate[80];
    std::snprintf(rate, sizeof rate, ", %.1f a minute", 60 * static_cast<double>(worked) / seconds);
    text += rate;
    if (c.bytes_done > 0) {
      const double left = seconds * static_cast<double>(c.bytes - c.bytes_skipped - c.bytes_done) /
                          static_cast<double>(c.bytes_done);
      const auto whole = static_cast<long long>(std::max(0.0, left));
      std::snprintf(rate, sizeof rate, ", %lld:%02lld:%02lld left", whole / 3600, whole / 60 % 60,
                    whole % 60);
      text += rate;
    }
  }
  context_.report("batch", c.models > 0 ? static_cast<double>(c.done) / static_cast<double>(c.models) : 1,
                  text);
}

Status Batch::work() {
  for (;;) {
    if (const std::optional<Error> stop = context_.stop()) {
      interrupt_all();
      return *stop;
    }
    start_some();
    show();
    if (running_.empty()) {
      if (stop_) return *stop_;
      if (!waiting_.empty()) continue;
      if (again_.empty()) return success();
      std::swap(waiting_, again_);
      for (const Task& t : waiting_) bytes_waiting_ += t.model.bytes;
      alone_ = true;
      continue;
    }
    std::vector<Worker*> workers;
    for (Running& r : running_) workers.push_back(&r.worker);
    wait_for_any(workers, kBatchPeriod);
    // The free places are taken before the journal is written, which waits for the disk; but not where what
    // has happened may end the batch.
    bool go_on = !context_.stop();
    std::vector<std::pair<Running, WorkerEnd>> ended;
    for (auto r = running_.begin(); r != running_.end();) {
      std::optional<WorkerEnd> how = r->worker.ended();
      if (!how) {
        ++r;
        continue;
      }
      go_on = go_on && how->exit_code != static_cast<int>(ErrorCode::usage) &&
              how->exit_code != static_cast<int>(ErrorCode::io);
      ended.emplace_back(std::move(*r), *std::move(how));
      r = running_.erase(r);
    }
    if (!ended.empty() && go_on) start_some();
    for (auto& [running, how] : ended) end(running, how);
  }
}

Result<BatchCounts> Batch::run() {
  if (Status s = open(); !s) return s.error();
  Status done = work();
  write_pending();
  counts_.seconds = std::chrono::duration<double>(Clock::now() - start_).count();
  if (!done) return done.error();
  if (!pending_.empty()) return *stop_;
  return counts_;
}

}  // namespace

Status BatchOptions::validate() const {
  const auto wrong = [](const char* what) { return Error{ErrorCode::usage, what}; };
  if (jobs < 0 || threads < 0 || cores < 1)
    return wrong("Jobs, threads and cores of a batch are positive numbers.");
  if (!(time_limit >= 0) || memory_limit_bytes < 0) return wrong("The limits of a batch are not negative.");
  if (shards < 1 || shard < 1 || shard > shards)
    return wrong("A shard has a number from 1 to the number of shards.");
  if (!words) return wrong("A batch needs to know how to start a worker.");
  return success();
}

BatchPlan::BatchPlan(const BatchOptions& o) : jobs(o.jobs), threads(o.threads), full(o.jobs == 0) {
  if (jobs == 0) jobs = std::max(1, o.cores / std::max(1, threads));
  least = std::max(1, o.cores / jobs);
}

int BatchPlan::threads_for(std::int64_t bytes, std::int64_t bytes_left, int cores, int free_cores) const {
  if (threads > 0) return threads;
  const double part = bytes_left > 0 ? static_cast<double>(bytes) / static_cast<double>(bytes_left) : 1;
  const int wanted = std::max(least, static_cast<int>(std::floor(part * cores + 1e-9)));
  return std::clamp(wanted, 1, std::max(1, free_cores));
}

Result<BatchCounts> run_batch(const BatchOptions& options, const RunContext& context) {
  if (Status s = options.validate(); !s) return s.error();
  return Batch(options, context).run();
}

}  // namespace overtet
