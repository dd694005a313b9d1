// The embedding of a closed surface that may pass through itself: the same triangles with nearly the same
// lengths and areas, intersecting nowhere. For what needs the surface's own metric and no crossings: cloth
// and shells at rest, textures, parametrisation.
//
// Guaranteed, decided exactly on the doubles that are handed out: no two faces have more in common than the
// vertex or edge that they share. The faces are the input's. A vertex that is not in `moved` is where it was,
// to the last bit. Same surface, same options: same embedding, to the byte, on any number of threads, as long
// as no deadline cuts it short (which is logged).
//
// Not guaranteed, but measured and handed out: how near lengths and areas are. Where a part of the surface
// stays collapsed, `collapsed` says so.
//
// Source: Sacht et al., "Consistent Volumetric Discretizations Inside Self-Intersecting Surfaces", 2013,
// section 3 (U0, steps 1 and 2); docs/paper.md says what is different. Components that cross each other are
// laid side by side first: no flow pulls them off each other.
#pragma once

#include <vector>

#include "overtet/report.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct EmbedOptions {
  // Between components that are laid side by side, relative to the diagonal of the bounding box; more than 0,
  // up to 10.
  double gap = 0.05;

  Status validate() const;
};

struct Embedding {
  Surface surface;                // U0, with the input's faces
  std::vector<Index> moved;       // vertices, sorted
  std::vector<Index> laid_aside;  // components that were moved as a whole first, sorted; they are numbered by
                                  // their first faces
  EmbeddingQuality quality;
};

// Works on surfaces of any genus and number of components, and on such as have no tet mesh.
// report: receives what the run did, even if it fails. The caller fills in its `options`, `input.format` and
// `input.notes`.
// Errors: usage, bad_input (not closed, oriented and manifold, or a face without area; the message names the
// element), unsolved (no flow ends without crossings), limit, interrupted, internal. Never throws.
Result<Embedding> embed(const Surface& surface, const EmbedOptions& options = {},
                        const RunContext& context = {}, Report* report = nullptr);

}  // namespace overtet
