#include "src/opening/angle_bounds.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/tet_energy/tet_quality.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

// A face at an edge, which it runs along from a to b.
struct EdgeOfFace {
  Index low, high;  // a and b, sorted
  Index a, b, opposite;
  bool operator<(const EdgeOfFace& o) const { return low != o.low ? low < o.low : high < o.high; }
};

std::vector<EdgeOfFace> edges_of(const TriangleMatrix& F) {
  std::vector<EdgeOfFace> edges;
  edges.reserve(3 * static_cast<std::size_t>(F.rows()));
  for (Index f = 0; f < F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Index a = F(f, k), b = F(f, (k + 1) % 3);
      edges.push_back({std::min(a, b), std::max(a, b), a, b, F(f, (k + 2) % 3)});
    }
  std::stable_sort(edges.begin(), edges.end());
  return edges;
}

class Bounds {
 public:
  Bounds(const TetMesh& mesh, const TriangleMatrix& F, const VertexMatrix& home, double reach)
      : mesh_(mesh), home_(home), reach_(reach), edges_(edges_of(F)), angle_(edges_.size(), 0) {}

  AngleBounds run() {
    sum_angles();
    AngleBounds out;
    for (std::size_t i = 0; i + 1 < edges_.size(); i += 2) {
      const EdgeOfFace &one = edges_[i], &other = edges_[i + 1];
      const bool ends = moved(one.a) || moved(one.b);
      const bool opposite = moved(one.opposite) || moved(other.opposite);
      const auto lower = [](double& bound, double radians) {
        bound = std::min(bound, radians * 180 / std::numbers::pi);
      };
      const double angle = angle_[i];
      lower(ends || opposite ? out.as_moved : out.elsewhere, angle);
      if (opposite && !ends) lower(out.at_moved, angle + opens(one) + opens(other));
    }
    return out;
  }

 private:
  bool moved(Index v) const { return mesh_.V.row(v) != home_.row(v); }
  Vector3d at(Index v) const { return mesh_.V.row(v); }

  // The interior angle at each edge, with its extra turns: at the first of its two faces in the list.
  void sum_angles() {
    for (Index t = 0; t < mesh_.T.rows(); ++t) {
      const std::array<Index, 4> c = {mesh_.T(t, 0), mesh_.T(t, 1), mesh_.T(t, 2), mesh_.T(t, 3)};
      std::array<double, 6> angles{};
      bool known = false;
      for (std::size_t e = 0; e < 6; ++e) {
        const Index a = c[static_cast<std::size_t>(kTetEdge[e][0])],
                    b = c[static_cast<std::size_t>(kTetEdge[e][1])];
        if (a >= mesh_.surface_vertices || b >= mesh_.surface_vertices) continue;
        const EdgeOfFace key{std::min(a, b), std::max(a, b), a, b, 0};
        const auto found = std::lower_bound(edges_.begin(), edges_.end(), key);
        if (found == edges_.end() || key < *found) continue;
        if (!known) angles = dihedral_angles(at(c[0]), at(c[1]), at(c[2]), at(c[3]));
        known = true;
        angle_[static_cast<std::size_t>(found - edges_.begin())] += angles[e];
      }
    }
  }

  // By how much the angle at the edge can grow when the face's opposite vertex goes elsewhere in its ball.
  double opens(const EdgeOfFace& e) const {
    if (!moved(e.opposite)) return 0;
    const Vector3d a = at(e.a), axis = (at(e.b) - a).normalized();
    const auto across = [&](const Vector3d& p) -> Vector3d { return p - a - axis.dot(p - a) * axis; };
    const Vector3d now = across(at(e.opposite)), home = across(home_.row(e.opposite).transpose());
    if (!(reach_ < home.norm())) return std::numbers::pi;
    return std::atan2(axis.dot(now.cross(home)), now.dot(home)) + std::asin(reach_ / home.norm());
  }

  const TetMesh& mesh_;
  const VertexMatrix& home_;
  const double reach_;
  const std::vector<EdgeOfFace> edges_;
  std::vector<double> angle_;
};

}  // namespace

AngleBounds angle_bounds(const TetMesh& mesh, const TriangleMatrix& F, const VertexMatrix& home,
                         double reach) {
  OVERTET_EXPECTS(mesh.surface_vertices == home.rows());
  return Bounds(mesh, F, home, reach).run();
}

}  // namespace overtet
