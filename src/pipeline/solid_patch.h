// The part of a tet mesh around boundary vertices that are not at their places, cut out as a problem of its
// own, and glued on again.
#pragma once

#include <vector>

#include "overtet/types.h"
#include "src/pipeline/draft.h"

namespace overtet {

// A closed surface, and a positive tet mesh with the same faces whose vertices are where they got to. Where
// the patch was cut out of the mesh both are in the same place.
struct SolidPatch {
  Surface target;
  TetMesh start;                // its boundary vertices first, in the order of `target`
  std::vector<Index> vertices;  // of the mesh: the number of each of start's
  std::vector<Index> tets;      // of the mesh: the number of each of start's, ascending
};

// The tets within `rings` (from 1 on) of `away`, what they enclose together with the surface nearby, and more
// where the patch would be pinched; the whole mesh if need be.
// pre: mesh is a solid whose first surface_vertices (rows of target) are its boundary's.
SolidPatch solid_around(const TetMesh& mesh, const VertexMatrix& target, const std::vector<Index>& away,
                        int rings);

// The mesh that the patch was cut out of, without its tets, with those of `inside` instead, and the boundary
// at the places of `target`. inside: a mesh of patch.target; its `placed` vertices and those of the mesh that
// stay count as placed.
Draft glued(const TetMesh& mesh, const VertexMatrix& target, const SolidPatch& patch, const Draft& inside);

}  // namespace overtet
