// Faces of a surface cut into smaller ones at given points and along given edges, the shape staying the same
// up to the rounding of the points.
//
// Where points lie is decided on a grid of whole barycentric coordinates: that of a face's corners is
// kFaceGrid. So a point on an edge lies on it exactly, on both sides, whatever its coordinates in space are
// rounded to; edges cross or do not, exactly.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <vector>

#include "overtet/result.h"
#include "overtet/types.h"
#include "src/mesh/topology.h"

namespace overtet {

// The finest for which twice the area of a triangle on it fits into 64 bits.
constexpr std::int64_t kFaceGrid = std::int64_t{1} << 30;

// A point inside a face, or inside one of its edges, where one weight is 0. The weights are not negative, at
// least two are positive, and their sum is kFaceGrid.
struct FacePoint {
  Index face = -1;
  std::array<std::int64_t, 3> weight{};  // of the face's corners
};

// An edge between two vertices of the surface or added points (#V + i: the i-th) of one face.
struct FaceEdge {
  Index face = -1, a = -1, b = -1;
};

struct Subdivision {
  Surface surface;            // the vertices come first, then the points
  std::vector<Index> face;    // of each face: the one that it is, or is a piece of; increasing
  std::vector<Index> pieced;  // faces that were cut, sorted
};

Eigen::Vector3d place_in_space(const Surface& surface, const FacePoint& point);
// The same point, as the face on the other side of its edge has it. pre: one weight is 0.
FacePoint seen_from_other_side(const SurfaceTopology& topology, const FacePoint& point);

// Faces without points stay as they are. In the others the edges given are edges of the result; the rest is
// chosen short edges first. Errors: internal (points coincide, or edges cross).
Result<Subdivision> subdivide(const Surface& surface, const SurfaceTopology& topology,
                              const std::vector<FacePoint>& points, const std::vector<FaceEdge>& edges);

}  // namespace overtet
