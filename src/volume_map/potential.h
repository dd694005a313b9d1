// The pull on a vertex that is away from its target: in proportion to the distance, and where it has a reach,
// far more from there on.
#pragma once

#include <algorithm>
#include <cmath>

namespace overtet::volume_map_detail {

// At the reach the pull is so much stronger than in proportion; and so much at most. It grows with this power
// of the squared distance.
constexpr double kFarPull = 10, kMostFarPull = 1e4;
constexpr int kFarPower = 8;

// What a squared distance costs, and its first two derivatives by the squared distance.
struct Potential {
  double value, slope, bend;
};

inline Potential potential(double squared, double reach) {
  if (!(reach > 0)) return {squared, 1, 0};
  static const double most = std::pow(kMostFarPull / kFarPull, 1.0 / kFarPower);
  const double unit = reach * reach, r = squared / unit, q = std::min(r, most);
  const double far = kFarPull * std::pow(q, kFarPower), slope = 1 + far;
  return {unit * (q + far * q / (kFarPower + 1) + slope * (r - q)), slope,
          r < most ? kFarPower * far / (q > 0 ? q : 1) / unit : 0};
}

}  // namespace overtet::volume_map_detail
