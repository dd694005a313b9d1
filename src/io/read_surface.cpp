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
  if (t.size() >= 3 && t.size() <= 8 && t.substr(t.size() - 3) == "OFF") return "off";
  if (t == "solid") return "stl";
  return "";
}

}  // namespace

Result<Surface> read_surface(const std::string& path, SurfaceReadInfo* info_out, const RunContext& context) {
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  Result<std::string> file = read_file(path);
  if (!file) return file.error();
  const std::string_view bytes = file.value();
  const auto slash = path.rfind('/');
  const std::string name = slash == std::string::npos ? path : path.substr(slash + 1);
  if (bytes.empty()) return malformed(name, "the file is empty");

  SurfaceReadInfo local;
  SurfaceReadInfo& info = info_out ? *info_out : local;
  info = {};
  const std::string extension = extension_of(path);
  std::string kind = sniff(bytes);
  const bool known = extension == "off" || extension == "obj" || extension == "ply" || extension == "stl";
  if (kind.empty()) {
    if (extension == "off") return malformed(name, "the file does not begin with OFF");
    if (extension == "ply") return malformed(name, "the file does not begin with ply");
    if (extension == "stl")
      return malformed(name,
                       "the file is neither ASCII STL (it does not begin with solid) nor binary STL "
                       "(its length does not fit its number of triangles)");
    if (extension != "obj")
      return malformed(name, "this is not a surface format that Overtet reads (OBJ, OFF, PLY, STL)");
    kind = "obj";
  } else if (known && extension != (kind == "bstl" ? "stl" : kind)) {
    info.notes.push_back("The extension is ." + extension + ", but the file begins like " +
                         (kind == "bstl" ? std::string("binary STL") : kind) + " and was read as such.");
  }

  Result<Polygons> parsed = kind == "off"    ? parse_off(name, bytes, info)
                            : kind == "ply"  ? parse_ply(name, bytes, info)
                            : kind == "stl"  ? parse_ascii_stl(name, bytes, info)
                            : kind == "bstl" ? parse_binary_stl(name, bytes, info)
                                             : parse_obj(name, bytes, info);
  if (!parsed) return parsed.error();
  const Polygons& polygons = parsed.value();
  if (polygons.xyz.empty()) return malformed(name, "the file has no vertices");
  if (polygons.sizes.empty()) return malformed(name, "the file has no faces");
  if (static_cast<std::int64_t>(polygons.corners.size() - 2 * polygons.sizes.size()) > kMaxCount)
    return malformed(name,
                     "the surface has more than 2147483647 triangles, the most that Overtet can number");
  Surface surface = triangulate(polygons, info.polygons);
  if (info.polygons > 0)
    info.notes.push_back(std::to_string(info.polygons) +
                         " faces with more than three corners were cut into triangles.");
  if (info.merged_vertices > 0)
    info.notes.push_back(std::to_string(info.merged_vertices) +
                         " equal corners of the STL file were merged into shared vertices.");
  return surface;
}

}  // namespace overtet
