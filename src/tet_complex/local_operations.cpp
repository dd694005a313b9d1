#include "src/tet_complex/local_operations.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/parallel/parallel.h"
#include "kernels/tet_energy/tet_quality.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

constexpr std::int64_t kGrain = 4096;  // tets
constexpr double kInfinity = std::numeric_limits<double>::infinity();
// A move that gains less than this is not worth a change of the mesh.
constexpr double kLeastGain = 1e-3;
// Functions within this factor of the worst steer the climb together with it.
constexpr double kActiveFactor[] = {2.0, 1.25, 1.02};
constexpr int kMostActive = 5;
constexpr int kMostHalvings = 10;
constexpr int kMostGrowth = 10;
constexpr std::size_t kLargestCavity = 60;
constexpr std::size_t kLargestDelaunayCavity = 20000;
constexpr int kLongestWalk = 100;
// Of the square of the radius of the smallest sphere through a boundary face: nearer vertices are not
// inserted.
constexpr double kEncroaching = 0.5;

// The point of the convex hull of up to kMostActive vectors that is nearest to the origin. It lies on a
// corner, an edge or a triangle unless the origin is inside.
Vector3d nearest_to_origin(const Vector3d* g, int n) {
  Vector3d best = g[0];
  double norm = best.squaredNorm();
  const auto take = [&](const Vector3d& p) {
    const double s = p.squaredNorm();
    if (s < norm) {
      norm = s;
      best = p;
    }
  };
  for (int i = 1; i < n; ++i) take(g[i]);
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j) {
      const Vector3d e = g[j] - g[i];
      const double ee = e.squaredNorm(), t = -g[i].dot(e);
      if (t > 0 && t < ee) take(g[i] + (t / ee) * e);
    }
  for (int i = 0; i < n; ++i)
    for (int j = i + 1; j < n; ++j)
      for (int k = j + 1; k < n; ++k) {
        const Vector3d e = g[j] - g[i], f = g[k] - g[i], normal = e.cross(f);
        const double nn = normal.squaredNorm();
        if (nn == 0) continue;
        const Vector3d p = normal * (g[i].dot(normal) / nn), q = p - g[i];
        const double u = q.cross(f).dot(normal), w = e.cross(q).dot(normal);
        if (u > 0 && w > 0 && u + w < nn) take(p);
      }
  return best;
}

}  // namespace

LocalOperations::LocalOperations(TetComplex& mesh) : mesh_(mesh) {
  quality_.resize(mesh.tet_capacity(), 0);
  fixed_.assign(mesh.vertex_count(), 0);
  parallel_for(mesh.tet_capacity(), kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (Index t = static_cast<Index>(begin); t < end; ++t)
      if (const auto& c = mesh.tet(t); mesh.alive(t)) quality_[t] = quality_of(c[0], c[1], c[2], c[3]);
  });
  for (Index t = 0; t < mesh.tet_capacity(); ++t) {
    if (!mesh.alive(t)) continue;
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
  double q = kInfinity;
  for (const Index t : tets) q = std::min(q, quality_[t]);
  return q;
}

LocalOperations::Face LocalOperations::inner_face(Index t, int k) const {
  static constexpr int kInner[4][3] = {{1, 3, 2}, {0, 2, 3}, {0, 3, 1}, {0, 1, 2}};
  const auto& c = mesh_.tet(t);
  return {c[kInner[k][0]], c[kInner[k][1]], c[kInner[k][2]]};
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

void LocalOperations::share(Index v, bool pinched) {
  if (shared_.empty()) shared_.assign(mesh_.vertex_count(), 0);
  fixed_[v] = 1;
  shared_[v] = pinched ? 2 : 1;
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

bool LocalOperations::commit(const Tets& removed) {
  if (!respects_shared(removed)) return false;
  mesh_.replace(removed, added_, changed_);
  quality_.resize(mesh_.tet_capacity(), 0);
  tet_mark_.resize(mesh_.tet_capacity(), 0);
  if (!spheres_.empty()) spheres_.resize(mesh_.tet_capacity());
  refresh(changed_);
  return true;
}

// ---------------------------------------------------------------------------------------------- splits

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
  const Index v = mesh_.add_vertex(p);
  fixed_.push_back(0);
  vertex_mark_.push_back(0);
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
  const Index v = mesh_.add_vertex(p);
  fixed_.push_back(0);
  vertex_mark_.push_back(0);
  added_.clear();
  for (const Face& f : faces_) added_.push_back({f[0], f[1], f[2], v});
  return commit(cavity_);
}

bool LocalOperations::split_tet(Index t, const Vector3d& p) {
  cavity_ = {t};
  faces_.clear();
  for (int j = 0; j < 4; ++j) faces_.push_back(inner_face(t, j));
  load_bases();
  if (!(quality_at(p, 0) > 0)) return false;
  const Index v = mesh_.add_vertex(p);
  fixed_.push_back(0);
  vertex_mark_.push_back(0);
  added_.clear();
  for (const Face& f : faces_) added_.push_back({f[0], f[1], f[2], v});
  return commit(cavity_);
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

bool LocalOperations::remove_edge(Index t, Index a, Index b) {
  mesh_.ring(t, a, b, ring_, link_);
  const int n = static_cast<int>(ring_.size());
  if (link_.size() != ring_.size() || n < 3 || n > kLargestRing) return false;
  const double must = worst(ring_);

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
        best[i][j] = length == 1 ? kInfinity : 0;
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

// ------------------------------------------------------------------------------------------- smoothing

void LocalOperations::load_bases() {
  bases_.clear();
  for (const Face& f : faces_)
    bases_.push_back({mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2])});
}

double LocalOperations::quality_at(const Vector3d& x, double stop) {
  double q = kInfinity;
  for (std::size_t i = 0; i < bases_.size(); ++i) {
    const double here = min_dihedral_sine(bases_[i].a, bases_[i].b, bases_[i].c, x);
    if (here >= q) continue;
    q = here;
    // The next trial is likely to fail at the same place: look there first.
    if (i > 0) std::swap(bases_[i], bases_[i / 2]);
    if (q <= stop) return q;
  }
  return q;
}

double LocalOperations::optimise(Vector3d& x, double q, int rounds) {
  struct Active {
    double log_sine;
    Vector3d gradient;
  };
  static thread_local std::vector<Active> all;
  for (int round = 0; round < rounds; ++round) {
    all.clear();
    DihedralSines sines;
    double least = kInfinity;
    for (const Base& f : bases_) {
      dihedral_sines(f.a, f.b, f.c, x, sines);
      for (int e = 0; e < 6; ++e) {
        const double s = std::log(std::max(sines.sine[e], 1e-40));
        if (!std::isfinite(s) || !sines.log_gradient[e].allFinite()) continue;
        all.push_back({s, sines.log_gradient[e]});
        least = std::min(least, s);
      }
    }
    if (all.empty()) return q;
    bool moved = false;
    for (const double factor : kActiveFactor) {
      const double limit = least + std::log(factor);
      std::array<Vector3d, kMostActive> active;
      active.fill(Vector3d::Zero());
      std::array<double, kMostActive> value{};
      int n = 0;
      for (const Active& a : all) {
        if (a.log_sine > limit) continue;
        if (n < kMostActive) {
          active[n] = a.gradient;
          value[n++] = a.log_sine;
        } else {
          const int worst_kept =
              static_cast<int>(std::max_element(value.begin(), value.end()) - value.begin());
          if (a.log_sine < value[worst_kept]) {
            active[worst_kept] = a.gradient;
            value[worst_kept] = a.log_sine;
          }
        }
      }
      const Vector3d y = nearest_to_origin(active.data(), n);
      const double yy = y.norm();
      if (!(yy > 0) || !std::isfinite(yy)) continue;
      const Vector3d direction = y / yy;
      double slope = kInfinity;
      for (int i = 0; i < n; ++i) slope = std::min(slope, active[i].dot(direction));
      if (!(slope > 1e-3 * yy)) continue;

      // Volumes are linear along the way: here the first one would be zero.
      double end = kInfinity;
      for (const Base& f : bases_) {
        const Vector3d normal = (f.b - f.a).cross(f.c - f.a);
        const double rate = normal.dot(direction);
        if (rate < 0) end = std::min(end, std::max(normal.dot(x - f.a), 0.0) / -rate);
      }
      if (!(end > 0) || !std::isfinite(end)) continue;
      // Where the linear model says that another function becomes the worst.
      double step = 0.7 * end;
      for (const Active& a : all) {
        const double s = a.gradient.dot(direction);
        if (a.log_sine > limit && s < slope) step = std::min(step, (a.log_sine - least) / (slope - s));
      }
      step = std::max(step, 1e-3 * end);
      double reached = q;
      Vector3d best = x;
      for (int halving = 0; halving < kMostHalvings; ++halving, step *= 0.5) {
        const Vector3d trial = x + step * direction;
        const double here = quality_at(trial, reached);
        if (here > reached) {
          reached = here;
          best = trial;
          if (halving > 0) break;
          // Right at the first try: go on as long as it pays.
          for (double longer = 2 * step; longer < 0.9 * end; longer *= 2) {
            const Vector3d far = x + longer * direction;
            const double there = quality_at(far, reached);
            if (!(there > reached)) break;
            reached = there;
            best = far;
          }
          break;
        }
      }
      if (reached > q * (1 + 1e-4)) {
        moved = true;
        const bool small = reached < q * 1.01;
        q = reached;
        x = best;
        if (small) return q;
        break;
      }
    }
    if (!moved) return q;
  }
  return q;
}

bool LocalOperations::star_of_free(Index v) {
  if (fixed_[v]) return false;
  mesh_.star(v, star_);
  if (star_.empty()) return false;
  faces_.clear();
  for (const Index t : star_) faces_.push_back(inner_face(t, mesh_.corner(t, v)));
  load_bases();
  return true;
}

bool LocalOperations::smooth(Index v, double gain) {
  if (!star_of_free(v)) return false;
  const double before = worst(star_);
  Vector3d x = mesh_.position(v);
  const double after = optimise(x, before, 6);
  if (!(after > before * gain)) return false;
  mesh_.move(v, x);
  refresh(star_);
  changed_ = star_;
  return true;
}

bool LocalOperations::move_towards(Index v, const Vector3d& target) {
  if (!star_of_free(v)) return false;
  const double before = worst(star_);
  const Vector3d from = mesh_.position(v);
  Vector3d best = from;
  double reached = before * (1 + kLeastGain);
  for (double step = 1; step > 0.05; step *= 0.5) {
    const Vector3d x = from + step * (target - from);
    const double q = quality_at(x, reached);
    if (q > reached) {
      reached = q;
      best = x;
    }
  }
  if (best == from) return false;
  mesh_.move(v, best);
  refresh(star_);
  changed_ = star_;
  return true;
}

bool LocalOperations::place(Index v, const Vector3d& p) {
  mesh_.star(v, star_);
  const Vector3d from = mesh_.position(v);
  mesh_.move(v, p);
  for (std::size_t i = 0; i < star_.size(); ++i) {
    const auto& c = mesh_.tet(star_[i]);
    const double q = quality_of(c[0], c[1], c[2], c[3]);
    if (q > 0) {
      quality_[star_[i]] = q;
      continue;
    }
    mesh_.move(v, from);
    for (std::size_t j = 0; j < i; ++j) {
      const auto& b = mesh_.tet(star_[j]);
      quality_[star_[j]] = quality_of(b[0], b[1], b[2], b[3]);
    }
    return false;
  }
  forget_spheres(star_);
  changed_ = star_;
  return true;
}

bool LocalOperations::place_all(std::span<const Index> vertices, std::span<const Vector3d> positions,
                                std::span<const Index> tets) {
  std::vector<Vector3d> from;
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    from.push_back(mesh_.position(vertices[i]));
    mesh_.move(vertices[i], positions[i]);
  }
  bool good = true;
  std::vector<double> quality;
  for (const Index t : tets) {
    const auto& c = mesh_.tet(t);
    quality.push_back(quality_of(c[0], c[1], c[2], c[3]));
    if (!(quality.back() > 0)) {
      good = false;
      break;
    }
  }
  if (!good) {
    for (std::size_t i = 0; i < vertices.size(); ++i) mesh_.move(vertices[i], from[i]);
    return false;
  }
  for (std::size_t i = 0; i < tets.size(); ++i) quality_[tets[i]] = quality[i];
  forget_spheres(tets);
  changed_.assign(tets.begin(), tets.end());
  return true;
}

// ------------------------------------------------------------------------------------------- insertion

bool LocalOperations::hull_of(const Tets& cavity, std::vector<Face>& hull) {
  const std::uint32_t inside = ++tet_stamp_;
  for (const Index t : cavity) tet_mark_[t] = inside;
  hull.clear();
  const std::uint32_t seen = ++vertex_stamp_;
  std::size_t vertices = 0;
  for (const Index t : cavity)
    for (int k = 0; k < 4; ++k) {
      const Index u = mesh_.neighbour(t, k);
      if (u >= 0 && tet_mark_[u] == inside) continue;
      hull.push_back(inner_face(t, k));
      for (const Index v : hull.back())
        if (vertex_mark_[v] != seen) {
          vertex_mark_[v] = seen;
          ++vertices;
        }
    }
  // A fixed vertex must not vanish.
  for (const Index t : cavity)
    for (const Index v : mesh_.tet(t))
      if (fixed_[v] && vertex_mark_[v] != seen) return false;
  // A sphere: every edge twice, Euler's number 2, connected across edges.
  struct HalfEdge {
    Index a, b, face;
  };
  static thread_local std::vector<HalfEdge> edges;
  static thread_local std::vector<Index> parent;
  edges.clear();
  parent.resize(hull.size());
  for (std::size_t f = 0; f < hull.size(); ++f) {
    parent[f] = static_cast<Index>(f);
    for (int k = 0; k < 3; ++k) {
      const Index a = hull[f][k], b = hull[f][(k + 1) % 3];
      edges.push_back({std::min(a, b), std::max(a, b), static_cast<Index>(f)});
    }
  }
  std::sort(edges.begin(), edges.end(), [](const HalfEdge& x, const HalfEdge& y) {
    return std::tie(x.a, x.b, x.face) < std::tie(y.a, y.b, y.face);
  });
  const auto root = [&](Index f) {
    while (parent[f] != f) f = parent[f] = parent[parent[f]];
    return f;
  };
  std::size_t pieces = hull.size();
  for (std::size_t i = 0; i < edges.size(); i += 2) {
    if (i + 1 >= edges.size() || edges[i].a != edges[i + 1].a || edges[i].b != edges[i + 1].b) return false;
    if (i + 2 < edges.size() && edges[i].a == edges[i + 2].a && edges[i].b == edges[i + 2].b) return false;
    const Index f = root(edges[i].face), g = root(edges[i + 1].face);
    if (f != g) {
      parent[f] = g;
      --pieces;
    }
  }
  return pieces == 1 && vertices + hull.size() == edges.size() / 2 + 2;
}

bool LocalOperations::insert(Tets& cavity, const Vector3d& start, double gain) {
  if (!hull_of(cavity, hull_)) return false;
  double old_worst = worst(cavity);
  Vector3d x = start;
  faces_ = hull_;
  load_bases();
  double q = quality_at(x, 0);
  if (!(q > 0)) return false;
  q = optimise(x, q, 3);
  // Take in the neighbour behind the face that makes the worst tet, as long as that helps.
  for (int growth = 0; growth < kMostGrowth && cavity.size() < kLargestCavity; ++growth) {
    double least = kInfinity;
    Face at{};
    for (const Face& f : hull_) {
      const double here =
          min_dihedral_sine(mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), x);
      if (here < least) {
        least = here;
        at = f;
      }
    }
    const std::uint32_t inside = tet_stamp_;  // of the last hull_of(), which was this cavity's
    Index beyond = -1;
    for (const Index t : cavity)
      for (int k = 0; k < 4 && beyond < 0; ++k) {
        const Index u = mesh_.neighbour(t, k);
        if (u >= 0 && tet_mark_[u] != inside && inner_face(t, k) == at) beyond = u;
      }
    if (beyond < 0) break;
    cavity.push_back(beyond);
    bool better = hull_of(cavity, grown_hull_);
    if (better) {
      faces_ = grown_hull_;
      load_bases();
      Vector3d moved = x;
      double grown = quality_at(moved, 0);
      if (grown > 0) grown = optimise(moved, grown, 2);
      better = grown > q;
      if (better) {
        q = grown;
        x = moved;
        std::swap(hull_, grown_hull_);
        old_worst = std::min(old_worst, quality_[beyond]);
      }
    }
    if (!better) {
      cavity.pop_back();
      break;
    }
  }
  faces_ = hull_;
  load_bases();
  q = optimise(x, quality_at(x, 0), 6);
  if (!(q > old_worst * gain)) return false;
  return fill(cavity, x);
}

bool LocalOperations::fill(const Tets& cavity, const Vector3d& x) {
  // Seen from x the cavity's boundary must fill the sphere once; in a mesh that overlaps itself it might
  // do so twice, and then the old tets were no embedded cavity.
  double angle = 0;
  for (const Face& f : hull_)
    angle += solid_angle(mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), x);
  if (!(angle < 6 * M_PI)) return false;
  const Index v = mesh_.add_vertex(x);
  fixed_.push_back(0);
  vertex_mark_.push_back(0);
  added_.clear();
  for (const Face& f : hull_) added_.push_back({f[0], f[1], f[2], v});
  return commit(cavity);
}

bool LocalOperations::insert_at_edge(Index t, Index a, Index b, double gain) {
  mesh_.ring(t, a, b, ring_, link_);
  if (link_.size() != ring_.size()) return false;
  cavity_ = ring_;
  return insert(cavity_, (mesh_.position(a) + mesh_.position(b)) / 2, gain);
}

bool LocalOperations::insert_at_tet(Index t, double gain) {
  cavity_ = {t};
  const auto& c = mesh_.tet(t);
  return insert(
      cavity_,
      (mesh_.position(c[0]) + mesh_.position(c[1]) + mesh_.position(c[2]) + mesh_.position(c[3])) / 4, gain);
}

// ------------------------------------------------------------------------------------------ refinement

namespace {

// The smallest sphere through a triangle's corners, a little shrunk, contains x. (Delaunay refinement that
// may split the boundary takes the whole sphere; here vertices are wanted near it, too.)
bool in_smallest_sphere(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& x) {
  const Vector3d u = b - a, v = c - a, n = u.cross(v);
  const Vector3d out = (u.squaredNorm() * v.cross(n) + v.squaredNorm() * n.cross(u)) / (2 * n.squaredNorm());
  return (x - a - out).squaredNorm() < kEncroaching * out.squaredNorm();
}

}  // namespace

const LocalOperations::Sphere& LocalOperations::circumsphere(Index t) {
  if (spheres_.empty()) spheres_.resize(mesh_.tet_capacity());
  Sphere& s = spheres_[t];
  if (s.squared_radius >= 0) return s;
  const auto& corner = mesh_.tet(t);
  const Vector3d& a = mesh_.position(corner[0]);
  const Vector3d u = mesh_.position(corner[1]) - a, v = mesh_.position(corner[2]) - a,
                 w = mesh_.position(corner[3]) - a, vw = v.cross(w);
  const Vector3d out =
      (u.squaredNorm() * vw + v.squaredNorm() * w.cross(u) + w.squaredNorm() * u.cross(v)) / (2 * u.dot(vw));
  s.centre = a + out;
  s.squared_radius = out.squaredNorm();
  return s;
}

double LocalOperations::squared_radius_edge(Index t) {
  return circumsphere(t).squared_radius / squared_shortest_edge(t);
}

double LocalOperations::squared_shortest_edge(Index t) const {
  const auto& c = mesh_.tet(t);
  const Vector3d &p = mesh_.position(c[0]), &q = mesh_.position(c[1]), &r = mesh_.position(c[2]),
                 &s = mesh_.position(c[3]);
  return std::min({(p - q).squaredNorm(), (p - r).squaredNorm(), (p - s).squaredNorm(), (q - r).squaredNorm(),
                   (q - s).squaredNorm(), (r - s).squaredNorm()});
}

bool LocalOperations::insert_circumcentre(Index t) {
  const Vector3d x = circumsphere(t).centre;
  const double room = squared_shortest_edge(t);
  if (!x.allFinite()) return false;

  // The tet that contains x, in the complex: from tet to tet across faces that x is beyond.
  const auto sees = [&](const Face& f) {
    const Vector3d& a = mesh_.position(f[0]);
    return (mesh_.position(f[1]) - a).cross(mesh_.position(f[2]) - a).dot(x - a) > 0;
  };
  Index at = t, from = -1;
  for (int step = 0;; ++step) {
    if (step == kLongestWalk) return false;
    Index beyond = at;
    for (int k = 0; k < 4 && beyond == at; ++k)
      if (const Index u = mesh_.neighbour(at, k); u != from && !sees(inner_face(at, k))) beyond = u;
    if (beyond < 0) return false;
    if (beyond == at) break;
    from = at;
    at = beyond;
  }

  cavity_ = {at};
  const std::uint32_t inside = ++tet_stamp_;
  tet_mark_[at] = inside;
  for (std::size_t i = 0; i < cavity_.size(); ++i) {
    if (cavity_.size() > kLargestDelaunayCavity) return false;
    for (const Index v : mesh_.tet(cavity_[i]))
      if ((mesh_.position(v) - x).squaredNorm() < room) return false;
    for (int k = 0; k < 4; ++k) {
      const Index u = mesh_.neighbour(cavity_[i], k);
      if (u < 0) {
        const Face f = inner_face(cavity_[i], k);
        if (in_smallest_sphere(mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), x))
          return false;
        continue;
      }
      if (tet_mark_[u] == inside) continue;
      const Sphere& s = circumsphere(u);
      if (!((x - s.centre).squaredNorm() < s.squared_radius)) continue;
      tet_mark_[u] = inside;
      cavity_.push_back(u);
    }
  }
  if (tet_mark_[t] != inside) return false;
  // Tets with a face that x does not see stay, until x sees all of the hull.
  for (bool shrunk = true; shrunk;) {
    shrunk = false;
    std::size_t kept = 0;
    for (const Index u : cavity_) {
      bool visible = true;
      for (int k = 0; k < 4 && visible; ++k) {
        const Index w = mesh_.neighbour(u, k);
        if (w >= 0 && tet_mark_[w] == inside) continue;
        const Face f = inner_face(u, k);
        visible = min_dihedral_sine(mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), x) > 0;
      }
      if (visible) {
        cavity_[kept++] = u;
      } else {
        tet_mark_[u] = 0;
        shrunk = true;
      }
    }
    cavity_.resize(kept);
  }
  if (tet_mark_[t] != inside || !hull_of(cavity_, hull_)) return false;
  return fill(cavity_, x);
}

}  // namespace overtet
