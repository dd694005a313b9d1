#include <algorithm>
#include <cctype>

#include "overtet/io.h"
#include "src/io/file.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet {

using namespace io_detail;

namespace {

std::string extension_of(const std::string& path) {
  const auto dot = path.rfind('.');
  const auto slash = path.rfind('/');
  if (dot == std::string::npos || (slash != std::string::npos && dot < slash)) return "";
  std::string e = path.substr(dot + 1);
  std::transform(e.begin(), e.end(), e.begin(), [](unsigned char c) { return std::tolower(c); });
  return e;
}

std::string_view first_token(std::string_view bytes) {
  TextCursor cursor("", bytes.substr(0, 4096), true);
  return cursor.to_token() ? cursor.token() : std::string_view();
}

// "off", "ply", "stl" (ASCII), "bstl" (binary), or "" where only the extension can tell.
std::string sniff(std::string_view bytes) {
  if (bytes.substr(0, 3) == "ply" && bytes.size() > 3 && (bytes[3] == '\n' || bytes[3] == '\r')) return "ply";
  if (is_binary_stl(bytes)) return "bstl";
  const std::string_view t = first_token(bytes);
  if (t == "off" || (t.size() >= 3 && t.size() <= 8 && t.substr(t.size() - 3) == "OFF")) return "off";
  if (t == "solid" || t == "SOLID" || t == "Solid") return "stl";
  return "";
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
  const std::string extension = extension_of(path);
  const std::string kind = sniff(bytes);
  const bool known = extension == "off" || extension == "obj" || extension == "ply" || extension == "stl";
  if (!kind.empty()) {
    if (known && extension != (kind == "bstl" ? "stl" : kind))
      info.notes.push_back("The extension is ." + extension + ", but the file begins like " +
                           (kind == "bstl" ? std::string("binary STL") : kind) + " and was read as such.");
    return kind;
  }
  if (extension == "obj") return std::string("obj");
  if (extension == "off") return malformed(name, "the file does not begin with OFF");
  if (extension == "ply") return malformed(name, "the file does not begin with ply");
  if (extension != "stl")
    return malformed(name, "this is not a surface format that Overtet reads (OBJ, OFF, PLY, STL)");
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
  std::string& bytes = file.value();
  const auto slash = path.rfind('/');
  const std::string name = slash == std::string::npos ? path : path.substr(slash + 1);
  if (bytes.empty()) return malformed(name, "the file is empty");

  SurfaceReadInfo local;
  SurfaceReadInfo& info = info_out ? *info_out : local;
  info = {};
  const Result<std::string> format = format_of(path, name, bytes, info);
  if (!format) return format.error();
  const std::string& kind = format.value();
  if (kind != "bstl" && (kind != "ply" || is_text_ply(bytes))) tidy_text(bytes);
  Result<Polygons> parsed = kind == "off"    ? parse_off(name, bytes, info)
                            : kind == "ply"  ? parse_ply(name, bytes, info)
                            : kind == "stl"  ? parse_ascii_stl(name, bytes, info)
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
  if (info.polygons > 0)
    info.notes.push_back(std::to_string(info.polygons) +
                         " faces with more than three corners were cut into triangles.");
  if (info.merged_vertices > 0)
    info.notes.push_back(std::to_string(info.merged_vertices) +
                         " equal corners of the STL file were merged into shared vertices.");
  return surface;
}

}  // namespace overtet
