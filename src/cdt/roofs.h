// Roofs over flat areas of needles: a few well-shaped triangles just inside the solid, which TetGen sees in
// place of the needles.
//
// A flat area of which one point sees all (star_areas.h) and its roof, which spans the same outline, enclose
// a thin slab. A hub just under the area sees both sides of it, so the slab is filled by one tet for each
// face of the area and of the roof. Along the outline a roof has one triangle an edge, all edges of a run
// with one point, at about the distance that the run is long: where the outline is a fine arc, near its
// centre, so that the tets behind it have room. Inside, the points of the runs stand around one more.
#pragma once

#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/cdt/star_areas.h"

namespace overtet {

struct RoofedSurface {
  Surface surface;  // with roofs; does not cross itself
  std::vector<Index>
      vertex;         // of the original, of each vertex of the surface but those of roofs, which come last
  VertexMatrix hubs;  // #roofs x 3
  TetMatrix slabs;    // positive; vertices: of the original, then of roofs, then hubs
  Index roof_vertices = 0;
};

// Those roofs that can be made; `hubs` has no row where there are none. surface: does not cross itself.
// areas: of find_star_areas(). Errors: limit or interrupted.
Result<RoofedSurface> raise_roofs(const Surface& surface, const std::vector<StarArea>& areas,
                                  const RunContext& context);

}  // namespace overtet
