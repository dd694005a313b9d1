#include "src/improve/set_apart.h"

#include <algorithm>
#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "kernels/near_points/near_points.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/improve/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

// The longest edge at each vertex.
std::vector<double> longest_edges(const TetMesh& mesh) {
  // Lengths are not negative: their order is that of their bits.
  std::vector<std::uint64_t> bits(static_cast<std::size_t>(mesh.V.rows()), 0);
  const auto raise = [&](Index v, std::uint64_t to) {
    const std::atomic_ref all(bits[v]);
    for (std::uint64_t known = all.load(std::memory_order_relaxed);
         known < to && !all.compare_exchange_weak(known, to, std::memory_order_relaxed);) {
    }
  };
  parallel_for(mesh.T.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t)
      for (const auto& [i, j] : kTetEdge) {
        const Index v = mesh.T(t, i), w = mesh.T(t, j);
        const auto length = std::bit_cast<std::uint64_t>((mesh.V.row(v) - mesh.V.row(w)).norm());
        raise(v, length), raise(w, length);
      }
  });
  std::vector<double> longest(bits.size());
  for (std::size_t v = 0; v < bits.size(); ++v) longest[v] = std::bit_cast<double>(bits[v]);
  return longest;
}

// Of the edges at a vertex, each as often as it has tets.
double mean_edge(const TetMesh& mesh, Index v, const std::vector<Index>& star) {
  double sum = 0;
  Index count = 0;
  for (const Index t : star)
    for (int k = 0; k < 4; ++k)
      if (const Index w = mesh.T(t, k); w != v) sum += (mesh.V.row(v) - mesh.V.row(w)).norm(), ++count;
  return count > 0 ? sum / count : 0;
}

// Vertices inside that may be too near to one of the surface or to one with a smaller number, ascending.
std::vector<Index> perhaps_too_near(const TetMesh& mesh, const NearPoints& points,
                                    const std::vector<double>& longest_edge) {
  const Index inside = static_cast<Index>(mesh.V.rows()) - mesh.surface_vertices;
  return parallel_collect<Index>(inside, kMediumGrain,
                                 [&](std::int64_t begin, std::int64_t end, std::vector<Index>& out) {
                                   std::vector<Index> found;
                                   for (std::int64_t i = begin; i < end; ++i) {
                                     const Index v = mesh.surface_vertices + static_cast<Index>(i);
                                     points.within(mesh.V.row(v), kApart * longest_edge[v], found);
                                     if (!found.empty() && found.front() < v) out.push_back(v);
                                   }
                                 });
}

// Moves one vertex.
class Step {
 public:
  Step(TetMesh& mesh, const NearPoints& points, Index v, double mean_edge, const std::vector<Index>& star)
      : mesh_(mesh), v_(v), mean_edge_(mean_edge), from_(mesh.V.row(v)) {
    for (const Index t : star) {
      int k = 0;
      while (mesh.T(t, k) != v) ++k;
      faces_.push_back(tet_inner_face(mesh.T.row(t), k));
    }
    // Whoever is as near as the longest way, and may have moved as far.
    points.within(from_, 2 * kAside[0] * mean_edge, near_);
  }

  bool take() {
    const double before = quality(from_);
    Vector3d best = from_;
    double best_quality = 0;
    for (const double step : kAside) {
      for (const Vector3d& direction : directions()) {
        const Vector3d to = from_ + step * mean_edge_ * direction;
        if (!far_enough(to)) continue;
        if (const double q = quality(to); q > best_quality) best_quality = q, best = to;
      }
      if (best_quality >= kHairWorse * before) break;
    }
    // Only what coincides must step aside whatever it costs.
    if (!(best_quality > (coincides() ? 0 : kHairWorse * before))) return false;
    mesh_.V.row(v_) = best;
    return true;
  }

 private:
  // Towards the middles of the tets around it.
  std::vector<Vector3d> directions() const {
    std::vector<Vector3d> all;
    for (const auto& f : faces_) {
      Vector3d to = -3 * from_;
      for (const Index w : f) to += mesh_.V.row(w);
      if (const double length = to.norm(); length > 0) all.push_back(to / length);
    }
    return all;
  }
  double quality(const Vector3d& p) const {
    double worst = HUGE_VAL;
    for (const auto& f : faces_)
      worst = std::min(worst, min_dihedral_sine(mesh_.V.row(f[0]), mesh_.V.row(f[1]), mesh_.V.row(f[2]), p));
    return worst;
  }
  bool coincides() const {
    return std::any_of(near_.begin(), near_.end(),
                       [&](Index w) { return w != v_ && mesh_.V.row(w).transpose() == from_; });
  }
  bool far_enough(const Vector3d& p) const {
    return std::all_of(near_.begin(), near_.end(), [&](Index w) {
      return w == v_ || (mesh_.V.row(w).transpose() - p).norm() > kApart * mean_edge_;
    });
  }

  TetMesh& mesh_;
  const Index v_;
  const double mean_edge_;
  const Vector3d from_;
  std::vector<std::array<Index, 3>> faces_;  // a positive tet with the vertex, each
  std::vector<Index> near_;
};

// The tets around each of the vertices, which ascend.
std::vector<std::vector<Index>> stars_of(const TetMesh& mesh, const std::vector<Index>& vertices) {
  std::vector<Index> place(static_cast<std::size_t>(mesh.V.rows()), -1);
  for (std::size_t i = 0; i < vertices.size(); ++i) place[vertices[i]] = static_cast<Index>(i);
  std::vector<std::vector<Index>> stars(vertices.size());
  for (Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 0; k < 4; ++k)
      if (const Index i = place[mesh.T(t, k)]; i >= 0) stars[i].push_back(t);
  return stars;
}

// Vertices of the surface that lie in one place.
void count_forced(const TetMesh& mesh, SetApartResult& result) {
  const NearPoints::Closest closest = NearPoints(mesh.V.topRows(mesh.surface_vertices)).closest();
  result.forced = closest.coincident;
  if (closest.coincident == 0) return;
  result.first = closest.a;
  result.second = closest.b;
}

}  // namespace

SetApartResult set_apart(TetMesh& mesh, const RunContext& context) {
  SetApartResult result;
  count_forced(mesh, result);
  const std::vector<double> longest = longest_edges(mesh);
  std::vector<char> has_moved(static_cast<std::size_t>(mesh.V.rows()), 0);
  // A second round where one has stepped near another one that has.
  for (int round = 0; round < kInVain && !context.stop(); ++round) {
    const NearPoints points(mesh.V);
    const std::vector<Index> movers = perhaps_too_near(mesh, points, longest);
    const std::vector<std::vector<Index>> stars = stars_of(mesh, movers);
    std::vector<Index> near;
    result.stuck = 0;
    bool any = false;
    for (std::size_t i = 0; i < movers.size(); ++i) {
      const Index v = movers[i];
      const double mean = mean_edge(mesh, v, stars[i]);
      points.within(mesh.V.row(v), kApart * mean, near);
      if (near.empty() || near.front() >= v) continue;
      if (!Step(mesh, points, v, mean, stars[i]).take()) {
        ++result.stuck;
        continue;
      }
      any = true;
      if (!std::exchange(has_moved[v], 1)) ++result.moved;
    }
    if (!any) break;
  }
  return result;
}

}  // namespace overtet
