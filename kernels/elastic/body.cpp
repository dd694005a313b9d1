#include "kernels/elastic/body.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "kernels/core/assertions.h"
#include "kernels/core/tuning.h"
#include "kernels/elastic/flat_time.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"

namespace overtet {

namespace {

using Eigen::Matrix3d, Eigen::Vector3d;

// What the tangent gives for two shape functions, whose gradients are turned already (V' g).
Matrix3d block_of(const MaterialTangent& A, const Vector3d& g, const Vector3d& h) {
  Matrix3d B;
  for (int k = 0; k < 3; ++k) {
    const int i = (k + 1) % 3, j = (k + 2) % 3;
    B(i, j) = g[i] * A.stretch(i, j) * h[j] + g[j] * A.cross[k] * h[i];
    B(j, i) = g[j] * A.stretch(j, i) * h[i] + g[i] * A.cross[k] * h[j];
    B(k, k) = g[k] * A.stretch(k, k) * h[k] + g[i] * A.same[j] * h[i] + g[j] * A.same[i] * h[j];
  }
  return A.U * B * A.U.transpose();
}

double sum(std::int64_t n, auto&& f) {
  return parallel_reduce(
      n, kMediumGrain, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        double part = 0;
        for (std::int64_t t = begin; t < end; ++t) part += f(t);
        return part;
      },
      [](double a, double b) { return a + b; });
}

void each(std::int64_t n, auto&& f) {
  parallel_for(n, kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) f(i);
  });
}

}  // namespace

ElasticBody::ElasticBody(const VertexMatrix& rest, const TetMatrix& T, const ElasticLaw& law,
                         std::vector<Index> number)
    : rest_(rest), T_(T), law_(law), number_(std::move(number)) {
  OVERTET_EXPECTS(std::ssize(number_) == rest.rows());
  shape_.resize(static_cast<std::size_t>(T.rows()));
  each(T.rows(), [&](std::int64_t t) { shape_[t] = tet_shape(rest_, T_, t); });
  first_.assign(static_cast<std::size_t>(rest.rows()) + 1, 0);
  for (const Index v : T_.reshaped()) ++first_[static_cast<std::size_t>(v) + 1];
  for (std::size_t v = 1; v < first_.size(); ++v) first_[v] += first_[v - 1];
  incidences_.resize(static_cast<std::size_t>(first_.back()));
  std::vector<std::int64_t> next(first_.begin(), first_.end() - 1);
  for (Index t = 0; t < tets(); ++t)
    for (int k = 0; k < 4; ++k) incidences_[next[T_(t, k)]++] = {t, k, {-1, -1, -1, -1}};
  find_pattern();
}

void ElasticBody::find_pattern() {
  for (std::size_t v = 0; v < number_.size(); ++v)
    if (number_[v] >= 0) vertex_.push_back(static_cast<Index>(v));
  free_ = static_cast<Index>(vertex_.size());
  first_block_.assign(vertex_.size() + 1, 0);
  std::vector<std::vector<Index>> rows_of(vertex_.size());
  each(free_, [&](std::int64_t n) {
    const Index v = vertex_[n];
    std::vector<Index>& rows = rows_of[n];
    rows.push_back(static_cast<Index>(n));
    for (std::int64_t at = first_[v]; at < first_[v + 1]; ++at)
      for (int k = 0; k < 4; ++k)
        if (const Index row = number_[T_(incidences_[at].tet, k)]; row > n) rows.push_back(row);
    std::sort(rows.begin(), rows.end());
    rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
    for (std::int64_t at = first_[v]; at < first_[v + 1]; ++at)
      for (int k = 0; k < 4; ++k)
        if (const Index row = number_[T_(incidences_[at].tet, k)]; row >= n)
          incidences_[at].block[k] =
              static_cast<Index>(std::lower_bound(rows.begin(), rows.end(), row) - rows.begin());
    first_block_[n + 1] = std::ssize(rows);
  });
  for (std::size_t n = 1; n < first_block_.size(); ++n) first_block_[n] += first_block_[n - 1];
  block_row_.resize(static_cast<std::size_t>(first_block_.back()));
  for (std::size_t n = 0; n < rows_of.size(); ++n)
    std::copy(rows_of[n].begin(), rows_of[n].end(), block_row_.begin() + first_block_[n]);
}

Matrix3d ElasticBody::gradient(std::int64_t t, const VertexMatrix& d) const {
  const Index* const v = tet(static_cast<Index>(t));
  Matrix3d edges;  // a column each; the gradients of all four corners are 0 in sum
  for (int k = 0; k < 3; ++k) edges.col(k) = (d.row(v[k + 1]) - d.row(v[0])).transpose();
  return edges * shape_[t].gradient.bottomRows<3>();
}

double ElasticBody::energy(const VertexMatrix& x) const {
  const VertexMatrix u = x - rest_;
  return sum(tets(), [&](std::int64_t t) { return shape_[t].volume * energy_density(law_, gradient(t, u)); });
}

double ElasticBody::stresses(const VertexMatrix& x, Stresses& P) const {
  const VertexMatrix u = x - rest_;
  P.resize(shape_.size());
  return sum(tets(), [&](std::int64_t t) {
    const Matrix3d G = gradient(t, u);
    P[t] = shape_[t].volume * piola_stress(law_, G);
    return shape_[t].volume * energy_density(law_, G);
  });
}

void ElasticBody::tangents(const VertexMatrix& x, Tangent kind, Tangents& out) const {
  const VertexMatrix u = x - rest_;
  out.resize(shape_.size());
  each(tets(), [&](std::int64_t t) { out[t] = material_tangent(law_, gradient(t, u), kind); });
}

Eigen::VectorXd ElasticBody::von_mises(const VertexMatrix& x) const {
  const VertexMatrix u = x - rest_;
  Eigen::VectorXd out(tets());
  each(tets(), [&](std::int64_t t) { out[t] = von_mises_stress(law_, gradient(t, u)); });
  return out;
}

void ElasticBody::add_change(const Tangents& tangents, const VertexMatrix& d, double factor,
                             Stresses& P) const {
  each(tets(),
       [&](std::int64_t t) { P[t] += factor * shape_[t].volume * tangents[t].times(gradient(t, d)); });
}

double ElasticBody::curvature(const Tangents& tangents, const VertexMatrix& d) const {
  return sum(tets(), [&](std::int64_t t) {
    const Matrix3d D = gradient(t, d);
    return shape_[t].volume * D.cwiseProduct(tangents[t].times(D)).sum();
  });
}

double ElasticBody::rounding() const {
  const double stiffness = 2 * law_.lame.mu + law_.lame.lambda, place = rest_.cwiseAbs().maxCoeff();
  const double squares = sum(tets(), [&](std::int64_t t) {
    const double slopes = shape_[t].gradient.squaredNorm();
    return shape_[t].volume * shape_[t].volume * slopes * slopes;
  });
  return kRoundedLength * stiffness * place * std::sqrt(squares);
}

VertexMatrix ElasticBody::gathered(const Stresses& P, double& size) const {
  VertexMatrix out(rest_.rows(), 3);
  const double squares = sum(rest_.rows(), [&](std::int64_t v) {
    Vector3d all = Vector3d::Zero();
    double square = 0;
    for (std::int64_t at = first_[v]; at < first_[v + 1]; ++at) {
      const Incidence& i = incidences_[at];
      const Vector3d part = P[i.tet] * shape_[i.tet].gradient.row(i.corner).transpose();
      all += part;
      square += part.squaredNorm();
    }
    out.row(v) = all;
    return square;
  });
  size = std::sqrt(squares);
  return out;
}

void ElasticBody::assemble(std::initializer_list<Part> parts, const Eigen::VectorXd& diagonal,
                           SymmetricMatrix& A) const {
  // A block's three columns: the diagonal block's 3, 2 and 1 entries, and below them three of every other
  // one.
  const auto others = [&](std::int64_t n) { return 3 * (first_block_[n + 1] - first_block_[n] - 1); };
  const auto start = [&](std::int64_t n, int column) {
    return 9 * (first_block_[n] - n) + 6 * n + column * (others(n) + 3) - column * (column - 1) / 2;
  };
  if (A.rows() != rows()) {
    A.resize(rows(), rows());
    const std::int64_t entries = 9 * (first_block_.back() - free_) + 6 * static_cast<std::int64_t>(free_);
    A.resizeNonZeros(entries);
    each(free_, [&](std::int64_t n) {
      for (int column = 0; column < 3; ++column) {
        int at = static_cast<int>(start(n, column));
        A.outerIndexPtr()[3 * n + column] = at;
        for (std::int64_t b = first_block_[n]; b < first_block_[n + 1]; ++b)
          for (int row = b == first_block_[n] ? column : 0; row < 3; ++row)
            A.innerIndexPtr()[at++] = 3 * block_row_[b] + row;
      }
    });
    A.outerIndexPtr()[rows()] = static_cast<int>(entries);
  }
  double* const values = A.valuePtr();
  each(free_, [&](std::int64_t n) {
    const Index v = vertex_[n];
    std::fill(values + start(n, 0), values + start(n, 0) + 3 * others(n) + 6, 0.0);
    for (std::int64_t at = first_[v]; at < first_[v + 1]; ++at) {
      const Incidence& in = incidences_[at];
      const TetShape& s = shape_[in.tet];
      Matrix3d sum[4];
      for (Matrix3d& m : sum) m.setZero();
      for (const Part& part : parts) {
        const MaterialTangent& tangent = (*part.tangents)[in.tet];
        const Eigen::Matrix<double, 4, 3> g = s.gradient * tangent.V;
        for (int k = 0; k < 4; ++k)
          if (in.block[k] >= 0)
            sum[k] += part.factor * s.volume *
                      block_of(tangent, g.row(k).transpose(), g.row(in.corner).transpose());
      }
      for (int k = 0; k < 4; ++k) {
        if (in.block[k] < 0) continue;
        for (int column = 0; column < 3; ++column) {
          double* const to = values + start(n, column);
          if (in.block[k] == 0)
            for (int row = column; row < 3; ++row) to[row - column] += sum[k](row, column);
          else
            for (int row = 0; row < 3; ++row) to[3 * in.block[k] - column + row] += sum[k](row, column);
        }
      }
    }
    for (int column = 0; column < 3; ++column) values[start(n, column)] += diagonal[v];
  });
}

ElasticBody::Way ElasticBody::way(const VertexMatrix& x, const VertexMatrix& d, double most) const {
  return parallel_reduce(
      tets(), kMediumGrain, Way{most, -1},
      [&](std::int64_t begin, std::int64_t end) {
        Way way{most, -1};
        for (std::int64_t t = begin; t < end; ++t) {
          Eigen::Matrix<double, 3, 4> from, along;
          for (int k = 0; k < 4; ++k) {
            from.col(k) = x.row(T_(t, k)).transpose();
            along.col(k) = d.row(T_(t, k)).transpose();
          }
          const double part = first_flat_time(from, along, way.part);
          if (part < way.part) way = {part, static_cast<Index>(t)};
        }
        return way;
      },
      [](const Way& a, const Way& b) { return b.part < a.part ? b : a; });
}

Index ElasticBody::first_flipped(const VertexMatrix& x) const {
  constexpr Index none = std::numeric_limits<Index>::max();
  const auto at = [&](std::int64_t t, int k) { return x.data() + 3 * static_cast<std::ptrdiff_t>(T_(t, k)); };
  const Index first = parallel_reduce(
      tets(), kMediumGrain, none,
      [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t t = begin; t < end; ++t)
          if (orient3d(at(t, 0), at(t, 1), at(t, 2), at(t, 3)) <= 0) return static_cast<Index>(t);
        return none;
      },
      [](Index a, Index b) { return std::min(a, b); });
  return first == none ? -1 : first;
}

double ElasticBody::least_ratio(const VertexMatrix& x) const {
  return parallel_reduce(
      tets(), kMediumGrain, std::numeric_limits<double>::infinity(),
      [&](std::int64_t begin, std::int64_t end) {
        double least = std::numeric_limits<double>::infinity();
        for (std::int64_t t = begin; t < end; ++t) {
          Matrix3d edges;
          for (int k = 0; k < 3; ++k) edges.col(k) = (x.row(T_(t, k + 1)) - x.row(T_(t, 0))).transpose();
          least =
              std::min(least, edges.col(0).dot(edges.col(1).cross(edges.col(2))) / (6 * shape_[t].volume));
        }
        return least;
      },
      [](double a, double b) { return std::min(a, b); });
}

}  // namespace overtet
