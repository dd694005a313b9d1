// Journals: what is written is read, whatever happened to the file.
#include "src/batch/journal.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>

#include "src/batch/content_hash.h"
#include "src/batch/leftovers.h"
#include "src/batch/outcome.h"
#include "tests/support/files.h"

namespace overtet {
namespace {

JournalEntry some_entry(const std::string& name) {
  JournalEntry e;
  e.name = name;
  e.sha256 = sha256_of(name);
  e.options = {"--improve", "20"};
  e.version = "0.1.0";
  e.input = "in/" + name + ".obj";
  e.input_bytes = 1234;
  e.status = "exact";
  e.exit_code = 0;
  e.message = "a \"quoted\" \\ message,\nof two lines";
  e.outputs = {{name + ".mesh", 99}};
  e.seconds = .1 + 1. / 3;
  e.cpu_seconds = 1e-9;
  e.peak_rss_bytes = 1ll << 40;
  e.threads = 3;
  e.time_limit = 12.5;
  e.tets = 77;
  e.dihedral_min = 17.25;
  e.result_hash = "0123456789abcdef";
  e.ended = "2026-11-30T18:00:00Z";
  return e;
}

TEST(Journal, LinesReadBackAsTheyWere) {
  const JournalEntry e = some_entry("a");
  const std::string line = to_line(e);
  EXPECT_EQ(line.find('\n'), line.size() - 1);
  const auto back = entry_of(line);
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(to_line(*back), line);
  EXPECT_EQ(back->seconds, e.seconds);
  EXPECT_EQ(back->message, e.message);
  EXPECT_EQ(back->faces, std::nullopt);
  EXPECT_EQ(back->dihedral_min, e.dihedral_min);
}

TEST(Journal, NamesNeedNotBeUtf8) {
  const JournalEntry e = some_entry("caf\xe9");
  const auto back = entry_of(to_line(e));
  ASSERT_TRUE(back.has_value());
  EXPECT_EQ(back->name, as_utf8(e.name));
  EXPECT_EQ(back->name, "caf\xef\xbf\xbd");
}

// Every prefix of a journal has the whole lines before the cut, and nothing else.
TEST(Journal, LinesThatAreCutOffAreSkipped) {
  const std::string text = to_line(some_entry("a")) + to_line(some_entry("b")) + to_line(some_entry("c"));
  for (std::size_t cut = 0; cut <= text.size(); ++cut) {
    const JournalContents c = journal_of(text.substr(0, cut));
    const auto whole = std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(cut), '\n');
    // A line that only lacks its line end is whole.
    EXPECT_GE(std::ssize(c.entries), whole);
    EXPECT_LE(std::ssize(c.entries), whole + 1);
    EXPECT_LE(c.wrong_lines.size(), 1u);
  }
}

TEST(Journal, WhatIsNoEntryIsSkipped) {
  std::string line = to_line(some_entry("a"));
  for (const char* other : {"", "[]", "null", "{}", "{\"journal\":1}", "{\"journal\":2,\"name\":\"x\"}",
                            "\x01\x02", "{\"journal\":1,\"name\":3}"}) {
    const JournalContents c = journal_of(line + other + "\n" + line);
    EXPECT_EQ(c.entries.size(), 2u) << other;
    EXPECT_EQ(c.wrong_lines.size(), *other ? 1u : 0u) << other;
  }
  line.replace(line.find("\"threads\":3"), 11, "\"threads\":9e99");
  EXPECT_FALSE(entry_of(line).has_value());
}

TEST(Journal, TheLastLineCountsWhateverTheClockSaid) {
  JournalEntry first = some_entry("a"), second = first, elsewhere = first;
  second.status = "infeasible", second.ended = "1970-01-01T00:00:00Z";  // the clock has jumped
  elsewhere.status = "limit", elsewhere.ended = "2026-11-29T00:00:00Z";
  std::map<std::string, JournalEntry> last;
  add_last({{first, second}, {}}, last);
  EXPECT_EQ(last.at("a").status, "infeasible");
  add_last({{elsewhere}, {}}, last);
  EXPECT_EQ(last.at("a").status, "limit");
}

TEST(Journal, ALineThatWasCutOffIsEndedBeforeTheNext) {
  const test::TemporaryFolder folder;
  const std::string line = to_line(some_entry("a"));
  test::write_text(folder.file("journal.jsonl"), line + line.substr(0, 40));
  {
    Journal journal;
    ASSERT_TRUE(journal.open(folder.path(), 1, 1).ok());
    ASSERT_TRUE(journal.append(some_entry("b")).ok());
  }
  const auto read = read_journal(folder.file("journal.jsonl"));
  ASSERT_TRUE(read.ok());
  ASSERT_EQ(read.value().entries.size(), 2u);
  EXPECT_EQ(read.value().entries[1].name, "b");
  EXPECT_EQ(read.value().wrong_lines, (std::vector<std::int64_t>{2}));
}

TEST(Journal, OneBatchAtATime) {
  const test::TemporaryFolder folder;
  Journal whole, second, shard;
  ASSERT_TRUE(whole.open(folder.path(), 1, 1).ok());
  const Status refused = second.open(folder.path(), 1, 1);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().code, ErrorCode::io);
  EXPECT_NE(refused.error().message.find("Another batch"), std::string::npos);
  EXPECT_FALSE(shard.open(folder.path(), 1, 2).ok());
}

TEST(Journal, ShardsWorkBesideEachOther) {
  const test::TemporaryFolder folder;
  Journal one, two, again, whole;
  EXPECT_TRUE(one.open(folder.path(), 1, 2).ok());
  EXPECT_TRUE(two.open(folder.path(), 2, 2).ok());
  EXPECT_FALSE(again.open(folder.path(), 2, 2).ok());
  EXPECT_FALSE(whole.open(folder.path(), 1, 1).ok());
}

// In a process of its own, whose files cannot grow.
TEST(Journal, AFullDiskLeavesNoPartOfALine) {
  const test::TemporaryFolder folder;
  const pid_t child = ::fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    Journal journal;
    bool right = journal.open(folder.path(), 1, 1).ok() && journal.append(some_entry("a")).ok();
    const rlimit most{to_line(some_entry("a")).size() + 100, RLIM_INFINITY};
    ::setrlimit(RLIMIT_FSIZE, &most);
    right = right && !journal.append(some_entry("b")).ok() && !journal.append(some_entry("c")).ok();
    ::_exit(right ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_EQ(test::read_text(folder.file("journal.jsonl")), to_line(some_entry("a")));
}

TEST(Journal, AJournalThatIsRemovedIsNoticed) {
  const test::TemporaryFolder folder;
  Journal journal;
  ASSERT_TRUE(journal.open(folder.path(), 1, 1).ok());
  ASSERT_TRUE(journal.append(some_entry("a")).ok());
  std::filesystem::remove(folder.file("journal.jsonl"));
  EXPECT_FALSE(journal.append(some_entry("b")).ok());
}

TEST(Journal, WhatIsSettled) {
  const test::TemporaryFolder folder;
  test::write_text(folder.file("a.mesh"), std::string(99, 'x'));
  JournalEntry e = some_entry("a");
  e.memory_limit_bytes = 1000;
  const auto with = [&](const char* status) {
    JournalEntry changed = e;
    changed.status = status;
    return changed;
  };
  const auto is_settled = [&](const JournalEntry& entry, double time, std::int64_t memory) {
    return settled(entry, {{"a.mesh", folder.file("a.mesh")}}, time, memory);
  };
  for (const char* status :
       {"exact", "repaired", "refined", "branched", "infeasible", "unsolved", "bad-input"})
    EXPECT_TRUE(is_settled(with(status), 99, 5000)) << status;
  for (const char* status : {"crashed", "failed", "interrupted", ""})
    EXPECT_FALSE(is_settled(with(status), 12.5, 1000)) << status;
  EXPECT_TRUE(is_settled(with("limit"), 12.5, 1000));
  EXPECT_TRUE(is_settled(with("limit"), 10, 900));
  EXPECT_FALSE(is_settled(with("limit"), 13, 1000));
  EXPECT_FALSE(is_settled(with("limit"), 0, 1000));
  EXPECT_FALSE(is_settled(with("limit"), 12.5, 4000));
  test::write_text(folder.file("a.mesh"), "cut off");
  EXPECT_FALSE(is_settled(e, 12.5, 1000));
  std::filesystem::remove(folder.file("a.mesh"));
  EXPECT_FALSE(is_settled(e, 12.5, 1000));
}

TEST(ContentHash, IsSha256) {
  const test::TemporaryFolder folder;
  test::write_text(folder.file("abc"), "abc");
  const auto state = state_of(folder.file("abc"));
  ASSERT_TRUE(state.ok());
  EXPECT_EQ(state.value().sha256,
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");  // FIPS 180-2
  EXPECT_TRUE(unchanged_since(state.value(), folder.file("abc")));
  test::write_text(folder.file("abc"), "abd");
  std::filesystem::last_write_time(folder.file("abc"), std::filesystem::file_time_type::clock::now());
  EXPECT_FALSE(unchanged_since(state.value(), folder.file("abc")));
  EXPECT_FALSE(state_of(folder.file("none")).ok());
  EXPECT_FALSE(state_of(folder.path()).ok());
  EXPECT_FALSE(state_of("/dev/null").ok());
}

TEST(Leftovers, AreUnfinishedNeighboursOfResults) {
  EXPECT_EQ(finished_name(".a.mesh.4711.0"), "a.mesh");
  EXPECT_EQ(finished_name(".a.mesh.Xy12ab"), "a.mesh");
  for (const char* other :
       {"a.mesh", ".a", ".", "", ".hidden.txt", ".a.mesh.12.", "..", ".4711.0", ".a.mesh.Xy12abc"})
    EXPECT_TRUE(finished_name(other) == "" || finished_name(other) != "a.mesh") << other;
  const test::TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("sub"));
  for (const char* name :
       {".a.mesh.12.0", ".other.mesh.12.0", "a.mesh", "sub/.b.json.abc123", "sub/.a.mesh.12.0"})
    test::write_text(folder.file(name), "x");
  remove_leftovers(folder.path(), {folder.file("a.mesh"), folder.file("sub/b.json")});
  EXPECT_EQ(folder.entries(), 3);
  EXPECT_FALSE(std::filesystem::exists(folder.file(".a.mesh.12.0")));
  EXPECT_FALSE(std::filesystem::exists(folder.file("sub/.b.json.abc123")));
  EXPECT_TRUE(std::filesystem::exists(folder.file("sub/.a.mesh.12.0")));
}

}  // namespace
}  // namespace overtet
