// The mesh that others make of a surface that passes through itself, to compare with: of the space that the
// surface winds around a positive number of times, whatever lies in one place is fused [Jacobson, Kavan,
// Sorkine-Hornung 2013]. Parts that pass through each other are glued there, so that fields, distances and
// forces pass from one to the other.
//
// Every tet is positive. Faces of the surface are cut where they cross, and what lies inside of others is no
// boundary any more. Same surface: same mesh, to the byte, on any number of threads.
#pragma once

#include "overtet/attributes.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

struct FusedOptions {
  double improve_degrees = 17;  // as MeshingOptions has it; 0: no pass

  Status validate() const;
};

// More than one surface vertex may lie in a place: the mesh has one there, the smallest of them.
struct FusedMesh {
  // Attributes: the boundary's triangles with the labels of the faces that they are parts of; input_face;
  // input_vertex (-1: not one of the surface's, or moved by the quality pass); regions, which are components;
  // layers, the winding number.
  LabelledTetMesh mesh;
  Index cut_faces = 0;       // of the surface's, cut where others cross them
  Index inner_vertices = 0;  // of the surface's, which lie inside this mesh
  Index surface_components = 0, components = 0;
  double solid_volume = 0;  // of the solid that the surface bounds: a place counts as often as it is covered
  double volume = 0;        // of this mesh
};

// pre: attributes are the surface's; its labels are used.
// Errors: bad_input (not closed, oriented and manifold, or a face without area: the message names it; or
// nothing has a positive winding number), unsolved (no mesh of all cells was found), limit, interrupted,
// internal. Never throws.
Result<FusedMesh> fused_mesh(const Surface& surface, const SurfaceAttributes& attributes = {},
                             const FusedOptions& options = {}, const RunContext& context = {});

}  // namespace overtet
