// Many models, each in a process of its own: nothing that one does costs another its result.
//
// run_batch() meshes the surfaces of a folder or manifest (model_list.h) into a folder, several at a time,
// biggest first, and writes a line a finished model to a journal there (journal.h). Guarantees:
//
//   - A model that crashes, hangs, or needs too much time or memory ends alone. Where that may have been for
//     want of memory, or another process killed it, it is tried once more, after all others and by itself.
//   - What the journal has is on the disk. Whatever ends the batch or a worker, with `resume` the next one
//   does
//     the rest and no more: what has an answer for the same contents, options and version is skipped.
//   - Results appear whole or not at all, under names that follow from the list (Model::name): NAME.mesh, or
//     what the format has, and NAME.json, the report.
//   - Answers do not depend on how many models run at a time, nor on threads or shards. (A limit that is
//   reached
//     may.)
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "overtet/io.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/batch/journal.h"
#include "src/batch/model_list.h"

namespace overtet {

// What a worker is to do.
struct BatchJob {
  const Model& model;
  std::string output, report;  // paths
  int threads = 1;
  double time_limit = 0;                // seconds; 0: none
  std::int64_t memory_limit_bytes = 0;  // 0: none
};

struct BatchCounts {
  std::int64_t models = 0, done = 0, skipped = 0;  // skipped ones are done, too
  std::int64_t bytes = 0, bytes_done = 0, bytes_skipped = 0;
  double seconds = 0;
  std::map<std::string, std::int64_t> statuses;  // of what is done, skipped ones included
};

// "31 exact, 2 infeasible, 1 limit"
std::string listed(const std::map<std::string, std::int64_t>& statuses);

// More than 12 members: what the user chose, option by option.
struct BatchOptions {
  std::string models, folder;  // where they are listed, where the results go
  int jobs = 0, threads = 0;   // models at a time, threads for each; 0: so that all cores are busy
  int cores = 1;
  double time_limit = 0;                // seconds for each model; 0: none
  std::int64_t memory_limit_bytes = 0;  // for each model; 0: its share of usable_memory_bytes
  std::int64_t usable_memory_bytes = 0;
  bool resume = false;
  int shard = 1, shards = 1;
  TetFormat format = TetFormat::medit;
  std::vector<std::string> options;  // of all models; part of what identifies a result
  // The command line of a worker, its program first.
  std::function<std::vector<std::string>(const BatchJob&)> words;
  // Called for each model that has ended, by the thread that called run_batch(). May be empty.
  std::function<void(const JournalEntry&, const BatchCounts&)> finished;

  Status validate() const;  // Errors: usage.
};

// Every model has a line in the journal when this succeeds. Errors: usage (options; the folder has a journal
// and `resume` is not set; the workers refuse their options), bad_input (manifest), io (list, journal,
// results: what is finished is kept), interrupted.
Result<BatchCounts> run_batch(const BatchOptions& options, const RunContext& context);

// How many models at a time, and how many threads for one that begins now.
struct BatchPlan {
  int jobs = 1;       // at most
  int threads = 0;    // for each; 0: by threads_for()
  int least = 1;      // threads, where they are not given
  bool full = false;  // the cores are the limit, not the jobs
  explicit BatchPlan(const BatchOptions& options);

  // A model gets the part of the cores that its bytes are of those left to do (its own included): no fewer
  // than `least`, and no more than are free.
  int threads_for(std::int64_t bytes, std::int64_t bytes_left, int cores, int free_cores) const;
};

}  // namespace overtet
