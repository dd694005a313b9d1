// overtet batch from outside, with the program as its own worker.
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/mount.h>
#include <unistd.h>

#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <random>
#include <thread>

#include "overtet/io.h"
#include "src/batch/journal.h"
#include "tests/support/files.h"
#include "tests/support/models.h"
#include "tests/support/process.h"

namespace overtet {
namespace {

namespace fs = std::filesystem;
using test::shell;
using test::ShellResult;

std::vector<JournalEntry> entries_in(const std::string& journal) {
  const auto read = read_journal(journal);
  return read ? read.value().entries : std::vector<JournalEntry>();
}

// What does not depend on when and where a model ran.
std::map<std::string, std::string> answers_of(const std::string& folder) {
  std::map<std::string, std::string> answers;
  const auto journals = journals_in(folder);
  for (const std::string& path : journals.value())
    for (const JournalEntry& e : entries_in(path))
      answers[e.name] = e.status + " " + e.message.substr(0, e.message.find(", checked exactly")) + " " +
                        e.result_hash + " " + std::to_string(e.outputs.size());
  // The message of a mesh names its file, which lies in the folder.
  for (auto& [name, answer] : answers)
    if (const auto at = answer.find(folder); at != std::string::npos) answer.erase(at, folder.size());
  return answers;
}

class BatchCli : public ::testing::Test {
 protected:
  void SetUp() override {
    fs::create_directories(folder_.file("in/more"));
    save("a_worm.off", test::curled_worm());
    save("more/sphere.ply", test::sphere(3));
    save("saucer.obj", test::saucer());
    save("more/torus.off", test::torus());
    save("spheres.off", test::two_spheres());
    save("slab.off", test::bent_slab());
    test::write_text(folder_.file("in/bad.off"), "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  }
  void save(const std::string& name, const Surface& s) {
    ASSERT_TRUE(write_surface(folder_.file("in/" + name), s, surface_format_of(name).value()).ok());
  }
  std::vector<std::string> words(const std::string& out, bool resume = false) {
    std::vector<std::string> w = {OVERTET_PROGRAM, "batch", folder_.file("in"), "-o", folder_.file(out),
                                  "--jobs",        "2"};
    if (resume) w.emplace_back("--resume");
    return w;
  }
  ShellResult batch(const std::string& rest) {
    return shell(std::string(OVERTET_PROGRAM) + " batch " + folder_.file("in") + " " + rest);
  }
  std::vector<std::string> entries_of(const std::string& folder) {
    std::vector<std::string> all;
    for (const auto& e : fs::recursive_directory_iterator(folder_.file(folder)))
      if (e.is_regular_file()) all.push_back(e.path().lexically_relative(folder_.file(folder)));
    std::sort(all.begin(), all.end());
    return all;
  }
  test::TemporaryFolder folder_, logs_;
};

TEST_F(BatchCli, AnswersAreThoseOfSingleRuns) {
  const ShellResult r =
      batch("-o " + folder_.file("out") + " --report " + folder_.file("all.json") + " -- --improve 12");
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_EQ(r.out, "");
  EXPECT_EQ(std::count(r.err.begin(), r.err.end(), '\n'), 8) << r.err;
  int meshes = 0;
  for (const JournalEntry& e : entries_in(folder_.file("out/journal.jsonl"))) {
    const ShellResult single = shell(std::string(OVERTET_PROGRAM) + " mesh " + e.input + " -o " +
                                     folder_.file("one.mesh") + " --improve 12 --threads 2");
    EXPECT_EQ(single.exit_code, e.exit_code) << e.name;
    if (single.exit_code != 0) continue;
    ++meshes;
    EXPECT_EQ(test::read_text(folder_.file("one.mesh")),
              test::read_text(folder_.file("out/" + e.name + ".mesh")))
        << e.name;
  }
  EXPECT_EQ(meshes, 5);
  const auto report = nlohmann::json::parse(test::read_text(folder_.file("all.json")));
  EXPECT_EQ(report["totals"]["statuses"],
            (nlohmann::json{{"bad-input", 1}, {"exact", 5}, {"infeasible", 1}}));
}

TEST_F(BatchCli, ShardsTogetherAreTheWhole) {
  ASSERT_EQ(batch("-o " + folder_.file("whole") + " --format vtu").exit_code, 0);
  for (const char* shard : {"3/3", "1/3", "2/3"})
    ASSERT_EQ(batch("-o " + folder_.file("parts") + " --format vtu --shard " + shard).exit_code, 0);
  EXPECT_EQ(answers_of(folder_.file("parts")), answers_of(folder_.file("whole")));
  EXPECT_EQ(answers_of(folder_.file("parts")).size(), 7u);
  const ShellResult again = batch("-o " + folder_.file("parts") + " --format vtu --resume");
  EXPECT_NE(again.err.find("7 done before"), std::string::npos) << again.err;
}

TEST_F(BatchCli, KillingItAtAnyMomentLosesNoResult) {
  ASSERT_EQ(batch("-o " + folder_.file("whole")).exit_code, 0);
  const auto whole = answers_of(folder_.file("whole"));
  const auto whole_files = entries_of("whole");
  const unsigned seed = std::random_device{}();
  std::mt19937 random(seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  for (int round = 0; round < 5; ++round) {
    const std::string out = "out" + std::to_string(round);
    for (int kills = 0; kills < 3; ++kills) {
      test::Process p(words(out, kills > 0), logs_.path());
      std::this_thread::sleep_for(std::chrono::milliseconds(random() % 400));
      std::vector<pid_t> workers = p.children();
      p.signal(SIGKILL);
      ASSERT_TRUE(p.wait(20).has_value());
      for (const pid_t worker : workers) {
        for (int i = 0; i < 2000 && test::is_running(worker); ++i)
          std::this_thread::sleep_for(std::chrono::milliseconds(5));
        EXPECT_FALSE(test::is_running(worker));
      }
    }
    test::Process last(words(out, true), logs_.path());
    ASSERT_EQ(last.wait(300), 0) << test::read_text(logs_.file("err"));
    EXPECT_EQ(answers_of(folder_.file(out)), whole);
    EXPECT_EQ(entries_of(out), whole_files);
  }
}

TEST_F(BatchCli, KillingWorkersLosesNoResult) {
  ASSERT_EQ(batch("-o " + folder_.file("whole")).exit_code, 0);
  test::Process p(words("out"), logs_.path());
  int killed = 0;
  std::optional<int> code;
  while (!(code = p.wait(.02))) {
    if (killed >= 3) continue;
    for (const pid_t worker : p.children())
      if (::kill(worker, SIGKILL) == 0) ++killed;
  }
  EXPECT_EQ(code, killed > 0 ? 0 : -1);
  EXPECT_EQ(answers_of(folder_.file("out")), answers_of(folder_.file("whole")));
}

TEST_F(BatchCli, SignalsEndItAndItsWorkers) {
  for (const auto& [number, expected] : {std::pair{SIGINT, 130}, {SIGTERM, 143}}) {
    const std::string out = "out" + std::to_string(number);
    test::Process p(words(out), logs_.path());
    std::vector<pid_t> workers;
    for (int i = 0; i < 2000 && workers.empty(); ++i) {
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
      workers = p.children();
    }
    ASSERT_FALSE(workers.empty());
    p.signal(number);
    EXPECT_EQ(p.wait(30), expected) << test::read_text(logs_.file("err"));
    EXPECT_NE(test::read_text(logs_.file("err")).find("--resume goes on"), std::string::npos);
    for (const pid_t worker : workers) EXPECT_FALSE(test::is_running(worker));
    EXPECT_EQ(shell(std::string(OVERTET_PROGRAM) + " batch " + folder_.file("in") + " -o " +
                    folder_.file(out) + " --resume")
                  .exit_code,
              0);
  }
}

TEST_F(BatchCli, TheSecondBatchOnAFolderRefuses) {
  test::Process p(words("out"), logs_.path());
  for (int i = 0; i < 2000 && !fs::exists(folder_.file("out/journal.jsonl")); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
  const ShellResult second = batch("-o " + folder_.file("out") + " --resume");
  EXPECT_EQ(second.exit_code, 7);
  EXPECT_NE(second.err.find("Another batch is at work"), std::string::npos) << second.err;
  EXPECT_EQ(p.wait(300), 0);
}

// A small disk of its own; only root can have one.
TEST_F(BatchCli, AFullDiskLosesNoResultAndLeavesNoPart) {
  if (::geteuid() != 0) GTEST_SKIP() << "only root can mount a small tmpfs";
  fs::create_directory(folder_.file("disk"));
  if (::mount("none", folder_.file("disk").c_str(), "tmpfs", 0, "size=260k") != 0)
    GTEST_SKIP() << "a tmpfs cannot be mounted here";
  const ShellResult full = batch("-o " + folder_.file("disk/out") + " --jobs 1");
  EXPECT_EQ(full.exit_code, 7) << full.err;
  const auto kept = read_journal(folder_.file("disk/out/journal.jsonl"));
  ASSERT_TRUE(kept.ok());
  EXPECT_TRUE(kept.value().wrong_lines.empty());
  int done = 0;
  for (const JournalEntry& e : kept.value().entries)
    for (const auto& [file, bytes] : e.outputs) {
      ++done;
      EXPECT_EQ(fs::file_size(folder_.file("disk/out/" + file)), static_cast<std::size_t>(bytes));
    }
  EXPECT_GT(done, 0);
  EXPECT_LT(done, 5);
  for (const std::string& file : entries_of("disk/out"))
    EXPECT_FALSE(fs::path(file).filename().string().starts_with("."));
  ASSERT_EQ(::mount("none", folder_.file("disk").c_str(), "tmpfs", MS_REMOUNT, "size=20m"), 0);
  EXPECT_EQ(batch("-o " + folder_.file("disk/out") + " --resume").exit_code, 0);
  ASSERT_EQ(::mount("none", folder_.file("disk").c_str(), "tmpfs", MS_REMOUNT | MS_RDONLY, "size=20m"), 0);
  const ShellResult read_only = batch("-o " + folder_.file("disk/out") + " --resume");
  EXPECT_EQ(read_only.exit_code, 7);
  EXPECT_NE(read_only.err.find("Read-only"), std::string::npos) << read_only.err;
  EXPECT_EQ(::umount(folder_.file("disk").c_str()), 0);
}

TEST_F(BatchCli, TheSummaryWritesTables) {
  ASSERT_EQ(batch("-o " + folder_.file("out")).exit_code, 0);
  const ShellResult r = shell(std::string(OVERTET_PROGRAM) + " batch --summary " + folder_.file("out") +
                              " --csv " + folder_.file("t.csv") + " --json " + folder_.file("t.json") +
                              " --html " + folder_.file("t.html"));
  ASSERT_EQ(r.exit_code, 0) << r.err;
  EXPECT_NE(r.out.find("5 exact, 1 infeasible, 1 bad-input"), std::string::npos) << r.out;
  const std::string csv = test::read_text(folder_.file("t.csv"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\r'), 8);
  EXPECT_EQ(nlohmann::json::parse(test::read_text(folder_.file("t.json")))["models"].size(), 7u);
  EXPECT_NE(test::read_text(folder_.file("t.html")).find("a_worm"), std::string::npos);
}

TEST_F(BatchCli, NamesCanStandInOptions) {
  ASSERT_EQ(
      batch("-o " + folder_.file("out") + " -- --on-infeasible refine --save-surface {name}_surface.ply")
          .exit_code,
      0);
  EXPECT_TRUE(fs::exists(folder_.file("out/more/torus_surface.ply")));
}

TEST_F(BatchCli, WrongUseIsSaid) {
  const std::pair<const char*, const char*> all[] = {{"", "-o FOLDER"},
                                                     {"-o OUT --shard 3/2", "I/N"},
                                                     {"-o OUT --shard x", "I/N"},
                                                     {"-o OUT --shard 1/2x", "I/N"},
                                                     {"-o OUT --csv t.csv", "--summary"},
                                                     {"-o OUT extra", "one folder or manifest"},
                                                     {"-o OUT -- --output x.mesh", "cannot stand after --"},
                                                     {"-o OUT -- -o x.mesh", "cannot stand after --"},
                                                     {"-o OUT -- --threads=3", "--jobs"},
                                                     {"-o OUT -- --time-limit 3", "before the --"},
                                                     {"-o OUT -- --improv 3", "do you mean --improve"},
                                                     {"-o OUT --job 3", "do you mean --jobs"}};
  for (const auto& [given, said] : all) {
    std::string line = given;
    if (const auto at = line.find("OUT"); at != std::string::npos) line.replace(at, 3, folder_.file("out"));
    const ShellResult r = batch(line);
    EXPECT_EQ(r.exit_code, 2) << given << ": " << r.err;
    EXPECT_NE(r.err.find(said), std::string::npos) << given << ": " << r.err;
    fs::remove_all(folder_.file("out"));
  }
}

}  // namespace
}  // namespace overtet
