#include "src/solve/elastic_minimum.h"

#include <algorithm>
#include <utility>

#include "kernels/core/tuning.h"
#include "src/solve/tuning.h"

namespace overtet::solve_detail {

namespace {

class Descent {
 public:
  Descent(const ElasticPotential& E, const ElasticGoal& goal, ElasticDirections& directions, VertexMatrix& x,
          const RunContext& context)
      : E_(E), goal_(goal), directions_(directions), x_(x), context_(context) {}

  Result<ElasticMinimum> run() {
    directions_.begin();
    for (int round = 0; round < kMostRounds; ++round) {
      const VertexMatrix given = way_of_held();
      if (given.rows() == 0) {
        if (Status s = descend(goal_.most_iterations); !s) return s.error();
        return minimum_;
      }
      Result<double> part = bring(given);
      if (!part) return part.error();
      if (part.value() < kPrecise) break;
      // Not all the way at once: what is free makes room first.
      if (part.value() < 1)
        if (Status s = descend(kInVain); !s) return s.error();
    }
    minimum_.brought = minimum_.converged = false;
    return minimum_;
  }

 private:
  // What is left of the ways of held vertices; empty: nothing.
  VertexMatrix way_of_held() const {
    VertexMatrix d = VertexMatrix::Zero(x_.rows(), 3);
    bool some = false;
    for (Eigen::Index v = 0; v < x_.rows(); ++v)
      if ((*goal_.held)[static_cast<std::size_t>(v)] && x_.row(v) != goal_.targets->row(v)) {
        d.row(v) = goal_.targets->row(v) - x_.row(v);
        some = true;
      }
    return some ? d : VertexMatrix();
  }

  // With the gradient of what is free.
  ElasticPotential::Slope slope(const VertexMatrix& x) const {
    ElasticPotential::Slope s = E_.slope(x);
    for (Eigen::Index v = 0; v < x.rows(); ++v)
      if ((*goal_.held)[static_cast<std::size_t>(v)]) s.gradient.row(v).setZero();
    return s;
  }

  // At most the tolerance where what is left is rounding.
  double residual(const ElasticPotential::Slope& s) const {
    const double norm = s.gradient.norm();
    return norm > 0 ? norm / (s.size + E_.rounding / goal_.tolerance) : 0;
  }

  // How much of the way d may be gone, at most 1.
  double allowed(const VertexMatrix& d) {
    const ElasticBody::Way way = E_.body->way(x_, d, 1 / kWayToFlat);
    if (way.tet >= 0) minimum_.flat = way.tet;
    return std::min(1.0, kWayToFlat * way.part);
  }

  // Moves the held vertices and, with them, all others, whatever the energy. The part of the way that was
  // gone.
  Result<double> bring(const VertexMatrix& given) {
    const Result<VertexMatrix> d = directions_.direction(E_, x_, slope(x_).gradient, given, context_);
    if (!d) return d.error();
    ++minimum_.iterations;
    double part = allowed(d.value());
    for (int halving = 0; halving < kMostRounds && part > 0; ++halving, part /= 2) {
      VertexMatrix to = x_ + part * d.value();
      if (part == 1)
        for (Eigen::Index v = 0; v < to.rows(); ++v)
          if ((*goal_.held)[static_cast<std::size_t>(v)]) to.row(v) = goal_.targets->row(v);
      if (E_.body->first_flipped(to) >= 0) {
        ++minimum_.line_search_steps;
        continue;
      }
      x_ = std::move(to);
      return part;
    }
    return 0.0;
  }

  Status descend(int most) {
    ElasticPotential::Slope here = slope(x_);
    minimum_.converged = false;
    for (int iteration = 0;; ++iteration) {
      minimum_.residual = residual(here);
      if (minimum_.residual <= goal_.tolerance) {
        minimum_.converged = true;
        return success();
      }
      if (iteration == most) return success();
      const Result<VertexMatrix> d = directions_.direction(E_, x_, here.gradient, {}, context_);
      if (!d) return d.error();
      ++minimum_.iterations;
      const double fall = here.gradient.cwiseProduct(d.value()).sum();
      if (fall < 0) {
        const double part = go(d.value(), fall, here);
        if (part > 0) continue;
        if (negligible(fall, here)) {
          minimum_.converged = true;  // as far as doubles can tell
          return success();
        }
      }
      if (!directions_.be_careful()) return success();
    }
  }

  // Whether a whole step changes the energy by less than its rounding.
  static bool negligible(double fall, const ElasticPotential::Slope& here) {
    return -fall <= kRoundedLength * here.value.size;
  }

  // Goes along d as far as the energy falls as it should [Armijo 1966]; where that cannot be told for
  // rounding, the gradient decides. fall: the energy's derivative on the way. Returns the part that was gone;
  // 0: nothing changes.
  double go(const VertexMatrix& d, double fall, ElasticPotential::Slope& here) {
    const bool by_gradient = negligible(fall, here);
    double part = allowed(d);
    for (int halving = 0; halving < kMostRounds && part > 0;
         ++halving, part /= 2, ++minimum_.line_search_steps) {
      const VertexMatrix to = x_ + part * d;
      ElasticPotential::Slope there = slope(to);
      const bool falls = by_gradient ? there.gradient.norm() < here.gradient.norm()
                                     : there.value.sum <= here.value.sum + kPrecise * part * fall;
      if (!falls || E_.body->first_flipped(to) >= 0) continue;
      directions_.gone(part, to - x_, there.gradient - here.gradient);
      x_ = to;
      here = std::move(there);
      return part;
    }
    return 0;
  }

  const ElasticPotential& E_;
  const ElasticGoal& goal_;
  ElasticDirections& directions_;
  VertexMatrix& x_;
  const RunContext& context_;
  ElasticMinimum minimum_;
};

}  // namespace

Result<ElasticMinimum> minimise(const ElasticPotential& E, const ElasticGoal& goal,
                                ElasticDirections& directions, VertexMatrix& x, const RunContext& context) {
  return Descent(E, goal, directions, x, context).run();
}

}  // namespace overtet::solve_detail
