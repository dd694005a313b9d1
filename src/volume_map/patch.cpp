#include "src/volume_map/patch.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "kernels/core/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"
#include "kernels/tet_energy/tet_energy.h"
#include "src/volume_map/potential.h"
#include "src/volume_map/tuning.h"

namespace overtet::volume_map_detail {

namespace {

using Eigen::Vector3d;

}  // namespace

std::vector<Patch> grow_patches(const TetComplex& mesh, Index boundary, const std::vector<Index>& seeds,
                                int interior_rings, int boundary_rings, const std::vector<char>& may_move) {
  std::vector<int> ring(mesh.vertex_count(), -1);
  std::vector<Index> queue, star;
  for (const Index v : seeds)
    if (ring[v] < 0) {
      ring[v] = 0;
      queue.push_back(v);
    }
  const int most = std::max(interior_rings, boundary_rings);
  for (std::size_t i = 0; i < queue.size(); ++i) {
    const Index v = queue[i];
    if (ring[v] >= most) continue;
    mesh.star(v, star);
    for (const Index t : star)
      for (const Index w : mesh.tet(t))
        if (ring[w] < 0) {
          ring[w] = ring[v] + 1;
          queue.push_back(w);
        }
  }
  std::vector<char> free(mesh.vertex_count(), 0);
  for (const Index v : queue)
    free[v] = v < boundary ? ring[v] <= boundary_rings && may_move[v] : ring[v] <= interior_rings;
  std::sort(queue.begin(), queue.end());
  std::vector<Patch> patches;
  std::vector<char> in_tets(mesh.tet_capacity(), 0);
  for (const Index seed : queue) {
    if (free[seed] != 1) continue;
    Patch patch;
    patch.free.push_back(seed);
    free[seed] = 2;
    for (std::size_t i = 0; i < patch.free.size(); ++i) {
      mesh.star(patch.free[i], star);
      for (const Index t : star) {
        if (in_tets[t]) continue;
        in_tets[t] = 1;
        patch.tets.push_back(t);
        for (const Index w : mesh.tet(t))
          if (free[w] == 1) {
            free[w] = 2;
            patch.free.push_back(w);
          }
      }
    }
    std::sort(patch.free.begin(), patch.free.end());
    std::sort(patch.tets.begin(), patch.tets.end());
    patches.push_back(std::move(patch));
  }
  return patches;
}

std::vector<std::array<Index, 4>> edge_ring(const TetComplex& mesh, Index a, Index b) {
  std::vector<std::array<Index, 4>> out;
  const Index t = mesh.tet_with_edge(a, b);
  if (t < 0) return out;
  std::vector<Index> tets, link;
  mesh.ring(t, a, b, tets, link);
  for (std::size_t i = 0; i < tets.size(); ++i) out.push_back({a, b, link[i], link[(i + 1) % link.size()]});
  return out;
}

double interior_angle(const TetComplex& mesh, Index a, Index b) {
  double sum = 0;
  for (const auto& c : edge_ring(mesh, a, b))
    sum += dihedral_angle(mesh.position(c[0]), mesh.position(c[1]), mesh.position(c[2]), mesh.position(c[3]));
  return sum;
}

PatchNewton::PatchNewton(const TetComplex& mesh, const Patch& patch, const VertexMatrix& target,
                         const std::vector<double>& length)
    : patch_(patch),
      target_(target),
      length_(length),
      free_(static_cast<Index>(patch.free.size())),
      factor_({CholeskyOptions::Ordering::amd, CholeskyOptions::Method::automatic}) {
  std::vector<Index> held;
  const auto free_number = [&](Index v) -> Index {
    const auto i = std::lower_bound(patch.free.begin(), patch.free.end(), v);
    return i != patch.free.end() && *i == v ? static_cast<Index>(i - patch.free.begin()) : -1;
  };
  for (const Index t : patch.tets)
    for (const Index v : mesh.tet(t))
      if (free_number(v) < 0) held.push_back(v);
  std::sort(held.begin(), held.end());
  held.erase(std::unique(held.begin(), held.end()), held.end());
  const auto number = [&](Index v) -> Index {
    if (const Index f = free_number(v); f >= 0) return f;
    return free_ + static_cast<Index>(std::lower_bound(held.begin(), held.end(), v) - held.begin());
  };
  const auto numbers = [&](const Corners& c) {
    return Corners{number(c[0]), number(c[1]), number(c[2]), number(c[3])};
  };
  for (const Index v : patch.free) at_.push_back(mesh.position(v));
  for (const Index v : held) at_.push_back(mesh.position(v));
  for (const Index t : patch.tets) tets_.push_back(numbers(mesh.tet(t)));
  for (const AngleGoal& goal : patch.goals) {
    Ring ring{{}, goal.angle};
    for (const Corners& c : goal.ring) ring.corners.push_back(numbers(c));
    if (!ring.corners.empty()) rings_.push_back(std::move(ring));
  }
}

std::vector<double> PatchNewton::weights(const PatchForces& forces) const {
  std::vector<double> w(static_cast<std::size_t>(free_), 0);
  if (!(forces.pull > 0)) return w;
  for (Index i = 0; i < free_; ++i) {
    const Index v = patch_.free[i];
    if (v >= target_.rows()) continue;
    w[i] = forces.pull / (length_[v] * length_[v]);
  }
  return w;
}

double PatchNewton::energy_at(const PatchForces& forces, const std::vector<double>& weights,
                              const std::vector<Vector3d>& at) const {
  double sum = parallel_reduce(
      static_cast<std::int64_t>(tets_.size()), kMediumGrain, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        double part = 0;
        for (std::int64_t i = begin; i < end; ++i) {
          const Corners& c = tets_[i];
          part += shape_energy(at[c[0]], at[c[1]], at[c[2]], at[c[3]], 1, 0);
          if (!std::isfinite(part)) return std::numeric_limits<double>::infinity();
        }
        return part;
      },
      [](double a, double b) { return a + b; });
  for (Index i = 0; i < free_; ++i)
    if (weights[i] > 0)
      sum += weights[i] *
             potential((at[i] - target_.row(patch_.free[i]).transpose()).squaredNorm(), forces.reach).value;
  if (forces.angle_weight > 0)
    for (const Ring& ring : rings_) {
      double angle = 0;
      for (const Corners& c : ring.corners) angle += dihedral_angle(at[c[0]], at[c[1]], at[c[2]], at[c[3]]);
      sum += forces.angle_weight * (angle - ring.goal) * (angle - ring.goal);
    }
  return sum;
}

double PatchNewton::energy(const PatchForces& forces) const {
  return energy_at(forces, weights(forces), at_);
}

bool PatchNewton::all_positive(const std::vector<Vector3d>& to, Moment when) const {
  const auto both = [](bool a, bool b) { return a && b; };
  return parallel_reduce(
      static_cast<std::int64_t>(tets_.size()), kMediumGrain, true,
      [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin; i < end; ++i) {
          const Corners& c = tets_[i];
          if (when == Moment::on_the_way) {
            const Vector3d before[4] = {at_[c[0]], at_[c[1]], at_[c[2]], at_[c[3]]};
            const Vector3d after[4] = {to[c[0]], to[c[1]], to[c[2]], to[c[3]]};
            if (!positive_on_the_way(before, after)) return false;
          } else if (orient3d(to[c[0]].data(), to[c[1]].data(), to[c[2]].data(), to[c[3]].data()) <= 0) {
            return false;
          }
        }
        return true;
      },
      both);
}

// The pattern: a block for every two free vertices of a tet or of an angle's tets.
bool PatchNewton::analyze() {
  std::vector<std::uint64_t> pairs;
  const auto add = [&](Index v, Index w) {
    if (!is_free(v) || !is_free(w)) return;
    pairs.push_back(static_cast<std::uint64_t>(std::min(v, w)) << 32 |
                    static_cast<std::uint32_t>(std::max(v, w)));
  };
  for (const Corners& c : tets_)
    for (int k = 0; k < 4; ++k)
      for (int l = k; l < 4; ++l) add(c[k], c[l]);
  for (const Ring& ring : rings_)
    for (const Corners& c : ring.corners)
      for (const Corners& d : ring.corners)
        for (const Index v : c)
          for (const Index w : d) add(v, w);
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  hessian_.block_start.assign(static_cast<std::size_t>(free_) + 1, 0);
  hessian_.block_rows.clear();
  for (const std::uint64_t pair : pairs) {
    ++hessian_.block_start[(pair >> 32) + 1];
    hessian_.block_rows.push_back(static_cast<Index>(pair & 0xffffffffu));
  }
  for (Index v = 0; v < free_; ++v) hessian_.block_start[v + 1] += hessian_.block_start[v];
  hessian_.matrix.resize(3 * free_, 3 * free_);
  hessian_.matrix.resizeNonZeros(9 * static_cast<Eigen::Index>(pairs.size()) - 3 * free_);
  int* const start = hessian_.matrix.outerIndexPtr();
  int* const rows = hessian_.matrix.innerIndexPtr();
  int at = 0;
  for (Index v = 0; v < free_; ++v)
    for (int j = 0; j < 3; ++j) {
      start[3 * v + j] = at;
      for (Index b = hessian_.block_start[v]; b < hessian_.block_start[v + 1]; ++b)
        for (int i = b == hessian_.block_start[v] ? j : 0; i < 3; ++i)
          rows[at++] = 3 * hessian_.block_rows[b] + i;
    }
  start[3 * free_] = at;
  return factor_.analyze(hessian_.matrix);
}

PatchNewton::Block PatchNewton::block(Index row, Index column) const {
  const int* const start = hessian_.matrix.outerIndexPtr() + 3 * column;
  if (row == column) return {{start[0], start[1], start[2]}, true};
  const auto first = hessian_.block_rows.begin() + hessian_.block_start[column];
  const auto p = static_cast<int>(
      std::lower_bound(first, hessian_.block_rows.begin() + hessian_.block_start[column + 1], row) - first -
      1);
  return {{start[0] + 3 + 3 * p, start[1] + 2 + 3 * p, start[2] + 1 + 3 * p}, false};
}

// The energy here, its gradient and its Hessian; an infinite energy where there is none.
double PatchNewton::assemble(const PatchForces& forces, const std::vector<double>& weights) {
  double* const values = hessian_.matrix.valuePtr();
  std::fill(values, values + hessian_.matrix.nonZeros(), 0.0);
  gradient_ = Eigen::VectorXd::Zero(3 * free_);
  // add(r, s): the entry of row r and column s of a block.
  const auto put = [&](Index v, Index w, const auto& entry) {
    if (v < w) return;  // the other triangle
    const Block b = block(v, w);
    for (int s = 0; s < 3; ++s)
      for (int r = b.diagonal ? s : 0; r < 3; ++r)
        values[b.column[s] + r - (b.diagonal ? s : 0)] += entry(r, s);
  };
  double energy = 0, part = 0;
  // Hessians are made by all threads, a few megabytes at a time, and added up in the order of the tets.
  constexpr std::size_t at_a_time = 2 * kLightGrain;
  std::vector<TetEnergy> buffer(std::min(at_a_time, tets_.size()));
  for (std::size_t first = 0; first < tets_.size(); first += at_a_time) {
    const std::size_t n = std::min(at_a_time, tets_.size() - first);
    parallel_for(static_cast<std::int64_t>(n), kMediumGrain / 4, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const Corners& c = tets_[first + static_cast<std::size_t>(i)];
        shape_energy(at_[c[0]], at_[c[1]], at_[c[2]], at_[c[3]], 1, 0, buffer[i]);
      }
    });
    for (std::size_t i = 0; i < n; ++i) {
      const TetEnergy& e = buffer[i];
      const Corners& c = tets_[first + i];
      part += e.value;
      if (!std::isfinite(part)) return part;
      if ((first + i + 1) % kMediumGrain == 0) energy += part, part = 0;  // bracketed as energy_at() does
      for (int k = 0; k < 4; ++k) {
        if (!is_free(c[k])) continue;
        gradient_.segment<3>(3 * c[k]) += e.gradient.segment<3>(3 * k);
        for (int l = 0; l < 4; ++l)
          if (is_free(c[l])) put(c[k], c[l], [&](int r, int s) { return e.hessian(3 * k + r, 3 * l + s); });
      }
    }
  }
  energy += part;
  for (Index i = 0; i < free_; ++i) {
    if (!(weights[i] > 0)) continue;
    const Vector3d d = at_[i] - target_.row(patch_.free[i]).transpose();
    const Potential p = potential(d.squaredNorm(), forces.reach);
    energy += weights[i] * p.value;
    gradient_.segment<3>(3 * i) += 2 * weights[i] * p.slope * d;
    put(i, i,
        [&](int r, int s) { return weights[i] * ((r == s ? 2 * p.slope : 0) + 4 * p.bend * d[r] * d[s]); });
  }
  if (forces.angle_weight > 0)
    for (const Ring& ring : rings_) {
      std::map<Index, Vector3d> slope;
      double angle = 0;
      Eigen::Matrix<double, 12, 1> g;
      for (const Corners& c : ring.corners) {
        angle += dihedral_angle(at_[c[0]], at_[c[1]], at_[c[2]], at_[c[3]], &g);
        for (int k = 0; k < 4; ++k)
          if (is_free(c[k])) {
            const auto [to, fresh] = slope.try_emplace(c[k], Vector3d::Zero());
            to->second += g.segment<3>(3 * k);
          }
      }
      const double d = angle - ring.goal;
      energy += forces.angle_weight * d * d;
      for (const auto& [v, gv] : slope) {
        gradient_.segment<3>(3 * v) += 2 * forces.angle_weight * d * gv;
        for (const auto& [w, gw] : slope)
          put(v, w, [&](int r, int s) { return 2 * forces.angle_weight * gv[r] * gw[s]; });
      }
    }
  // The shape energy does not feel translations and scale of a patch without fixed corners. Relative to each
  // entry: tets of very different sizes may be in one patch, and tiny ones must not hold the others.
  for (Index v = 0; v < free_; ++v) {
    const Block b = block(v, v);
    for (const int at : b.column) values[at] *= 1 + kRounding;
  }
  return energy;
}

bool PatchNewton::step(const PatchForces& forces) {
  if (free_ == 0) return false;
  if (!analyzed_ && !analyze()) return false;
  analyzed_ = true;
  work_ += factor_.factor_entries() + kTetCost * static_cast<double>(tets_.size());
  const std::vector<double> weights = this->weights(forces);
  const double energy = assemble(forces, weights);
  if (!std::isfinite(energy) || !factor_.factor(hessian_.matrix)) return false;
  VertexMatrix direction = VertexMatrix::Zero(3 * free_, 3);
  direction.col(0) = -gradient_;
  if (!factor_.solve(direction, direction) || !direction.col(0).allFinite()) return false;
  const double slope = gradient_.dot(direction.col(0));
  if (!(slope < 0)) return false;

  std::vector<Vector3d> to = at_;
  double part = 1;
  int halving = 0;
  for (; halving < kHalvings; ++halving, part *= 0.5) {
    for (Index i = 0; i < free_; ++i)
      for (int k = 0; k < 3; ++k) to[i][k] = at_[i][k] + part * direction(3 * i + k, 0);
    if (all_positive(to, Moment::on_the_way) &&
        energy_at(forces, weights, to) <= energy + kArmijo * part * slope)
      break;
  }
  if (halving == kHalvings) return false;
  // Exact positivity decides; rounding may say no at the end of a good way: go half of it.
  for (halving = 0; !all_positive(to, Moment::at_the_end); ++halving) {
    if (halving == kHalvings) return false;
    for (Index i = 0; i < free_; ++i) to[i] = 0.5 * (to[i] + at_[i]);
  }
  at_ = std::move(to);
  return true;
}

}  // namespace overtet::volume_map_detail
