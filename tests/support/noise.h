// Surfaces with every coordinate moved at random: at hinges this makes all that can go wrong there.
#pragma once

#include <cstdint>
#include <random>

#include "tests/support/models.h"

namespace overtet::test {

// Each coordinate moves by at most half the amplitude.
inline Surface noisy(Surface s, std::uint64_t seed, double amplitude) {
  std::mt19937_64 random(seed);
  for (Eigen::Index i = 0; i < s.V.size(); ++i)
    s.V.data()[i] += amplitude * (static_cast<double>(random() >> 11) * 0x1p-53 - 0.5);
  return s;
}

// Elbows whose hinges have odd integers that nothing pairs, though the winding is nowhere negative.
// number: 0 to 3.
inline Surface obstructed_elbow(int number) {
  constexpr int kSeeds[] = {11, 31, 75, 145};
  const int seed = kSeeds[number];
  return noisy(elbow(150, 8 + seed % 5), static_cast<std::uint64_t>(seed), 0.02 + 0.2 * (seed % 7) / 7);
}

}  // namespace overtet::test
