#include <signal.h>

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <filesystem>

#include "overtet/io.h"
#include "src/batch/batch.h"
#include "src/batch/summary.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"

namespace overtet {

namespace {

// An option of `mesh` that a batch sets for each model.
Status check_mesh_options(const std::vector<std::string>& words) {
  for (const std::string& word : words) {
    const std::string name = word.substr(0, word.find('='));
    const auto use = [&](const char* instead) {
      return Error{ErrorCode::usage, name + " cannot stand after --; " + instead};
    };
    if (name == "--output" || (name.starts_with("-o") && !name.starts_with("--")) || name == "--report")
      return use("each model's results are named by batch -o.");
    if (name == "--threads") return use("use --jobs and --threads-per-job of batch.");
    if (name == "--time-limit" || name == "--memory-limit" || name == "--format")
      return use("give it to batch, before the --.");
  }
  return success();
}

Status read_shard(const std::string& text, BatchOptions& options) {
  if (text.empty()) return success();
  const char* const end = text.data() + text.size();
  const auto first = std::from_chars(text.data(), end, options.shard);
  const bool slash = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
  const auto second = slash ? std::from_chars(first.ptr + 1, end, options.shards) : first;
  if (slash && second.ec == std::errc() && second.ptr == end && options.shard >= 1 &&
      options.shard <= options.shards)
    return success();
  return Error{ErrorCode::usage, "--shard " + text + " is not I/N with I from 1 to N, as 2/20."};
}

// A file whose name begins with - would be taken for an option.
std::string as_argument(const std::string& path) { return path.starts_with("-") ? "./" + path : path; }

std::vector<std::string> words_of(const BatchJob& job, const BatchCommand& command,
                                  const CommonOptions& common) {
  // The very program that runs, even if another one has its name by now.
  std::vector<std::string> words = {"/proc/self/exe",
                                    "mesh",
                                    as_argument(job.model.path),
                                    "--output=" + job.output,
                                    "--report=" + job.report,
                                    "--threads=" + std::to_string(job.threads),
                                    "--log-level=" + common.log_level};
  if (!command.format.empty()) words.push_back("--format=" + command.format);
  char limit[64];
  if (job.time_limit > 0) {
    std::snprintf(limit, sizeof limit, "--time-limit=%.17g", job.time_limit);
    words.emplace_back(limit);
  }
  if (job.memory_limit_bytes > 0)
    words.push_back("--memory-limit=" +
                    std::to_string(std::max<std::int64_t>(1, job.memory_limit_bytes >> 20)));
  const std::string stem = job.report.substr(0, job.report.size() - std::string(".json").size());
  const std::string place = "{name}";
  for (const std::vector<std::string>* list : {&command.mesh_options, &job.model.options})
    for (std::string word : *list) {
      for (std::size_t at = word.find(place); at != std::string::npos;
           at = word.find(place, at + stem.size()))
        word.replace(at, place.size(), stem);
      words.push_back(std::move(word));
    }
  return words;
}

std::string clock_time(double seconds) {
  char text[64];
  if (seconds < 600)
    std::snprintf(text, sizeof text, "%.1f s", seconds);
  else
    std::snprintf(text, sizeof text, "%.0f h %02.0f min", std::floor(seconds / 3600),
                  std::floor(seconds / 60) - 60 * std::floor(seconds / 3600));
  return text;
}

// A line for a model: at once, so that a log shows how far the batch is.
void tell(const JournalEntry& e, const BatchCounts& counts, Terminal& terminal) {
  const bool meshed = has_mesh(e);
  if (terminal.has_bar() && meshed) return;
  std::string text = "[" + std::to_string(counts.done) + "/" + std::to_string(counts.models) + "] " + e.name +
                     ": " + e.status;
  if (meshed) {
    text += ", " + std::to_string(e.tets.value_or(0)) + " tets";
    char angle[64];
    std::snprintf(angle, sizeof angle, ", smallest angle %.3g degrees", e.dihedral_min.value_or(0));
    text += angle;
  }
  text += ", " + clock_time(e.seconds);
  if (!meshed) text += ": " + e.message;
  terminal.say(text);
}

int summary(const BatchCommand& command, Terminal& terminal) {
  const Result<BatchSummary> made = summarise(command.models);
  if (!made) return fail(terminal, made.error());
  for (const std::string& note : made.value().notes) terminal.log(LogLevel::warning, note);
  using Writer = std::string (*)(const BatchSummary&);
  const std::pair<const std::string*, Writer> files[] = {
      {&command.csv, &to_csv}, {&command.json, &to_json}, {&command.html, &to_html}};
  for (const auto& [path, writer] : files)
    if (!path->empty())
      if (Status s = write_text(*path, writer(made.value())); !s) return fail(terminal, s.error());
  const bool printed =
      std::any_of(std::begin(files), std::end(files), [](const auto& f) { return *f.first == "-"; });
  if (!printed) std::fputs(to_text(made.value()).c_str(), stdout);
  return std::fflush(stdout) == 0 ? 0 : fail(terminal, {ErrorCode::io, "Cannot write standard output."});
}

int exit_code_of(const BatchCounts& counts) {
  if (counts.statuses.contains("crashed")) return static_cast<int>(ErrorCode::internal);
  return counts.statuses.contains("failed") ? static_cast<int>(ErrorCode::io) : 0;
}

Status check(const BatchCommand& c) {
  const auto wrong = [](const char* what) { return Error{ErrorCode::usage, what}; };
  if (c.summary) {
    if (!c.folder.empty() || c.resume || !c.mesh_options.empty() || !c.shard.empty() || !c.report.empty())
      return wrong("--summary meshes nothing; --csv, --json and --html say what it writes.");
    return success();
  }
  if (c.models.size() != 1)
    return wrong("Name one folder or manifest; a manifest can list the surfaces of several folders.");
  if (c.folder.empty()) return wrong("Name the folder of the results: -o FOLDER.");
  if (!c.csv.empty() || !c.json.empty() || !c.html.empty())
    return wrong("--csv, --json and --html are for --summary; --report writes JSON at the end of a batch.");
  return check_mesh_options(c.mesh_options);
}

}  // namespace

int run(const BatchCommand& command, const CommonOptions& common, Terminal& terminal) {
  if (Status s = check(command); !s) return fail(terminal, s.error());
  if (command.summary) return summary(command, terminal);
  BatchOptions options;
  if (Status s = read_shard(command.shard, options); !s) return fail(terminal, s.error());
  const std::string format = command.format.empty() ? "medit" : command.format;
  options.format = tet_format_named(format).value();
  options.models = command.models[0];
  options.folder = command.folder;
  options.jobs = command.jobs;
  options.threads = command.threads_per_job;
  options.cores = usable_cores();
  options.time_limit = common.time_limit;
  options.memory_limit_bytes = static_cast<std::int64_t>(std::min(common.memory_limit, 0x1p40) * 0x1p20);
  options.usable_memory_bytes =
      static_cast<std::int64_t>(std::min<std::size_t>(usable_memory_bytes(), 1ull << 60));
  options.resume = command.resume;
  options.options = command.mesh_options;
  options.options.insert(options.options.begin(), "--format=" + format);
  options.words = [&](const BatchJob& job) { return words_of(job, command, common); };
  options.finished = [&](const JournalEntry& e, const BatchCounts& counts) { tell(e, counts, terminal); };
  if (!command.report.empty()) {
    OutputProbe probe;
    if (Status s = probe.open(command.report); !s) return fail(terminal, s.error());
  }
  // Who started us may have arranged that children vanish unseen.
  ::signal(SIGCHLD, SIG_DFL);
  RunContext context;
  context.cancel = &interrupt_flag();
  context.progress = [&](std::string_view stage, double fraction, std::string_view detail) {
    terminal.progress(stage, fraction, detail);
  };
  context.log = [&](LogLevel level, std::string_view message) { terminal.log(level, message); };
  const Result<BatchCounts> done = run_batch(options, context);
  terminal.clear();
  if (!done) {
    Error error = done.error();
    if (error.code == ErrorCode::interrupted)
      error.message = "Interrupted; what is finished is in " + options.folder + ", and --resume goes on.";
    return fail(terminal, error);
  }
  if (!command.report.empty()) {
    const Result<BatchSummary> made = summarise({options.folder});
    if (!made) return fail(terminal, made.error());
    if (Status s = write_text(command.report, to_json(made.value())); !s) return fail(terminal, s.error());
  }
  const BatchCounts& c = done.value();
  std::string text = options.folder + ": " + std::to_string(c.models) +
                     (c.models == 1 ? " model: " : " models: ") + listed(c.statuses);
  if (c.skipped > 0) text += " (" + std::to_string(c.skipped) + " done before)";
  terminal.say(text + ", " + clock_time(c.seconds) + ".");
  return exit_code_of(c);
}

}  // namespace overtet
