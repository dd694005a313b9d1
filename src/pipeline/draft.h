// A tet mesh on its way to the quality pass. Internal to src/pipeline.
#pragma once

#include <utility>

#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet {

struct Draft {
  TetMesh mesh;
  // Vertices inside that were placed with care, for well-shaped tets (src/cdt/free_points.h). They come first
  // after the surface's; what follows was left by what made the mesh, and may lie anywhere.
  Index placed = 0;
};

inline Result<Draft> without_placed(Result<TetMesh> mesh) {
  if (!mesh) return mesh.error();
  return Draft{std::move(mesh).value(), 0};
}

}  // namespace overtet
