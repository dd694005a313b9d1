// LocalOperations: where a vertex is placed best.
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <optional>
#include <span>

#include "kernels/core/tuning.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

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
        const double height = g[i].dot(normal);
        // Most planes are farther away than what is known; the squared distance has few roundings.
        if (nn == 0 || height * height > norm * nn * (1 + kRounding)) continue;
        const Vector3d p = normal * (height / nn), q = p - g[i];
        const double u = q.cross(f).dot(normal), w = e.cross(q).dot(normal);
        if (u > 0 && w > 0 && u + w < nn) take(p);
      }
  return best;
}

}  // namespace

void LocalOperations::load_bases() {
  bases_.clear();
  for (const Face& f : faces_)
    bases_.push_back({mesh_.position(f[0]), mesh_.position(f[1]), mesh_.position(f[2]), 1, 0});
}

double LocalOperations::quality_at(const Vector3d& x, double stop) {
  double q = HUGE_VAL;
  for (std::size_t i = 0; i < bases_.size(); ++i) {
    const double here = bases_[i].weight * min_dihedral_sine(bases_[i].a, bases_[i].b, bases_[i].c, x);
    if (here >= q) continue;
    q = here;
    // The next trial is likely to fail at the same place: look there first.
    if (i > 0) std::swap(bases_[i], bases_[i / 2]);
    if (q <= stop) return q;
  }
  return q;
}

void LocalOperations::load_fan() {
  fan_.clear();
  for (const Base& f : bases_) fan_.add(f.a, f.b, f.c, f.weight);
}

double LocalOperations::gather_sines(const Vector3d& x, std::vector<LogSine>& all) {
  static thread_local std::vector<TetFan::Sine> sines;
  fan_.sines_near_worst(x, kFarFromWorst, sines);
  all.clear();
  double least = HUGE_VAL;
  for (const TetFan::Sine& s : sines) {
    const double value = std::log(std::max(s.sine, 1e-40));
    if (!std::isfinite(value) || !s.log_gradient.allFinite()) continue;
    all.push_back({value, s.log_gradient});
    least = std::min(least, value);
  }
  return least;
}

std::optional<LocalOperations::Uphill> LocalOperations::uphill(const std::vector<LogSine>& all,
                                                               double limit) {
  std::array<Vector3d, kMostActive> active;
  active.fill(Vector3d::Zero());
  std::array<double, kMostActive> value{};
  int n = 0;
  for (const LogSine& a : all) {
    if (a.value > limit) continue;
    if (n < kMostActive) {
      active[n] = a.gradient;
      value[n++] = a.value;
    } else {
      const int worst_kept = static_cast<int>(std::max_element(value.begin(), value.end()) - value.begin());
      if (a.value < value[worst_kept]) {
        active[worst_kept] = a.gradient;
        value[worst_kept] = a.value;
      }
    }
  }
  const Vector3d y = nearest_to_origin(active.data(), n);
  const double yy = y.norm();
  if (!(yy > 0) || !std::isfinite(yy)) return std::nullopt;
  Uphill out{y / yy, HUGE_VAL};
  for (int i = 0; i < n; ++i) out.slope = std::min(out.slope, active[i].dot(out.direction));
  if (!(out.slope > 1e-3 * yy)) return std::nullopt;
  return out;
}

double LocalOperations::end_of_way(const Vector3d& x, const Vector3d& direction) const {
  // Volumes are linear along the way.
  double end = HUGE_VAL;
  for (const Base& f : bases_) {
    const Vector3d normal = (f.b - f.a).cross(f.c - f.a);
    const double rate = normal.dot(direction);
    if (rate < 0) end = std::min(end, std::max(normal.dot(x - f.a), 0.0) / -rate);
  }
  return end;
}

double LocalOperations::climb(Vector3d& x, double q, const Uphill& way, double step, double end) {
  const double least_gain = thorough_ ? 0 : kLeastStepGain;
  const Vector3d from = x;
  for (int halving = 0; halving < kMostHalvings && step * way.slope > least_gain; ++halving, step *= 0.5) {
    const Vector3d trial = from + step * way.direction;
    const double here = fan_.worst_at(trial, q);
    if (!(here > q)) continue;
    q = here;
    x = trial;
    if (halving > 0) break;
    // Right at the first try: go on as long as it pays.
    for (double longer = 2 * step; longer < 0.9 * end; longer *= 2) {
      const Vector3d far = from + longer * way.direction;
      const double there = fan_.worst_at(far, q);
      if (!(there > q)) break;
      q = there;
      x = far;
    }
    break;
  }
  return q;
}

double LocalOperations::optimise(Vector3d& x, double q, int rounds) {
  const std::span<const double> factors = thorough_ ? std::span<const double>(kAllFactors) : kActiveFactor;
  static thread_local std::vector<LogSine> all;
  if (bases_.empty()) return q;
  load_fan();
  for (int round = 0; round < rounds; ++round) {
    const double least = gather_sines(x, all);
    if (all.empty()) return q;
    bool moved = false;
    for (const double factor : factors) {
      const double limit = least + std::log(factor);
      const std::optional<Uphill> way = uphill(all, limit);
      if (!way) continue;
      const double end = end_of_way(x, way->direction);
      if (!(end > 0) || !std::isfinite(end)) continue;
      // Where the linear model says that another function becomes the worst.
      double step = 0.7 * end;
      for (const LogSine& a : all) {
        const double s = a.gradient.dot(way->direction);
        if (a.value > limit && s < way->slope) step = std::min(step, (a.value - least) / (way->slope - s));
      }
      Vector3d best = x;
      const double reached = climb(best, q, *way, std::max(step, 1e-3 * end), end);
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
  load_star(v);
  return !star_.empty();
}

void LocalOperations::load_star(Index v) {
  mesh_.star(v, star_);
  faces_.clear();
  for (const Index t : star_) faces_.push_back(inner_face(t, mesh_.corner(t, v)));
  load_bases();
}

bool LocalOperations::smooth(Index v, double gain) {
  if (!star_of_free(v)) return false;
  const double before = worst(star_);
  Vector3d x = mesh_.position(v);
  const double after = optimise(x, before, 6);
  if (!(after > before * gain) || !may_move(v, x)) return false;
  mesh_.move(v, x);
  refresh(star_);
  changed_ = star_;
  return true;
}

bool LocalOperations::smooth_within(Index v, const Vector3d& centre, double radius) {
  load_star(v);
  if (star_.empty()) return false;
  const double before = worst(star_);
  Vector3d x = mesh_.position(v);
  double after = optimise(x, before, 6);
  if (const double far = (x - centre).norm(); far > radius) {
    // Back to the ball; a little inside, so that rounding does not lead out.
    x = centre + (radius * (1 - 1e-12) / far) * (x - centre);
    after = quality_at(x, before);
  }
  return after > before * kAnyGain && place(v, x);
}

bool LocalOperations::move_towards(Index v, const Vector3d& target) {
  if (!star_of_free(v)) return false;
  const double before = worst(star_);
  const Vector3d from = mesh_.position(v);
  Vector3d best = from;
  double reached = before * kAnyGain;
  for (double step = 1; step > 0.05; step *= 0.5) {
    const Vector3d x = from + step * (target - from);
    const double q = quality_at(x, reached);
    if (q > reached) {
      reached = q;
      best = x;
    }
  }
  if (best == from || !may_move(v, best)) return false;
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

}  // namespace overtet
