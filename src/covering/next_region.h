// Which open region the search for gluings takes next: a tree of their numbers of options.
#pragma once

#include <algorithm>
#include <compare>
#include <cstddef>
#include <limits>
#include <vector>

namespace overtet {

// The open regions of a part, ready to say which comes next: one without options, the first of them; else the
// one with the fewest, of these one with the most changes next to it, of these the first.
class NextRegion {
 public:
  explicit NextRegion(std::size_t regions) {
    while (leaves_ < regions) leaves_ *= 2;
    keys_.assign(2 * leaves_, kOut);
  }

  void set(std::size_t i, double options, int changes) {
    put(i, {options, options > 0 ? -changes : 0, static_cast<std::ptrdiff_t>(i)});
  }
  void take_out(std::size_t i) { put(i, kOut); }

  bool none() const { return keys_[1] == kOut; }
  bool stuck() const { return keys_[1].options == 0; }
  std::size_t next() const { return static_cast<std::size_t>(keys_[1].region); }

 private:
  struct Key {
    double options;
    int changes;  // negative, so that more come first
    std::ptrdiff_t region;
    auto operator<=>(const Key&) const = default;
  };
  static constexpr Key kOut{std::numeric_limits<double>::infinity(), 0, 0};

  void put(std::size_t i, const Key& key) {
    std::size_t at = leaves_ + i;
    for (keys_[at] = key; at > 1; at /= 2) keys_[at / 2] = std::min(keys_[at], keys_[at ^ 1]);
  }

  std::size_t leaves_ = 1;
  std::vector<Key> keys_;  // of a binary tree, each the smaller of two; the root has number 1
};

}  // namespace overtet
