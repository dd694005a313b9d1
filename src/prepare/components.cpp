#include <algorithm>

#include "kernels/core/union_find.h"
#include "src/prepare/steps.h"

namespace overtet {

namespace {

double area_of(const Surface& s, Index f) {
  const Eigen::Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
  return (b - a).cross(c - a).norm() / 2;
}

}  // namespace

StepOutcome drop_components(WorkingSurface& working, Index fewest_faces, bool largest_only) {
  Surface& s = working.surface;
  UnionFind sets(static_cast<std::size_t>(s.V.rows()));
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 1; k < 3; ++k) sets.join_smaller(s.F(f, 0), s.F(f, k));
  std::vector<Index> faces(s.V.rows(), 0);  // by root
  std::vector<double> area(s.V.rows(), 0);
  for (Index f = 0; f < s.F.rows(); ++f) {
    const Index root = sets.root(s.F(f, 0));
    ++faces[root];
    area[root] += area_of(s, f);
  }
  const auto largest = static_cast<Index>(std::max_element(area.begin(), area.end()) - area.begin());
  const auto goes = [&](Index root) {
    return root != largest && (largest_only || faces[root] < fewest_faces);
  };
  StepOutcome out;
  std::int64_t components = 0;
  for (Index v = 0; v < s.V.rows(); ++v) {
    if (faces[v] == 0) continue;
    ++components;
    if (goes(v)) ++out.done;
  }
  Index n = 0;
  const Index given = static_cast<Index>(s.F.rows());
  for (Index f = 0; f < given; ++f) {
    if (goes(sets.root(s.F(f, 0)))) continue;
    if (n != f) s.F.row(n) = s.F.row(f), working.face_of[n] = working.face_of[f];
    ++n;
  }
  s.F.conservativeResize(n, 3);
  working.face_of.resize(n);
  out.figures = {{"components", components}, {"faces", std::int64_t{given - n}}};
  return out;
}

}  // namespace overtet
