// What a worker has left behind, read into a line of the journal.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "overtet/io.h"
#include "src/batch/journal.h"
#include "src/batch/worker.h"

namespace overtet {

struct Outcome {
  bool memory_limit = false;  // it ended at its memory limit: with more it may succeed
  bool interrupted = false;   // somebody asked it to end
  bool disk_full = false;     // or read-only: the next one will not fare better
};

// Reads the report and what was printed; fills in what the entry says of the end: status, message, figures.
Outcome outcome_of(const WorkerEnd& how, const std::string& report, JournalEntry& entry);

// The ending that files of this format have.
const char* ending_of(TetFormat format);

// As a journal has it: what is not UTF-8 is replaced by U+FFFD.
std::string as_utf8(const std::string& text);
std::vector<std::string> as_utf8(const std::vector<std::string>& words);

}  // namespace overtet
