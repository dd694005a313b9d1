#include "kernels/parallel/parallel.h"
#include "kernels/parallel/grouping.h"

#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <random>
#include <stdexcept>
#include <thread>
#include <vector>

namespace overtet {
namespace {

double rough(std::int64_t i) { return std::sin(static_cast<double>(i)) * std::pow(10.0, i % 17 - 8); }

double rough_sum(std::int64_t n, std::int64_t grain) {
  return parallel_reduce(
      n, grain, 0.0,
      [](std::int64_t begin, std::int64_t end) {
        double sum = 0;
        for (std::int64_t i = begin; i < end; ++i) sum += rough(i);
        return sum;
      },
      [](double a, double b) { return a + b; });
}

TEST(Parallel, ForVisitsEveryIndexOnce) {
  for (std::int64_t n : {0, 1, 7, 64, 65, 1000, 100003}) {
    std::vector<int> seen(n, 0);
    parallel_for(n, 64, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) ++seen[i];
    });
    for (int count : seen) ASSERT_EQ(count, 1);
  }
}

TEST(Parallel, ReduceHasTheSameBitsOnAnyNumberOfThreads) {
  double first = 0;
  for (int threads : {1, 2, 3, 8}) {
    const ScopedThreads scope(threads);
    EXPECT_EQ(thread_cap(), threads);
    for (int repeat = 0; repeat < 20; ++repeat) {
      const double sum = rough_sum(50021, 128);
      if (threads == 1 && repeat == 0) first = sum;
      ASSERT_EQ(sum, first) << threads << " threads";
    }
  }
}

TEST(Parallel, ReduceOfBooleansAndEmptyRange) {
  const auto any = [](std::int64_t n, std::int64_t hit) {
    return parallel_reduce(
        n, 8, false, [&](std::int64_t b, std::int64_t e) { return b <= hit && hit < e; },
        [](bool a, bool b) { return a || b; });
  };
  EXPECT_FALSE(any(0, 0));
  EXPECT_TRUE(any(1000, 999));
  EXPECT_FALSE(any(1000, 1000));
}

TEST(Parallel, CollectKeepsTheOrder) {
  for (int threads : {1, 2, 8}) {
    const ScopedThreads scope(threads);
    const auto list = parallel_collect<std::int64_t>(
        10007, 16, [](std::int64_t begin, std::int64_t end, std::vector<std::int64_t>& out) {
          for (std::int64_t i = begin; i < end; ++i)
            if (i % 3 == 1) out.push_back(i);
        });
    ASSERT_EQ(list.size(), 3336u);
    for (std::size_t k = 0; k < list.size(); ++k) ASSERT_EQ(list[k], static_cast<std::int64_t>(3 * k + 1));
  }
}

TEST(Parallel, NestedLoopsWork) {
  for (int threads : {1, 2, 8}) {
    const ScopedThreads scope(threads);
    std::vector<double> sums(50);
    parallel_for(50, 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) sums[i] = rough_sum(2000 + i, 64);
    });
    const ScopedThreads one(1);
    for (int i = 0; i < 50; ++i) ASSERT_EQ(sums[i], rough_sum(2000 + i, 64));
  }
}

// Loops in the blocks of a loop once ran on all cores.
TEST(Parallel, OneThreadIsOneThreadInNestedLoopsToo) {
  const ScopedThreads scope(1);
  const std::thread::id here = std::this_thread::get_id();
  std::atomic<int> elsewhere = 0;
  parallel_for(4, 1, [&](std::int64_t, std::int64_t) {
    EXPECT_EQ(thread_cap(), 1);
    parallel_for(1000, 1, [&](std::int64_t, std::int64_t) {
      std::this_thread::sleep_for(std::chrono::microseconds(1));
      elsewhere += std::this_thread::get_id() != here;
    });
  });
  EXPECT_EQ(elsewhere, 0);
  EXPECT_EQ(thread_cap(), 1);
}

TEST(Parallel, ExceptionsLeaveTheLoop) {
  EXPECT_THROW(parallel_for(1000, 1,
                            [](std::int64_t begin, std::int64_t) {
                              if (begin == 500) throw std::runtime_error("block 500");
                            }),
               std::runtime_error);
  EXPECT_NE(rough_sum(1000, 10), 0.0);  // and the pool still works
}

TEST(Parallel, ProcessWideCap) {
  set_thread_cap(3);
  EXPECT_EQ(thread_cap(), 3);
  {
    const ScopedThreads scope(1);
    EXPECT_EQ(thread_cap(), 1);
  }
  EXPECT_EQ(thread_cap(), 3);
  set_thread_cap(0);
  EXPECT_GE(thread_cap(), 1);
}

TEST(Parallel, TasksAreTakenInOrderAndOnce) {
  for (const int threads : {1, 2, 3}) {
    const ScopedThreads scope(threads);
    std::vector<std::atomic<int>> runs(100);
    std::vector<int> when(100);
    std::atomic<int> clock{0};
    parallel_tasks(100, [&](std::int64_t i) {
      when[i] = clock++;
      ++runs[i];
    });
    for (int i = 0; i < 100; ++i) {
      EXPECT_EQ(1, runs[i]);
      if (threads == 1) {
        EXPECT_EQ(i, when[i]);
      }
    }
  }
  parallel_tasks(0, [](std::int64_t) { FAIL(); });
}

TEST(Parallel, InvokeRunsBoth) {
  int a = 0, b = 0;
  parallel_invoke([&] { a = 1; }, [&] { b = 2; });
  EXPECT_EQ(a + b, 3);
}

TEST(Grouping, ItemsStayInOrderOnAnyNumberOfThreads) {
  std::mt19937 random(11);
  for (const int n : {0, 1, 50, 3000})
    for (const int groups : {1, 7, 500}) {
      std::vector<int> key(n);
      for (int& k : key) k = static_cast<int>(random() % groups);
      std::vector<std::vector<int>> want(groups);
      for (int i = 0; i < n; ++i) want[key[i]].push_back(i);
      for (const int threads : {1, 2, 3, 8}) {
        const ScopedThreads scope(threads);
        RawVector<std::uint32_t> start;
        RawVector<int> items;
        group_items(groups, start, items, [&](auto visit) {
          for (int i = 0; i < n; ++i) visit(key[i], i);
        });
        ASSERT_EQ(start[groups], static_cast<std::uint32_t>(n));
        for (int g = 0; g < groups; ++g)
          ASSERT_EQ(std::vector<int>(items.begin() + start[g], items.begin() + start[g + 1]), want[g]);
      }
    }
}

TEST(Grouping, SortInGroupsIsThatOfTheStandardLibrary) {
  std::mt19937 random(11);
  for (const int threads : {1, 2, 3})
    for (const int n : {0, 1, 5000, 100000}) {
      const ScopedThreads scope(threads);
      std::vector<std::pair<int, int>> list(n);
      for (auto& x : list) x = {static_cast<int>(random() % 10000), static_cast<int>(random() % 10)};
      auto sorted = list;
      std::sort(sorted.begin(), sorted.end());
      parallel_sort_groups(list, 10000, [](const auto& x) { return x.first; });
      EXPECT_EQ(sorted, list);
    }
}

TEST(Grouping, SortIsThatOfTheStandardLibrary) {
  std::mt19937 random(12);
  for (const int n : {0, 1, 1000, 32768, 32769, 200000}) {
    std::vector<int> list(n);
    for (int& x : list) x = static_cast<int>(random() % 5000);
    std::vector<int> want = list;
    std::sort(want.begin(), want.end());
    parallel_sort(list);
    EXPECT_EQ(list, want);
  }
}

}  // namespace
}  // namespace overtet
