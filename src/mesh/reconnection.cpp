// LocalOperations: cavities filled anew without new vertices.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "kernels/core/tet_tables.h"
#include "kernels/delaunay/tuning.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/polyhedron.h"
#include "src/mesh/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

using Sums = std::array<std::array<double, kMostPoints>, kMostPoints>;  // [i][j], i < j

void add_angles(Sums& sums, const Polyhedron::Tet& t, const std::array<double, 6>& angles) {
  for (int e = 0; e < 6; ++e) {
    const auto [i, j] = std::minmax(t[kTetEdge[e][0]], t[kTetEdge[e][1]]);
    sums[i][j] += angles[e];
  }
}

// The edges of the hull keep their angles, all others make one turn.
bool turns_stay(const std::array<std::uint32_t, kMostPoints>& hull, const Sums& before, const Sums& after,
                int points) {
  for (int j = 0; j < points; ++j)
    for (int i = 0; i < j; ++i) {
      const bool on_hull = hull[i] >> j & 1;
      if (!on_hull && after[i][j] == 0) continue;
      if (!(std::fabs(after[i][j] - (on_hull ? before[i][j] : 2 * M_PI)) < kTurnTolerance)) return false;
    }
  return true;
}

// The number of v in the polyhedron on these points, which ascend; -1: it is none of them.
int number_in(const std::vector<Index>& points, Index v) {
  const auto at = std::lower_bound(points.begin(), points.end(), v);
  return at != points.end() && *at == v ? static_cast<int>(at - points.begin()) : -1;
}

// The tets around each vertex hang together across faces.
bool stars_connected(const std::vector<Polyhedron::Tet>& tets, int points) {
  std::vector<Polyhedron::Tet> star;
  for (int v = 0; v < points; ++v) {
    star.clear();
    for (const auto& t : tets)
      if (std::find(t.begin(), t.end(), v) != t.end()) star.push_back(t);
    std::size_t reached = std::min<std::size_t>(1, star.size());
    for (std::size_t i = 0; i < reached; ++i)
      for (std::size_t j = reached; j < star.size(); ++j) {
        int common = 0;
        for (const int x : star[j]) common += std::find(star[i].begin(), star[i].end(), x) != star[i].end();
        if (common == 3) std::swap(star[j], star[reached++]);
      }
    if (reached < star.size()) return false;
  }
  return true;
}

}  // namespace

void LocalOperations::bar_elsewhere(const Refill& how, const EdgeBits& known, const EdgeBits& hull,
                                    Polyhedron& p) {
  const std::vector<Index>& points = link_;
  const int n = static_cast<int>(points.size());
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < i; ++j) {
      const Index v = points[i], w = points[j];
      const bool allowed =
          known[i] >> j & 1 || !((!fixed_chords_ && fixed_[v] && fixed_[w]) || (shared(v) && shared(w)));
      if (!allowed || v == how.without || w == how.without) p.bar_edge(i, j);
    }
  for (int i = 0; i < n; ++i) {
    if (hull[i] == 0) continue;
    mesh_.star(points[i], star_);
    for (const Index t : star_) {
      if (tet_mark_[t] == tet_stamp_) continue;
      int c[4], m = 0;
      for (const Index v : mesh_.tet(t))
        if (const int j = number_in(points, v); j >= 0) c[m++] = j;
      for (int x = 0; x < m; ++x)
        for (int y = 0; y < x; ++y) {
          if (!(hull[c[x]] >> c[y] & 1)) p.bar_edge(c[x], c[y]);
          for (int z = 0; z < y; ++z) p.bar_face(c[x], c[y], c[z]);
        }
    }
  }
  if (how.no_face[0] >= 0) {
    const auto& f = how.no_face;
    p.bar_face(number_in(points, f[0]), number_in(points, f[1]), number_in(points, f[2]));
  }
}

bool LocalOperations::refill(const Tets& cavity, const Refill& how) {
  if (!hull_of(cavity, hull_)) return false;
  static thread_local Polyhedron p;
  static thread_local std::vector<Polyhedron::Tet> filling;
  std::vector<Index>& points = link_;
  points.clear();
  for (const Index t : cavity) points.insert(points.end(), mesh_.tet(t).begin(), mesh_.tet(t).end());
  std::sort(points.begin(), points.end());
  points.erase(std::unique(points.begin(), points.end()), points.end());
  if (points.size() > kMostPoints) return false;
  const int n = static_cast<int>(points.size());
  const auto local = [&](Index v) { return number_in(points, v); };
  for (const Index v : points)
    if (v < static_cast<Index>(shared_.size()) && shared_[v] > 1) return false;

  p.clear();
  for (const Index v : points) p.add_point(v == how.moved ? how.to : mesh_.position(v));
  EdgeBits known{}, hull{};  // the cavity's, and those of its hull
  const auto join = [](auto& edges, int i, int j) { edges[i] |= 1u << j, edges[j] |= 1u << i; };
  for (const Face& f : hull_) {
    const Polyhedron::Face g{local(f[0]), local(f[1]), local(f[2])};
    p.add_face(g);
    for (int k = 0; k < 3; ++k) join(hull, g[k], g[(k + 1) % 3]);
  }
  Sums before{}, after{};
  for (const Index t : cavity) {
    const auto& v = mesh_.tet(t);
    const Polyhedron::Tet c{local(v[0]), local(v[1]), local(v[2]), local(v[3])};
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) join(known, c[i], c[j]);
    add_angles(before, c,
               dihedral_angles(mesh_.position(v[0]), mesh_.position(v[1]), mesh_.position(v[2]),
                               mesh_.position(v[3])));
  }
  bar_elsewhere(how, known, hull, p);
  if (!(p.fill(how.must, kFillSteps, filling) > how.must)) return false;

  // The cavity may not be embedded: nothing may make another turn, or hang on a vertex alone.
  for (const auto& t : filling)
    add_angles(after, t, dihedral_angles(p.point(t[0]), p.point(t[1]), p.point(t[2]), p.point(t[3])));
  if (!turns_stay(hull, before, after, n) || !stars_connected(filling, n)) return false;
  added_.clear();
  for (const auto& t : filling) added_.push_back({points[t[0]], points[t[1]], points[t[2]], points[t[3]]});
  if (how.moved < 0) return commit(cavity);
  const Vector3d from = mesh_.position(how.moved);
  mesh_.move(how.moved, how.to);
  if (commit(cavity)) return true;
  mesh_.move(how.moved, from);
  return false;
}

bool LocalOperations::remove_vertex(Index v, double enough) {
  if (fixed_[v]) return false;
  mesh_.star(v, cavity_);
  Refill how;
  how.must = std::min(worst(cavity_), enough);
  how.without = v;
  return !cavity_.empty() && refill(cavity_, how);
}

bool LocalOperations::rebuild_star(Index v, const std::array<Index, 3>& no_face, const Vector3d& to,
                                   double enough) {
  if (fixed_[v]) return false;
  mesh_.star(v, cavity_);
  Refill how;
  how.must = std::min(worst(cavity_), enough);
  how.no_face = no_face;
  how.moved = v;
  how.to = to;
  return !cavity_.empty() && refill(cavity_, how);
}

bool LocalOperations::reconnect(Index t, double gain) {
  Refill how;
  how.must = gain * quality_[t];
  const auto corners = mesh_.tet(t);
  for (const Index v : corners) {
    if (fixed_[v]) continue;
    mesh_.star(v, cavity_);
    if (cavity_.size() <= kMostTetsFilled && refill(cavity_, how)) return true;
  }
  // What lies around it, as long as the points are few enough: first the neighbours that bring no new ones,
  // and of these the worst. The last cavity that was a ball.
  struct Candidate {
    Index t;
    int fresh;  // corners that the cavity does not have
  };
  static thread_local std::vector<Candidate> beside;  // of the cavity, in the order in which it met them
  beside.clear();
  cavity_.clear();
  std::vector<Index> points;
  const auto has_point = [&](Index v) { return std::find(points.begin(), points.end(), v) != points.end(); };
  const auto take = [&](Index next) {
    cavity_.push_back(next);
    for (const Index v : mesh_.tet(next)) {
      if (has_point(v)) continue;
      points.push_back(v);
      for (Candidate& c : beside) {
        const auto& corner = mesh_.tet(c.t);
        c.fresh -= std::find(corner.begin(), corner.end(), v) != corner.end();
      }
    }
    for (int k = 0; k < 4; ++k) {
      const Index u = mesh_.neighbour(next, k);
      const auto is_it = [u](const Candidate& c) { return c.t == u; };
      if (u < 0 || std::find(cavity_.begin(), cavity_.end(), u) != cavity_.end() ||
          std::any_of(beside.begin(), beside.end(), is_it))
        continue;
      const auto& corner = mesh_.tet(u);
      beside.push_back({u, static_cast<int>(4 - std::count_if(corner.begin(), corner.end(), has_point))});
    }
  };
  take(t);
  while (cavity_.size() < kMostTetsFilled && !beside.empty()) {
    const auto next =
        std::min_element(beside.begin(), beside.end(), [&](const Candidate& x, const Candidate& y) {
          return x.fresh != y.fresh ? x.fresh < y.fresh : quality_[x.t] < quality_[y.t];
        });
    if (points.size() + static_cast<std::size_t>(next->fresh) > kMostPoints) break;
    const Index best = next->t;
    beside.erase(next);
    take(best);
  }
  while (cavity_.size() > 1 && !hull_of(cavity_, hull_)) cavity_.pop_back();
  return cavity_.size() > 1 && refill(cavity_, how);
}

}  // namespace overtet
