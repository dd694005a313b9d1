#include "src/solve/elastic_directions.h"

#include <utility>

#include "src/solve/parts.h"
#include "src/solve/tuning.h"

namespace overtet::solve_detail {

namespace {

const Error kNoMemory{ErrorCode::limit, "There is not enough memory to solve this system."};

// Prepares the factor for matrices of this pattern.
Status analyzed(SparseCholesky& factor, const SymmetricMatrix& A, const RunContext& context) {
  if (auto stop = context.stop()) return *stop;
  if (!factor.analyze(A))
    return Error{ErrorCode::limit, "There is not enough memory for the factor of this system."};
  if (auto e = context.no_room_for(static_cast<std::size_t>(8 * factor.factor_entries()))) return *e;
  return success();
}

// The matrix as it is, as long as it is positive definite; else, until a whole step was gone, that of the
// tets' definite parts.
class NewtonDirections final : public ElasticDirections {
 public:
  explicit NewtonDirections(const std::vector<Index>& number) : number_(number) {}

  Result<VertexMatrix> direction(const ElasticPotential& E, const VertexMatrix& x, const VertexMatrix& g,
                                 const VertexMatrix& given, const RunContext& context) override {
    if (auto stop = context.stop()) return *stop;
    Result<bool> factored = factor(E, x, exact_ ? Tangent::exact : Tangent::definite, context);
    if (factored && !factored.value() && exact_) {
      exact_ = false;
      factored = factor(E, x, Tangent::definite, context);
    }
    if (!factored) return factored.error();
    if (!factored.value()) return not_definite();
    const VertexMatrix change = given.rows() > 0 ? VertexMatrix(g + E.change(tangents_, given)) : g;
    Eigen::VectorXd b(E.body->rows());
    for (std::size_t v = 0; v < number_.size(); ++v)
      if (number_[v] >= 0)
        b.segment<3>(3 * number_[v]) = -change.row(static_cast<Eigen::Index>(v)).transpose();
    if (!factor_.solve(b, b)) return kNoMemory;
    VertexMatrix out = given.rows() > 0 ? given : VertexMatrix(VertexMatrix::Zero(g.rows(), 3));
    for (std::size_t v = 0; v < number_.size(); ++v)
      if (number_[v] >= 0) out.row(static_cast<Eigen::Index>(v)) = b.segment<3>(3 * number_[v]).transpose();
    return out;
  }

  void gone(double part, const VertexMatrix&, const VertexMatrix&) override {
    if (part == 1) exact_ = true;
  }
  void begin() override { exact_ = true; }
  bool be_careful() override { return std::exchange(exact_, false); }

 private:
  // False: not positive definite.
  Result<bool> factor(const ElasticPotential& E, const VertexMatrix& x, Tangent kind,
                      const RunContext& context) {
    E.body->tangents(x, kind, tangents_);
    E.assemble(tangents_, A_);
    if (!analyzed_)
      if (Status s = analyzed(factor_, A_, context); !s) return s.error();
    analyzed_ = true;
    if (auto stop = context.stop()) return *stop;
    ++factorisations;
    return factor_.factor(A_);
  }

  const std::vector<Index> number_;
  ElasticBody::Tangents tangents_;
  SymmetricMatrix A_;
  // METIS, whatever the size: the matrix is of a solid, and is factored many times.
  SparseCholesky factor_{{CholeskyOptions::Ordering::metis, CholeskyOptions::Method::automatic}};
  bool analyzed_ = false, exact_ = true;
};

class QuasiNewtonDirections final : public ElasticDirections {
 public:
  QuasiNewtonDirections(const std::vector<Index>& number, SymmetricMatrix stiffness)
      : number_(number), stiffness_(std::move(stiffness)) {
    for (const Index n : number_) free_ = std::max(free_, n + 1);
  }

  Result<VertexMatrix> direction(const ElasticPotential& E, const VertexMatrix&, const VertexMatrix& g,
                                 const VertexMatrix& given, const RunContext& context) override {
    if (auto stop = context.stop()) return *stop;
    if (Status s = factor(E, context); !s) return s.error();
    VertexMatrix q = kept(g);
    if (given.rows() > 0) {
      VertexMatrix change;
      multiply(stiffness_, given, change);
      q += (1 + E.viscosity) * kept(change);
    }
    // The two loops of L-BFGS [Nocedal 1980].
    std::vector<double> alpha(pairs_.size());
    for (std::size_t i = pairs_.size(); i-- > 0;) {
      alpha[i] = pairs_[i].s.cwiseProduct(q).sum() / pairs_[i].sy;
      q -= alpha[i] * pairs_[i].y;
    }
    if (!factor_.solve(q, q)) return kNoMemory;
    for (std::size_t i = 0; i < pairs_.size(); ++i)
      q += (alpha[i] - pairs_[i].y.cwiseProduct(q).sum() / pairs_[i].sy) * pairs_[i].s;
    VertexMatrix out = given.rows() > 0 ? given : VertexMatrix(VertexMatrix::Zero(g.rows(), 3));
    for (std::size_t v = 0; v < number_.size(); ++v)
      if (number_[v] >= 0) out.row(static_cast<Eigen::Index>(v)) = -q.row(number_[v]);
    return out;
  }

  void gone(double, const VertexMatrix& way, const VertexMatrix& g_change) override {
    Pair pair{kept(way), kept(g_change), 0};
    pair.sy = pair.s.cwiseProduct(pair.y).sum();
    if (!(pair.sy > 0)) return;
    pairs_.push_back(std::move(pair));
    if (pairs_.size() > kRemembered) pairs_.pop_front();
  }
  void begin() override { pairs_.clear(); }
  bool be_careful() override {
    const bool something = !pairs_.empty();
    pairs_.clear();
    return something;
  }

 private:
  struct Pair {
    VertexMatrix s, y;
    double sy;
  };

  VertexMatrix kept(const VertexMatrix& all) const {
    VertexMatrix out(free_, 3);
    for (std::size_t v = 0; v < number_.size(); ++v)
      if (number_[v] >= 0) out.row(number_[v]) = all.row(static_cast<Eigen::Index>(v));
    return out;
  }

  // Where the weights of its parts are others than before.
  Status factor(const ElasticPotential& E, const RunContext& context) {
    const std::array<double, 2> weights{1 + E.viscosity, E.inertia + E.drag};
    if (weights == weights_) return success();
    SymmetricMatrix A = weights[0] * kept_part(stiffness_, number_, free_);
    for (std::size_t v = 0; v < number_.size(); ++v)
      if (const Index n = number_[v]; n >= 0)
        A.coeffRef(n, n) += weights[1] * (*E.mass)[static_cast<Eigen::Index>(v)];
    if (weights_ == std::array<double, 2>{})
      if (Status s = analyzed(factor_, A, context); !s) return s;
    ++factorisations;
    if (!factor_.factor(A)) return not_definite();
    weights_ = weights;
    pairs_.clear();
    return success();
  }

  const std::vector<Index> number_;
  const SymmetricMatrix stiffness_;
  Index free_ = 0;
  std::array<double, 2> weights_{};
  SparseCholesky factor_{{CholeskyOptions::Ordering::metis, CholeskyOptions::Method::automatic}};
  std::deque<Pair> pairs_;
};

}  // namespace

std::unique_ptr<ElasticDirections> newton_directions(const std::vector<Index>& number) {
  return std::make_unique<NewtonDirections>(number);
}

std::unique_ptr<ElasticDirections> quasi_newton_directions(const std::vector<Index>& number,
                                                           SymmetricMatrix stiffness) {
  return std::make_unique<QuasiNewtonDirections>(number, std::move(stiffness));
}

}  // namespace overtet::solve_detail
