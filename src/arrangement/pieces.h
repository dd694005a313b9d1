// Inside the arrangement: the triangles of the complex while it is being cut.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "src/arrangement/arrangement.h"

namespace overtet {

// A triangle of the growing complex with the input faces that run along it.
struct Piece {
  std::array<Index, 3> corners;
  ArrangementSheet sheet;
  std::vector<ArrangementSheet> more;  // only where faces coincide
  bool cut = false;                    // part of a face that was cut, or next to one that changed
  bool fresh = true;  // changed since it was last compared with all others (tolerant_cutter.h)
};

}  // namespace overtet
