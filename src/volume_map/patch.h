// A part of the mesh whose vertices move together, and Newton steps on it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "overtet/types.h"
#include "src/tet_complex/tet_complex.h"

namespace overtet::volume_map_detail {

// A boundary edge whose interior dihedral angle is driven to a value; a, b < target rows.
struct AngleGoal {
  Index a, b;
  double angle;
};

struct Patch {
  std::vector<Index> free;   // vertices that move, ascending
  std::vector<Index> tets;   // with a free corner, ascending
  std::vector<double> size;  // per tet: the edge length that makes its volume 1 (for eps > 0)
  std::vector<AngleGoal> goals;
};

struct PatchForces {
  double eps = 0;   // of the shape energy, relative to each tet's size; 0: barrier
  double pull = 0;  // of free boundary vertices to the target
  const std::vector<double>* weights = nullptr;  // of the pull, by boundary vertex; null: all 1
  double angle_weight = 0;

  double pull_at(Index v) const { return weights ? pull * (*weights)[v] : pull; }
};

class PatchSolver {
 public:
  // target: of the boundary vertices (the first rows); length: per vertex, the unit of distances.
  PatchSolver(const VertexMatrix& target, const std::vector<double>& length);

  // The free vertices within rings of the seeds: interior ones within `interior_rings`, boundary ones
  // within `boundary_rings` where may_move says so. One patch for each connected group, in the order of
  // their smallest vertex.
  std::vector<Patch> grow(const TetComplex& mesh, const std::vector<Index>& seeds, int interior_rings,
                          int boundary_rings, const std::vector<char>& may_move);

  double energy(const TetComplex& mesh, const Patch& patch, const PatchForces& forces) const;

  // One Newton step with line search. positions: of patch.free after the step. With eps = 0 every tet is
  // positive on the whole straight way there (up to rounding). False: no descent.
  bool step(const TetComplex& mesh, const Patch& patch, const PatchForces& forces,
            std::vector<Eigen::Vector3d>& positions);

  // The interior angle at the boundary edge a-b: the sum over its tets. 0 when there is no such edge.
  static double interior_angle(const TetComplex& mesh, Index a, Index b);

 private:
  struct Ring {  // tets of a goal's edge as (a, b, c, d)
    std::vector<std::array<Index, 4>> corners;
    double goal;
  };
  std::vector<Ring> rings(const TetComplex& mesh, const Patch& patch) const;
  double energy_at(const TetComplex& mesh, const Patch& patch, const PatchForces& forces,
                   const std::vector<Ring>& rings, const std::vector<Eigen::Vector3d>& moved) const;

  const VertexMatrix& target_;
  const std::vector<double>& length_;
  mutable std::vector<Index> local_;  // per vertex: its place in patch.free or -1
};

}  // namespace overtet::volume_map_detail
