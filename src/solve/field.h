// Laplace's, Poisson's and the biharmonic equation; see solve_field().
#pragma once

#include "overtet/solve.h"

namespace overtet::solve_detail {

// pre: the options are valid.
Result<Field> field(const LabelledTetMesh& mesh, const FieldOptions& options, const RunContext& context);

}  // namespace overtet::solve_detail
