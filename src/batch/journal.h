// The journal of a batch: a line of JSON for each finished model. A line is there when all of it, and what it
// speaks of, is on the disk; so whatever ends a batch, the next one knows what is done.
#pragma once

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "overtet/result.h"

namespace overtet {

// What became of a model. More than 12 members: a plain record of a line.
struct JournalEntry {
  // What identifies the work: the same again need not be done again. Limits are not part of it (repeats()).
  std::string name;    // of its results, relative to the folder of the batch
  std::string sha256;  // of the surface's file
  std::vector<std::string> options;
  std::string version;  // of Overtet

  std::string input;  // the path of the surface, as the batch opened it
  std::int64_t input_bytes = 0;
  std::string status;  // of the report ("exact", "infeasible", ...); "crashed": a signal ended every try
  std::optional<int> exit_code;
  std::string message;
  std::vector<std::pair<std::string, std::int64_t>> outputs;  // files in the batch's folder, and their bytes
  double seconds = 0, cpu_seconds = 0;
  std::int64_t peak_rss_bytes = 0;
  int threads = 0, tries = 1;
  double time_limit = 0;                              // seconds; 0: none
  std::int64_t memory_limit_bytes = 0;                // 0: none
  std::optional<std::int64_t> vertices, faces, tets;  // of the surface, of the mesh
  std::optional<double> dihedral_min, dihedral_p01;   // degrees
  std::string result_hash;
  std::string host, shard;  // shard: "2/20", empty for the whole
  std::string ended;        // UTC, as 2026-11-30T18:00:00Z
};

// One line with its line end. What is not UTF-8 in names and messages is replaced by U+FFFD.
std::string to_line(const JournalEntry& entry);
// None where the line is no entry: cut off, or something else.
std::optional<JournalEntry> entry_of(const std::string& line);

struct JournalContents {
  std::vector<JournalEntry> entries;      // in the order of the file
  std::vector<std::int64_t> wrong_lines;  // numbers from 1; a last line that was cut off is one
};

// Errors: io.
Result<JournalContents> read_journal(const std::string& path);
JournalContents journal_of(const std::string& text);

// Adds the last line of each name in a journal to those of others. Between journals the time decides; inside
// one the order does, whatever the clock said.
void add_last(JournalContents contents, std::map<std::string, JournalEntry>& last);

// "journal.jsonl", or "journal-2-of-20.jsonl" of a shard.
std::string journal_name(int shard, int shards);
// The journals in a folder, sorted by name. Errors: io.
Result<std::vector<std::string>> journals_in(const std::string& folder);

// Whether a model need not be done again: it has an answer that the same options would give again, and its
// outputs are there, as long as they were. A limit that was reached is such an answer if the limits now are
// no higher; what crashed or failed is none. files: what its outputs are called now, and the path of each.
bool settled(const JournalEntry& entry, const std::map<std::string, std::string>& files, double time_limit,
             std::int64_t memory_limit_bytes);

// The journal that a batch writes. While it is open no other batch can open it (flock), nor one of the whole
// list beside one of a shard.
class Journal {
 public:
  Journal() = default;
  ~Journal();
  Journal(const Journal&) = delete;
  Journal& operator=(const Journal&) = delete;

  // Creates the file where there is none; ends a last line that was cut off. Errors: io, with the process
  // that holds it, if that is known.
  Status open(const std::string& folder, int shard, int shards);
  // When it returns, the line is on the disk, or nothing of it is in the file. Errors: io.
  Status append(const JournalEntry& entry);
  const std::string& path() const { return path_; }

 private:
  Status lock(const std::string& path, int how, int& fd);
  std::string path_;
  int fd_ = -1, whole_fd_ = -1;
};

}  // namespace overtet
