// The stage that fills the embedded surface U0 with tets (Sacht et al. 2013, section 3, step 3), ready for
// the volume map: the surface's faces are the boundary (components that face inwards bound cavities), its
// vertices come first, and no tet, interior face or interior edge has boundary vertices only. Such an element
// could not follow the boundary to its final place: where the surface folds onto itself, a tet with four
// boundary vertices has a volume that is decided by the input alone.
#pragma once

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/cdt/tetgen.h"

namespace overtet {

struct TetMeshOptions {
  double radius_edge = 2.0;  // of TetGen's quality tets; interior points only
  bool quality = true;
  bool pre_splits = true;

  Status validate() const;
};

struct TetMeshResult {
  TetMesh mesh;
  Index edges_split = 0, faces_split = 0, tets_split = 0;
  bool without_quality = false;  // TetGen failed with quality tets and succeeded without
  double tetgen_seconds = 0, seconds = 0;
  std::size_t tetgen_peak_rss_bytes = 0;
};

// pre: `embedded` is closed and does not intersect itself; outward faces.
// Errors: those of tetrahedralize(); unsolved when a cavity lies in no solid, or when a split is not possible
// in double precision.
Result<TetMeshResult> tet_mesh(const Surface& embedded, const TetMeshOptions& options,
                               const RunContext& context);

// The guarantees above, checked exactly; where assertions are on, tet_mesh() does so itself.
Status check_postconditions(const TetMeshResult& result, const Surface& embedded,
                            const TetMeshOptions& options);

}  // namespace overtet
