#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>

#include "kernels/core/point_table.h"
#include "src/io/face_groups.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

constexpr std::size_t kHeader = 84, kTriangle = 50;

std::uint32_t little_u32(const char* p) {
  std::uint32_t x = 0;
  for (int k = 3; k >= 0; --k) x = x << 8 | static_cast<unsigned char>(p[k]);
  return x;
}

enum class Keyword { vertex, facet, endfacet, outer, endloop, solid, endsolid, end, other };

// Of the next word, in letters of any size.
Keyword keyword(std::string_view word) {
  constexpr std::pair<std::string_view, Keyword> names[] = {
      {"vertex", Keyword::vertex},     {"facet", Keyword::facet},
      {"outer", Keyword::outer},       {"endloop", Keyword::endloop},
      {"endfacet", Keyword::endfacet}, {"solid", Keyword::solid},
      {"endsolid", Keyword::endsolid}, {"end", Keyword::end}};
  for (const auto& [name, key] : names)
    if (name.size() == word.size() &&
        std::equal(name.begin(), name.end(), word.begin(), [](char a, char b) { return a == (b | 0x20); }))
      return key;
  return Keyword::other;
}

// "end" is followed by what ends: "end solid" is "endsolid" to some.
Keyword end_of(Keyword what) {
  return what == Keyword::facet   ? Keyword::endfacet
         : what == Keyword::solid ? Keyword::endsolid
                                  : Keyword::endloop;
}

}  // namespace

bool is_binary_stl(std::string_view bytes, bool longer) {
  if (bytes.size() < kHeader) return false;
  const std::uint64_t count = little_u32(bytes.data() + 80), size = kHeader + kTriangle * count;
  return bytes.size() == size || (longer && count > 0 && bytes.size() > size);
}

Result<Polygons> parse_binary_stl(std::string_view name, std::string_view bytes, SurfaceReadInfo& info) {
  info.format = "STL, binary";
  info.has_vertex_order = false;
  const std::size_t triangles = little_u32(bytes.data() + 80);
  info.source.face_word = "triangle";
  if (triangles > static_cast<std::size_t>(kMaxCount) / 3)
    return malformed(name, "there are too many triangles (at most 715827882)");
  Polygons out;
  out.corners.reserve(3 * triangles);
  out.sizes.assign(triangles, 3);
  PointTable table(triangles / 2);
  for (std::size_t t = 0; t < triangles; ++t) {
    const char* p = bytes.data() + kHeader + kTriangle * t + 12;
    for (int k = 0; k < 3; ++k) {
      std::array<double, 3> x;
      for (double& c : x) {
        c = std::bit_cast<float>(little_u32(p));
        p += 4;
        if (!std::isfinite(c))
          return malformed(name, "a coordinate of triangle " + std::to_string(t) + " is not a finite number");
      }
      out.corners.push_back(table.number_of(x.data()));
    }
  }
  out.xyz = table.take_xyz();
  info.merged_vertices = static_cast<std::int64_t>(out.corners.size() - out.xyz.size() / 3);
  return out;
}

Result<Polygons> parse_ascii_stl(std::string_view name, std::string_view bytes, SurfaceReadInfo& info) {
  info.format = "STL, ASCII";
  info.source.face_word = "triangle";
  info.has_vertex_order = false;
  if (const std::int64_t line = line_of_nul(bytes))
    return malformed(name, "line " + std::to_string(line) + " contains a NUL byte, so it is not text");
  TextCursor in(name, bytes, false);
  Polygons out;
  PointTable table(bytes.size() / 512);
  FaceGroups solids;
  int corners = 0;
  bool inside = false;  // of a facet
  while (in.to_token()) {
    const std::string_view word = in.token();
    Keyword key = keyword(word);
    if (key == Keyword::end && !in.at_line_end()) key = end_of(keyword(in.token()));
    const auto bad = [&](const std::string& what) {
      in.fail(what + " (triangle " + std::to_string(out.sizes.size()) + ")");
      return in.error();
    };
    if (key == Keyword::vertex) {
      if (!inside || corners == 3)
        return bad(inside ? "a triangle must have three corners" : "a vertex stands outside a facet");
      std::array<double, 3> x;
      for (double& c : x)
        if (!in.real(c, [&] { return "triangle " + std::to_string(out.sizes.size()); })) return in.error();
      if (out.corners.size() >= static_cast<std::size_t>(kMaxCount) - 3)
        return malformed(name, "there are too many triangles (at most 715827882)");
      out.corners.push_back(table.number_of(x.data()));
      if (static_cast<std::size_t>(table.size()) > out.vertex_line.size())
        out.vertex_line.push_back(static_cast<std::uint32_t>(in.line()));
      ++corners;
    } else if (key == Keyword::facet) {
      if (inside) return bad("a facet begins before the previous one has ended");
      inside = true;
      corners = 0;
      out.face_line.push_back(static_cast<std::uint32_t>(in.line()));
    } else if (key == Keyword::endfacet) {
      if (!inside || corners != 3) return bad("a triangle must have three corners");
      out.sizes.push_back(3);
      inside = false;
    } else if (key == Keyword::solid) {
      solids.begin(FaceGroups::solid, in, out.sizes.size());
    } else if (key == Keyword::other || key == Keyword::end) {
      return bad(quoted(word) + " is not an STL keyword");
    }
    in.next_line();
  }
  if (inside) return malformed(name, "the file ends inside triangle " + std::to_string(out.sizes.size()));
  out.xyz = table.take_xyz();
  info.merged_vertices = static_cast<std::int64_t>(out.corners.size() - out.xyz.size() / 3);
  solids.finish(out.sizes.size(), out.attributes);
  return out;
}

}  // namespace overtet::io_detail
