#include "src/mesh/local_operations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/parallel/counts.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/mesh/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

}  // namespace

LocalOperations::LocalOperations(TetComplex& mesh) : mesh_(mesh) {
  quality_.resize(mesh.tet_capacity(), 0);
  count(Count::touched_tets, 2 * mesh.tet_count());
  fixed_.assign(mesh.vertex_count(), 0);
  parallel_for(mesh.tet_capacity(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (Index t = static_cast<Index>(begin); t < end; ++t)
      if (const auto& c = mesh.tet(t); mesh.alive(t)) quality_[t] = quality_of(c[0], c[1], c[2], c[3]);
  });
  for (Index t = 0; t < mesh.tet_capacity(); ++t) {
    if (!mesh.alive(t)) continue;
    OVERTET_EXPECTS(quality_[t] > 0);
    const auto& c = mesh.tet(t);
    for (int k = 0; k < 4; ++k)
      if (mesh.neighbour(t, k) < 0)
        for (int j = 0; j < 4; ++j)
          if (j != k) fixed_[c[j]] = 1;
  }
  vertex_mark_.assign(mesh.vertex_count(), 0);
  tet_mark_.assign(mesh.tet_capacity(), 0);
}

double LocalOperations::quality_of(Index a, Index b, Index c, Index d) const {
  return min_dihedral_sine(mesh_.position(a), mesh_.position(b), mesh_.position(c), mesh_.position(d));
}

double LocalOperations::worst(const Tets& tets) const {
  double q = HUGE_VAL;
  for (const Index t : tets) q = std::min(q, quality_[t]);
  return q;
}

LocalOperations::Face LocalOperations::inner_face(Index t, int k) const {
  return tet_inner_face(mesh_.tet(t), k);
}

void LocalOperations::refresh(std::span<const Index> tets) {
  for (const Index t : tets) {
    const auto& c = mesh_.tet(t);
    quality_[t] = quality_of(c[0], c[1], c[2], c[3]);
  }
  forget_spheres(tets);
}

void LocalOperations::forget_spheres(std::span<const Index> tets) {
  if (spheres_.empty()) return;
  for (const Index t : tets) spheres_[t].squared_radius = -1;
}

void LocalOperations::share(Index v, Sharing how) {
  if (shared_.empty()) shared_.assign(mesh_.vertex_count(), 0);
  fixed_[v] = 1;
  shared_[v] = how == Sharing::pinched ? 2 : 1;
}

bool LocalOperations::respects_shared(const Tets& removed) const {
  if (shared_.empty()) return true;
  // A vertex without tets is the one that this operation inserts: no other part knows it.
  const auto is_old = [&](Index v) { return mesh_.tet_of(v) >= 0; };
  const auto kind = [&](Index v) { return v < static_cast<Index>(shared_.size()) ? shared_[v] : char{0}; };
  const auto known = [&](const Index* v, int n) {
    return std::any_of(removed.begin(), removed.end(), [&](Index t) {
      const auto& c = mesh_.tet(t);
      return std::all_of(v, v + n, [&](Index x) { return std::find(c.begin(), c.end(), x) != c.end(); });
    });
  };
  for (const auto& c : added_) {
    int of_shared = 0, of_pinched = 0;
    for (const Index v : c) {
      of_shared += kind(v) > 0;
      of_pinched += kind(v) > 1;
    }
    if (of_shared < 2 && of_pinched == 0) continue;
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < i; ++j) {
        const Index edge[2] = {c[i], c[j]};
        const bool pinched = std::max(kind(c[i]), kind(c[j])) > 1 && is_old(c[i]) && is_old(c[j]);
        if (((kind(c[i]) && kind(c[j])) || pinched) && !known(edge, 2)) return false;
      }
    for (int k = 0; k < 4; ++k) {
      const Index face[3] = {c[(k + 1) % 4], c[(k + 2) % 4], c[(k + 3) % 4]};
      int in_shared = 0, in_pinched = 0, old = 0;
      for (const Index v : face) {
        in_shared += kind(v) > 0;
        in_pinched += kind(v) > 1;
        old += is_old(v);
      }
      if ((in_shared == 3 || (in_pinched > 0 && old == 3)) && !known(face, 3)) return false;
    }
  }
  return true;
}

bool LocalOperations::respects_limit(const Tets& removed) const {
  if (!limit_) return true;
  double most = 0;
  for (const auto& c : added_) most = std::max(most, limit_->excess(c, corners_of(c)).factor);
  if (most <= 1) return true;
  return std::any_of(removed.begin(), removed.end(), [&](Index t) { return excess(t).factor >= most; });
}

bool LocalOperations::may_move(Index v, const Vector3d& to) const {
  if (!limit_) return true;
  double before = 1, after = 0;
  for (const Index t : star_) {
    const auto& c = mesh_.tet(t);
    auto at = corners_of(c);
    before = std::max(before, limit_->excess(c, at).factor);
    at[mesh_.corner(t, v)] = to;
    after = std::max(after, limit_->excess(c, at).factor);
  }
  return after <= before;
}

bool LocalOperations::commit(const Tets& removed) {
  if (!respects_shared(removed) || !respects_limit(removed)) return false;
  mesh_.replace(removed, added_, changed_);
  quality_.resize(mesh_.tet_capacity(), 0);
  tet_mark_.resize(mesh_.tet_capacity(), 0);
  if (!spheres_.empty()) spheres_.resize(mesh_.tet_capacity());
  refresh(changed_);
  OVERTET_EXPECTS(worst(changed_) > 0);
  return true;
}

// ---------------------------------------------------------------------------------------------- splits

Index LocalOperations::new_vertex(const Vector3d& p, std::span<const Index> near) {
  if (limit_) limit_->add_vertex(p, near, mesh_.positions());
  fixed_.push_back(0);
  vertex_mark_.push_back(0);
  return mesh_.add_vertex(p);
}

bool LocalOperations::star_of_new_vertex(const std::vector<Face>& faces, const Vector3d& p,
                                         const Tets& removed) {
  link_.clear();
  if (limit_)
    for (const Face& f : faces) link_.insert(link_.end(), f.begin(), f.end());
  const Index v = new_vertex(p, link_);
  added_.clear();
  for (const Face& f : faces) added_.push_back({f[0], f[1], f[2], v});
  return commit(removed);
}

bool LocalOperations::split_edge(Index a, Index b, const Vector3d& p) {
  const Index t = mesh_.tet_with_edge(a, b);
  if (t < 0) return false;
  mesh_.ring(t, a, b, ring_, link_);
  if (link_.size() != ring_.size()) return false;
  const std::size_t n = ring_.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d &x = mesh_.position(link_[i]), &y = mesh_.position(link_[(i + 1) % n]);
    if (!(min_dihedral_sine(mesh_.position(a), p, x, y) > 0)) return false;
    if (!(min_dihedral_sine(p, mesh_.position(b), x, y) > 0)) return false;
  }
  const std::array<Index, 2> ends{a, b};
  const Index v = new_vertex(p, ends);
  added_.clear();
  for (std::size_t i = 0; i < n; ++i) {
    added_.push_back({a, v, link_[i], link_[(i + 1) % n]});
    added_.push_back({v, b, link_[i], link_[(i + 1) % n]});
  }
  return commit(ring_);
}

bool LocalOperations::split_face(Index t, int k, const Vector3d& p) {
  const Index u = mesh_.neighbour(t, k);
  if (u < 0) return false;
  cavity_ = {t, u};
  faces_.clear();
  for (const Index s : cavity_)
    for (int j = 0; j < 4; ++j)
      if (const Index n = mesh_.neighbour(s, j); n != t && n != u) faces_.push_back(inner_face(s, j));
  load_bases();
  if (faces_.size() != 6 || !(quality_at(p, 0) > 0)) return false;
  return star_of_new_vertex(faces_, p, cavity_);
}

bool LocalOperations::split_tet(Index t, const Vector3d& p) {
  cavity_ = {t};
  faces_.clear();
  for (int j = 0; j < 4; ++j) faces_.push_back(inner_face(t, j));
  load_bases();
  if (!(quality_at(p, 0) > 0)) return false;
  return star_of_new_vertex(faces_, p, cavity_);
}

// ----------------------------------------------------------------------------------------------- flips

bool LocalOperations::flip_23(Index t, int k) {
  const Index u = mesh_.neighbour(t, k);
  if (u < 0) return false;
  const Face f = inner_face(t, k);
  const Index d = mesh_.tet(t)[k];
  Index e = -1;
  for (int j = 0; j < 4; ++j)
    if (mesh_.neighbour(u, j) == t) e = mesh_.tet(u)[j];
  if (!fixed_chords_ && fixed_[d] && fixed_[e]) return false;
  const double must = std::min(quality_[t], quality_[u]);
  for (int i = 0; i < 3; ++i)
    if (!(quality_of(f[i], f[(i + 1) % 3], e, d) > must)) return false;
  if (mesh_.has_edge(d, e)) return false;
  added_.clear();
  for (int i = 0; i < 3; ++i) added_.push_back({f[i], f[(i + 1) % 3], e, d});
  cavity_ = {t, u};
  return commit(cavity_);
}

bool LocalOperations::remove_edge(Index t, Index a, Index b, double enough) {
  mesh_.ring(t, a, b, ring_, link_);
  const int n = static_cast<int>(ring_.size());
  if (link_.size() != ring_.size() || n < 3 || n > kLargestRing) return false;
  const double must = std::min(worst(ring_), enough);

  // best[i][j]: the worst tet of the best triangulation of the ring polygon's corners i..j.
  double best[kLargestRing][kLargestRing];
  int middle[kLargestRing][kLargestRing];
  double triangle[kLargestRing][kLargestRing][kLargestRing];
  bool barred[kLargestRing][kLargestRing] = {};
  for (int i = 0; i < n; ++i)
    for (int k = i + 1; k < n; ++k)
      for (int j = k + 1; j < n; ++j) triangle[i][k][j] = -1;  // not computed
  const auto quality_of_triangle = [&](int i, int k, int j) {
    double& q = triangle[i][k][j];
    if (q >= 0) return q;
    q = quality_of(link_[i], link_[k], link_[j], b);
    if (q > must) q = std::min(q, quality_of(link_[i], link_[j], link_[k], a));
    if (!(q > must)) q = 0;
    return q;
  };
  const auto is_chord = [n](int i, int j) { return j - i > 1 && !(i == 0 && j == n - 1); };
  if (!fixed_chords_)
    for (int i = 0; i < n; ++i)
      for (int j = i + 2; j < n; ++j) barred[i][j] = is_chord(i, j) && fixed_[link_[i]] && fixed_[link_[j]];

  // The best triangulation may use an edge that the mesh has already, elsewhere: bar it and look again.
  for (int attempt = 0; attempt < 4; ++attempt) {
    for (int length = 1; length < n; ++length)
      for (int i = 0; i + length < n; ++i) {
        const int j = i + length;
        best[i][j] = length == 1 ? HUGE_VAL : 0;
        middle[i][j] = -1;
        if (length == 1 || barred[i][j]) continue;
        for (int k = i + 1; k < j; ++k) {
          const double sides = std::min(best[i][k], best[k][j]);
          if (!(sides > best[i][j])) continue;
          const double q = std::min(sides, quality_of_triangle(i, k, j));
          if (q > best[i][j]) {
            best[i][j] = q;
            middle[i][j] = k;
          }
        }
      }
    if (!(best[0][n - 1] > must)) return false;

    added_.clear();
    bool clean = true;
    std::array<std::pair<int, int>, kLargestRing> stack;
    int top = 0;
    stack[top++] = {0, n - 1};
    while (top > 0) {
      const auto [i, j] = stack[--top];
      if (j - i < 2) continue;
      const int k = middle[i][j];
      if (is_chord(i, j) && mesh_.has_edge(link_[i], link_[j])) {
        barred[i][j] = true;
        clean = false;
      }
      added_.push_back({link_[i], link_[k], link_[j], b});
      added_.push_back({link_[i], link_[j], link_[k], a});
      stack[top++] = {i, k};
      stack[top++] = {k, j};
    }
    // Three edges that are there already may also bound a face that is there already.
    if (n == 3 && mesh_.tet_with_face(link_[0], link_[1], link_[2]) >= 0) return false;
    if (!clean) continue;
    return commit(ring_);
  }
  return false;
}

// -------------------------------------------------------------------------------------------- collapse

bool LocalOperations::collapse(Index v, Index w, double enough) {
  if (fixed_[v]) return false;
  mesh_.star(v, star_);
  if (star_.empty()) return false;
  const double must = std::min(worst(star_), enough);
  added_.clear();
  ring_.clear();
  for (const Index t : star_) {
    auto c = mesh_.tet(t);
    if (c[0] == w || c[1] == w || c[2] == w || c[3] == w) {
      ring_.push_back(t);
      continue;
    }
    c[mesh_.corner(t, v)] = w;
    if (!(quality_of(c[0], c[1], c[2], c[3]) > must)) return false;
    added_.push_back(c);
  }
  if (ring_.empty()) return false;

  // Link condition: what the links of v and w share is the link of the edge, nothing else.
  mesh_.star(w, other_star_);
  const std::uint32_t near_w = ++vertex_stamp_, on_ring = ++vertex_stamp_;
  for (const Index t : other_star_)
    for (const Index x : mesh_.tet(t)) vertex_mark_[x] = near_w;
  for (const Index t : ring_)
    for (const Index x : mesh_.tet(t)) vertex_mark_[x] = on_ring;
  for (const auto& c : added_)
    for (const Index x : c) {
      if (x == w) continue;
      if (vertex_mark_[x] == near_w) return false;  // the edge w-x is there already
      if (!fixed_chords_ && vertex_mark_[x] != on_ring && fixed_[w] && fixed_[x]) return false;
    }
  const auto in_ring = [&](Index x, Index y) {
    for (const Index t : ring_) {
      int found = 0;
      for (const Index z : mesh_.tet(t)) found += z == x || z == y;
      if (found == 2) return true;
    }
    return false;
  };
  for (const auto& c : added_) {
    Index others[3];
    int n = 0;
    for (const Index x : c)
      if (x != w) others[n++] = x;
    for (int i = 0; i < 3; ++i) {
      const Index x = others[i], y = others[(i + 1) % 3];
      if (vertex_mark_[x] != on_ring || vertex_mark_[y] != on_ring || in_ring(x, y)) continue;
      for (const Index t : other_star_) {  // is w-x-y a face already?
        int found = 0;
        for (const Index z : mesh_.tet(t)) found += z == x || z == y;
        if (found == 2) return false;
      }
    }
  }
  return commit(star_);
}

}  // namespace overtet
