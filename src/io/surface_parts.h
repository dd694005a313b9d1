// What the surface readers share. Internal to src/io.
#pragma once

#include <cstdint>
#include <limits>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "overtet/io.h"
#include "overtet/result.h"
#include "overtet/types.h"

namespace overtet {
class TextWriter;  // file.h
}

namespace overtet::io_detail {

constexpr std::int64_t kMaxCount = std::numeric_limits<Index>::max();

// Vertices and polygons as a file lists them.
struct Polygons {
  std::vector<double> xyz;
  std::vector<Index> corners;
  std::vector<Index> sizes;      // of each face, at least 3
  SurfaceAttributes attributes;  // of these vertices and faces
  // On which they begin; empty in binary files, and where no one asks for them. Of STL: of the first corner.
  std::vector<std::uint32_t> vertex_line, face_line;
};

inline Error malformed(std::string_view file, const std::string& what) {
  return {ErrorCode::bad_input, std::string(file) + ": " + what + "."};
}

Result<Polygons> parse_off(std::string_view name, std::string_view bytes, SurfaceReadInfo& info);
Result<Polygons> parse_obj(std::string_view name, std::string_view bytes, SurfaceReadInfo& info);
Result<Polygons> parse_ply(std::string_view name, std::string_view bytes, SurfaceReadInfo& info);
Result<Polygons> parse_ascii_stl(std::string_view name, std::string_view bytes, SurfaceReadInfo& info);
Result<Polygons> parse_binary_stl(std::string_view name, std::string_view bytes, SurfaceReadInfo& info);
// longer: also where something follows the triangles.
bool is_binary_stl(std::string_view bytes, bool longer = false);
// folder: where the files are that a .gltf file names, with a slash at its end.
Result<Polygons> parse_gltf(std::string_view name, const std::string& folder, std::string_view bytes,
                            SurfaceReadInfo& info);
bool is_gltf(std::string_view bytes);

// What read_surface() makes of the bytes of a file. The path tells the extension, the name in messages, and
// where the files are that a .gltf file names.
Result<Surface> parse_surface(const std::string& path, std::string bytes, SurfaceReadInfo& info);

// What write_surface() writes.
void print_surface(TextWriter& out, const Surface& surface, SurfaceFormat format, const Labels& labels);

// What read_sizes() makes of the bytes of a file.
Result<std::vector<double>> parse_sizes(std::string_view name, std::string_view bytes);

// Cuts the polygons into triangles, in order; counts the ones that were not triangles. A polygon of n corners
// becomes n - 2 triangles; a corner that is named twice in a row is left out and comes last, as a triangle
// with two equal corners. face_of: of each triangle its polygon, where some were cut.
Surface triangulate(const Polygons& polygons, std::int64_t& cut, std::vector<Index>& face_of);

}  // namespace overtet::io_detail
