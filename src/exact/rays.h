// Exact signed crossings of rays with a surface, and winding numbers. For .cpp files only.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "kernels/bvh/bvh.h"
#include "overtet/types.h"
#include "src/exact/rational.h"

namespace overtet::exact {

enum class RayStatus { counted, grazes, starts_on_surface };

struct RayCount {
  RayStatus status = RayStatus::counted;
  int winding = 0;                  // signed crossings: the winding number just ahead of the start
  std::optional<Rational> nearest;  // parameter of the first crossing, when asked for
};

enum class RayQuestion { winding, winding_and_nearest };

// By rational arithmetic behind a floating-point filter. What it is made of must outlive it.
class Rays {
 public:
  Rays(const VertexMatrix& V, const TriangleMatrix& F, const TriangleBvh& bvh);

  // Directions may have any length, also one that no double can hold.
  //
  // The ray from m along d, tilted by an infinitesimal amount towards `tilt` when that is given. Faces in
  // `skip` (sorted) are not counted: those that contain m. m then may lie on the surface.
  RayCount count(const Point& m, const Point& d, const Point* tilt, const std::vector<Index>& skip,
                 RayQuestion question = RayQuestion::winding) const;

  // How the line from m along d passes face f: 1 or -1 through its inside, leaving or entering; 0 not at
  // all; kGrazes through its border or in its plane.
  static constexpr int kGrazes = 2;
  int passes(const Point& m, const Point& d, Index f) const;

  // The height of m over face f's plane, times twice f's area: in doubles, wrong by `error` at most
  // (infinity outside the range of the filter); and its sign, exact: 1 in front of the face.
  double height(const Point& m, Index f, double& error) const;
  int side(const Point& m, Index f) const;
  // Where the line through a and b meets face f's plane: 0 at a, 1 at b. pre: a and b differ in height.
  Rational cut(const Point& a, const Point& b, Index f) const;

  // The winding number of m, or none when m lies on the surface.
  std::optional<int> winding(const Point& m) const;

  // All faces that contain m, sorted.
  std::vector<Index> faces_at(const Point& m) const;

  const double* corner(Index f, int k) const { return V_.data() + 3 * std::int64_t{F_(f, k)}; }
  const TriangleMatrix& F() const { return F_; }
  const VertexMatrix& V() const { return V_; }
  Vec normal(Index f) const;                         // (b - a) x (c - a), exact
  Whole whole_normal(Index f) const;                 // times a positive number
  std::array<double, 3> unit_normal(Index f) const;  // in doubles, for choosing directions only

 private:
  struct Line;
  struct Corners;
  int passes(Line& line, Corners& corners, Index f) const;

  const VertexMatrix& V_;
  const TriangleMatrix& F_;
  const TriangleBvh& bvh_;
  double scale_ = 1;  // the largest coordinate
  bool filter_ = true;
};

// A deterministic sequence of numbers in (-1, 1) for directions; k = 0, 1, 2, ...
double scatter(int k);

}  // namespace overtet::exact
