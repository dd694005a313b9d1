#include "src/volume_map/patch.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "kernels/sparse/cholesky.h"
#include "kernels/tet_energy/tet_energy.h"

namespace overtet::volume_map_detail {

namespace {

using Eigen::Vector3d;

constexpr double kArmijo = 1e-4;
constexpr int kHalvings = 14;

// Marks the patch's vertices in a table for the life of this object.
struct LocalNumbers {
  LocalNumbers(std::vector<Index>& table, const std::vector<Index>& vertices, Index count)
      : table(table), vertices(vertices) {
    if (static_cast<Index>(table.size()) < count) table.resize(count, -1);
    for (std::size_t i = 0; i < vertices.size(); ++i) table[vertices[i]] = static_cast<Index>(i);
  }
  ~LocalNumbers() {
    for (const Index v : vertices) table[v] = -1;
  }
  std::vector<Index>& table;
  const std::vector<Index>& vertices;
};

}  // namespace

PatchSolver::PatchSolver(const VertexMatrix& target, const std::vector<double>& length)
    : target_(target), length_(length) {}

std::vector<Patch> PatchSolver::grow(const TetComplex& mesh, const std::vector<Index>& seeds,
                                     int interior_rings, int boundary_rings,
                                     const std::vector<char>& may_move) {
  const Index nb = static_cast<Index>(target_.rows());
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
    free[v] = v < nb ? ring[v] <= boundary_rings && may_move[v] : ring[v] <= interior_rings;
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

double PatchSolver::interior_angle(const TetComplex& mesh, Index a, Index b) {
  const Index t = mesh.tet_with_edge(a, b);
  if (t < 0) return 0;
  std::vector<Index> tets, link;
  mesh.ring(t, a, b, tets, link);
  double sum = 0;
  for (std::size_t i = 0; i < tets.size(); ++i)
    sum += dihedral_angle(mesh.position(a), mesh.position(b), mesh.position(link[i]),
                          mesh.position(link[(i + 1) % link.size()]));
  return sum;
}

std::vector<PatchSolver::Ring> PatchSolver::rings(const TetComplex& mesh, const Patch& patch) const {
  std::vector<Ring> out;
  std::vector<Index> tets, link;
  for (const AngleGoal& goal : patch.goals) {
    const Index t = mesh.tet_with_edge(goal.a, goal.b);
    if (t < 0) continue;
    mesh.ring(t, goal.a, goal.b, tets, link);
    Ring ring;
    ring.goal = goal.angle;
    for (std::size_t i = 0; i < tets.size(); ++i)
      ring.corners.push_back({goal.a, goal.b, link[i], link[(i + 1) % link.size()]});
    out.push_back(std::move(ring));
  }
  return out;
}

double PatchSolver::energy_at(const TetComplex& mesh, const Patch& patch, const PatchForces& forces,
                              const std::vector<Ring>& rings, const std::vector<Vector3d>& moved) const {
  const auto at = [&](Index v) -> const Vector3d& {
    return local_[v] >= 0 ? moved[local_[v]] : mesh.position(v);
  };
  double sum = 0;
  for (std::size_t i = 0; i < patch.tets.size(); ++i) {
    const auto& c = mesh.tet(patch.tets[i]);
    sum += shape_energy(at(c[0]), at(c[1]), at(c[2]), at(c[3]), patch.size.empty() ? 1 : patch.size[i],
                        forces.eps);
    if (!std::isfinite(sum)) return std::numeric_limits<double>::infinity();
  }
  if (forces.pull > 0)
    for (std::size_t i = 0; i < patch.free.size(); ++i)
      if (const Index v = patch.free[i]; v < target_.rows())
        sum += forces.pull_at(v) * (moved[i] - target_.row(v).transpose()).squaredNorm() /
               (length_[v] * length_[v]);
  if (forces.angle_weight > 0)
    for (const Ring& ring : rings) {
      double angle = 0;
      for (const auto& c : ring.corners) angle += dihedral_angle(at(c[0]), at(c[1]), at(c[2]), at(c[3]));
      sum += forces.angle_weight * (angle - ring.goal) * (angle - ring.goal);
    }
  return sum;
}

double PatchSolver::energy(const TetComplex& mesh, const Patch& patch, const PatchForces& forces) const {
  const LocalNumbers numbers(local_, patch.free, mesh.vertex_count());
  std::vector<Vector3d> here;
  for (const Index v : patch.free) here.push_back(mesh.position(v));
  return energy_at(mesh, patch, forces, rings(mesh, patch), here);
}

bool PatchSolver::step(const TetComplex& mesh, const Patch& patch, const PatchForces& forces,
                       std::vector<Vector3d>& positions) {
  const LocalNumbers numbers(local_, patch.free, mesh.vertex_count());
  const int n = static_cast<int>(patch.free.size());
  if (n == 0) return false;
  const std::vector<Ring> angle_rings = forces.angle_weight > 0 ? rings(mesh, patch) : std::vector<Ring>{};

  Eigen::VectorXd gradient = Eigen::VectorXd::Zero(3 * n);
  std::vector<Eigen::Triplet<double, int>> entries;
  entries.reserve(patch.tets.size() * 78);
  const auto add = [&](Index v, Index w, int i, int j, double x) {
    const int row = 3 * local_[v] + i, column = 3 * local_[w] + j;
    if (row >= column) entries.emplace_back(row, column, x);
  };
  double energy = 0;
  TetEnergy e;
  for (std::size_t i = 0; i < patch.tets.size(); ++i) {
    const auto& c = mesh.tet(patch.tets[i]);
    shape_energy(mesh.position(c[0]), mesh.position(c[1]), mesh.position(c[2]), mesh.position(c[3]),
                 patch.size.empty() ? 1 : patch.size[i], forces.eps, e);
    if (!std::isfinite(e.value)) return false;
    energy += e.value;
    for (int k = 0; k < 4; ++k) {
      if (local_[c[k]] < 0) continue;
      gradient.segment<3>(3 * local_[c[k]]) += e.gradient.segment<3>(3 * k);
      for (int l = 0; l < 4; ++l) {
        if (local_[c[l]] < 0) continue;
        for (int r = 0; r < 3; ++r)
          for (int s = 0; s < 3; ++s) add(c[k], c[l], r, s, e.hessian(3 * k + r, 3 * l + s));
      }
    }
  }
  if (forces.pull > 0)
    for (int i = 0; i < n; ++i) {
      const Index v = patch.free[i];
      if (v >= target_.rows()) continue;
      const double w = forces.pull_at(v) / (length_[v] * length_[v]);
      const Vector3d d = mesh.position(v) - target_.row(v).transpose();
      energy += w * d.squaredNorm();
      gradient.segment<3>(3 * i) += 2 * w * d;
      for (int r = 0; r < 3; ++r) add(v, v, r, r, 2 * w);
    }
  for (const Ring& ring : angle_rings) {
    std::map<Index, Vector3d> slope;
    double angle = 0;
    Eigen::Matrix<double, 12, 1> g;
    for (const auto& c : ring.corners) {
      angle += dihedral_angle(mesh.position(c[0]), mesh.position(c[1]), mesh.position(c[2]),
                              mesh.position(c[3]), &g);
      for (int k = 0; k < 4; ++k)
        if (local_[c[k]] >= 0) {
          const auto [at, fresh] = slope.try_emplace(c[k], Vector3d::Zero());
          at->second += g.segment<3>(3 * k);
        }
    }
    const double d = angle - ring.goal;
    energy += forces.angle_weight * d * d;
    for (const auto& [v, gv] : slope) {
      gradient.segment<3>(3 * local_[v]) += 2 * forces.angle_weight * d * gv;
      for (const auto& [w, gw] : slope)
        for (int r = 0; r < 3; ++r)
          for (int s = 0; s < 3; ++s) add(v, w, r, s, 2 * forces.angle_weight * gv[r] * gw[s]);
    }
  }
  // The shape energy does not feel translations and scale of a patch without fixed corners. Relative to each
  // entry: tets of very different sizes may be in one patch, and tiny ones must not hold the others.
  Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(3 * n);
  for (const auto& t : entries)
    if (t.row() == t.col()) diagonal[t.row()] += t.value();
  for (int i = 0; i < 3 * n; ++i) entries.emplace_back(i, i, 1e-9 * diagonal[i]);
  SymmetricMatrix H(3 * n, 3 * n);
  H.setFromTriplets(entries.begin(), entries.end());
  SparseCholesky factor({CholeskyOptions::Ordering::amd, CholeskyOptions::Method::automatic});
  if (!factor.analyze(H) || !factor.factor(H)) return false;
  VertexMatrix B = VertexMatrix::Zero(3 * n, 3);
  B.col(0) = -gradient;
  if (!factor.solve(B, B) || !B.col(0).allFinite()) return false;
  const Eigen::VectorXd direction = B.col(0);
  const double slope = gradient.dot(direction);
  if (!(slope < 0)) return false;

  positions.resize(n);
  double length = 1;
  for (int halving = 0; halving < kHalvings; ++halving, length *= 0.5) {
    for (int i = 0; i < n; ++i)
      positions[i] = mesh.position(patch.free[i]) + length * direction.segment<3>(3 * i);
    if (forces.eps == 0) {
      bool positive = true;
      for (const Index t : patch.tets) {
        Vector3d from[4], to[4];
        for (int k = 0; k < 4; ++k) {
          const Index v = mesh.tet(t)[k];
          from[k] = mesh.position(v);
          to[k] = local_[v] >= 0 ? positions[local_[v]] : from[k];
        }
        if (!positive_on_the_way(from, to)) {
          positive = false;
          break;
        }
      }
      if (!positive) continue;
    }
    if (energy_at(mesh, patch, forces, angle_rings, positions) <= energy + kArmijo * length * slope)
      return true;
  }
  return false;
}

}  // namespace overtet::volume_map_detail
