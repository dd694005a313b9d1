// What the surface allows the angles of a mesh to be.
//
// The tets at an edge of the surface share the surface's interior angle there, so none of them has a larger
// angle than that. So no mesh of the surface, however good, has a larger least dihedral angle than the least
// interior angle. Where a repair may move vertices, the same holds for all places where they may go.
#pragma once

#include "overtet/types.h"

namespace overtet {

// Degrees. No tet has six angles larger than the first (that of the regular one), so no bound is larger.
inline constexpr double kRegularAngle = 70.528779365509308;

struct AngleBounds {
  // At the surface's edges in faces with a moved vertex: the tet at the face has the edge and the vertex.
  double as_moved = kRegularAngle;  // of all meshes with the moved vertices where they are
  double at_moved =
      kRegularAngle;  // wherever they go within `reach`: at edges that have not moved themselves
  // At edges between faces without moved vertices, wherever those go.
  double elsewhere = kRegularAngle;
};

// mesh: of a surface with the faces F; home: #V x 3, where its vertices were before the repair; reach: how
// far a vertex may be from its home, in the unit of the coordinates. An edge has as many extra turns in the
// meshes that are spoken of as in this one. pre: every tet positive; mesh.surface_vertices == home.rows().
AngleBounds angle_bounds(const TetMesh& mesh, const TriangleMatrix& F, const VertexMatrix& home,
                         double reach);

}  // namespace overtet
