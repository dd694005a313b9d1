// Borders that lie beside each other brought to the very same places. The clean-up, which merges what lies in
// one place where that closes edges, does the rest; what it did not merge goes back to where it was.
//
// CGAL 5.5 has something like it (Polygon_mesh_processing/internal/Snapping), which is not part of its manual
// and wants the whole surface as a half-edge structure.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <utility>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/prepare/working_surface.h"

namespace overtet {

struct Joined {
  // Vertices that have been put where another one is, and where they were; ascending.
  std::vector<std::pair<Index, Eigen::Vector3d>> moved;
};

// Vertices on borders that are no farther apart than `distance` are put where the one with the smallest
// number is; none moves farther. O(n log n) for n border vertices. Errors: limit, interrupted.
Result<Joined> put_together(WorkingSurface& working, double distance, const RunContext& context);

// Edges on borders are split at the vertices of other edges that lie within `distance` of them; pieces of a
// face come last. A new vertex lies exactly where the other one does. Returns how many edges were split.
std::int64_t split_at_vertices(WorkingSurface& working, double distance);

// After a clean-up: vertices that were not merged with another one are put back. Returns how many were
// merged.
std::int64_t put_back(const Joined& joined, const Cleanup& cleaned, Surface& surface);

}  // namespace overtet
