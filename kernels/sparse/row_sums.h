// One row of a sparse matrix while it is summed: what is added to a column twice is added up. Sums are made
// in the order in which they come, so that a row is the same bytes whoever makes it.
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "overtet/types.h"

namespace overtet {

// A table of open addresses, never more than half full, that is emptied by take().
class RowSums {
 public:
  RowSums() { grow(); }

  void add(Index column, double value) {
    std::size_t at = place(column);
    while (slot_[at].column != column) {
      if (slot_[at].column < 0) {
        slot_[at] = {column, 0};
        columns_.push_back(column);
        if (2 * columns_.size() > slot_.size()) {
          grow();
          at = place(column);
          while (slot_[at].column != column) at = next(at);
        }
        break;
      }
      at = next(at);
    }
    slot_[at].value += value;
  }

  // Appends the row, by column, and is empty then. Returns how many entries there are.
  Index take(std::vector<Index>& columns, std::vector<double>& values) {
    std::sort(columns_.begin(), columns_.end());
    const auto count = static_cast<Index>(columns_.size());
    for (const Index column : columns_) {
      std::size_t at = place(column);
      while (slot_[at].column != column) at = next(at);
      columns.push_back(column);
      values.push_back(slot_[at].value);
    }
    clear();
    return count;
  }

 private:
  struct Slot {
    Index column = -1;
    double value = 0;
  };
  std::size_t place(Index column) const {
    return (static_cast<std::uint32_t>(column) * 2654435769u) >> shift_;  // Fibonacci hashing
  }
  std::size_t next(std::size_t at) const { return (at + 1) & (slot_.size() - 1); }
  void clear() {
    // Every slot of a run of columns is theirs, so that emptying each one's own run empties the table.
    if (8 * columns_.size() > slot_.size()) {
      std::fill(slot_.begin(), slot_.end(), Slot{});
    } else {
      for (const Index column : columns_)
        for (std::size_t at = place(column); slot_[at].column >= 0; at = next(at)) slot_[at] = Slot{};
    }
    columns_.clear();
  }
  void grow() {
    std::vector<Slot> old = std::move(slot_);
    slot_.assign(old.empty() ? 128 : 2 * old.size(), Slot{});
    shift_ = old.empty() ? 32 - 7 : shift_ - 1;
    for (const Slot& s : old) {
      if (s.column < 0) continue;
      std::size_t at = place(s.column);
      while (slot_[at].column >= 0) at = next(at);
      slot_[at] = s;
    }
  }

  std::vector<Slot> slot_;
  std::vector<Index> columns_;
  int shift_ = 0;  // 32 - the logarithm of how many slots there are
};

}  // namespace overtet
