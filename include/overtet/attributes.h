// What comes with a surface and goes with its tet mesh: labels, colours, what a file's properties say, and
// where things come from. Nothing here moves a vertex or changes a tet.
//
// Vertices, faces and tets are counted from 0. Labels are numbers as the input gives them, else counted
// from 1.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "overtet/verification.h"

namespace overtet {

enum class NumberType { uint8, int32, int64, float32, float64 };  // how a file stores it

// `width` numbers for each vertex or face. Whole numbers beyond 2^53 are rounded.
struct Attribute {
  std::string name;
  NumberType type = NumberType::float64;
  int width = 1;
  std::vector<double> values;
};

// A number for each face or tet, or none at all; names of some of the numbers.
struct Labels {
  std::vector<Index> of;
  std::map<Index, std::string> names;
};

struct SurfaceAttributes {
  Labels faces;   // #F: OBJ g, o and usemtl; STL solids; PLY label; OFF colours; Gmsh groups; MEDIT refs
  Labels solids;  // #F: which solid a face belongs to, where the file says it (OBJ o, STL solid)
  std::vector<Attribute> vertex_data, face_data;
  // The numbers that vertices and faces have in the file, where something was left out, polygons were cut or
  // corners merged. Empty: the same.
  std::vector<Index> input_vertex, input_face;
};

// The same after vertices and faces were left out or put in another order: for each of the new ones, the
// number of the old one; empty: all are as they were. -1: a vertex that is new, and gets 0, or NaN. So what a
// clean-up or a refinement has done to a surface (Cleanup::vertex_of and face_of, RefinedSurface::face) is
// done to its attributes. pre: numbers in range of what the attributes were for.
SurfaceAttributes carried(const SurfaceAttributes& attributes, const std::vector<Index>& old_vertex,
                          const std::vector<Index>& old_face);

struct MeshAttributes {
  TriangleMatrix triangles;         // #B x 3: the boundary faces, as the surface has them
  Labels labels;                    // #B: of the triangles
  std::vector<Index> input_face;    // #B: the surface's face
  Labels regions;                   // #T: which solid a tet belongs to
  std::vector<Index> layers;        // #T: how many layers of the solid there are at the tet's centre
  std::vector<Index> input_vertex;  // #V: the surface's vertex; -1: an inner one
  std::vector<Attribute> vertex_data, triangle_data;  // #V, #B
};

struct LabelledTetMesh {
  TetMesh mesh;
  MeshAttributes attributes;
};

// The labels that a mesh of this surface gets: what came with the faces, else the surface's components,
// counted from 1 by their smallest face.
Labels labels_of_faces(const Surface& surface, const SurfaceAttributes& attributes);

struct MeshAttributeOptions {
  bool layers = true;  // what takes longest, a twentieth of meshing: not all formats have a place for it
  // The surface's largest winding number, where it is known: where that is 1, so is the number of layers.
  std::optional<int> winding_max;
};

// All that a file of the mesh should say.
//
// pre: the mesh is one of the surface (verification.h), surface_vertices included; where a repair has moved
// vertices, the mesh's places count. Regions are the components of the tets, by their smallest face of the
// surface. Where the input names several solids, a component whose faces are all of one solid gets that
// solid's number and name; the others get numbers after the solids'. Layers are exact: the winding number of
// the surface at a point inside the tet, its centroid where that is not on the surface. Inner vertices have
// 0, or NaN, as vertex data. Same result on any number of threads. Errors: limit, interrupted. May throw
// std::bad_alloc.
Result<MeshAttributes> mesh_attributes(const Surface& surface, const SurfaceAttributes& attributes,
                                       const TetMesh& mesh, const MeshAttributeOptions& options = {},
                                       const RunContext& context = {});

// R7: the triangles that a file has besides the tets are the surface's faces, with its orientation, and their
// labels the surface's. Nothing is wrong where it has none. geometry_only: see VerifyOptions.
std::vector<VerifyFailure> verify_attributes(const Surface& surface, const SurfaceAttributes& attributes,
                                             const LabelledTetMesh& mesh, bool geometry_only = false);

}  // namespace overtet
