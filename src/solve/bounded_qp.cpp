#include "src/solve/bounded_qp.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <iterator>
#include <limits>

#include "src/solve/parts.h"
#include "src/solve/tuning.h"

namespace overtet::solve_detail {

namespace {

using Vector = Eigen::VectorXd;

enum class Bound : std::uint8_t { none, lower, upper };

// One problem. (Its members: the problem's data, the state of both methods, and what is said of them.)
class BoundedSearch {
 public:
  BoundedSearch(const SymmetricMatrix& Q, const Vector& c, double constant, const RunContext& context)
      : Q_(Q), c_(c), constant_(constant), context_(context), n_(Q.rows()) {
    diagonal_.resize(n_);
    at_.assign(static_cast<std::size_t>(n_), Bound::none);
    for (Eigen::Index j = 0; j < n_; ++j) diagonal_[j] = Q.valuePtr()[Q.outerIndexPtr()[j]];
  }

  Result<BoundedSolution> solve() {
    Result<bool> done = false;
    BoundedSolution out;
    if (n_ == 0) {
      out.end = BoundedSolution::End::exact;
      return out;
    }
    if (Status s = begin_interior(); !s) return s.error();
    for (const double gap : kInteriorGaps) {
      if (Status s = interior(gap); !s) return s.error();
      done = active_set();
      if (!done) return done.error();
      if (done.value()) break;
    }
    if (!done.value()) x_ = inner_;
    using End = BoundedSolution::End;
    out.end = done.value() ? End::exact : gap_ <= *std::rbegin(kInteriorGaps) ? End::gap : End::stalled;
    // A last rounding beyond a bound is taken back.
    out.x = x_.cwiseMax(0.0).cwiseMin(1.0).array() + 0.0;  // no -0
    const Vector Qx = times(Q_, out.x);
    out.residual = residual(out.x, Qx + c_);
    out.energy = out.x.dot(Qx) / 2 + c_.dot(out.x);
    out.active_set_steps = active_set_steps_;
    out.interior_steps = interior_steps_;
    return out;
  }

 private:
  double residual(const Vector& x, const Vector& g) const {
    return (x - (x - g.cwiseQuotient(diagonal_)).cwiseMax(0.0).cwiseMin(1.0)).cwiseAbs().maxCoeff();
  }

  // The unknowns at no bound solve their equations.
  Status solve_free() {
    std::vector<Index> number(static_cast<std::size_t>(n_), -1);
    Index count = 0;
    x_.setZero(n_);
    for (Eigen::Index i = 0; i < n_; ++i) {
      const Bound b = at_[static_cast<std::size_t>(i)];
      if (b == Bound::none) number[static_cast<std::size_t>(i)] = count++;
      if (b == Bound::upper) x_[i] = 1;
    }
    if (count == 0) return success();
    const Vector g = times(Q_, x_) + c_;
    Vector right(count);
    for (Eigen::Index i = 0; i < n_; ++i)
      if (const Index k = number[static_cast<std::size_t>(i)]; k >= 0) right[k] = -g[i];
    const SymmetricMatrix A = kept_part(Q_, number, count);
    Result<SparseCholesky> factor = factored(A, context_, CholeskyOptions::Ordering::natural);
    if (!factor) return factor.error();
    const Result<Vector> first = solved_by(factor.value(), right);
    if (!first) return first.error();
    // One step of iterative refinement.
    const Result<Vector> more = solved_by(factor.value(), right - times(A, first.value()));
    if (!more) return more.error();
    for (Eigen::Index i = 0; i < n_; ++i)
      if (const Index k = number[static_cast<std::size_t>(i)]; k >= 0)
        x_[i] = first.value()[k] + more.value()[k];
    return success();
  }

  // From at_. False: it goes round in circles.
  Result<bool> active_set() {
    Eigen::Index fewest = std::numeric_limits<Eigen::Index>::max();
    for (int chances = kActiveSetChances; chances > 0;) {
      if (auto stop = context_.stop()) return *stop;
      if (Status s = solve_free(); !s) return s.error();
      ++active_set_steps_;
      const Vector g = times(Q_, x_) + c_;
      Eigen::Index at_fault = 0;
      for (Eigen::Index i = 0; i < n_; ++i) {
        Bound& b = at_[static_cast<std::size_t>(i)];
        const double step = g[i] / diagonal_[i];
        const Bound was = b;
        // What rounding alone can do is no fault.
        if (b == Bound::none)
          b = x_[i] < -kFault ? Bound::lower : x_[i] > 1 + kFault ? Bound::upper : Bound::none;
        else if (b == Bound::lower ? step < -kFault : step > kFault)
          b = Bound::none;
        at_fault += b != was;
      }
      if (at_fault == 0) return true;
      if (at_fault < fewest) {
        fewest = at_fault;
        chances = kActiveSetChances;
      } else {
        --chances;
      }
    }
    return false;
  }

  Status begin_interior() {
    A_ = Q_;
    if (!factor_.analyze(A_))
      return Error{ErrorCode::limit, "There is not enough memory for the factor of this system."};
    if (auto e = context_.no_room_for(static_cast<std::size_t>(8 * factor_.factor_entries()))) return *e;
    inner_ = Vector::Constant(n_, 0.5);
    // Multipliers of the size of the gradient.
    z_ = (times(Q_, inner_) + c_).cwiseAbs().cwiseMax(1e-2 * diagonal_);
    y_ = z_;
    return success();
  }

  // Until the gap between the energy and a lower bound is as small a part of the energy; leaves at_ as its
  // solution says.
  Status interior(double wanted) {
    for (int step = 0; step < kInteriorSteps; ++step) {
      if (auto stop = context_.stop()) return *stop;
      const Vector low = inner_, high = Vector::Ones(n_) - inner_, Qx = times(Q_, inner_);
      const Vector dual = Qx + c_ - z_ + y_;  // to become 0
      const double gap = low.dot(z_) + high.dot(y_);
      const double energy = constant_ + inner_.dot(Qx) / 2 + c_.dot(inner_);
      gap_ = energy > 0 ? gap / energy : gap > 0;
      if (gap_ <= wanted) break;
      ++interior_steps_;
      const Vector more = z_.cwiseQuotient(low) + y_.cwiseQuotient(high);
      for (Eigen::Index j = 0; j < n_; ++j) A_.valuePtr()[A_.outerIndexPtr()[j]] = diagonal_[j] + more[j];
      if (!factor_.factor(A_)) {
        if (interior_steps_ == 1) return not_definite();
        break;  // no more digits
      }
      Vector dx, dz, dy;
      // low_part: what low z is to change by, in first order; high_part likewise.
      const auto direction = [&](const Vector& low_part, const Vector& high_part) -> Status {
        const Vector right = -dual + low_part.cwiseQuotient(low) - high_part.cwiseQuotient(high);
        Result<Vector> solution = solved_by(factor_, right);
        if (!solution) return solution.error();
        dx = std::move(solution).value();
        dz = (low_part - z_.cwiseProduct(dx)).cwiseQuotient(low);
        dy = (high_part + y_.cwiseProduct(dx)).cwiseQuotient(high);
        return success();
      };
      const auto longest = [&] {
        double a = 1;
        for (Eigen::Index i = 0; i < n_; ++i) {
          if (dx[i] < 0) a = std::min(a, -low[i] / dx[i]);
          if (dx[i] > 0) a = std::min(a, high[i] / dx[i]);
          if (dz[i] < 0) a = std::min(a, -z_[i] / dz[i]);
          if (dy[i] < 0) a = std::min(a, -y_[i] / dy[i]);
        }
        return a;
      };
      if (Status s = direction(-low.cwiseProduct(z_), -high.cwiseProduct(y_)); !s) return s;
      const double a = longest();
      const double after = (low + a * dx).dot(z_ + a * dz) + (high - a * dx).dot(y_ + a * dy);
      const double target = std::pow(after / gap, 3) * gap / static_cast<double>(2 * n_);
      const Vector low_part = (target - (low.cwiseProduct(z_) + dx.cwiseProduct(dz)).array()).matrix();
      const Vector high_part = (target - (high.cwiseProduct(y_) - dx.cwiseProduct(dy)).array()).matrix();
      if (Status s = direction(low_part, high_part); !s) return s;
      const double b = kInteriorShare * longest();
      inner_ += b * dx, z_ += b * dz, y_ += b * dy;
    }
    for (Eigen::Index i = 0; i < n_; ++i)
      at_[static_cast<std::size_t>(i)] = z_[i] / diagonal_[i] > inner_[i]       ? Bound::lower
                                         : y_[i] / diagonal_[i] > 1 - inner_[i] ? Bound::upper
                                                                                : Bound::none;
    return success();
  }

  const SymmetricMatrix& Q_;
  const Vector& c_;
  const double constant_;
  const RunContext& context_;
  const Eigen::Index n_;
  Vector diagonal_;
  Vector x_;
  std::vector<Bound> at_;
  Vector inner_, z_, y_;  // the interior point, and the multipliers of the lower and the upper bounds
  SymmetricMatrix A_;     // Q and what the bounds add to its diagonal
  SparseCholesky factor_{
      {.ordering = CholeskyOptions::Ordering::natural, .method = CholeskyOptions::Method::automatic}};
  double gap_ = 1;  // of the interior point, a part of the energy
  int active_set_steps_ = 0, interior_steps_ = 0;
};

}  // namespace

Result<BoundedQp> BoundedQp::prepare(const SymmetricMatrix& Q, const RunContext& context) {
  if (auto stop = context.stop()) return *stop;
  BoundedQp out;
  SparseCholesky factor(
      {.ordering = CholeskyOptions::Ordering::metis, .method = CholeskyOptions::Method::automatic});
  if (!factor.analyze(Q))
    return Error{ErrorCode::limit, "There is not enough memory for the factor of this system."};
  out.factor_entries_ = factor.factor_entries();
  out.order_ = factor.order();
  const auto n = static_cast<Eigen::Index>(out.order_.size());
  std::vector<int> row(out.order_.size());
  for (std::size_t k = 0; k < row.size(); ++k)
    row[static_cast<std::size_t>(out.order_[k])] = static_cast<int>(k);
  std::vector<Eigen::Triplet<double, int>> entries;
  entries.reserve(static_cast<std::size_t>(Q.nonZeros()));
  for (Eigen::Index j = 0; j < Q.outerSize(); ++j)
    for (SymmetricMatrix::InnerIterator it(Q, j); it; ++it) {
      const int a = row[static_cast<std::size_t>(it.row())], b = row[static_cast<std::size_t>(j)];
      entries.emplace_back(std::max(a, b), std::min(a, b), it.value());
    }
  out.Q_.resize(n, n);
  out.Q_.setFromTriplets(entries.begin(), entries.end());
  return out;
}

Result<BoundedSolution> BoundedQp::solve(const Vector& c, double constant, const RunContext& context) const {
  Vector ordered(c.size());
  for (std::size_t k = 0; k < order_.size(); ++k) ordered[static_cast<Eigen::Index>(k)] = c[order_[k]];
  Result<BoundedSolution> found = BoundedSearch(Q_, ordered, constant, context).solve();
  if (!found) return found;
  Vector x(c.size());
  for (std::size_t k = 0; k < order_.size(); ++k)
    x[order_[k]] = found.value().x[static_cast<Eigen::Index>(k)];
  found.value().x = std::move(x);
  return found;
}

}  // namespace overtet::solve_detail
