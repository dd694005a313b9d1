// What files of meshes hold, surfaces as well as tets: the readers of MEDIT, Gmsh, VTK, TetGen and Abaqus
// fill this, and a surface or a tet mesh is made of it. Internal to src/io.
#pragma once

#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "overtet/attributes.h"
#include "overtet/io.h"
#include "src/io/surface_parts.h"

namespace overtet::io_detail {

// More than 12 members: a plain record of what files may have.
struct MeshParts {
  std::vector<double> xyz;
  std::vector<Index> input_vertex;    // of each vertex, or empty
  std::vector<Index> tets;            // four corners each
  Labels regions;                     // of each tet, or empty
  std::vector<Index> layers;          // of each tet, or empty
  std::vector<Index> corners, sizes;  // of polygons
  Labels labels;                      // of each polygon, or empty
  std::vector<Index> input_face;      // of each polygon, or empty
  std::vector<Attribute> vertex_data, polygon_data;
  bool second_order = false;  // there are vertices in the middle of edges
  std::string format;         // for instance "MEDIT"
};

Result<MeshParts> parse_medit(std::string_view name, std::string_view bytes);
Result<MeshParts> parse_gmsh(std::string_view name, std::string_view bytes);
Result<MeshParts> parse_vtk_xml(std::string_view name, std::string_view bytes);
Result<MeshParts> parse_vtk(std::string_view name, std::string_view bytes);
Result<MeshParts> parse_abaqus(std::string_view name, std::string_view bytes);
// Of the path without .node and .ele; gz: ".gz" where the files' names end so.
Result<MeshParts> read_tetgen(const std::string& base, const std::string& gz);
// One file after the other; `first`: the number of the first node.
Status parse_tetgen_nodes(std::string_view name, std::string_view bytes, MeshParts& out, std::int64_t& first);
Status parse_tetgen_tets(std::string_view name, std::string_view bytes, MeshParts& out, std::int64_t& first);
Status parse_tetgen_faces(std::string_view name, std::string_view bytes, MeshParts& out, std::int64_t& first);
// What read_labelled_tets() makes of the bytes of a file that is not TetGen's; without a format: as the file
// begins.
Result<LabelledTetMesh> parse_tets(std::string_view name, std::optional<TetFormat> format,
                                   std::string_view bytes);

// Which of them a file is, by what it begins with: "medit", "gmsh", "vtk_xml", "vtk", "abaqus", or "".
std::string_view mesh_kind(std::string_view bytes);

// Errors: bad_input, where there are no vertices or tets.
Result<LabelledTetMesh> tet_mesh_of(std::string_view name, MeshParts&& parts);
// The polygons, without the vertices that none of them has, which `info` tells of.
Result<Polygons> polygons_of(std::string_view name, MeshParts&& parts, SurfaceReadInfo& info);

// In the middle of the edges of a tet with ten vertices come those after the corners; of a triangle with six.
// The edges by their corners, as VTK, Abaqus and MEDIT count them.
inline constexpr int kMiddleOf[6][2] = {{0, 1}, {1, 2}, {2, 0}, {0, 3}, {1, 3}, {2, 3}};

// A label or a number of an element that a file has as a double; 0 where that is none.
inline Index as_index(double x) { return std::abs(x) <= double{kMaxCount} ? static_cast<Index>(x) : 0; }

}  // namespace overtet::io_detail
