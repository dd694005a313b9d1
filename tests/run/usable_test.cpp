// What the machine, control groups and Slurm let a process have.
#include "src/run/usable.h"

#include <gtest/gtest.h>
#include <sched.h>
#include <stdlib.h>

#include <filesystem>
#include <thread>

#include "overtet/run_context.h"
#include "tests/support/files.h"

namespace overtet {
namespace {

class Quota : public ::testing::Test {
 protected:
  void file(const std::string& path, const std::string& text) {
    const std::filesystem::path full = folder_.file(path);
    std::filesystem::create_directories(full.parent_path());
    test::write_text(full, text);
  }
  std::optional<double> cores(const std::string& groups) { return cores_of_quota(groups, folder_.path()); }
  test::TemporaryFolder folder_;
};

TEST_F(Quota, OfTheSecondVersion) {
  file("a/b/cpu.max", "150000 100000\n");
  EXPECT_EQ(cores("0::/a/b\n"), 1.5);
  EXPECT_EQ(cores("0::/a/c\n"), std::nullopt);
  EXPECT_EQ(cores("0::/\n"), std::nullopt);
}

TEST_F(Quota, OfAGroupAboveCounts) {
  file("a/cpu.max", "300000 100000\n");
  file("a/b/cpu.max", "max 100000\n");
  EXPECT_EQ(cores("0::/a/b\n"), 3.);
  file("cpu.max", "200000 100000\n");
  EXPECT_EQ(cores("0::/a/b\n"), 2.);
  EXPECT_EQ(cores("0::/elsewhere/on/the/host\n"), 2.);
}

TEST_F(Quota, OfTheFirstVersion) {
  file("cpu,cpuacct/x/cpu.cfs_quota_us", "400000\n");
  file("cpu,cpuacct/x/cpu.cfs_period_us", "100000\n");
  EXPECT_EQ(cores("7:cpu,cpuacct:/x\n3:memory:/x\n"), 4.);
  file("cpu,cpuacct/x/cpu.cfs_quota_us", "-1\n");
  EXPECT_EQ(cores("7:cpu,cpuacct:/x\n"), std::nullopt);
}

TEST_F(Quota, WhatIsNoSuchFileIsNoQuota) {
  file("cpu.max", "many few\n");
  for (const char* groups : {"", "\n", "0:", "::", "0::\n", "0::relative\n", "nonsense"})
    EXPECT_EQ(cores(groups), std::nullopt) << groups;
}

TEST(UsableCores, AreNoMoreThanAffinityAndSlurmAllow) {
  const int all = usable_cores();
  EXPECT_GE(all, 1);
  EXPECT_LE(all, static_cast<int>(std::thread::hardware_concurrency()));
  ASSERT_EQ(::setenv("SLURM_CPUS_PER_TASK", "1", 1), 0);
  EXPECT_EQ(usable_cores(), 1);
  ASSERT_EQ(::setenv("SLURM_CPUS_PER_TASK", "100000", 1), 0);
  EXPECT_EQ(usable_cores(), all);
  ASSERT_EQ(::setenv("SLURM_CPUS_PER_TASK", "2 or so", 1), 0);
  EXPECT_EQ(usable_cores(), all);
  ::unsetenv("SLURM_CPUS_PER_TASK");
  cpu_set_t before, one;
  ASSERT_EQ(::sched_getaffinity(0, sizeof before, &before), 0);
  CPU_ZERO(&one);
  for (int cpu = 0; CPU_COUNT(&one) == 0; ++cpu)
    if (CPU_ISSET(cpu, &before)) CPU_SET(cpu, &one);
  ASSERT_EQ(::sched_setaffinity(0, sizeof one, &one), 0);
  EXPECT_EQ(usable_cores(), 1);
  ::sched_setaffinity(0, sizeof before, &before);
}

TEST(SlurmMemory, IsThatOfTheNodeOrOfTheCores) {
  const auto set = [](const char* name, const char* value) { ::setenv(name, value, 1); };
  EXPECT_EQ(slurm_memory_bytes(), std::nullopt);
  set("SLURM_MEM_PER_CPU", "500");
  EXPECT_EQ(slurm_memory_bytes(), 500ll << 20);
  set("SLURM_CPUS_PER_TASK", "4");
  EXPECT_EQ(slurm_memory_bytes(), 2000ll << 20);
  set("SLURM_MEM_PER_NODE", "700");
  EXPECT_EQ(slurm_memory_bytes(), 700ll << 20);
  EXPECT_LE(usable_memory_bytes(), std::size_t{700} << 20);
  set("SLURM_MEM_PER_NODE", "0");  // all of it
  set("SLURM_MEM_PER_CPU", "9000000000000000000");
  EXPECT_GT(slurm_memory_bytes().value_or(0), 1ll << 50);
  for (const char* name : {"SLURM_MEM_PER_CPU", "SLURM_CPUS_PER_TASK", "SLURM_MEM_PER_NODE"})
    ::unsetenv(name);
}

}  // namespace
}  // namespace overtet
