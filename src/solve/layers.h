// Points, segments and triangles in tet meshes that overlap themselves: found by going from tet to tet, so
// that they stay in one layer. Internal to src/solve.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "kernels/bvh/box_tree.h"
#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet::solve_detail {

using Barycentric = std::array<double, 4>;

// What of a tet belongs to a trace: a corner counts (its bit) where its barycentric coordinate is not nearly
// 0.
struct Crossed {
  Index tet = 0;
  unsigned corners = 0;
  double begin = 0, end = 1;  // of a segment, the part of it in the tet
};

class Layers {
 public:
  // pre: every tet is positive. Errors: bad_input (a face of more than two tets).
  static Result<Layers> of(const TetMesh& mesh);

  // The tets that contain a point, by layer: tets of one layer hang together over faces that have the point.
  // Layers come in the order of their smallest tets.
  std::vector<std::vector<Index>> at(const Eigen::Vector3d& p) const;
  std::vector<Index> around(Index vertex) const;  // the tets that have it

  // The tets along p + s (q - p), 0 <= s <= 1, from those of `begin`, which contain p, as far as the solid
  // goes without a break. Tets that the segment only touches are among them.
  std::vector<Crossed> segment(const Eigen::Vector3d& p, const Eigen::Vector3d& q,
                               const std::vector<Index>& begin) const;

  // The same of a triangle. leaves: a point of it where it leaves the solid, if it does.
  std::vector<Crossed> triangle(const std::array<Eigen::Vector3d, 3>& corners,
                                const std::vector<Index>& begin,
                                std::optional<Eigen::Vector3d>& leaves) const;

  Barycentric in(Index tet, const Eigen::Vector3d& p) const;

 private:
  explicit Layers(const TetMesh& mesh) : mesh_(&mesh) {}

  const TetMesh* mesh_;
  BoxTree boxes_;
  TetMatrix neighbour_;  // beyond the face without corner k; -1: none
};

}  // namespace overtet::solve_detail
