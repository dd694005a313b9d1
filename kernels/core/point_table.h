// Numbers for points: equal points get one number. An open hash table (linear probing).
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <vector>

#include "overtet/types.h"

namespace overtet {

// Points are numbered 0, 1, ... in the order in which they first come. Equal means equal as numbers: -0 is 0.
// pre: coordinates are finite.
class PointTable {
 public:
  // expected: about how many different points will come.
  explicit PointTable(std::size_t expected) {
    std::size_t size = 64;
    while (size < 2 * expected) size *= 2;
    slots_.assign(size, {});
  }

  Index number_of(const double* point) {
    const std::array<double, 3> p{point[0] + 0.0, point[1] + 0.0, point[2] + 0.0};  // -0 becomes 0
    const std::uint64_t h = hash(p);
    if (3 * size() > 2 * static_cast<Index>(slots_.size())) grow();
    const std::size_t mask = slots_.size() - 1;
    const auto tag = static_cast<std::uint32_t>(h >> 32);
    for (std::size_t at = h & mask;; at = (at + 1) & mask) {
      Slot& slot = slots_[at];
      if (slot.number < 0) {
        slot = {size(), tag};
        xyz_.insert(xyz_.end(), p.begin(), p.end());
        return slot.number;
      }
      if (slot.tag == tag &&
          std::memcmp(&xyz_[3 * static_cast<std::size_t>(slot.number)], p.data(), sizeof p) == 0)
        return slot.number;
    }
  }

  Index size() const { return static_cast<Index>(xyz_.size() / 3); }
  // Three numbers a point, with 0 for -0.
  const std::vector<double>& xyz() const { return xyz_; }
  std::vector<double> take_xyz() { return std::move(xyz_); }

 private:
  struct Slot {
    Index number = -1;
    std::uint32_t tag = 0;  // upper bits of the hash: most unequal points differ here
  };

  static std::uint64_t hash(const std::array<double, 3>& p) {
    std::uint64_t h = 0;
    for (const double x : p) {
      h ^= std::bit_cast<std::uint64_t>(x);
      h *= 0x9E3779B97F4A7C15ull;
      h ^= h >> 29;
    }
    h *= 0xBF58476D1CE4E5B9ull;
    return h ^ (h >> 32);
  }

  void grow() {
    slots_.assign(2 * slots_.size(), {});
    const std::size_t mask = slots_.size() - 1;
    for (Index v = 0; v < size(); ++v) {
      std::array<double, 3> p;
      std::memcpy(p.data(), &xyz_[3 * static_cast<std::size_t>(v)], sizeof p);
      const std::uint64_t h = hash(p);
      std::size_t at = h & mask;
      while (slots_[at].number >= 0) at = (at + 1) & mask;
      slots_[at] = {v, static_cast<std::uint32_t>(h >> 32)};
    }
  }

  std::vector<Slot> slots_;
  std::vector<double> xyz_;
};

}  // namespace overtet
