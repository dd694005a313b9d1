// Which points lie near each other: a tree of cuts across the axes, each at the median (Bentley,
// "Multidimensional binary search trees used for associative searching", 1975). Any points, also many in one
// place.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <limits>
#include <vector>

#include "overtet/types.h"

namespace overtet {

class NearPoints {
 public:
  // O(n log n). pre: all coordinates are finite. The points are copied, by a power of two nearer to 1, so
  // that squares of distances neither overflow nor vanish.
  explicit NearPoints(const VertexMatrix& points);

  // The numbers of all points within this distance of p, ascending. (Distances are rounded; 0: exactly
  // there.)
  void within(const Eigen::Vector3d& p, double distance, std::vector<Index>& found) const;

  // Of all pairs of points.
  struct Closest {
    std::int64_t coincident = 0;  // points exactly in one place with another one
    double distance = std::numeric_limits<double>::infinity();  // of the closest two, rounded; 0: exactly
    Index a = -1, b = -1;                                       // two that are as near as that, a < b
  };
  // Nearly linear: each point's search goes no further than the closest pair so far. The same on any number
  // of threads.
  Closest closest() const;

 private:
  struct Point {
    Eigen::Vector3d at;
    Index number;
  };
  struct Best;
  void build(std::int64_t begin, std::int64_t end);
  void visit_within(std::int64_t begin, std::int64_t end, const Eigen::Vector3d& p, double squared,
                    std::vector<Index>& found) const;
  void look(std::int64_t begin, std::int64_t end, const Point& p, Best& best) const;

  std::vector<Point> points_;  // in the order of the tree; the point at a cut is in the middle of its range
  int exponent_ = 0;           // the points are the caller's times 2 to this
  std::vector<signed char> axis_;  // of the cut at the middle of a range, by that place
};

}  // namespace overtet
