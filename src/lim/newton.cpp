#include "src/lim/newton.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"

namespace overtet::lim_detail {

namespace {

using Corners = Eigen::Matrix<double, 3, 4>;

// Volume at t, times 6, as Bernstein coefficients on [0, 1] of the cubic.
std::array<double, 4> volumes_on_the_way(const Corners& from, const Corners& to) {
  Eigen::Vector3d p[3], q[3];
  for (int k = 0; k < 3; ++k) p[k] = from.col(k + 1) - from.col(0), q[k] = to.col(k + 1) - to.col(0);
  const auto det = [](const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& c) {
    return a.dot(b.cross(c));
  };
  return {det(p[0], p[1], p[2]), (det(q[0], p[1], p[2]) + det(p[0], q[1], p[2]) + det(p[0], p[1], q[2])) / 3,
          (det(p[0], q[1], q[2]) + det(q[0], p[1], q[2]) + det(q[0], q[1], p[2])) / 3, det(q[0], q[1], q[2])};
}

// How far on the way, at most `most` of it, the tet is certain to be positive.
double positive_until(const Corners& from, const Corners& to, double most) {
  std::array<double, 4> b = volumes_on_the_way(from, to);
  double t = 1;
  for (;;) {
    if (t <= most && std::all_of(b.begin(), b.end(), [](double x) { return x > 0; })) return t;
    if (t < kRounding) return 0;
    // The coefficients on the part of the way that is left: de Casteljau.
    const double part = t > most ? most / t : 0.8;
    for (int round = 1; round < 4; ++round)
      for (int i = 3; i >= round; --i) b[i] = (1 - part) * b[i - 1] + part * b[i];
    t = t > most ? most : t * part;
  }
}

}  // namespace

Newton::Newton(const TetMesh& mesh, const VertexMatrix& target, double barrier, double unit)
    : target_(target),
      T_(mesh.T),
      barrier_(barrier),
      unit_(unit),
      x_(mesh.V),
      factor_({CholeskyOptions::Ordering::amd, CholeskyOptions::Method::automatic}) {
  for (std::size_t t = 0; t < static_cast<std::size_t>(T_.rows()); ++t) {
    const Corners c = corners(x_, t);
    rest_.push_back(rest_tet(c.col(0), c.col(1), c.col(2), c.col(3)));
  }
}

Corners Newton::corners(const VertexMatrix& x, std::size_t t) const {
  Corners c;
  for (int k = 0; k < 4; ++k) c.col(k) = x.row(T_(static_cast<Eigen::Index>(t), k)).transpose();
  return c;
}

StrainWeights Newton::weights(std::size_t t) const {
  return {rest_[t].volume / (unit_ * unit_ * unit_), barrier_};
}

Newton::Energies Newton::energies_at(const VertexMatrix& x) const {
  Energies e = parallel_reduce(
      static_cast<std::int64_t>(rest_.size()), kMediumGrain, Energies{},
      [&](std::int64_t begin, std::int64_t end) {
        Energies part;
        for (std::int64_t t = begin; t < end; ++t) {
          const Corners c = corners(x, static_cast<std::size_t>(t));
          StrainWeights w = weights(static_cast<std::size_t>(t));
          const double both = strain_barrier(c, rest_[t], w);
          w.barrier = 0;
          const double strain = strain_barrier(c, rest_[t], w);
          part.strain += strain;
          part.barrier += both - strain;
        }
        return part;
      },
      [](Energies a, const Energies& b) {
        a.strain += b.strain, a.barrier += b.barrier;
        return a;
      });
  e.distance = (x.topRows(target_.rows()) - target_).squaredNorm() / (unit_ * unit_);
  return e;
}

// The pattern: a block for every edge.
bool Newton::analyze() {
  const auto vertices = static_cast<Index>(x_.rows());
  std::vector<std::uint64_t> pairs;
  pairs.reserve(6 * rest_.size() + static_cast<std::size_t>(vertices));
  for (Index v = 0; v < vertices; ++v)
    pairs.push_back((static_cast<std::uint64_t>(v) << 32) | static_cast<std::uint32_t>(v));
  const auto key = [](Index a, Index b) {
    return static_cast<std::uint64_t>(std::min(a, b)) << 32 | static_cast<std::uint32_t>(std::max(a, b));
  };
  for (Eigen::Index t = 0; t < T_.rows(); ++t)
    for (const auto& [i, j] : kTetEdge) pairs.push_back(key(T_(t, i), T_(t, j)));
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  std::vector<Index> begin(static_cast<std::size_t>(vertices) + 1, 0);
  for (const std::uint64_t pair : pairs) ++begin[(pair >> 32) + 1];
  for (Index v = 0; v < vertices; ++v) begin[v + 1] += begin[v];
  hessian_.resize(3 * vertices, 3 * vertices);
  hessian_.resizeNonZeros(9 * static_cast<Eigen::Index>(pairs.size()) -
                          3 * static_cast<Eigen::Index>(vertices));
  int* const start = hessian_.outerIndexPtr();
  int* const rows = hessian_.innerIndexPtr();
  int at = 0;
  diagonal_.resize(static_cast<std::size_t>(vertices));
  for (Index v = 0; v < vertices; ++v)
    for (int j = 0; j < 3; ++j) {
      start[3 * v + j] = at;
      diagonal_[v][j] = at;
      for (Index b = begin[v]; b < begin[v + 1]; ++b)
        for (int i = b == begin[v] ? j : 0; i < 3; ++i)
          rows[at++] = 3 * static_cast<int>(pairs[b] & 0xffffffffu) + i;
    }
  start[3 * vertices] = at;
  blocks_.resize(rest_.size());
  for (Eigen::Index t = 0; t < T_.rows(); ++t)
    for (int e = 0; e < 6; ++e) {
      const Index a = T_(t, kTetEdge[e][0]), b = T_(t, kTetEdge[e][1]), column = std::min(a, b);
      const auto first = pairs.begin() + begin[column];
      const auto p =
          static_cast<int>(std::lower_bound(first, pairs.begin() + begin[column + 1], key(a, b)) - first - 1);
      // After the diagonal block's 3, 2 and 1 entries.
      for (int j = 0; j < 3; ++j) blocks_[t][e][j] = diagonal_[column][j] + 3 - j + 3 * p;
    }
  return factor_.analyze(hessian_);
}

void Newton::assemble(double alpha) {
  double* const values = hessian_.valuePtr();
  std::fill(values, values + hessian_.nonZeros(), 0.0);
  gradient_ = Eigen::VectorXd::Zero(3 * x_.rows());
  // Hessians are made by all threads, a few megabytes at a time, and added up in the order of the tets.
  constexpr std::size_t at_a_time = 2 * kLightGrain;
  std::vector<TetEnergy> buffer(std::min(at_a_time, rest_.size()));
  for (std::size_t first = 0; first < rest_.size(); first += at_a_time) {
    const std::size_t n = std::min(at_a_time, rest_.size() - first);
    parallel_for(static_cast<std::int64_t>(n), kMediumGrain / 4, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        const std::size_t t = first + static_cast<std::size_t>(i);
        strain_barrier(corners(x_, t), rest_[t], weights(t), Curvature::definite, buffer[i]);
      }
    });
    for (std::size_t i = 0; i < n; ++i) {
      const TetEnergy& e = buffer[i];
      const std::size_t t = first + i;
      for (int k = 0; k < 4; ++k) {
        const Index v = T_(static_cast<Eigen::Index>(t), k);
        gradient_.segment<3>(3 * v) += e.gradient.segment<3>(3 * k);
        for (int s = 0; s < 3; ++s)
          for (int r = s; r < 3; ++r) values[diagonal_[v][s] + r - s] += e.hessian(3 * k + r, 3 * k + s);
      }
      for (int edge = 0; edge < 6; ++edge) {
        int row = kTetEdge[edge][0], column = kTetEdge[edge][1];
        if (T_(static_cast<Eigen::Index>(t), row) < T_(static_cast<Eigen::Index>(t), column))
          std::swap(row, column);
        for (int s = 0; s < 3; ++s)
          for (int r = 0; r < 3; ++r)
            values[blocks_[t][edge][s] + r] += e.hessian(3 * row + r, 3 * column + s);
      }
    }
  }
  const double pull = 2 * alpha / (unit_ * unit_);
  for (Eigen::Index v = 0; v < target_.rows(); ++v) {
    gradient_.segment<3>(3 * v) += pull * (x_.row(v) - target_.row(v)).transpose();
    for (int j = 0; j < 3; ++j) values[diagonal_[v][j]] += pull;
  }
  // Where curvatures have been set to zero nothing may hold a vertex.
  double most = 0;
  for (const auto& v : diagonal_)
    for (const int at : v) most = std::max(most, values[at]);
  for (const auto& v : diagonal_)
    for (const int at : v) values[at] += kRounding * values[at] + 1e-16 * most;
}

double Newton::way(const VertexMatrix& direction) const {
  const VertexMatrix to = x_ + direction;
  return parallel_reduce(
      static_cast<std::int64_t>(rest_.size()), kMediumGrain, 1.0,
      [&](std::int64_t begin, std::int64_t end) {
        double part = 1;
        for (std::int64_t t = begin; t < end; ++t)
          part = positive_until(corners(x_, static_cast<std::size_t>(t)),
                                corners(to, static_cast<std::size_t>(t)), part);
        return part;
      },
      [](double a, double b) { return std::min(a, b); });
}

bool Newton::positive_at(const VertexMatrix& x) const {
  return parallel_reduce(
      T_.rows(), kMediumGrain, true,
      [&](std::int64_t begin, std::int64_t end) {
        const auto at = [&](std::int64_t t, int k) {
          return x.data() + 3 * static_cast<std::ptrdiff_t>(T_(t, k));
        };
        for (std::int64_t t = begin; t < end; ++t)
          if (orient3d(at(t, 0), at(t, 1), at(t, 2), at(t, 3)) <= 0) return false;
        return true;
      },
      [](bool a, bool b) { return a && b; });
}

double Newton::step(double alpha, bool& ok) {
  ok = analyzed_ || analyze();
  analyzed_ = ok;
  if (!ok) return 0;
  assemble(alpha);
  ok = factor_.factor(hessian_);
  if (!ok) return 0;
  VertexMatrix solution = VertexMatrix::Zero(gradient_.size(), 3);
  solution.col(0) = -gradient_;
  ok = factor_.solve(solution, solution) && solution.col(0).allFinite();
  if (!ok || !(gradient_.dot(solution.col(0)) < 0)) return 0;
  VertexMatrix direction(x_.rows(), 3);
  for (Eigen::Index i = 0; i < gradient_.size(); ++i) direction.data()[i] = solution(i, 0);
  const double before = energies_at(x_).all(alpha);
  double part = way(direction);
  for (int halving = 0; halving < kMostRounds && part > 0; ++halving, part /= 2) {
    const VertexMatrix to = x_ + part * direction;
    if (!(energies_at(to).all(alpha) < before) || !positive_at(to)) continue;
    x_ = to;
    return part;
  }
  return 0;
}

}  // namespace overtet::lim_detail
