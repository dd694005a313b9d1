#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cstring>

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

// Gives equal points one number, in the order of their first appearance. Equal means equal as numbers:
// -0 is 0.
class PointTable {
 public:
  explicit PointTable(std::size_t corners) {
    std::size_t size = 64;
    while (size < corners) size *= 2;  // a closed surface has about a sixth as many points as corners
    slots_.assign(size, -1);
  }
  Index number_of(std::array<double, 3> p, std::vector<double>& xyz) {
    for (double& x : p) x += 0.0;  // -0 becomes 0
    std::uint64_t h = 0;
    for (const double x : p) {
      h ^= std::bit_cast<std::uint64_t>(x);
      h *= 0x9E3779B97F4A7C15ull;
      h ^= h >> 29;
    }
    if (2 * xyz.size() > 3 * slots_.size()) grow(xyz);
    for (std::size_t at = h & (slots_.size() - 1);; at = (at + 1) & (slots_.size() - 1)) {
      const Index v = slots_[at];
      if (v < 0) {
        slots_[at] = static_cast<Index>(xyz.size() / 3);
        xyz.insert(xyz.end(), p.begin(), p.end());
        hashes_.push_back(h);
        return slots_[at];
      }
      if (std::memcmp(&xyz[3 * static_cast<std::size_t>(v)], p.data(), sizeof p) == 0) return v;
    }
  }

 private:
  void grow(const std::vector<double>&) {
    slots_.assign(2 * slots_.size(), -1);
    for (std::size_t v = 0; v < hashes_.size(); ++v) {
      std::size_t at = hashes_[v] & (slots_.size() - 1);
      while (slots_[at] >= 0) at = (at + 1) & (slots_.size() - 1);
      slots_[at] = static_cast<Index>(v);
    }
  }
  std::vector<Index> slots_;
  std::vector<std::uint64_t> hashes_;
};

}  // namespace

bool is_binary_stl(std::string_view bytes) {
  return bytes.size() >= kHeader &&
         bytes.size() == kHeader + kTriangle * static_cast<std::uint64_t>(little_u32(bytes.data() + 80));
}

Result<Polygons> parse_binary_stl(std::string_view name, std::string_view bytes, SurfaceReadInfo& info) {
  info.format = "STL, binary";
  info.has_vertex_order = false;
  const std::size_t triangles = (bytes.size() - kHeader) / kTriangle;
  if (triangles > static_cast<std::size_t>(kMaxCount) / 3)
    return malformed(name, "there are too many triangles (at most 715827882)");
  Polygons out;
  out.corners.reserve(3 * triangles);
  out.sizes.assign(triangles, 3);
  PointTable table(triangles);
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
      out.corners.push_back(table.number_of(x, out.xyz));
    }
  }
  info.merged_vertices = static_cast<std::int64_t>(out.corners.size() - out.xyz.size() / 3);
  return out;
}

Result<Polygons> parse_ascii_stl(std::string_view name, std::string_view bytes, SurfaceReadInfo& info) {
  info.format = "STL, ASCII";
  info.has_vertex_order = false;
  if (const std::int64_t line = line_of_nul(bytes))
    return malformed(name, "line " + std::to_string(line) + " contains a NUL byte, so it is not text");
  TextCursor in(name, bytes, false);
  Polygons out;
  PointTable table(bytes.size() / 256);
  FaceGroups solids;
  int corners = 0;
  bool inside = false;  // of a facet
  while (in.to_token()) {
    std::string key(in.token().substr(0, 16));
    std::transform(key.begin(), key.end(), key.begin(), [](unsigned char c) { return std::tolower(c); });
    const auto bad = [&](const std::string& what) {
      in.fail(what + " (triangle " + std::to_string(out.sizes.size()) + ")");
      return in.error();
    };
    if (key == "vertex") {
      if (!inside || corners == 3)
        return bad(inside ? "a triangle must have three corners" : "a vertex stands outside a facet");
      std::array<double, 3> x;
      for (double& c : x)
        if (!in.real(c, [&] { return "triangle " + std::to_string(out.sizes.size()); })) return in.error();
      if (out.corners.size() >= static_cast<std::size_t>(kMaxCount) - 3)
        return malformed(name, "there are too many triangles (at most 715827882)");
      out.corners.push_back(table.number_of(x, out.xyz));
      ++corners;
    } else if (key == "facet") {
      if (inside) return bad("a facet begins before the previous one has ended");
      inside = true;
      corners = 0;
    } else if (key == "endfacet") {
      if (!inside || corners != 3) return bad("a triangle must have three corners");
      out.sizes.push_back(3);
      inside = false;
    } else if (key == "solid") {
      solids.begin(FaceGroups::solid, in, out.sizes.size());
    } else if (key != "outer" && key != "endloop" && key != "endsolid") {
      return bad(quoted(key) + " is not an STL keyword");
    }
    in.next_line();
  }
  if (inside) return malformed(name, "the file ends inside triangle " + std::to_string(out.sizes.size()));
  info.merged_vertices = static_cast<std::int64_t>(out.corners.size() - out.xyz.size() / 3);
  solids.finish(out.sizes.size(), out.attributes);
  return out;
}

}  // namespace overtet::io_detail
