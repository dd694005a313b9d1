#include "kernels/parallel/counts.h"

#include <gtest/gtest.h>

#include <thread>

#include "kernels/parallel/parallel.h"

namespace overtet {
namespace {

TEST(Counts, AddUpOverThreadsAndTheirEnds) {
  const std::int64_t before = counted(Count::contacts), other = counted(Count::tested_pairs);
  parallel_for(10'000, 7, [](std::int64_t begin, std::int64_t end) { count(Count::contacts, end - begin); });
  for (int i = 0; i < 5; ++i) std::thread([] { count(Count::contacts); }).join();
  EXPECT_EQ(counted(Count::contacts) - before, 10'005);
  EXPECT_EQ(counted(Count::tested_pairs), other);
}

}  // namespace
}  // namespace overtet
