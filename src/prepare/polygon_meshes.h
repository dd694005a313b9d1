// What CGAL's Polygon Mesh Processing does for the steps, on plain data: small surfaces with borders.
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

#include "overtet/types.h"

namespace overtet {

enum class Filling { faired, refined, plain };

struct FilledHole {
  std::vector<Eigen::Vector3d> points;      // new ones
  std::vector<std::array<Index, 3>> faces;  // a vertex of the surface, or -1 - i for points[i]
};

// Fills the hole with these vertices, in the order in which the faces beside it run. None where CGAL finds no
// filling, one that is not finite, or the surface is not manifold there. (Other holes may have vertices in
// common with it.) `refined`: with new vertices, as dense as around the hole; `faired`: they go on from the
// faces around it smoothly, too.
std::optional<FilledHole> filled(const Surface& around, const std::vector<Index>& hole, Filling filling);

struct NeedleLimits {
  double degrees = 1;  // a face with an angle below that is a needle
  double move = 0;     // of an edge that is collapsed, and of the surface where one is flipped: a length
};

// The faces after needles have been collapsed and flipped, by their old numbers; {-1, -1, -1}: gone. No
// vertex moves; the `fixed` ones (by vertex) stay. Empty where the surface is not manifold.
std::vector<std::array<Index, 3>> without_needles(const Surface& around, const std::vector<char>& fixed,
                                                  const NeedleLimits& limits);

}  // namespace overtet
