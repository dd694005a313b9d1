#include "kernels/fem/elements.h"

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <algorithm>
#include <numeric>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/sparse/rows.h"

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

// What the stiffness of one tet is made of: the integrals of the products of the gradients of barycentric
// coordinates.
using Products = Eigen::Matrix4d;
Products products_of(const TetShape& s) { return s.volume * (s.gradient * s.gradient.transpose()); }

// Row i of a linear tet's stiffness.
void linear_row(const TetShape& s, int i, double* row) {
  for (int k = 0; k < 4; ++k) row[k] = s.volume * s.gradient.row(i).dot(s.gradient.row(k));
}

// Row i of a quadratic tet's stiffness: of a corner or an edge with the corners, then with the edges.
void quadratic_row(const Products& P, int i, double* row) {
  const auto both = [](int a, int b) { return a == b ? 0.1 : 0.05; };  // the integral of lambda_a lambda_b
  const auto corner_edge = [&](int c, int k, int l) {
    return 4 * ((4 * both(c, k) - 0.25) * P(c, l) + (4 * both(c, l) - 0.25) * P(c, k));
  };
  if (i < 4) {
    for (int j = 0; j < 4; ++j) row[j] = (16 * both(i, j) - 1) * P(i, j);
    for (int e = 0; e < 6; ++e) row[4 + e] = corner_edge(i, kTetEdge[e][0], kTetEdge[e][1]);
    return;
  }
  const auto& [p, q] = kTetEdge[i - 4];
  for (int j = 0; j < 4; ++j) row[j] = corner_edge(j, p, q);
  for (int e = 0; e < 6; ++e) {
    const auto& [k, l] = kTetEdge[e];
    row[4 + e] =
        16 * (both(k, p) * P(l, q) + both(k, q) * P(l, p) + both(l, p) * P(k, q) + both(l, q) * P(k, p));
  }
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
  find_sequence();
  group_items(nodes(), first_, incidences_, [&](auto visit) {
    for (Index t = 0; t < tets(); ++t)
      for (int k = 0; k < nodes_each(); ++k)
        visit(place_in_sequence_[static_cast<std::size_t>(node_(t, k))], Incidence{t, k});
  });
}

// Edges by their smaller vertex: of each one the larger ones, sorted.
void TetElements::add_middles(const VertexMatrix& V) {
  RawVector<std::int64_t> start;
  RawVector<Index> larger;
  group_items(vertices_, start, larger, [&](auto visit) {
    for (Index t = 0; t < tets(); ++t)
      for (const auto& [i, j] : kTetEdge)
        visit(std::min(node_(t, i), node_(t, j)), std::max(node_(t, i), node_(t, j)));
  });
  first_edge_.assign(static_cast<std::size_t>(vertices_) + 1, 0);
  parallel_for(vertices_, kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      const auto from = larger.begin() + start[v], to = larger.begin() + start[v + 1];
      std::sort(from, to);
      first_edge_[static_cast<std::size_t>(v) + 1] = static_cast<Index>(std::unique(from, to) - from);
    }
  });
  for (std::size_t v = 1; v < first_edge_.size(); ++v) first_edge_[v] += first_edge_[v - 1];
  edge_.resize(static_cast<std::size_t>(first_edge_.back()));
  place_.conservativeResize(vertices_ + std::ssize(edge_), 3);
  parallel_for(vertices_, kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v)
      for (Index e = first_edge_[static_cast<std::size_t>(v)];
           e < first_edge_[static_cast<std::size_t>(v) + 1]; ++e) {
        const Index other = larger[start[v] + (e - first_edge_[static_cast<std::size_t>(v)])];
        edge_[static_cast<std::size_t>(e)] = {static_cast<Index>(v), other};
        place_.row(vertices_ + e) = (V.row(v) + V.row(other)) / 2;
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
  const auto v = static_cast<std::size_t>(edge[0]);
  const auto at = std::lower_bound(edge_.begin() + first_edge_[v], edge_.begin() + first_edge_[v + 1], edge);
  OVERTET_EXPECTS(at != edge_.end() && *at == edge);
  return vertices_ + static_cast<Index>(at - edge_.begin());
}

// Meshes are written with neighbouring tets near each other, but vertices in any order: nodes that are taken
// in the order of the tets find most of what they need in the cache.
void TetElements::find_sequence() {
  place_in_sequence_.assign(static_cast<std::size_t>(nodes()), -1);
  sequence_.reserve(place_in_sequence_.size());
  const auto take = [&](Index node) {
    Index& place = place_in_sequence_[static_cast<std::size_t>(node)];
    if (place >= 0) return;
    place = static_cast<Index>(sequence_.size());
    sequence_.push_back(node);
  };
  for (Index t = 0; t < tets(); ++t)
    for (int k = 0; k < nodes_each(); ++k) take(node_(t, k));
  used_ = static_cast<Index>(sequence_.size());
  for (Index v = 0; v < nodes(); ++v) take(v);
}

// fill(t, j, row): what tet t adds in column j. Every column is gathered by one thread. Of `each` nodes a
// tet, which come first among its nodes.
template <class Fill>
SymmetricMatrix TetElements::assemble(int each, const std::vector<Index>& number, Index count,
                                      Fill&& fill) const {
  std::vector<Index> node_of(static_cast<std::size_t>(count));
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] >= 0) node_of[static_cast<std::size_t>(number[v])] = static_cast<Index>(v);
  return matrix_of_rows<SymmetricMatrix>(count, count, [&](Index column, RowSums& sums) {
    std::array<double, 10> row;
    each_tet_of(node_of[static_cast<std::size_t>(column)], [&](Index t, int j) {
      fill(t, j, row.data());
      for (int i = 0; i < each; ++i)
        if (const Index n = number[static_cast<std::size_t>(node_(t, i))]; n >= column)
          sums.add(n, row[static_cast<std::size_t>(i)]);
    });
  });
}

// part(t, i): what tet t adds for its node i.
template <class Part>
Eigen::VectorXd TetElements::gather(Part&& part) const {
  Eigen::VectorXd out(nodes());
  parallel_for(nodes(), kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t v = begin; v < end; ++v) {
      const Index node = sequence_[static_cast<std::size_t>(v)];
      double sum = 0;
      each_tet_of(node, [&](Index t, int corner) { sum += part(t, corner); });
      out[node] = sum;
    }
  });
  return out;
}

void TetElements::stiffness_row(Index t, int i, double* row) const {
  const TetShape& s = shape(t);
  if (order_ == 2) {
    quadratic_row(products_of(s), i, row);
    return;
  }
  linear_row(s, i, row);
}

SymmetricMatrix TetElements::stiffness(const std::vector<Index>& number, Index count) const {
  OVERTET_EXPECTS(std::ssize(number) == nodes());
  return assemble(nodes_each(), number, count,
                  [&](Index t, int j, double* row) { stiffness_row(t, j, row); });
}

SymmetricMatrix TetElements::linear_stiffness(const std::vector<Index>& number, Index count) const {
  return assemble(4, number, count, [&](Index t, int j, double* row) { linear_row(shape(t), j, row); });
}

SymmetricMatrix TetElements::stiffness() const { return stiffness(every_node(), nodes()); }

std::vector<Index> TetElements::every_node() const {
  std::vector<Index> number(static_cast<std::size_t>(nodes()));
  std::iota(number.begin(), number.end(), 0);
  return number;
}

SymmetricMatrix TetElements::mass() const {
  const Eigen::MatrixXd reference = reference_mass(3, order_);
  return assemble(nodes_each(), every_node(), nodes(), [&](Index t, int j, double* row) {
    for (int i = 0; i < nodes_each(); ++i) row[i] = shape(t).volume * reference(i, j);
  });
}

Eigen::VectorXd TetElements::stiffness_times(const Eigen::VectorXd& u) const {
  OVERTET_EXPECTS(u.size() == nodes());
  return gather([&](Index t, int i) {
    std::array<double, 10> row;
    double sum = 0;
    bool zero = true;
    for (int k = 0; k < nodes_each() && zero; ++k) zero = u[node_(t, k)] == 0;
    if (zero) return sum;
    stiffness_row(t, i, row.data());
    for (int k = 0; k < nodes_each(); ++k) sum += row[static_cast<std::size_t>(k)] * u[node_(t, k)];
    return sum;
  });
}

Eigen::VectorXd TetElements::mass_times(const Eigen::VectorXd& f) const {
  OVERTET_EXPECTS(f.size() == nodes());
  const Eigen::MatrixXd reference = reference_mass(3, order_);
  return gather([&](Index t, int i) {
    double sum = 0;
    for (int k = 0; k < nodes_each(); ++k) sum += reference(k, i) * f[node_(t, k)];
    return shape(t).volume * sum;
  });
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
      std::array<double, 10> row;
      double sum = 0;
      for (int i = 0; i < nodes_each(); ++i) {
        stiffness_row(tet, i, row.data());
        double times_u = 0;
        for (int j = 0; j < nodes_each(); ++j) times_u += row[static_cast<std::size_t>(j)] * u[node(tet, j)];
        sum += times_u * u[node(tet, i)];
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
