// Surface files: OBJ, OFF (with colours and normals: COFF, NOFF, ...), PLY (ASCII, both byte orders) and
// STL (ASCII and binary).
//
// Reading keeps the order of the vertices. What a file begins with counts more than its extension.
// Polygons are cut into triangles, the equal vertices of STL are merged; both are said in the notes.
// Whatever is malformed is refused with one sentence that names the line or the element; a count that
// the file is too short for is refused before memory is taken for it. Whether the surface is closed,
// oriented and so on is not looked at here.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet {

struct SurfaceReadInfo {
  std::string format;                // for instance "PLY, binary, little endian"
  std::int64_t polygons = 0;         // faces with more than three corners, now triangulated
  std::int64_t merged_vertices = 0;  // of an STL file: corners that share a vertex with an earlier one
  bool has_vertex_order = true;      // false for STL, which lists corners only
  std::vector<std::string> notes;    // one sentence each, for the user
};

Result<Surface> read_surface(const std::string& path, SurfaceReadInfo* info = nullptr);

enum class SurfaceFormat { off, obj, ply };  // PLY: binary, little endian, doubles

Result<SurfaceFormat> surface_format_of(const std::string& path);  // by extension
// Atomic; what read_surface reads back is identical.
Status write_surface(const std::string& path, const Surface& surface, SurfaceFormat format);

}  // namespace overtet
