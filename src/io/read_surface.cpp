#include <algorithm>
#include <optional>
#include <utility>

#include "overtet/io.h"
#include "src/io/face_groups.h"
#include "src/io/file.h"
#include "src/io/mesh_parts.h"
#include "src/io/names.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"
#include "src/io/tuning.h"

namespace overtet {

using namespace io_detail;

namespace {

std::string_view first_token(std::string_view bytes) {
  TextCursor cursor("", bytes.substr(0, 4096), true);
  return cursor.to_token() ? cursor.token() : std::string_view();
}

// "off", "ply", "stl" (ASCII), "bstl" (binary), one of mesh_kind(), or "" where only the extension can tell.
std::string sniff(std::string_view bytes) {
  if (bytes.substr(0, 3) == "ply" && bytes.size() > 3 && (bytes[3] == '\n' || bytes[3] == '\r')) return "ply";
  if (is_binary_stl(bytes)) return "bstl";
  const std::string_view t = first_token(bytes);
  if (t == "off" || (t.size() >= 3 && t.size() <= 8 && t.substr(t.size() - 3) == "OFF")) return "off";
  if (t == "solid" || t == "SOLID" || t == "Solid") return "stl";
  if (is_gltf(bytes)) return "gltf";
  const std::string_view mesh = mesh_kind(bytes);
  return mesh == "abaqus" ? "" : std::string(mesh);
}

// Those of the kinds that are read as meshes with polygons.
std::optional<Result<Polygons>> parse_mesh(std::string_view kind, std::string_view name,
                                           std::string_view bytes, SurfaceReadInfo& info) {
  Result<MeshParts> parts = kind == "gmsh"      ? parse_gmsh(name, bytes)
                            : kind == "medit"   ? parse_medit(name, bytes)
                            : kind == "vtk_xml" ? parse_vtk_xml(name, bytes)
                            : kind == "vtk"     ? parse_vtk(name, bytes)
                                                : Result<MeshParts>(Error{});
  if (parts.ok()) return polygons_of(name, std::move(parts).value(), info);
  if (parts.error().message.empty()) return std::nullopt;
  return parts.error();
}

// The extension that files of a kind have.
bool fits(std::string_view extension, std::string_view kind) {
  if (kind == "gmsh") return extension == "msh";
  if (kind == "medit") return extension == "mesh";
  if (kind == "gltf") return extension == "gltf" || extension == "glb";
  if (kind == "vtk_xml") return extension == "vtp" || extension == "vtu";
  return extension == (kind == "bstl" ? "stl" : kind);
}

}  // namespace

namespace {

// "vertex 12 (line 15)"; numbers are shown as the file counts.
std::string name_in_file(const char* word, Index i, Index first, const std::vector<std::uint32_t>& lines) {
  std::string name = std::string(word) + " " + std::to_string(std::int64_t{i} + first);
  if (static_cast<std::size_t>(i) < lines.size())
    name += " (line " + std::to_string(lines[static_cast<std::size_t>(i)]) + ")";
  return name;
}

// The format that the file is in, as sniff() names it.
Result<std::string> format_of(const std::string& path, const std::string& name, std::string_view bytes,
                              SurfaceReadInfo& info) {
  const std::string extension = parts_of_name(path).extension;
  const std::string kind = sniff(bytes);
  static constexpr std::string_view extensions[] = {"off", "obj", "ply",  "stl", "msh", "mesh",
                                                    "vtp", "vtu", "gltf", "glb", "vtk"};
  const bool known =
      std::find(std::begin(extensions), std::end(extensions), extension) != std::end(extensions);
  if (!kind.empty()) {
    if (known && !fits(extension, kind))
      info.notes.push_back("The extension is ." + extension + ", but the file begins like " +
                           (kind == "bstl" ? std::string("binary STL") : kind) + " and was read as such.");
    return kind;
  }
  if (extension == "obj" || path == "-") return std::string("obj");
  if (extension == "off") return malformed(name, "the file does not begin with OFF");
  if (extension == "ply") return malformed(name, "the file does not begin with ply");
  if (extension != "stl")
    return malformed(
        name,
        "this is not a surface format that Overtet reads (OBJ, OFF, PLY, STL, glTF, VTP, VTK, MEDIT, Gmsh)");
  if (!is_binary_stl(bytes, true))
    return malformed(name,
                     "the file is neither ASCII STL (it does not begin with solid) nor binary STL "
                     "(its length does not fit its number of triangles)");
  info.notes.push_back("What follows the last triangle of the file was ignored.");
  return std::string("bstl");
}

bool is_text_ply(std::string_view bytes) {
  return bytes.substr(0, bytes.find("end_header")).find("format ascii") != std::string_view::npos;
}

// What does not belong to a text: NULs at its end, and line ends of a carriage return alone.
void tidy_text(std::string& bytes) {
  while (!bytes.empty() && bytes.back() == '\0') bytes.pop_back();
  if (bytes.find('\n') == std::string::npos) std::replace(bytes.begin(), bytes.end(), '\r', '\n');
}

}  // namespace

std::string SurfaceSource::vertex_name(Index v) const {
  return name_in_file("vertex", vertex_in_file(v), first, vertex_line);
}
std::string SurfaceSource::face_name(Index f) const {
  return name_in_file(face_word, face_in_file(f), first, face_line);
}

Result<Surface> read_surface(const std::string& path, SurfaceReadInfo* info_out, const RunContext& context) {
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  Result<std::string> file = read_file(path);
  if (!file) return file.error();
  SurfaceReadInfo local;
  return parse_surface(path, std::move(file).value(), info_out ? *info_out : local);
}

Result<Surface> io_detail::parse_surface(const std::string& path, std::string bytes, SurfaceReadInfo& info) {
  const std::string name = file_name(path);
  if (bytes.empty()) return malformed(name, "the file is empty");
  info = {};
  const std::size_t file_size = bytes.size();
  const std::string folder = path == "-" ? "" : path.substr(0, path.size() - name.size());
  const Result<std::string> format = format_of(path, name, bytes, info);
  if (!format) return format.error();
  const std::string& kind = format.value();
  if (kind == "off" || kind == "obj" || kind == "stl" || (kind == "ply" && is_text_ply(bytes)))
    tidy_text(bytes);
  std::optional<Result<Polygons>> mesh = parse_mesh(kind, name, bytes, info);
  Result<Polygons> parsed = mesh             ? *std::move(mesh)
                            : kind == "off"  ? parse_off(name, bytes, info)
                            : kind == "ply"  ? parse_ply(name, bytes, info)
                            : kind == "stl"  ? parse_ascii_stl(name, bytes, info)
                            : kind == "gltf" ? parse_gltf(name, folder, bytes, info)
                            : kind == "bstl" ? parse_binary_stl(name, bytes, info)
                                             : parse_obj(name, bytes, info);
  if (!parsed) return parsed.error();
  Polygons& polygons = parsed.value();
  if (polygons.xyz.empty()) return malformed(name, "the file has no vertices");
  if (polygons.sizes.empty()) return malformed(name, "the file has no faces");
  if (static_cast<std::int64_t>(polygons.corners.size() - 2 * polygons.sizes.size()) > kMaxCount)
    return malformed(name,
                     "the surface has more than 2147483647 triangles, the most that Overtet can number");
  Surface surface = triangulate(polygons, info.polygons, info.source.face);
  info.source.vertex_line = std::move(polygons.vertex_line);
  info.source.face_line = std::move(polygons.face_line);
  std::size_t width = 0;
  for (const Attribute& a : polygons.attributes.face_data) width += static_cast<std::size_t>(a.width);
  if (info.polygons > 0 &&
      static_cast<std::size_t>(surface.F.rows()) * width > kMostSpread / sizeof(double) * file_size) {
    polygons.attributes.face_data.clear();
    info.notes.push_back(
        "The data of faces were left out: there are too many for triangles of such large faces.");
  }
  spread_to_triangles(polygons.sizes, polygons.attributes);
  info.attributes = std::move(polygons.attributes);
  if (info.polygons > 0)
    info.notes.push_back(std::to_string(info.polygons) +
                         " faces with more than three corners were cut into triangles.");
  if (info.merged_vertices > 0)
    info.notes.push_back(std::to_string(info.merged_vertices) +
                         " equal corners of the STL file were merged into shared vertices.");
  return surface;
}

}  // namespace overtet
