// Batches whose workers are shell scripts: they crash, hang, run out of memory and tell lies.
#include "src/batch/batch.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <atomic>
#include <filesystem>
#include <mutex>
#include <thread>

#include "overtet/version.h"
#include "src/batch/journal.h"
#include "tests/support/files.h"

namespace overtet {
namespace {

namespace fs = std::filesystem;

class Batch : public ::testing::Test {
 protected:
  void model(const std::string& name, const std::string& text = "x") {
    fs::create_directories(fs::path(folder_.file("in/" + name)).parent_path());
    test::write_text(folder_.file("in/" + name), text);
  }
  // Each worker runs the script with the input, output and report as $1, $2, $3, threads and memory as $4,
  // $5.
  BatchOptions options(const std::string& script) {
    BatchOptions o;
    o.models = folder_.file("in");
    o.folder = folder_.file("out");
    o.cores = 2;
    o.usable_memory_bytes = std::int64_t{4} << 30;
    o.words = [script](const BatchJob& job) {
      return std::vector<std::string>{"/bin/sh",
                                      "-c",
                                      script + "\n",
                                      "sh",
                                      job.model.path,
                                      job.output,
                                      job.report,
                                      std::to_string(job.threads),
                                      std::to_string(job.memory_limit_bytes)};
    };
    return o;
  }
  Result<BatchCounts> run(const BatchOptions& o) { return run_batch(o, context_); }
  std::vector<JournalEntry> entries() {
    auto read = read_journal(folder_.file("out/journal.jsonl"));
    return read ? read.value().entries : std::vector<JournalEntry>();
  }
  JournalEntry last(const std::string& name) {
    JournalEntry found;
    for (const JournalEntry& e : entries())
      if (e.name == name) found = e;
    return found;
  }
  std::string log() { return test::read_text(folder_.file("log")); }
  std::ptrdiff_t lines_logged() {
    const std::string text = log();
    return std::count(text.begin(), text.end(), '\n');
  }
  std::string to_log(const std::string& words) {
    return "echo " + words + " >> " + folder_.file("log") + "\n";
  }

  const std::string exact =
      "echo mesh > \"$2\"; echo '{\"status\": \"exact\", \"message\": \"done\", \"result_hash\": \"ab\", "
      "\"quality\": "
      "{\"tets\": 5, \"dihedral_min\": 17.5}, \"input\": {\"faces\": 4, \"vertices\": 4}}' > \"$3\"; exit 0";
  test::TemporaryFolder folder_;
  RunContext context_;
};

TEST_F(Batch, EveryModelGetsALineAndItsResults) {
  for (const char* name : {"a.obj", "b.off", "sub/c.ply"}) model(name);
  const auto done = run(options(exact));
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(done.value().done, 3);
  EXPECT_EQ(listed(done.value().statuses), "3 exact");
  ASSERT_EQ(entries().size(), 3u);
  const JournalEntry c = last("sub/c");
  EXPECT_EQ(c.tets, 5);
  EXPECT_EQ(c.dihedral_min, 17.5);
  EXPECT_EQ(c.faces, 4);
  EXPECT_EQ(c.exit_code, 0);
  EXPECT_EQ(c.version, version());
  ASSERT_EQ(c.outputs.size(), 1u);
  EXPECT_EQ(c.outputs[0].first, "sub/c.mesh");
  EXPECT_EQ(test::read_text(folder_.file("out/sub/c.mesh")), "mesh\n");
  EXPECT_TRUE(fs::exists(folder_.file("out/sub/c.json")));
}

TEST_F(Batch, BiggestFirst) {
  model("small.obj", "1");
  model("large.obj", std::string(1000, 'x'));
  model("middle.obj", std::string(100, 'x'));
  BatchOptions o = options(to_log("$1") + exact);
  o.jobs = 1;
  ASSERT_TRUE(run(o).ok());
  EXPECT_LT(log().find("large"), log().find("middle"));
  EXPECT_LT(log().find("middle"), log().find("small"));
}

TEST_F(Batch, ACrashIsTriedOnceMoreByItself) {
  model("a.obj");
  model("b.obj");
  const auto done = run(options(
      to_log("$1 $4") + "case $1 in *a.obj) echo 'overtet: last words' >&2; kill -SEGV $$;; esac; " + exact));
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(listed(done.value().statuses), "1 exact, 1 crashed");
  const JournalEntry a = last("a");
  EXPECT_EQ(a.tries, 2);
  EXPECT_EQ(a.exit_code, std::nullopt);
  EXPECT_NE(a.message.find("Signal 11"), std::string::npos) << a.message;
  EXPECT_NE(a.message.find("last words"), std::string::npos) << a.message;
  EXPECT_NE(log().find("a.obj 2"), std::string::npos) << "the second try has all cores";
}

TEST_F(Batch, AModelThatIsKilledOnceSucceedsInTheEnd) {
  model("a.obj");
  const auto done = run(options("if [ -e " + folder_.file("again") + " ]; then " + exact + "; fi; touch " +
                                folder_.file("again") + "; kill -9 $$"));
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(listed(done.value().statuses), "1 exact");
  EXPECT_EQ(last("a").tries, 2);
}

TEST_F(Batch, WhatItsShareOfMemoryIsTooLittleForGetsAllOfIt) {
  for (const char* name : {"a.obj", "b.obj"}) model(name);
  const auto done = run(options(to_log("$1 $5") +
                                "case $1:$5 in *a.obj:*) if [ $5 -lt 3000000000 ]; then echo '{\"status\": "
                                "\"limit\", \"message\": \"The memory limit of 1 MiB "
                                "was reached.\"}' > \"$3\"; exit 6; fi;; esac; " +
                                exact));
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(listed(done.value().statuses), "2 exact");
  EXPECT_EQ(entries().size(), 2u);
  EXPECT_EQ(last("a").tries, 2);
  EXPECT_EQ(last("b").tries, 1);
}

TEST_F(Batch, AMemoryLimitThatWasGivenIsKept) {
  model("a.obj");
  BatchOptions o = options(
      "[ $5 = 1000 ] || exit 70; echo '{\"status\": \"limit\", \"message\": \"memory\"}' > \"$3\"; exit 6");
  o.memory_limit_bytes = 1000;
  ASSERT_TRUE(run(o).ok());
  EXPECT_EQ(last("a").status, "limit");
  EXPECT_EQ(last("a").tries, 1);
}

TEST_F(Batch, WhatDoesNotEndAtItsTimeLimitIsKilled) {
  model("a.obj");
  BatchOptions o = options("trap '' TERM INT; while :; do sleep 1; done");
  o.time_limit = .1;
  const auto done = run(o);
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(last("a").status, "limit");
  EXPECT_EQ(last("a").tries, 1);
}

TEST_F(Batch, ResumingRepeatsOnlyWhatIsNotSettled) {
  for (const char* name : {"a.obj", "b.obj", "c.obj", "d.obj"}) model(name, name);
  const std::string script =
      to_log("$1") + "case $1 in *c.obj) [ -e " + folder_.file("late") + " ] || exit 70;; esac; " + exact;
  ASSERT_TRUE(run(options(script)).ok());
  EXPECT_EQ(last("c").status, "failed");
  fs::remove(folder_.file("log"));
  test::write_text(folder_.file("late"), "");
  fs::remove(folder_.file("out/b.mesh"));
  model("d.obj", "another one");

  BatchOptions o = options(script);
  EXPECT_EQ(run(o).error().code, ErrorCode::usage) << "it did not say that it resumes";
  o.resume = true;
  const auto done = run(o);
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(done.value().skipped, 1);
  EXPECT_EQ(log().find("a.obj"), std::string::npos);
  for (const char* name : {"b.obj", "c.obj", "d.obj"}) EXPECT_NE(log().find(name), std::string::npos) << name;
  EXPECT_EQ(listed(done.value().statuses), "4 exact");

  fs::remove(folder_.file("log"));
  o.options = {"--improve", "20"};  // another option, another result
  ASSERT_TRUE(run(o).ok());
  EXPECT_EQ(lines_logged(), 4);
}

TEST_F(Batch, ResultsOfOtherContentsDoNotStay) {
  model("a.obj", "one");
  ASSERT_TRUE(run(options(exact)).ok());
  EXPECT_TRUE(fs::exists(folder_.file("out/a.mesh")));
  model("a.obj", "two");
  BatchOptions o = options("echo '{\"status\": \"infeasible\", \"message\": \"none\"}' > \"$3\"; exit 5");
  o.resume = true;
  ASSERT_TRUE(run(o).ok());
  EXPECT_EQ(last("a").status, "infeasible");
  EXPECT_FALSE(fs::exists(folder_.file("out/a.mesh")));
}

TEST_F(Batch, AFileThatChangesMeanwhileIsReadAgain) {
  model("a.obj", "one");
  const auto done =
      run(options("if [ $(cat \"$1\") = one ]; then sleep .05; echo two > \"$1\"; fi; " + exact));
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(last("a").status, "exact");
  EXPECT_EQ(last("a").tries, 2);
  EXPECT_EQ(last("a").input_bytes, 4);
  model("b.obj", "");
  BatchOptions o = options("echo more >> \"$1\"; " + exact);
  o.resume = true;
  ASSERT_TRUE(run(o).ok());
  EXPECT_EQ(last("b").status, "failed");
  EXPECT_NE(last("b").message.find("written to"), std::string::npos);
}

TEST_F(Batch, AFullDiskEndsTheBatchAndKeepsWhatIsDone) {
  for (const char* name : {"a.obj", "b.obj", "c.obj", "d.obj"}) model(name);
  BatchOptions o = options(
      "case $1 in *b.obj) echo 'overtet: Cannot write x: No space left on device.' >&2; exit 7;; esac; " +
      exact);
  o.jobs = 1;
  const auto done = run(o);
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().code, ErrorCode::io);
  EXPECT_EQ(last("a").status, "exact");
  EXPECT_EQ(entries().size(), 2u);
}

TEST_F(Batch, OptionsThatWorkersRefuseEndTheBatch) {
  for (const char* name : {"a.obj", "b.obj", "c.obj"}) model(name);
  BatchOptions o = options(to_log("$1") + "echo 'overtet: mesh has no option --improv.' >&2; exit 2");
  o.jobs = 1;
  const auto done = run(o);
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().code, ErrorCode::usage);
  EXPECT_NE(done.error().message.find("--improv"), std::string::npos);
  EXPECT_EQ(lines_logged(), 1);
}

TEST_F(Batch, WorkersThatLieAreFailures) {
  for (const char* name : {"a.obj", "b.obj", "c.obj"}) model(name);
  ASSERT_TRUE(run(options("case $1 in *a.obj) exit 0;; *b.obj) echo '{\"status\": 3}' > \"$3\"; exit 4;; *) "
                          "echo garbage > \"$3\"; "
                          "exit 99;; esac"))
                  .ok());
  EXPECT_EQ(last("a").status, "failed");
  EXPECT_EQ(last("b").status, "unsolved");
  EXPECT_EQ(last("c").status, "failed");
}

TEST_F(Batch, OddFilesAreAnswersToo) {
  test::write_text(folder_.file("list"), "none.obj\nin/pipe.obj\nin/dir.obj\nin/a.obj\n");
  model("a.obj");
  ASSERT_EQ(::mkfifo(folder_.file("in/pipe.obj").c_str(), 0600), 0);
  fs::create_directory(folder_.file("in/dir.obj"));
  BatchOptions o = options(exact);
  o.models = folder_.file("list");
  const auto done = run(o);
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(listed(done.value().statuses), "1 exact, 3 failed");
}

TEST_F(Batch, HostileNamesStayInTheFolder) {
  const std::string names[] = {"a\nb.obj", "-o.obj",       "$(touch x).obj",
                               "'\".obj",  "\xff\xfe.obj", std::string(200, 'n') + ".obj"};
  for (const std::string& name : names) model(name, name);
  const auto done = run(options(exact));
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(listed(done.value().statuses), "6 exact");
  BatchOptions o = options("exit 70");
  o.resume = true;
  const auto again = run(o);
  ASSERT_TRUE(again.ok());
  EXPECT_EQ(again.value().skipped, 6);
}

TEST_F(Batch, ANameThatIsTooLongHarmsNoOther) {
  test::write_text(folder_.file("list"),
                   "in/a.obj\n{\"input\": \"in/b.obj\", \"output\": \"" + std::string(300, 'n') + "/x\"}\n");
  model("a.obj");
  model("b.obj");
  BatchOptions o = options(exact);
  o.models = folder_.file("list");
  const auto done = run(o);
  ASSERT_TRUE(done.ok());
  EXPECT_EQ(listed(done.value().statuses), "1 exact, 1 failed");
}

TEST_F(Batch, AnInterruptEndsTheWorkersAndIsNoAnswer) {
  for (const char* name : {"a.obj", "b.obj", "c.obj"}) model(name);
  std::atomic<bool> cancel{false};
  context_.cancel = &cancel;
  BatchOptions o = options("trap '' TERM; echo $$ >> " + folder_.file("log") + "; sleep 100");
  std::thread later([&] {
    while (lines_logged() < 2) std::this_thread::sleep_for(std::chrono::milliseconds(5));
    cancel = true;
  });
  const auto done = run(o);
  later.join();
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().code, ErrorCode::interrupted);
  EXPECT_TRUE(entries().empty());
  std::istringstream ids(log());
  for (int id; ids >> id;) EXPECT_NE(::kill(id, 0), 0) << "worker " << id << " still runs";
}

TEST_F(Batch, NeverMoreThanTheJobsAtATime) {
  for (int i = 0; i < 12; ++i) model("m" + std::to_string(i) + ".obj");
  for (const int jobs : {1, 3}) {
    fs::remove_all(folder_.file("out"));
    fs::remove(folder_.file("log"));
    BatchOptions o = options(to_log("+") + "sleep .03\n" + to_log("-") + exact);
    o.jobs = jobs;
    ASSERT_TRUE(run(o).ok());
    int now = 0, most = 0;
    const std::string text = log();
    for (const char c : text) {
      if (c == '+') most = std::max(most, ++now);
      if (c == '-') --now;
    }
    EXPECT_LE(most, jobs);
    EXPECT_EQ(now, 0);
  }
}

TEST_F(Batch, ResultsNeedAFolderOfTheirOwn) {
  model("a.obj");
  BatchOptions o = options(exact);
  o.folder = o.models;
  EXPECT_EQ(run(o).error().code, ErrorCode::usage);
  o.folder = folder_.file("in/a.obj");
  EXPECT_EQ(run(o).error().code, ErrorCode::io);
  fs::remove(folder_.file("in/a.obj"));
  o.folder = folder_.file("out");
  EXPECT_EQ(run(o).error().code, ErrorCode::usage) << "there is nothing to mesh";
}

TEST(BatchPlan, KeepsAllCoresBusy) {
  const auto plan = [](int cores, int jobs, int threads) {
    BatchOptions o;
    o.cores = cores;
    o.jobs = jobs;
    o.threads = threads;
    return BatchPlan(o);
  };
  EXPECT_EQ(plan(8, 0, 0).jobs, 8);
  EXPECT_EQ(plan(8, 0, 3).jobs, 2);
  EXPECT_EQ(plan(2, 0, 5).jobs, 1);
  EXPECT_EQ(plan(8, 5, 0).jobs, 5);
  EXPECT_EQ(plan(8, 2, 0).threads_for(1, 1000, 8, 8), 4);
  EXPECT_EQ(plan(8, 2, 3).threads_for(1, 1000, 8, 8), 3);
  EXPECT_EQ(plan(2, 5, 0).threads_for(1, 1000, 2, -3), 1);
  // One among many gets one; one that is half of all that is left gets half of the cores.
  EXPECT_EQ(plan(8, 0, 0).threads_for(1, 1000, 8, 8), 1);
  EXPECT_EQ(plan(8, 0, 0).threads_for(500, 1000, 8, 8), 4);
  EXPECT_EQ(plan(8, 0, 0).threads_for(500, 1000, 8, 3), 3);
  EXPECT_EQ(plan(8, 0, 0).threads_for(500, 500, 8, 8), 8);
}

TEST(BatchOptions, AreChecked) {
  BatchOptions o;
  EXPECT_FALSE(o.validate().ok());
  o.words = [](const BatchJob&) { return std::vector<std::string>(); };
  EXPECT_TRUE(o.validate().ok());
  o.shard = 3, o.shards = 2;
  EXPECT_FALSE(o.validate().ok());
  o.shard = 1, o.jobs = -1;
  EXPECT_FALSE(o.validate().ok());
}

}  // namespace
}  // namespace overtet
