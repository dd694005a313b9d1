#include "kernels/fem/elements.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

namespace {

// One term of a polynomial in barycentric coordinates.
struct Term {
  double factor = 0;
  std::array<int, 4> power{};
};

// The shape functions of a simplex, in the order of reference_mass().
std::vector<std::vector<Term>> shape_functions(int dimension, int order) {
  std::vector<std::vector<Term>> out;
  const auto power = [](int i, int j) {
    std::array<int, 4> p{};
    if (i >= 0) ++p[static_cast<std::size_t>(i)];
    if (j >= 0) ++p[static_cast<std::size_t>(j)];
    return p;
  };
  for (int i = 0; i <= dimension; ++i) {
    if (order == 1)
      out.push_back({{1, power(i, -1)}});
    else
      out.push_back({{2, power(i, i)}, {-1, power(i, -1)}});
  }
  if (order == 2)
    for (int i = 0; i <= dimension; ++i)
      for (int j = i + 1; j <= dimension; ++j) out.push_back({{4, power(i, j)}});
  return out;
}

// Over a simplex of volume 1: d! times the product of the powers' factorials over (their sum + d)!.
double integral(const std::array<int, 4>& power, int dimension) {
  const auto factorial = [](int n) {
    double f = 1;
    for (int i = 2; i <= n; ++i) f *= i;
    return f;
  };
  double top = factorial(dimension);
  int sum = 0;
  for (const int p : power) top *= factorial(p), sum += p;
  return top / factorial(sum + dimension);
}

// The product of grad N_i and grad N_j, integrated, of quadratic elements: of two corners, a corner and an
// edge, two edges.
double quadratic_stiffness(const TetShape& s, int i, int j) {
  if (i > j) std::swap(i, j);
  const auto dot = [&](int a, int b) { return s.gradient.row(a).dot(s.gradient.row(b)); };
  const auto both = [](int a, int b) { return a == b ? 0.1 : 0.05; };  // the integral of lambda_a lambda_b
  if (j < 4) return s.volume * (16 * both(i, j) - 1) * dot(i, j);
  const auto& [k, l] = kTetEdge[j - 4];
  if (i < 4)
    return 4 * s.volume * ((4 * both(i, k) - 0.25) * dot(i, l) + (4 * both(i, l) - 0.25) * dot(i, k));
  const auto& [p, q] = kTetEdge[i - 4];
  return 16 * s.volume *
         (both(k, p) * dot(l, q) + both(k, q) * dot(l, p) + both(l, p) * dot(k, q) + both(l, q) * dot(k, p));
}

}  // namespace

Eigen::MatrixXd reference_mass(int dimension, int order) {
  const auto shapes = shape_functions(dimension, order);
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(std::ssize(shapes), std::ssize(shapes));
  for (std::size_t i = 0; i < shapes.size(); ++i)
    for (std::size_t j = 0; j < shapes.size(); ++j)
      for (const Term& a : shapes[i])
        for (const Term& b : shapes[j]) {
          std::array<int, 4> power = a.power;
          for (std::size_t k = 0; k < 4; ++k) power[k] += b.power[k];
          M(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j)) +=
              a.factor * b.factor * integral(power, dimension);
        }
  return M;
}

TetShape tet_shape(const VertexMatrix& V, const TetMatrix& T, Eigen::Index t) {
  Eigen::Matrix3d edges;  // one a column
  for (int k = 0; k < 3; ++k) edges.col(k) = (V.row(T(t, k + 1)) - V.row(T(t, 0))).transpose();
  const double det = edges.determinant();
  TetShape s;
  s.volume = det / 6;
  s.gradient.row(1) = edges.col(1).cross(edges.col(2)).transpose() / det;
  s.gradient.row(2) = edges.col(2).cross(edges.col(0)).transpose() / det;
  s.gradient.row(3) = edges.col(0).cross(edges.col(1)).transpose() / det;
  s.gradient.row(0) = -s.gradient.bottomRows<3>().colwise().sum();
  return s;
}

TetElements::TetElements(const VertexMatrix& V, const TetMatrix& T, int order)
    : order_(order), place_(V), vertices_(static_cast<Index>(V.rows())) {
  OVERTET_EXPECTS(order == 1 || order == 2);
  shape_.resize(static_cast<std::size_t>(T.rows()));
  parallel_for(T.rows(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t) shape_[static_cast<std::size_t>(t)] = tet_shape(V, T, t);
  });
  node_.resize(T.rows(), nodes_each());
  node_.leftCols(4) = T;
  if (order == 2) add_middles(V);
  find_incidences();
}

void TetElements::add_middles(const VertexMatrix& V) {
  edge_ = parallel_collect<std::array<Index, 2>>(
      tets(), kMediumGrain,
      [&](std::int64_t begin, std::int64_t end, std::vector<std::array<Index, 2>>& list) {
        for (std::int64_t t = begin; t < end; ++t)
          for (const auto& [i, j] : kTetEdge)
            list.push_back({std::min(node_(t, i), node_(t, j)), std::max(node_(t, i), node_(t, j))});
      });
  std::sort(edge_.begin(), edge_.end());
  edge_.erase(std::unique(edge_.begin(), edge_.end()), edge_.end());
  edge_.shrink_to_fit();
  place_.conservativeResize(vertices_ + std::ssize(edge_), 3);
  parallel_for(std::ssize(edge_), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t e = begin; e < end; ++e) {
      const auto& [a, b] = edge_[static_cast<std::size_t>(e)];
      place_.row(vertices_ + e) = (V.row(a) + V.row(b)) / 2;
    }
  });
  parallel_for(tets(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t)
      for (int e = 0; e < 6; ++e)
        node_(t, 4 + e) = middle(node_(t, kTetEdge[e][0]), node_(t, kTetEdge[e][1]));
  });
}

Index TetElements::middle(Index a, Index b) const {
  const std::array<Index, 2> edge{std::min(a, b), std::max(a, b)};
  const auto at = std::lower_bound(edge_.begin(), edge_.end(), edge);
  OVERTET_EXPECTS(at != edge_.end() && *at == edge);
  return vertices_ + static_cast<Index>(at - edge_.begin());
}

// Of each node its tets, in their order.
void TetElements::find_incidences() {
  first_.assign(static_cast<std::size_t>(nodes()) + 1, 0);
  for (Index t = 0; t < tets(); ++t)
    for (int k = 0; k < nodes_each(); ++k) ++first_[static_cast<std::size_t>(node_(t, k)) + 1];
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  incidences_.resize(static_cast<std::size_t>(first_.back()));
  std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
  for (Index t = 0; t < tets(); ++t)
    for (int k = 0; k < nodes_each(); ++k)
      incidences_[static_cast<std::size_t>(next[static_cast<std::size_t>(node_(t, k))]++)] = {t, k};
}

// entry(t, i, j): what tet t adds for its nodes i and j. Every column is gathered by one thread.
template <class Entry>
SymmetricMatrix TetElements::assemble(Entry&& entry) const {
  const int each = nodes_each();
  const auto visit = [&](Index column, auto&& f) {
    for (std::int64_t at = first_[static_cast<std::size_t>(column)];
         at < first_[static_cast<std::size_t>(column) + 1]; ++at) {
      const auto& [t, j] = incidences_[static_cast<std::size_t>(at)];
      for (int i = 0; i < each; ++i)
        if (node_(t, i) >= column) f(t, i, j);
    }
  };
  std::vector<std::vector<Index>> rows_of_block(
      static_cast<std::size_t>((nodes() + kMediumGrain - 1) / kMediumGrain));
  SymmetricMatrix A(nodes(), nodes());
  int* const start = A.outerIndexPtr();
  parallel_for(nodes(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    std::vector<Index>& all = rows_of_block[static_cast<std::size_t>(begin / kMediumGrain)];
    std::vector<Index> rows;
    for (std::int64_t v = begin; v < end; ++v) {
      rows.clear();
      visit(static_cast<Index>(v), [&](Index t, int i, int) { rows.push_back(node_(t, i)); });
      std::sort(rows.begin(), rows.end());
      rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
      all.insert(all.end(), rows.begin(), rows.end());
      start[v + 1] = static_cast<int>(rows.size());
    }
  });
  start[0] = 0;
  for (Index v = 0; v < nodes(); ++v) start[v + 1] += start[v];
  A.resizeNonZeros(start[nodes()]);
  parallel_for(nodes(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    const std::vector<Index>& all = rows_of_block[static_cast<std::size_t>(begin / kMediumGrain)];
    std::copy(all.begin(), all.end(), A.innerIndexPtr() + start[begin]);
    std::fill(A.valuePtr() + start[begin], A.valuePtr() + start[end], 0.0);
    for (std::int64_t v = begin; v < end; ++v) {
      const int* const rows = A.innerIndexPtr() + start[v];
      double* const values = A.valuePtr() + start[v];
      const auto count = start[v + 1] - start[v];
      visit(static_cast<Index>(v), [&](Index t, int i, int j) {
        values[std::lower_bound(rows, rows + count, node_(t, i)) - rows] += entry(t, i, j);
      });
    }
  });
  return A;
}

// part(t, i): what tet t adds for its node i.
template <class Part>
Eigen::VectorXd TetElements::gather(Part&& part) const {
  Eigen::VectorXd out(nodes());
  parallel_for(nodes(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      double sum = 0;
      for (std::int64_t at = first_[static_cast<std::size_t>(v)];
           at < first_[static_cast<std::size_t>(v) + 1]; ++at)
        sum += part(incidences_[static_cast<std::size_t>(at)].tet,
                    incidences_[static_cast<std::size_t>(at)].corner);
      out[v] = sum;
    }
  });
  return out;
}

SymmetricMatrix TetElements::stiffness() const {
  if (order_ == 2)
    return assemble([&](Index t, int i, int j) { return quadratic_stiffness(shape(t), i, j); });
  return assemble([&](Index t, int i, int j) {
    const TetShape& s = shape(t);
    return s.volume * s.gradient.row(i).dot(s.gradient.row(j));
  });
}

SymmetricMatrix TetElements::mass() const {
  const Eigen::MatrixXd reference = reference_mass(3, order_);
  return assemble([&](Index t, int i, int j) { return shape(t).volume * reference(i, j); });
}

Eigen::VectorXd TetElements::lumped_mass() const {
  OVERTET_EXPECTS(order_ == 1);
  return gather([&](Index t, int) { return shape(t).volume / 4; });
}

Eigen::VectorXd TetElements::energy(const Eigen::VectorXd& u) const {
  Eigen::VectorXd out(tets());
  parallel_for(tets(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t) {
      const auto tet = static_cast<Index>(t);
      double sum = 0;
      for (int i = 0; i < nodes_each(); ++i)
        for (int j = 0; j < nodes_each(); ++j) {
          const double k =
              order_ == 2 ? quadratic_stiffness(shape(tet), i, j)
                          : shape(tet).volume * shape(tet).gradient.row(i).dot(shape(tet).gradient.row(j));
          sum += k * u[node(tet, i)] * u[node(tet, j)];
        }
      out[t] = sum / 2;
    }
  });
  return out;
}

VertexMatrix TetElements::gradient(const Eigen::VectorXd& u) const {
  OVERTET_EXPECTS(order_ == 1);
  VertexMatrix out(tets(), 3);
  parallel_for(tets(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t) {
      Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
      for (int k = 0; k < 4; ++k) sum += u[node_(t, k)] * shape(static_cast<Index>(t)).gradient.row(k);
      out.row(t) = sum;
    }
  });
  return out;
}

Eigen::VectorXd TetElements::divergence(const VertexMatrix& X) const {
  OVERTET_EXPECTS(order_ == 1 && X.rows() == tets());
  return gather([&](Index t, int i) { return shape(t).volume * shape(t).gradient.row(i).dot(X.row(t)); });
}

}  // namespace overtet
