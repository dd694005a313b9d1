// The Delaunay tetrahedra of points, as plain arrays.
#pragma once

#include <array>
#include <functional>
#include <memory>

#include "kernels/parallel/raw_vector.h"
#include "overtet/types.h"

namespace overtet {

// Tets with neighbours: next[t][k] is the tet beyond the face opposite to corner k, or -1.
struct TetArrays {
  RawVector<std::array<Index, 4>> tet, next;
};

// The Delaunay tets of points that come in lots: what is known early can be inserted while the rest is being
// computed. The tets do not depend on the lots, their order does.
//
// Serial but for tets(); O(n log n) for points spread over a surface. Decisions are exact. Points on common
// spheres are told apart by their coordinates (symbolic perturbation), so the answer depends on the points,
// their order and the lots only.
class DelaunayBuilder {
 public:
  DelaunayBuilder();
  ~DelaunayBuilder();
  DelaunayBuilder(DelaunayBuilder&&) noexcept;
  DelaunayBuilder& operator=(DelaunayBuilder&&) noexcept;

  // points: n rows of three finite doubles; they get the numbers that follow. False, and all is as at the
  // beginning, where two points are alike, or when stop() has said so (it is asked every few thousand
  // points).
  bool insert(const double* points, Index n, const std::function<bool()>& stop);

  // How many there are.
  Index points() const;

  // They fill the convex hull, all of them exactly positive. Empty when all points lie in a plane.
  TetArrays tets() const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

// The same of one lot. points: no two alike. Empty also when stop() has said so.
TetArrays delaunay(const double* points, Index n, const std::function<bool()>& stop);

}  // namespace overtet
