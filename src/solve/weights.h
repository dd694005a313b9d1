// Bounded biharmonic weights; see skinning_weights().
#pragma once

#include "overtet/weights.h"

namespace overtet::solve_detail {

// pre: handles and options are valid.
Result<SkinningWeights> weights(const TetMesh& mesh, const Handles& handles, const WeightOptions& options,
                                const RunContext& context);

Result<SkinnedMesh> skinned(const TetMesh& mesh, const Eigen::MatrixXd& weights,
                            const std::vector<AffineMatrix>& transforms);

}  // namespace overtet::solve_detail
