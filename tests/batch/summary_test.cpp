// Summaries: counts that add up, tables that any name can stand in.
#include "src/batch/summary.h"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <numeric>
#include <random>

#include "tests/support/files.h"

namespace overtet {
namespace {

JournalEntry entry(const std::string& name, const std::string& status, double seconds,
                   const std::string& ended) {
  JournalEntry e;
  e.name = name;
  e.status = status;
  e.exit_code = status == "exact" ? 0 : 5;
  e.seconds = e.cpu_seconds = seconds;
  e.ended = ended;
  if (status == "exact") e.dihedral_min = 10 + seconds, e.tets = 100;
  return e;
}

TEST(Summary, TheLastLineOfAModelCounts) {
  const test::TemporaryFolder folder;
  test::write_text(folder.file("journal-1-of-2.jsonl"),
                   to_line(entry("a", "limit", 9, "2026-11-30T10:00:00Z")) +
                       to_line(entry("a", "exact", 1, "2026-11-30T11:00:00Z")));
  test::write_text(folder.file("journal-2-of-2.jsonl"),
                   to_line(entry("b", "infeasible", 2, "2026-11-30T10:00:00Z")) + "cut o");
  const auto made = summarise({folder.path()});
  ASSERT_TRUE(made.ok());
  ASSERT_EQ(made.value().models.size(), 2u);
  EXPECT_EQ(made.value().models[0].status, "exact");
  EXPECT_EQ(made.value().notes.size(), 1u);
  const auto json = nlohmann::json::parse(to_json(made.value()));
  EXPECT_EQ(json["totals"]["statuses"], (nlohmann::json{{"exact", 1}, {"infeasible", 1}}));
  EXPECT_EQ(json["totals"]["seconds"]["sum"], 3.);
  EXPECT_NE(to_text(made.value()).find("1 exact, 1 infeasible"), std::string::npos);
  EXPECT_FALSE(summarise({folder.file("none")}).ok());
  const test::TemporaryFolder empty;
  EXPECT_EQ(summarise({empty.path()}).error().code, ErrorCode::usage);
}

TEST(Summary, AnyNameCanStandInATable) {
  BatchSummary s;
  for (const char* name :
       {"plain", "a,b", "quo\"te", "line\nend", "=1+1", "<script>alert(1)</script>", "\x01", "caf\xe9"})
    s.models.push_back(entry(name, "exact", 1, ""));
  const std::string csv = to_csv(s), html = to_html(s);
  EXPECT_NE(csv.find("\"a,b\",exact"), std::string::npos);
  EXPECT_NE(csv.find("\"quo\"\"te\""), std::string::npos);
  EXPECT_NE(csv.find("\"line\nend\""), std::string::npos);
  EXPECT_NE(csv.find("'=1+1"), std::string::npos);
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  EXPECT_NE(html.find("&lt;script&gt;alert"), std::string::npos);
  EXPECT_EQ(html.find('\x01'), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(to_json(s))["models"].size(), 8u);
}

TEST(Summary, EmptyOnesArePossible) {
  const BatchSummary none;
  EXPECT_NE(to_text(none).find("models    0"), std::string::npos);
  EXPECT_EQ(nlohmann::json::parse(to_json(none))["totals"]["models"], 0);
  EXPECT_NE(to_html(none).find("</html>"), std::string::npos);
}

TEST(Summary, QuantilesAreThoseOfTheSortedList) {
  const unsigned seed = 7;
  std::mt19937 random(seed);
  for (int round = 0; round < 100; ++round) {
    std::vector<double> x(1 + random() % 50);
    for (double& v : x) v = random() % 20;
    std::vector<double> sorted = x;
    std::sort(sorted.begin(), sorted.end());
    EXPECT_EQ(quantile(x, 0), sorted.front()) << "seed " << seed;
    EXPECT_EQ(quantile(x, 1), sorted.back());
    const double median = quantile(x, .5);
    EXPECT_GE(2 * std::count_if(x.begin(), x.end(), [&](double v) { return v <= median; }), std::ssize(x));
    EXPECT_GE(2 * std::count_if(x.begin(), x.end(), [&](double v) { return v >= median; }), std::ssize(x));
  }
  EXPECT_EQ(quantile({}, .5), 0);
}

TEST(Summary, HistogramsCountEveryValueOnce) {
  const unsigned seed = 8;
  std::mt19937 random(seed);
  for (int round = 0; round < 200; ++round) {
    SCOPED_TRACE("seed " + std::to_string(seed) + ", round " + std::to_string(round));
    const bool logarithmic = round % 2 == 0;
    std::vector<double> x(1 + random() % 60);
    const double scale = std::pow(10, static_cast<double>(random() % 9) - 4);
    for (double& v : x)
      v = scale * (1e-3 + static_cast<double>(random() % 1000)) * (random() % 5 == 0 ? 100 : 1);
    const Histogram h = histogram(x, logarithmic);
    ASSERT_EQ(h.limits.size(), h.counts.size() + 1);
    EXPECT_EQ(std::accumulate(h.counts.begin(), h.counts.end(), 0), static_cast<int>(x.size()));
    EXPECT_LE(h.counts.size(), 40u);
    for (const double v : x) {
      EXPECT_GE(v, h.limits.front() * (1 - 1e-9) - 1e-12);
      EXPECT_LE(v, h.limits.back() * (1 + 1e-9));
    }
    EXPECT_TRUE(std::is_sorted(h.limits.begin(), h.limits.end()));
  }
  EXPECT_TRUE(histogram({}, true).counts.empty());
  EXPECT_EQ(histogram({3, 3, 3}, false).counts.size(), 1u);
}

}  // namespace
}  // namespace overtet
