// Parts of a surface that are solids of their own, meshed one by one.
//
// A connected component whose winding number is nowhere negative bounds a solid by itself, whatever it passes
// through or coincides with; the union of the parts' meshes is a mesh of the whole. So components never have
// to be cut along each other, and only crossings of a component with itself are left to the immersion. A
// component that faces inwards is a cavity and goes with the smallest one around it. Parts that are far from
// each other go together into one mesh; a part that has no mesh by itself is joined with what is near it.
// Repairs take the parts one by one, too.
#pragma once

#include <vector>

#include "overtet/report.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/diagnose.h"
#include "src/mesh/submesh.h"
#include "src/pipeline/draft.h"
#include "src/pipeline/meshing_job.h"

namespace overtet {

// No crossings, no component inside another one: any mesh of the inside is the answer.
bool is_plain(const Diagnosis& diagnosis);
struct PlainMesh {
  Draft draft;
  Index missing_facets = 0, tetgen_facets = 0, tetgen_parts = 0;  // as TetgenResult's
};
// By Delaunay tets, or TetGen, with roofs over needles. pre: is_plain().
Result<PlainMesh> mesh_plain(const Surface& surface, const RunContext& context);

// The parts, where there are two or more.
std::vector<SubSurface> parts_of(const Surface& surface, const Diagnosis& diagnosis);

struct PartMesh {
  std::vector<Index> vertices;  // of the whole, increasing: the part's surface vertices
  TetMesh mesh;
  Index placed = 0;  // as Draft's
};
// One mesh with the surface vertices V; those in `parts` are not looked at.
Draft united(const VertexMatrix& V, const std::vector<PartMesh>& parts);

// Whether several parts lie so close to each other that meshing them one by one is worth while.
bool has_parts(const Surface& surface, const Diagnosis& diagnosis);

// A positive tet mesh of the surface, not yet checked. pre: has_parts().
Result<Draft> mesh_by_parts(const MeshingJob& job);

}  // namespace overtet
