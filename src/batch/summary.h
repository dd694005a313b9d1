// What batches have done, from their journals: of all shards, and of all attempts, the last line of each
// model.
#pragma once

#include <string>
#include <vector>

#include "overtet/result.h"
#include "src/batch/journal.h"

namespace overtet {

struct BatchSummary {
  std::vector<JournalEntry> models;  // by name
  std::vector<std::string> notes;    // lines that could not be read: one sentence each
};

// From journals, or folders with journals. Errors: io; usage (a folder without a journal).
Result<BatchSummary> summarise(const std::vector<std::string>& journals_or_folders);

std::string to_text(const BatchSummary& summary);  // some lines: counts, spread of times, what has no mesh
std::string to_csv(const BatchSummary& summary);   // RFC 4180: a row a model, with a heading
std::string to_json(const BatchSummary& summary);  // {"totals": {...}, "models": [...]}
// One page that needs nothing else: counts, histograms, a table that can be sorted.
std::string to_html(const BatchSummary& summary);

bool has_mesh(const JournalEntry& entry);
double peak_mib(const JournalEntry& entry);

// The smallest value that a share of all values (0 to 1) does not exceed; 0 of none.
double quantile(std::vector<double> values, double share);

// Bars of a histogram of positive values on a logarithmic axis, or of any on an even one.
struct Histogram {
  std::vector<double> limits;  // of the bars: one more than there are bars
  std::vector<int> counts;
};
Histogram histogram(const std::vector<double>& values, bool logarithmic);

}  // namespace overtet
