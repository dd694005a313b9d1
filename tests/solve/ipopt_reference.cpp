// Bounded biharmonic weights beside Ipopt, an interior point method of others: the energies must agree.
//
// usage: ipopt_reference MESH HANDLES [MORE...]    pairs of files
//
// Prints a line a handle, and ends with 1 where the relative difference of a pair of energies is above 1e-6.
#include <IpIpoptApplication.hpp>
#include <IpSolveStatistics.hpp>
#include <IpTNLP.hpp>
#include <chrono>
#include <cstdio>
#include <ctime>

#include "kernels/fem/elements.h"
#include "overtet/weights.h"
#include "src/solve/handle_pins.h"

namespace {

using namespace overtet;
using Matrix = Eigen::SparseMatrix<double, Eigen::ColMajor, int>;
using Vector = Eigen::VectorXd;

// The least w' A w / 2, 0 <= w <= 1, of all vertices; those that are held have equal bounds.
class Problem : public Ipopt::TNLP {
 public:
  Problem(const Matrix& A, const Vector& low, const Vector& high) : A_(A), low_(low), high_(high) {}
  double energy = 0;
  Vector w;

  bool get_nlp_info(Ipopt::Index& n, Ipopt::Index& m, Ipopt::Index& jacobian, Ipopt::Index& hessian,
                    IndexStyleEnum& style) override {
    n = static_cast<int>(A_.rows());
    m = jacobian = 0;
    hessian = static_cast<int>(Matrix(A_.triangularView<Eigen::Lower>()).nonZeros());
    style = C_STYLE;
    return true;
  }
  bool get_bounds_info(Ipopt::Index n, double* low, double* high, Ipopt::Index, double*, double*) override {
    std::copy(low_.data(), low_.data() + n, low);
    std::copy(high_.data(), high_.data() + n, high);
    return true;
  }
  bool get_starting_point(Ipopt::Index n, bool, double* x, bool, double*, double*, Ipopt::Index, bool,
                          double*) override {
    for (int i = 0; i < n; ++i) x[i] = (low_[i] + high_[i]) / 2;
    return true;
  }
  bool eval_f(Ipopt::Index n, const double* x, bool, double& f) override {
    const Eigen::Map<const Vector> v(x, n);
    f = v.dot(A_ * v) / 2;
    return true;
  }
  bool eval_grad_f(Ipopt::Index n, const double* x, bool, double* g) override {
    Eigen::Map<Vector>(g, n) = A_ * Eigen::Map<const Vector>(x, n);
    return true;
  }
  bool eval_g(Ipopt::Index, const double*, bool, Ipopt::Index, double*) override { return true; }
  bool eval_jac_g(Ipopt::Index, const double*, bool, Ipopt::Index, Ipopt::Index, Ipopt::Index*, Ipopt::Index*,
                  double*) override {
    return true;
  }
  bool eval_h(Ipopt::Index, const double*, bool, double factor, Ipopt::Index, const double*, bool,
              Ipopt::Index, Ipopt::Index* row, Ipopt::Index* column, double* value) override {
    int at = 0;
    for (int j = 0; j < A_.outerSize(); ++j)
      for (Matrix::InnerIterator it(A_, j); it; ++it) {
        if (it.row() < j) continue;
        if (value)
          value[at] = factor * it.value();
        else
          row[at] = it.row(), column[at] = j;
        ++at;
      }
    return true;
  }
  void finalize_solution(Ipopt::SolverReturn, Ipopt::Index n, const double* x, const double*, const double*,
                         Ipopt::Index, const double*, const double*, double f, const Ipopt::IpoptData*,
                         Ipopt::IpoptCalculatedQuantities*) override {
    w = Eigen::Map<const Vector>(x, n);
    energy = f;
  }

 private:
  const Matrix& A_;
  const Vector &low_, &high_;
};

double cpu() { return static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

// The largest relative difference of energies; negative: something went wrong.
double compare(const char* mesh_path, const char* handles_path) {
  const Result<TetMesh> mesh = read_tets(mesh_path);
  const Result<Handles> handles = read_handles(handles_path);
  if (!mesh || !handles) {
    std::puts((mesh ? handles.error() : mesh.error()).message.c_str());
    return -1;
  }
  const TetMesh& m = mesh.value();
  const double begin = cpu();
  const Result<SkinningWeights> ours = skinning_weights(m, handles.value());
  const double our_time = cpu() - begin;
  const auto pins = solve_detail::handle_pins(m, handles.value(), {});
  if (!ours || !pins) {
    std::puts((ours ? pins.error() : ours.error()).message.c_str());
    return -1;
  }
  // In one piece, with all vertices: another way than that of src/solve.
  const TetElements elements(m.V, m.T, 1);
  const Matrix K = elements.stiffness().selfadjointView<Eigen::Lower>();
  const Vector inverse = elements.lumped_mass().cwiseInverse();
  Matrix A = K * inverse.asDiagonal() * K;
  const double scale = 1e-4 * A.diagonal().mean();  // so that energies are of order 1
  A /= scale;
  double worst = 0, their_time = 0;
  for (std::size_t h = 0; h < handles.value().handles.size(); ++h) {
    Vector low = Vector::Zero(m.V.rows()), high = Vector::Ones(m.V.rows());
    for (const auto& pin : pins.value().pins) {
      low[pin.vertex] = high[pin.vertex] = 0;
      for (const auto& [handle, weight] : pin.weights)
        if (handle == static_cast<int>(h)) low[pin.vertex] = high[pin.vertex] = weight;
    }
    Ipopt::SmartPtr<Problem> problem = new Problem(A, low, high);
    Ipopt::SmartPtr<Ipopt::IpoptApplication> ipopt = IpoptApplicationFactory();
    auto options = ipopt->Options();
    options->SetIntegerValue("print_level", 0);
    options->SetStringValue("sb", "yes");
    options->SetStringValue("linear_solver", "mumps");
    options->SetStringValue("hessian_constant", "yes");
    options->SetStringValue("mu_strategy", "adaptive");
    options->SetStringValue("fixed_variable_treatment", "make_parameter");
    // So that bounds are bounds, and the energy is known to some digits.
    options->SetNumericValue("bound_relax_factor", 0);
    options->SetNumericValue("tol", 1e-9);
    options->SetNumericValue("compl_inf_tol", 1e-9);
    options->SetNumericValue("dual_inf_tol", 1e-9);
    options->SetNumericValue("acceptable_tol", 1e-8);
    options->SetIntegerValue("max_iter", 300);
    options->SetStringValue("nlp_scaling_method", "none");
    const double start = cpu();
    if (ipopt->Initialize() != Ipopt::Solve_Succeeded) return -1;
    const auto status = ipopt->OptimizeTNLP(problem);
    const double seconds = cpu() - start;
    their_time += seconds;
    if (status != Ipopt::Solve_Succeeded && status != Ipopt::Solved_To_Acceptable_Level)
      std::printf("  (Ipopt ended with status %d)\n", static_cast<int>(status));
    const double e = ours.value().handles[h].energy / scale;
    const double difference = std::abs(e - problem->energy) / problem->energy;
    worst = std::max(worst, difference);
    std::printf("%s %s: %.15g, Ipopt %.15g (%d steps, %.2f s): relative difference %.2g (signed %.2g)\n",
                mesh_path, handles.value().handles[h].name.c_str(), e, problem->energy,
                static_cast<int>(ipopt->Statistics()->IterationCount()), seconds, difference,
                (e - problem->energy) / problem->energy);
  }
  std::printf("%s: %ld tets, %zu handles: CPU seconds %.2f, Ipopt %.2f; worst difference %.2g\n", mesh_path,
              static_cast<long>(m.T.rows()), handles.value().handles.size(), our_time, their_time, worst);
  return worst;
}

}  // namespace

int main(int count, char** words) {
  bool right = count >= 3;
  for (int i = 1; i + 1 < count; i += 2) {
    const double worst = compare(words[i], words[i + 1]);
    right = right && worst >= 0 && worst <= 1e-6;
  }
  return right ? 0 : 1;
}
