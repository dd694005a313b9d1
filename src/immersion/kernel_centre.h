// A point well inside the kernel of a star: the region from which every wall of the star is seen from the
// inside.
//
// The point is the analytic centre, the maximum of the product of the distances from all planes. It follows
// affine maps, so a kernel that is as thin as the digits allow costs no more steps than a round one. Source:
// Boyd and Vandenberghe, "Convex Optimization", 8.5.3 (analytic centre) and 11.4.1 (the first phase, which
// finds a point inside at all by pushing the least distance up).
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

namespace overtet {

// Three corners of a wall, counter-clockwise seen from inside.
using Wall = std::array<Eigen::Vector3d, 3>;

// The way from `start` to the centre, or none where the walls leave nothing open that doubles can tell. The
// planes are computed relative to `start` with twice the digits, which matters where walls are needles.
// Nothing here is exact: who moves a point there confirms each tet.
std::optional<Eigen::Vector3d> kernel_centre(const std::vector<Wall>& walls, const Eigen::Vector3d& start);

}  // namespace overtet
