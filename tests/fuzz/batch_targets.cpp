#include <algorithm>
#include <set>

#include "src/batch/journal.h"
#include "src/batch/model_list.h"
#include "src/batch/summary.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/targets.h"

namespace overtet::fuzz {

void journal(std::string_view bytes) {
  const std::string text(bytes);
  const JournalContents contents = journal_of(text);
  for (const JournalEntry& e : contents.entries) {
    const std::string line = to_line(e);
    require(std::count(line.begin(), line.end(), '\n') == 1 && line.back() == '\n',
            "an entry is not one line", line);
    const std::optional<JournalEntry> again = entry_of(line);
    require(again.has_value(), "an entry is not read back", line);
    require(to_line(*again) == line, "another entry is read back", line);
    static_cast<void>(settled(e, {}, 1, 1));
  }
  // What a batch of these shows.
  std::map<std::string, JournalEntry> last;
  add_last(contents, last);
  BatchSummary summary;
  for (const auto& [name, entry] : last) summary.models.push_back(entry);
  require(to_json(summary).starts_with("{"), "a summary is no JSON");
  require(to_html(summary).starts_with("<!"), "a summary is no page");
  require(!to_csv(summary).empty() && !to_text(summary).empty(), "a summary is empty");
}

void manifest(std::string_view bytes) {
  const Result<std::vector<Model>> models =
      models_of_manifest(std::string(bytes), "/no/such/folder", "list.txt");
  if (!models) return check_error(models.error());
  std::set<std::string> names;
  for (const Model& m : models.value()) {
    require(!m.name.empty() && m.name[0] != '/', "a name is none, or leads elsewhere", m.name);
    require(("/" + m.name + "/").find("/../") == std::string::npos, "a name leads elsewhere", m.name);
    require(names.insert(m.name).second, "two models have one name", m.name);
  }
  // Every model belongs to one shard.
  std::size_t parts = 0;
  for (int i = 1; i <= 3; ++i) parts += shard_of(models.value(), i, 3).size();
  require(parts == models.value().size(), "a model belongs to no shard, or to two");
}

}  // namespace overtet::fuzz
