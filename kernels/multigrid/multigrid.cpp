#include "kernels/multigrid/multigrid.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "kernels/core/assertions.h"
#include "kernels/multigrid/aggregates.h"
#include "kernels/multigrid/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

namespace multigrid_detail {

using Vector = Eigen::VectorXd;

// (A x)_i
double row_times(const RowMatrix& A, std::int64_t i, const double* x) {
  const int* const start = A.outerIndexPtr();
  const int* const column = A.innerIndexPtr();
  const double* const value = A.valuePtr();
  double sum = 0;
  for (int at = start[i]; at < start[i + 1]; ++at) sum += value[at] * x[column[at]];
  return sum;
}

template <class F>
void each_row(std::int64_t rows, F&& f) {
  parallel_for(rows, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) f(i);
  });
}

// The sum of f(i).
template <class F>
double sum_of(std::int64_t rows, F&& f) {
  return parallel_reduce(
      rows, kLightGrain, 0.0,
      [&](std::int64_t begin, std::int64_t end) {
        double sum = 0;
        for (std::int64_t i = begin; i < end; ++i) sum += f(i);
        return sum;
      },
      [](double a, double b) { return a + b; });
}

struct Level {
  explicit Level(RowMatrix matrix) : A(std::move(matrix)) {}

  RowMatrix A;
  Vector scale;                         // one over the l1 norm of each row
  RowMatrix prolongation, restriction;  // to the next level; on the last one empty
  Vector x, b, residual, step, other;   // while it works: other is the next step

  // False: a diagonal entry is not positive, or an entry not finite.
  bool find_scale() {
    scale.resize(A.rows());
    return sum_of(A.rows(), [&](std::int64_t i) {
             double norm = 0, diagonal = 0;
             for (RowMatrix::InnerIterator it(A, i); it; ++it) {
               norm += std::abs(it.value());
               if (it.col() == i) diagonal = it.value();
             }
             scale[i] = 1 / norm;
             return diagonal > 0 && std::isfinite(norm) ? 0.0 : 1.0;
           }) == 0;
  }

  // The polynomials of degree k from those of degree k - 1: step' = shrink step + grow scale residual.
  static double shrink(int k) { return (2 * k - 3.0) / (2 * k + 1); }
  static double grow(int k) { return (8 * k - 4.0) / (2 * k + 1); }

  // x from 0, and residual = b - A x.
  void smooth_from_zero() {
    const std::int64_t rows = A.rows();
    each_row(rows, [&](std::int64_t i) {
      residual[i] = b[i];
      step[i] = grow(1) * scale[i] * b[i];
      x[i] = step[i];
    });
    take_steps();
    each_row(rows, [&](std::int64_t i) { residual[i] -= row_times(A, i, step.data()); });
  }

  // From the x that is there.
  void smooth() {
    each_row(A.rows(), [&](std::int64_t i) {
      residual[i] = b[i] - row_times(A, i, x.data());
      step[i] = grow(1) * scale[i] * residual[i];
    });
    each_row(A.rows(), [&](std::int64_t i) { x[i] += step[i]; });
    take_steps();
  }

  // pre: the first step is taken.
  void take_steps() {
    for (int k = 2; k <= kSmootherDegree; ++k) {
      each_row(A.rows(), [&](std::int64_t i) {
        residual[i] -= row_times(A, i, step.data());
        other[i] = shrink(k) * step[i] + grow(k) * scale[i] * residual[i];
        x[i] += other[i];
      });
      step.swap(other);
    }
  }
};

}  // namespace multigrid_detail

using namespace multigrid_detail;

struct Multigrid::Impl {
  std::vector<Level> levels;
  // Of the last level: one of them.
  std::optional<Eigen::LLT<Eigen::MatrixXd>> dense;
  std::optional<SparseCholesky> sparse;

  bool add_level(RowMatrix A) {
    levels.emplace_back(std::move(A));
    Level& level = levels.back();
    for (Vector* v : {&level.x, &level.b, &level.residual, &level.step, &level.other})
      v->resize(level.A.rows());
    return level.find_scale();
  }

  void set_prolongation(RowMatrix P) {
    levels.back().prolongation = std::move(P);
    levels.back().restriction = transposed(levels.back().prolongation);
  }

  // Adds levels until the last one is small, or grows smaller no more.
  bool coarsen() {
    while (levels.back().A.rows() > kDenseUnknowns) {
      const RowMatrix& A = levels.back().A;
      const Aggregates aggregates = aggregates_of(A, kStrongCoupling);
      if (aggregates.count == 0 || 2 * static_cast<Eigen::Index>(aggregates.count) > A.rows()) break;
      set_prolongation(smoothed_prolongation(A, aggregates, kStrongCoupling));
      if (!add_level(product(levels.back().restriction, product(A, levels.back().prolongation))))
        return false;
    }
    return factor_last();
  }

  bool factor_last() {
    const RowMatrix& A = levels.back().A;
    if (A.rows() == 0) return true;
    if (A.rows() <= kDenseUnknowns) {
      dense.emplace(Eigen::MatrixXd(A));
      return dense->info() == Eigen::Success;
    }
    sparse.emplace(CholeskyOptions{.ordering = CholeskyOptions::Ordering::automatic,
                                   .method = CholeskyOptions::Method::automatic});
    const SymmetricMatrix lower = RowMatrix(A.triangularView<Eigen::Upper>()).transpose();
    return sparse->analyze(lower) && sparse->factor(lower);
  }

  bool solve_last(Level& level) {
    if (dense) {
      level.x = dense->solve(level.b);
      return true;
    }
    VertexMatrix right = VertexMatrix::Zero(level.b.size(), 3), left;
    right.col(0) = level.b;
    if (!sparse->solve(right, left)) return false;
    level.x = left.col(0);
    return true;
  }

  // levels[l].x from levels[l].b: a V-cycle.
  void cycle(std::size_t l) {
    Level& level = levels[l];
    if (l + 1 == levels.size()) {
      solve_last(level);
      return;
    }
    Level& coarser = levels[l + 1];
    level.smooth_from_zero();
    each_row(coarser.A.rows(),
             [&](std::int64_t i) { coarser.b[i] = row_times(level.restriction, i, level.residual.data()); });
    cycle(l + 1);
    each_row(level.A.rows(),
             [&](std::int64_t i) { level.x[i] += row_times(level.prolongation, i, coarser.x.data()); });
    level.smooth();
  }

  // Of b - A x as doubles: its norm, if the rounding of products were all.
  double rounding(const Vector& x, const Vector& b) const {
    const RowMatrix& A = levels.front().A;
    return std::numeric_limits<double>::epsilon() * std::sqrt(sum_of(A.rows(), [&](std::int64_t i) {
             double sum = std::abs(b[i]);
             for (RowMatrix::InnerIterator it(A, i); it; ++it) sum += std::abs(it.value() * x[it.col()]);
             return sum * sum;
           }));
  }

  double residual_of(const Vector& x, const Vector& b, Vector& r) {
    const RowMatrix& A = levels.front().A;
    return sum_of(A.rows(), [&](std::int64_t i) {
      r[i] = b[i] - row_times(A, i, x.data());
      return r[i] * r[i];
    });
  }
};

Multigrid::Multigrid() : impl_(std::make_unique<Impl>()) {}
Multigrid::~Multigrid() = default;
Multigrid::Multigrid(Multigrid&&) noexcept = default;
Multigrid& Multigrid::operator=(Multigrid&&) noexcept = default;

bool Multigrid::prepare(const SymmetricMatrix& A) {
  *impl_ = Impl();
  return A.rows() == A.cols() && A.isCompressed() && impl_->add_level(both_triangles(A)) && impl_->coarsen();
}

bool Multigrid::prepare(const SymmetricMatrix& A, RowMatrix prolongation, const SymmetricMatrix& coarse) {
  *impl_ = Impl();
  if (A.rows() != A.cols() || !A.isCompressed() || coarse.rows() != coarse.cols() || !coarse.isCompressed() ||
      prolongation.rows() != A.rows() || prolongation.cols() != coarse.rows())
    return false;
  if (!impl_->add_level(both_triangles(A))) return false;
  impl_->set_prolongation(std::move(prolongation));
  return impl_->add_level(both_triangles(coarse)) && impl_->coarsen();
}

Iterations Multigrid::solve(const Vector& b, Vector& x, const IterationOptions& options) {
  OVERTET_EXPECTS(!impl_->levels.empty() && b.size() == impl_->levels.front().A.rows() &&
                  x.size() == b.size());
  Level& top = impl_->levels.front();
  const std::int64_t rows = top.A.rows();
  Iterations out;
  const double size = std::sqrt(sum_of(rows, [&](std::int64_t i) { return b[i] * b[i]; }));
  if (size == 0) {
    x.setZero();
    out.converged = true;
    return out;
  }
  Vector r(rows), p(rows), q(rows);
  double squared = impl_->residual_of(x, b, r), before = 0;
  const auto above = [&](double part) { return squared > part * part * size * size; };
  const auto go_on = [&] { return out.count < options.most_iterations && !(options.stop && options.stop()); };
  // What the iteration keeps for the residual parts from b - A x: where that is too large, it starts again,
  // as long as that helps.
  for (double last = 2 * squared; above(options.tolerance) && squared < last;) {
    last = squared;
    for (bool first = true; above(options.aim) && go_on(); first = false) {
      ++out.count;
      each_row(rows, [&](std::int64_t i) { top.b[i] = r[i]; });
      impl_->cycle(0);
      const Vector& z = top.x;
      const double now = sum_of(rows, [&](std::int64_t i) { return r[i] * z[i]; });
      if (!(now > 0)) break;
      const double beta = first ? 0 : now / before;
      each_row(rows, [&](std::int64_t i) { p[i] = first ? z[i] : z[i] + beta * p[i]; });
      before = now;
      const double curvature = sum_of(rows, [&](std::int64_t i) {
        q[i] = row_times(top.A, i, p.data());
        return p[i] * q[i];
      });
      if (!(curvature > 0)) break;
      const double alpha = now / curvature;
      squared = sum_of(rows, [&](std::int64_t i) {
        x[i] += alpha * p[i];
        r[i] -= alpha * q[i];
        return r[i] * r[i];
      });
    }
    squared = impl_->residual_of(x, b, r);
  }
  out.residual = std::sqrt(squared) / size;
  out.converged = out.residual <= options.tolerance || (out.residual <= 100 * options.tolerance &&
                                                        out.residual * size <= 4 * impl_->rounding(x, b));
  return out;
}

double Multigrid::entries() const {
  double sum = 0;
  for (const Level& level : impl_->levels) sum += static_cast<double>(level.A.nonZeros());
  return sum;
}

int Multigrid::levels() const { return static_cast<int>(impl_->levels.size()); }

}  // namespace overtet
