#include "src/repair/smoothing.h"

#include <Eigen/SparseCore>
#include <algorithm>
#include <cmath>

#include "kernels/sparse/cholesky.h"
#include "src/repair/tuning.h"

namespace overtet {

VertexRings::VertexRings(Index vertices, const TriangleMatrix& F) {
  // Of a closed oriented surface: every edge is run along once in each direction.
  start_.assign(static_cast<std::size_t>(vertices) + 1, 0);
  for (Index f = 0; f < F.rows(); ++f)
    for (int k = 0; k < 3; ++k) ++start_[F(f, k) + 1];
  for (Index v = 0; v < vertices; ++v) start_[v + 1] += start_[v];
  next_.resize(static_cast<std::size_t>(start_[vertices]));
  std::vector<Index> fill(start_.begin(), start_.end() - 1);
  for (Index f = 0; f < F.rows(); ++f)
    for (int k = 0; k < 3; ++k) next_[fill[F(f, k)]++] = F(f, (k + 1) % 3);
}

std::vector<Index> VertexRings::grown(const std::vector<Index>& seeds, int rings,
                                      std::vector<char>& scratch) const {
  std::vector<Index> all;
  for (const Index v : seeds)
    if (!scratch[v]) scratch[v] = 1, all.push_back(v);
  std::size_t first = 0;
  for (int ring = 0; ring < rings; ++ring) {
    const std::size_t last = all.size();
    for (; first < last; ++first)
      for (const Index u : (*this)(all[first]))
        if (!scratch[u]) scratch[u] = 1, all.push_back(u);
  }
  for (const Index v : all) scratch[v] = 0;
  std::sort(all.begin(), all.end());
  return all;
}

VertexMatrix smoothed(const VertexMatrix& V, const VertexMatrix& values, const VertexRings& rings,
                      const std::vector<Index>& free, Smoothing kind, const std::vector<float>& part) {
  const auto column = [&](Index v) -> Index {
    const auto i = std::lower_bound(free.begin(), free.end(), v);
    return i != free.end() && *i == v ? static_cast<Index>(i - free.begin()) : -1;
  };
  double mean = 0;
  std::int64_t edges = 0;
  bool held = false;
  for (const Index v : free)
    for (const Index u : rings(v)) {
      mean += (V.row(u) - V.row(v)).norm();
      ++edges;
      held = held || column(u) < 0;
    }
  mean /= static_cast<double>(std::max<std::int64_t>(edges, 1));
  if (!held || !(mean > 0)) return {};
  const auto weight = [&](Index u, Index v) {
    return mean / std::max((V.row(u) - V.row(v)).norm(), kShortestEdge * mean);
  };

  // The rows: the free vertices, and for the plate their neighbours too.
  std::vector<Index> rows = free;
  if (kind == Smoothing::thin_plate) {
    for (const Index v : free)
      for (const Index u : rings(v)) rows.push_back(u);
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  }
  const auto n = static_cast<Eigen::Index>(free.size());
  std::vector<Eigen::Triplet<double>> entries;
  VertexMatrix right = VertexMatrix::Zero(static_cast<Eigen::Index>(rows.size()), 3);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Index v = rows[i];
    double sum = 0;
    for (const Index u : rings(v)) sum += weight(u, v);
    // The membrane's matrix is symmetric; the plate's rows are means, so that all count alike.
    const double scale = kind == Smoothing::thin_plate ? 1 / sum : 1;
    const auto put = [&](Index u, double w) {
      if (const Index c = column(u); c >= 0)
        entries.emplace_back(static_cast<int>(i), c, w);
      else
        right.row(static_cast<Eigen::Index>(i)) -= w * values.row(u);
    };
    double hold = 0;
    if (kind == Smoothing::membrane && !part.empty()) {
      hold = sum * (1 / std::max<double>(part[i], 1e-3) - 1);
      right.row(static_cast<Eigen::Index>(i)) += hold * values.row(v);
    }
    put(v, sum * scale + hold);
    for (const Index u : rings(v)) put(u, -weight(u, v) * scale);
  }
  Eigen::SparseMatrix<double> A(static_cast<Eigen::Index>(rows.size()), n);
  A.setFromTriplets(entries.begin(), entries.end());
  if (kind == Smoothing::thin_plate) {
    right = (A.transpose() * right).eval();
    A = Eigen::SparseMatrix<double>(A.transpose() * A);
  }
  SymmetricMatrix Q = A.triangularView<Eigen::Lower>();
  Q.makeCompressed();
  SparseCholesky factor;
  VertexMatrix X;
  if (!factor.analyze(Q) || !factor.factor(Q) || !factor.solve(right, X) || !X.allFinite()) return {};
  return X;
}

}  // namespace overtet
