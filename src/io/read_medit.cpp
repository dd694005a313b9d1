#include <algorithm>
#include <utility>

#include "src/io/mesh_parts.h"
#include "src/io/tokens.h"

namespace overtet::io_detail {

namespace {

// What one keyword begins.
class MeditReader {
 public:
  MeditReader(std::string_view name, std::string_view bytes) : in_(name, bytes) {}

  Result<MeshParts> read() {
    parts_.format = "MEDIT";
    std::string_view key;
    while (in_.word(key) && key != "End")
      if (!section(key)) return in_.error();
    if (!have_vertices_) return malformed(in_.name(), "the file has no vertices");
    return std::move(parts_);
  }

 private:
  bool section(std::string_view key) {
    std::int64_t n = 0;
    if (key == "MeshVersionFormatted") return in_.integer(n, "the version");
    if (key == "Dimension")
      return in_.integer(n, "the dimension") && (n == 3 || in_.fail("the dimension is not 3"));
    if (key == "Vertices") return vertices();
    const bool tets = key.starts_with("Tetrahedra"), triangles = key.starts_with("Triangles"),
               squares = key == "Quadrilaterals", second = key.ends_with("P2");
    if ((tets || triangles || squares) && key != "RequiredTriangles")
      return elements(tets ? 4 : squares ? 4 : 3, second ? (tets ? 6 : 3) : 0, tets);
    // Sections that are left out: so many numbers an item.
    static constexpr std::pair<std::string_view, int> others[] = {{"Edges", 3},
                                                                  {"EdgesP2", 4},
                                                                  {"Corners", 1},
                                                                  {"Ridges", 1},
                                                                  {"RequiredEdges", 1},
                                                                  {"RequiredVertices", 1},
                                                                  {"Hexahedra", 9},
                                                                  {"Prisms", 7},
                                                                  {"Pyramids", 6},
                                                                  {"RequiredTriangles", 1},
                                                                  {"Normals", 3},
                                                                  {"Tangents", 3},
                                                                  {"NormalAtVertices", 2},
                                                                  {"TangentAtVertices", 2},
                                                                  {"NormalAtTriangleVertices", 3}};
    const auto* it =
        std::find_if(std::begin(others), std::end(others), [&](const auto& w) { return w.first == key; });
    if (it == std::end(others)) return in_.fail(quoted(key) + " is not a MEDIT section that Overtet knows");
    return in_.count(n, 2 * it->second, "the length of a section") && in_.skip(n * it->second);
  }

  bool vertices() {
    std::int64_t n = 0, reference = 0;
    if (have_vertices_) return in_.fail("the vertices are listed twice");
    if (!in_.count(n, 8, "the number of vertices")) return false;
    parts_.xyz.resize(static_cast<std::size_t>(3 * n));
    for (std::int64_t v = 0; v < n; ++v) {
      for (int k = 0; k < 3; ++k)
        if (!in_.real(parts_.xyz[static_cast<std::size_t>(3 * v + k)], "a vertex")) return false;
      if (!in_.integer(reference, "a vertex reference")) return false;
    }
    return have_vertices_ = true;
  }

  // Corners, so many vertices in the middle of edges, and a reference.
  bool elements(int corners, int middles, bool tets) {
    std::int64_t n = 0;
    const char* what = tets ? "the number of tets" : "the number of faces";
    if (!have_vertices_)
      return in_.fail(std::string(tets ? "the tets" : "the faces") + " come before the vertices");
    if (!in_.count(n, 2 * (corners + middles + 1), what)) return false;
    const auto vertices = static_cast<std::int64_t>(parts_.xyz.size() / 3);
    std::vector<Index>& out = tets ? parts_.tets : parts_.corners;
    Labels& labels = tets ? parts_.regions : parts_.labels;
    parts_.second_order |= middles > 0;
    for (std::int64_t e = 0; e < n; ++e) {
      Index v = 0, reference = 0;
      for (int k = 0; k < corners + middles; ++k) {
        if (!in_.vertex(v, vertices, 1, tets ? "a corner of a tet" : "a corner of a face")) return false;
        if (k < corners) out.push_back(v);
      }
      if (!in_.label(reference, "a reference")) return false;
      labels.of.push_back(reference);
      if (!tets) parts_.sizes.push_back(corners);
    }
    return true;
  }

  Tokens in_;
  MeshParts parts_;
  bool have_vertices_ = false;
};

}  // namespace

Result<MeshParts> parse_medit(std::string_view name, std::string_view bytes) {
  return MeditReader(name, bytes).read();
}

}  // namespace overtet::io_detail
