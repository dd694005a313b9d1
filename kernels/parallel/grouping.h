// Items grouped by a key, and lists sorted, by all threads and always with the same result.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "kernels/parallel/parallel.h"
#include "kernels/parallel/raw_vector.h"

namespace overtet {

// Counting sort. for_each(visit) calls visit(key, item) for every item, always in the same order, and may be
// called several times at once; 0 <= key < groups. Afterwards the items of group g are items[start[g]] ..
// items[start[g + 1] - 1], in the order in which they were visited. Offset: holds the number of items.
//
// Every thread visits everything and keeps the keys of its own range: worth while when a visit costs
// next to nothing. There is one result, whatever the ranges are.
template <class Offset, class Item, class ForEach>
void group_items(std::int64_t groups, RawVector<Offset>& start, RawVector<Item>& items, ForEach&& for_each) {
  const std::int64_t ranges = std::clamp(thread_cap(), 1, 16);
  const auto range = [&](std::int64_t r) { return groups * r / ranges; };
  std::vector<Offset> total(static_cast<std::size_t>(ranges) + 1, 0);
  start.resize(static_cast<std::size_t>(groups) + 1);
  parallel_for(ranges, 1, [&](std::int64_t r, std::int64_t) {
    const std::int64_t begin = range(r), end = range(r + 1);
    Offset* const here = start.data() + begin;
    const std::uint64_t size = static_cast<std::uint64_t>(end - begin);
    std::fill(here, here + size, 0);
    for_each([&](std::int64_t key, const Item&) {
      if (const std::uint64_t at = static_cast<std::uint64_t>(key - begin); at < size) ++here[at];
    });
    for (std::uint64_t k = 0; k < size; ++k) total[r + 1] += here[k];
  });
  for (std::int64_t r = 0; r < ranges; ++r) total[r + 1] += total[r];
  items.resize(total[ranges]);
  parallel_for(ranges, 1, [&](std::int64_t r, std::int64_t) {
    const std::int64_t begin = range(r), end = range(r + 1);
    Offset* const here = start.data() + begin;
    const std::uint64_t size = static_cast<std::uint64_t>(end - begin);
    // Starts, moved on while the items come: what is left are the ends, each the start of the next group.
    Offset sum = total[r];
    for (std::uint64_t k = 0; k < size; ++k) {
      const Offset count = here[k];
      here[k] = sum;
      sum += count;
    }
    for_each([&](std::int64_t key, const Item& item) {
      if (const std::uint64_t at = static_cast<std::uint64_t>(key - begin); at < size)
        items[here[at]++] = item;
    });
    for (std::uint64_t k = size; k-- > 1;) here[k] = here[k - 1];
    if (size > 0) here[0] = total[r];
  });
  start[groups] = total[ranges];
}

// As parallel_sort() where `<` compares keys first: faster when groups are small. 0 <= key(item) < groups.
template <class T, class Key>
void parallel_sort_groups(std::vector<T>& list, std::int64_t groups, Key&& key) {
  constexpr std::int64_t grain = 4096;
  RawVector<std::int64_t> start;
  RawVector<T> sorted;
  group_items(groups, start, sorted, [&](auto visit) {
    for (const T& item : list) visit(key(item), item);
  });
  parallel_for(groups, grain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t g = begin; g < end; ++g)
      std::sort(sorted.begin() + start[g], sorted.begin() + start[g + 1]);
    std::copy(sorted.begin() + start[begin], sorted.begin() + start[end], list.begin() + start[begin]);
  });
}

// As std::sort; equal elements must not be told apart. Blocks of a fixed size are sorted, then merged.
template <class T>
void parallel_sort(std::vector<T>& list) {
  constexpr std::int64_t block = 1 << 15;
  const std::int64_t n = static_cast<std::int64_t>(list.size());
  const auto at = [&](std::int64_t i) { return list.begin() + std::min(i, n); };
  parallel_for(n, block, [&](std::int64_t begin, std::int64_t end) { std::sort(at(begin), at(end)); });
  for (std::int64_t width = block; width < n; width *= 2)
    parallel_for((n + 2 * width - 1) / (2 * width), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i)
        std::inplace_merge(at(2 * i * width), at((2 * i + 1) * width), at((2 * i + 2) * width));
    });
}

}  // namespace overtet
