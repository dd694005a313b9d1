#include "overtet/weights.h"

#include "src/api/guarded.h"
#include "src/solve/weights.h"

namespace overtet {

Result<SkinningWeights> skinning_weights(const TetMesh& mesh, const Handles& handles,
                                         const WeightOptions& options, const RunContext& outer) {
  if (Status valid = options.validate(); !valid) return valid.error();
  if (Status valid = handles.validate(); !valid) return valid.error();
  return guarded(outer, [&](const RunContext& context) {
    return solve_detail::weights(mesh, handles, options, context);
  });
}

Result<SkinnedMesh> skinned(const TetMesh& mesh, const Eigen::MatrixXd& weights,
                            const std::vector<AffineMatrix>& transforms) {
  return guarded({}, [&](const RunContext&) { return solve_detail::skinned(mesh, weights, transforms); });
}

}  // namespace overtet
