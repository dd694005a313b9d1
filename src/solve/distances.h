// The heat method on tets [Crane, Weischedel, Wardetzky 2013]: heat from the sources for a short time, its
// gradient's directions, and the potential that has these; of its directions the same again.
#pragma once

#include <span>
#include <vector>

#include "kernels/fem/elements.h"
#include "overtet/solve.h"
#include "src/solve/parts.h"

namespace overtet::solve_detail {

// See Distances.
class HeatMethod {
 public:
  static Result<HeatMethod> prepare(const TetMesh& mesh, const DistanceOptions& options,
                                    const RunContext& context);
  Result<Eigen::VectorXd> from(std::span<const Index> sources, const RunContext& context) const;

 private:
  explicit HeatMethod(const TetMesh& mesh);
  Result<Eigen::VectorXd> with_directions_of(const Eigen::VectorXd& u) const;
  Eigen::VectorXd along_first_edges(std::span<const Index> sources) const;

  TetElements elements_;
  Components components_;
  std::vector<Index> number_;  // of the vertices of tets, as in heat_
  std::vector<Index> held_;    // the same without one vertex a component, as in potential_
  Index used_ = 0, free_ = 0;
  SparseCholesky heat_, potential_;
};

}  // namespace overtet::solve_detail
