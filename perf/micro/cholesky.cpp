// The factor of L + 100 M (cotangent Laplacian and mass, the matrix of a flow step): every ordering with both
// kinds of factor. One thread. Measured with CHOLMOD itself, because the program offers only what it needs;
// cholesky/overtet is the program's own choice.
//
// Counters: rows, nonzeros of the factor (as the analysis counts them), factor_bytes (what the factor takes
// after the numeric factorisation), residual (of one solve, relative).
#include <suitesparse/cholmod.h>

#include "kernels/laplacian/laplacian.h"
#include "kernels/sparse/cholesky.h"
#include "perf/micro/models.h"

namespace {

using namespace overtet;
using perf::count;

SymmetricMatrix system_of(const Surface& s) {
  SymmetricMatrix Q = cotangent_laplacian(s.V, s.F, 0.05);
  const Eigen::VectorXd mass = lumped_mass(s.V, s.F);
  for (Eigen::Index i = 0; i < Q.cols(); ++i) Q.valuePtr()[Q.outerIndexPtr()[i]] += 100 * mass[i];
  return Q;
}

struct Cholmod {
  Cholmod(const SymmetricMatrix& A, int ordering, bool supernodal) {
    cholmod_start(&common);
    common.nmethods = 1;
    common.method[0].ordering = ordering;
    common.postorder = 1;
    common.supernodal = supernodal ? CHOLMOD_SUPERNODAL : CHOLMOD_SIMPLICIAL;
    common.final_ll = 1;
    matrix.nrow = matrix.ncol = static_cast<std::size_t>(A.rows());
    matrix.nzmax = static_cast<std::size_t>(A.nonZeros());
    matrix.p = const_cast<int*>(A.outerIndexPtr());
    matrix.i = const_cast<int*>(A.innerIndexPtr());
    matrix.x = const_cast<double*>(A.valuePtr());
    matrix.stype = -1;
    matrix.itype = CHOLMOD_INT;
    matrix.xtype = CHOLMOD_REAL;
    matrix.dtype = CHOLMOD_DOUBLE;
    matrix.sorted = matrix.packed = 1;
  }
  ~Cholmod() {
    cholmod_free_factor(&factor, &common);
    cholmod_finish(&common);
  }
  Cholmod(const Cholmod&) = delete;
  Cholmod& operator=(const Cholmod&) = delete;

  void analyze() {
    cholmod_free_factor(&factor, &common);
    factor = cholmod_analyze(&matrix, &common);
  }
  void factorize() { cholmod_factorize(&matrix, factor, &common); }
  cholmod_dense* solve(const Eigen::MatrixXd& B) {
    cholmod_dense b{};
    b.nrow = b.d = static_cast<std::size_t>(B.rows());
    b.ncol = static_cast<std::size_t>(B.cols());
    b.nzmax = b.nrow * b.ncol;
    b.x = const_cast<double*>(B.data());
    b.xtype = CHOLMOD_REAL;
    b.dtype = CHOLMOD_DOUBLE;
    return cholmod_solve(CHOLMOD_A, factor, &b, &common);
  }
  double bytes() const {
    const cholmod_factor& L = *factor;
    const double n = static_cast<double>(L.n);
    if (L.is_super)
      return 8.0 * static_cast<double>(L.xsize) + 4.0 * static_cast<double>(L.ssize) +
             12.0 * static_cast<double>(L.nsuper + 1) + 8 * n;
    return 12.0 * static_cast<double>(L.nzmax) + 24 * n;
  }

  cholmod_common common{};
  cholmod_sparse matrix{};
  cholmod_factor* factor = nullptr;
};

enum Step { analysis, numeric, solution };

void measure(benchmark::State& state, const Surface& s, int ordering, bool supernodal, Step step) {
  const SymmetricMatrix Q = system_of(s);
  Cholmod c(Q, ordering, supernodal);
  c.analyze();
  if (!c.factor) {
    state.SkipWithError("CHOLMOD was built without this ordering");
    return;
  }
  const double entries = c.common.lnz;
  c.factorize();
  const Eigen::MatrixXd B = s.V;
  for (auto _ : state) {
    if (step == analysis) c.analyze();
    if (step == numeric) c.factorize();
    if (step == solution) {
      cholmod_dense* x = c.solve(B);
      cholmod_free_dense(&x, &c.common);
    }
  }
  if (step == analysis) c.factorize();
  cholmod_dense* x = c.solve(B);
  const Eigen::Map<const Eigen::MatrixXd> X(static_cast<const double*>(x->x), B.rows(), B.cols());
  const Eigen::MatrixXd R = Q.selfadjointView<Eigen::Lower>() * X - B;
  count(state, "rows", static_cast<double>(Q.rows()));
  count(state, "nonzeros", entries);
  count(state, "factor_bytes", c.bytes());
  count(state, "residual", R.norm() / B.norm());
  cholmod_free_dense(&x, &c.common);
}

void own(benchmark::State& state, const Surface& s, Step step) {
  const SymmetricMatrix Q = system_of(s);
  SparseCholesky factor;
  if (!factor.analyze(Q) || !factor.factor(Q)) {
    state.SkipWithError("no factor");
    return;
  }
  VertexMatrix X;
  for (auto _ : state) {
    bool fine = true;
    if (step == analysis) fine = factor.analyze(Q);
    if (step == numeric) fine = factor.factor(Q);
    if (step == solution) fine = factor.solve(s.V, X);
    benchmark::DoNotOptimize(fine);
  }
  count(state, "rows", static_cast<double>(Q.rows()));
  count(state, "nonzeros", factor.factor_entries());
}

void laplacian(benchmark::State& state, const Surface& s) {
  for (auto _ : state) benchmark::DoNotOptimize(cotangent_laplacian(s.V, s.F, 0.05));
  count(state, "faces", static_cast<double>(s.F.rows()));
}

void register_all() {
  perf::for_each_model("laplacian/cotangent", laplacian);
  const char* steps[] = {"analyze", "factor", "solve"};
  for (const Step step : {analysis, numeric, solution})
    perf::for_each_model(std::string("cholesky/overtet/") + steps[step],
                         [=](benchmark::State& state, const Surface& s) { own(state, s, step); });
  const std::pair<const char*, int> orderings[] = {
      {"amd", CHOLMOD_AMD}, {"metis", CHOLMOD_METIS}, {"nesdis", CHOLMOD_NESDIS}};
  for (const auto& [name, ordering] : orderings)
    for (const bool supernodal : {false, true})
      for (const Step step : {analysis, numeric, solution})
        perf::for_each_model(
            std::string("cholesky/") + name + (supernodal ? "/supernodal/" : "/simplicial/") + steps[step],
            [=, o = ordering](benchmark::State& state, const Surface& s) {
              measure(state, s, o, supernodal, step);
            });
}

}  // namespace

int main(int argc, char** argv) { return overtet::perf::run(argc, argv, register_all); }
