// The least value of an elastic potential, by steps on which no tet becomes flat. Internal to src/solve.
#pragma once

#include "src/solve/elastic_directions.h"

namespace overtet::solve_detail {

struct ElasticMinimum {
  int iterations = 0, line_search_steps = 0;
  double residual = 0;
  bool converged = false;
  bool brought = true;  // held vertices are where they are to be
  Index flat = -1;      // the tet that was in the way last; -1: none
};

// From x, which gets the result. held: of each vertex, whether it is; `targets`, where it is to be. Nothing
// is promised of x after an error. pre: every tet of x is positive. Errors: unsolved (no factor), limit,
// interrupted.
struct ElasticGoal {
  const std::vector<char>* held = nullptr;
  const VertexMatrix* targets = nullptr;
  double tolerance = 0;
  int most_iterations = 0;
};
Result<ElasticMinimum> minimise(const ElasticPotential& E, const ElasticGoal& goal,
                                ElasticDirections& directions, VertexMatrix& x, const RunContext& context);

}  // namespace overtet::solve_detail
