// The means of src/cdt/tetgen.h's tetrahedralize_stubbornly() one by one, for the tests. Internal to src/cdt.
#pragma once

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "src/cdt/tetgen.h"

namespace overtet {

// What has been tried to get one mesh, and whether more is worth while.
class Attempts {
 public:
  explicit Attempts(const TetgenOptions& options);

  bool left() const { return facets_ > 0; }
  bool another_order() const;  // of points, for TetGen
  bool any_endless() const { return any_endless_; }

  // Of one more attempt, at so many facets; hands the result on.
  Result<TetgenResult> count(Eigen::Index facets, Result<TetgenResult> result);
  // Edges have been cut: one order at least.
  void other_facets();

 private:
  double facets_;
  int endless_ = 0;
  bool any_endless_ = false;
};

// tetrahedralize() of the same complex shown in another order: its axes turned, from the fourth number on its
// points shuffled, too. The geometry stays the same to the last bit, and so do the promises.
Result<TetgenResult> tetrahedralize_in_order(const Plc& plc, const TetgenOptions& options,
                                             const RunContext& context, int number);

// With edges of facets cut in half (split_edges.h), again and again.
Result<TetgenResult> tetrahedralize_split(const Plc& plc, const TetgenOptions& options,
                                          const RunContext& context, Attempts& attempts);

}  // namespace overtet
