// A part of the mesh whose vertices move together, and Newton steps on it.
#pragma once

#include <Eigen/Core>
#include <array>
#include <memory>
#include <vector>

#include "kernels/sparse/cholesky.h"
#include "overtet/types.h"
#include "src/mesh/tet_complex.h"

namespace overtet::volume_map_detail {

// A boundary edge whose interior dihedral angle, the sum over its tets, is driven to a value.
struct AngleGoal {
  Index a, b;
  double angle;
  std::vector<std::array<Index, 4>> ring;  // its tets as (a, b, c, d)
};

struct Patch {
  std::vector<Index> free;  // vertices that move, ascending
  std::vector<Index> tets;  // with a free corner, ascending
  std::vector<AngleGoal> goals;
};

// The free vertices within rings of the seeds: interior ones within `interior_rings`, boundary ones (the
// first `boundary`) within `boundary_rings` where may_move says so. One patch for each connected group, in
// the order of their smallest vertex. No two patches share a tet.
std::vector<Patch> grow_patches(const TetComplex& mesh, Index boundary, const std::vector<Index>& seeds,
                                int interior_rings, int boundary_rings, const std::vector<char>& may_move);

// The tets around the edge a-b as corners (a, b, c, d); none when there is no such edge.
std::vector<std::array<Index, 4>> edge_ring(const TetComplex& mesh, Index a, Index b);

// The interior angle at the boundary edge a-b: the sum over its tets. 0 when there is no such edge.
double interior_angle(const TetComplex& mesh, Index a, Index b);

struct PatchForces {
  double pull = 0;  // of free boundary vertices to the target, relative to the shape energy of a tet
  // > 0: vertices about as far from their targets as this, and further, are pulled more than in proportion
  // to the distance: a potential with its own Hessian, so that steps do not overshoot.
  double reach = 0;
  double angle_weight = 0;
};

// Newton steps on one patch, on a copy of its part of the mesh: patches that share no tet may be stepped by
// several threads at the same time. The work inside a step is shared out as well; same bytes on any number.
class PatchNewton {
 public:
  // target: of the boundary vertices (the first rows); length: per vertex, the unit of distances.
  // All arguments must outlive it; the mesh is read by the constructor only.
  PatchNewton(const TetComplex& mesh, const Patch& patch, const VertexMatrix& target,
              const std::vector<double>& length);

  double energy(const PatchForces& forces) const;

  // One step with line search. Every tet is positive on the whole straight way there (up to rounding) and
  // exactly positive at its end. False: no descent; nothing changes.
  bool step(const PatchForces& forces);

  // Of patch.free.
  std::vector<Eigen::Vector3d> positions() const { return {at_.begin(), at_.begin() + free_}; }

  // What the steps so far have cost: the same on every machine.
  double work() const { return work_; }

 private:
  using Corners = std::array<Index, 4>;
  struct Ring {
    std::vector<Corners> corners;
    double goal;
  };

  bool is_free(Index v) const { return v < free_; }
  // Where the block of two free vertices (row >= column) begins in each of its columns.
  struct Block {
    int column[3];
    bool diagonal;
  };
  Block block(Index row, Index column) const;
  bool analyze();
  double assemble(const PatchForces& forces, const std::vector<double>& weights);
  double energy_at(const PatchForces& forces, const std::vector<double>& weights,
                   const std::vector<Eigen::Vector3d>& at) const;
  std::vector<double> weights(const PatchForces& forces) const;
  enum class Moment { on_the_way, at_the_end };
  bool all_positive(const std::vector<Eigen::Vector3d>& to, Moment when) const;

  const Patch& patch_;
  const VertexMatrix& target_;
  const std::vector<double>& length_;
  Index free_ = 0;                   // vertices 0 .. free_ - 1 of at_ are patch.free, the others are held
  std::vector<Eigen::Vector3d> at_;  // positions now
  std::vector<Corners> tets_;
  std::vector<Ring> rings_;
  // In blocks of 3 x 3, lower triangle: those of column c have the rows block_rows[block_start[c] ...].
  struct Hessian {
    std::vector<Index> block_start, block_rows;
    SymmetricMatrix matrix;
  };
  Hessian hessian_;
  Eigen::VectorXd gradient_;
  SparseCholesky factor_;
  bool analyzed_ = false;
  double work_ = 0;
};

}  // namespace overtet::volume_map_detail
