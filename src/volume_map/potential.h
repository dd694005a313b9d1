// The pull on a vertex that is away from its target: in proportion to the distance, and where it has a reach,
// far more from there on.
#pragma once

#include <algorithm>
#include <cmath>

#include "src/volume_map/tuning.h"

namespace overtet::volume_map_detail {

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
