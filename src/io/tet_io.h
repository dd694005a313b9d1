// Tet mesh files: MEDIT .mesh, Gmsh .msh 2.2 and 4.1, VTU, TetGen .node/.ele.
//
// Numbers are written in the shortest decimal form that reads back as the same double (VTU: as the bytes
// themselves), so the mesh that is read back is the mesh that was written, to the last bit. A file
// appears whole or not at all; of the two TetGen files both are complete before either gets its name.
#pragma once

#include <string>
#include <string_view>

#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet {

enum class TetFormat { medit, gmsh22, gmsh41, vtu, tetgen };

// "medit", "msh22", "msh41", "vtu", "tetgen" (as in --format).
Result<TetFormat> tet_format_named(std::string_view name);
// By extension: .mesh, .msh (4.1), .vtu, .node or .ele.
Result<TetFormat> tet_format_of(const std::string& path);

Status write_tets(const std::string& path, const TetMesh& mesh, TetFormat format);

// What is read: vertices and tets in file order; other elements are skipped. `surface_vertices` is 0.
// Malformed files are refused like surfaces. VTU: ASCII, inline binary and raw appended, uncompressed.
Result<TetMesh> read_tets(const std::string& path);

}  // namespace overtet
