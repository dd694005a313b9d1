#include <cctype>

#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet::io_detail {

// Reads v and f lines; everything else that looks like an OBJ keyword is ignored.
Result<Polygons> parse_obj(std::string_view name, std::string_view bytes, SurfaceReadInfo& info) {
  info.format = "OBJ";
  info.source.first = 1;
  if (const std::int64_t line = line_of_nul(bytes))
    return malformed(name, "line " + std::to_string(line) + " contains a NUL byte, so it is not text");
  TextCursor in(name, bytes, true);
  Polygons out;
  // A face may name a vertex that comes later in the file: the largest such name, checked at the end.
  std::int64_t ahead = 0, ahead_line = 0, ahead_face = 0;
  std::int64_t vertices = 0;
  while (in.to_token()) {
    const std::string_view key = in.token();
    if (key == "v") {
      const auto which = [&] { return "vertex " + std::to_string(vertices + 1); };
      double p[3];
      for (double& x : p)
        if (!in.real(x, which)) return in.error();
      out.xyz.insert(out.xyz.end(), p, p + 3);
      out.vertex_line.push_back(static_cast<std::uint32_t>(in.line()));
      if (++vertices > kMaxCount)
        return malformed(name,
                         "the file has more than 2147483647 vertices, the most that Overtet can number");
    } else if (key == "f") {
      const auto face = static_cast<std::int64_t>(out.sizes.size()) + 1;
      const auto which = [&] { return "face " + std::to_string(face); };
      Index size = 0;
      out.face_line.push_back(static_cast<std::uint32_t>(in.line()));
      while (!in.at_line_end()) {
        std::string_view corner = in.token();
        const std::string_view whole = corner;
        corner = corner.substr(0, corner.find('/'));
        std::int64_t v = 0;
        const auto [stop, code] = std::from_chars(corner.data(), corner.data() + corner.size(), v);
        if (code != std::errc() || stop != corner.data() + corner.size()) {
          in.fail(quoted(whole) + " does not name a vertex (" + which() + ")");
          return in.error();
        }
        const std::int64_t zero_based = v > 0 ? v - 1 : vertices + v;
        if (v == 0 || zero_based < 0) {
          in.fail(v == 0 ? "there is no vertex 0; OBJ numbers vertices from 1 (" + which() + ")"
                         : "there are fewer than " + std::to_string(-v) + " vertices before this line (" +
                               which() + ")");
          return in.error();
        }
        if (v > vertices && v > ahead) ahead = v, ahead_line = in.line(), ahead_face = face;
        if (zero_based > kMaxCount) break;
        out.corners.push_back(static_cast<Index>(zero_based));
        ++size;
      }
      if (ahead > kMaxCount) break;
      if (size < 3) {
        in.fail("a face needs at least three corners (" + which() + ")");
        return in.error();
      }
      out.sizes.push_back(size);
    } else {
      for (const char c : key) {
        if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') continue;
        in.fail(quoted(key) + " is not an OBJ keyword");
        return in.error();
      }
      if (!std::isalpha(static_cast<unsigned char>(key[0]))) {
        in.fail(quoted(key) + " is not an OBJ keyword");
        return in.error();
      }
    }
    in.next_line();
  }
  if (ahead > vertices) {
    in.fail_at(ahead_line, "there is no vertex " + std::to_string(ahead) + "; the file has " +
                               std::to_string(vertices) + " (face " + std::to_string(ahead_face) + ")");
    return in.error();
  }
  return out;
}

}  // namespace overtet::io_detail
