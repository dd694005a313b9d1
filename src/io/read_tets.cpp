#include "overtet/io.h"

#include <algorithm>
#include <array>
#include <limits>
#include <unordered_map>
#include <vector>

#include "src/io/file.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"
#include "src/io/vtu.h"

namespace overtet {

namespace {

using io_detail::kMaxCount, io_detail::malformed;

// A TextCursor that reads over line ends, as these formats allow, and counts that the file can hold.
class Tokens {
 public:
  Tokens(std::string_view name, std::string_view text) : name_(name), in_(name, text, true) {}

  bool word(std::string_view& w) {
    if (!in_.to_token()) return false;
    w = in_.token();
    return true;
  }
  bool real(double& x, const char* what) {
    return in_.to_token() ? in_.real(x, [&] { return what; })
                          : in_.fail("the file ends where a number should be");
  }
  bool integer(std::int64_t& x, const char* what) {
    return in_.to_token() ? in_.integer(x, [&] { return what; })
                          : in_.fail("the file ends where a number should be");
  }
  // A number of items that take at least `bytes_each` each.
  bool count(std::int64_t& n, std::int64_t bytes_each, const char* what) {
    if (!integer(n, what)) return false;
    if (n < 0 || n > kMaxCount || n > static_cast<std::int64_t>(in_.bytes_left() + 1) / bytes_each)
      return fail("the file is too short for " + std::to_string(n) + " (" + what + ")");
    return true;
  }
  bool skip(std::int64_t numbers) {
    std::string_view w;
    for (; numbers > 0; --numbers)
      if (!word(w)) return fail("the file ends too early");
    return true;
  }
  void next_line() { in_.next_line(); }
  bool at_line_end() { return in_.at_line_end(); }
  bool fail(const std::string& what) { return in_.fail(what); }
  const Error& error() const { return in_.error(); }

 private:
  std::string_view name_;
  TextCursor in_;
};

bool corner(Tokens& in, std::int64_t vertices, std::int64_t first, Index& out) {
  std::int64_t v = 0;
  if (!in.integer(v, "a corner of a tet")) return false;
  if (v < first || v - first >= vertices) return in.fail("there is no vertex " + std::to_string(v));
  out = static_cast<Index>(v - first);
  return true;
}

Result<TetMesh> read_medit(Tokens& in, std::string_view name) {
  TetMesh m;
  bool have_vertices = false, have_tets = false;
  std::string_view key;
  while (in.word(key)) {
    std::int64_t n = 0;
    if (key == "End") break;
    if (key == "MeshVersionFormatted") {
      if (!in.integer(n, "the version")) return in.error();
    } else if (key == "Dimension") {
      if (!in.integer(n, "the dimension")) return in.error();
      if (n != 3) return malformed(name, "the dimension is not 3");
    } else if (key == "Vertices") {
      if (!in.count(n, 8, "the number of vertices")) return in.error();
      m.V.resize(n, 3);
      std::int64_t reference = 0;
      for (std::int64_t v = 0; v < n; ++v) {
        for (int k = 0; k < 3; ++k)
          if (!in.real(m.V(v, k), "a vertex")) return in.error();
        if (!in.integer(reference, "a vertex reference")) return in.error();
      }
      have_vertices = true;
    } else if (key == "Tetrahedra") {
      if (!have_vertices) return malformed(name, "the tets come before the vertices");
      if (!in.count(n, 10, "the number of tets")) return in.error();
      m.T.resize(n, 4);
      std::int64_t reference = 0;
      for (std::int64_t t = 0; t < n; ++t) {
        for (int k = 0; k < 4; ++k)
          if (!corner(in, m.V.rows(), 1, m.T(t, k))) return in.error();
        if (!in.integer(reference, "a tet reference")) return in.error();
      }
      have_tets = true;
    } else {
      // Other sections: a count and then a fixed number of numbers each, up to the next keyword.
      static constexpr std::pair<std::string_view, int> widths[] = {
          {"Triangles", 4},         {"Edges", 3},
          {"Corners", 1},           {"Ridges", 1},
          {"RequiredEdges", 1},     {"RequiredVertices", 1},
          {"RequiredTriangles", 1}, {"Quadrilaterals", 5}};
      const auto* it =
          std::find_if(std::begin(widths), std::end(widths), [&](const auto& w) { return w.first == key; });
      if (it == std::end(widths)) {
        in.fail(quoted(key) + " is not a MEDIT section that Overtet knows");
        return in.error();
      }
      if (!in.count(n, 2 * it->second, "the length of a section")) return in.error();
      if (!in.skip(n * it->second)) return in.error();
    }
  }
  if (!have_vertices || !have_tets) return malformed(name, "the file has no vertices or no tets");
  return m;
}

// Gmsh numbers nodes as it likes; file order becomes our order.
struct NodeNumbers {
  std::unordered_map<std::int64_t, Index> of;
  bool consecutive = true;  // node k is number k + 1: no table needed
  Index count = 0;
  void add(std::int64_t tag) {
    if (consecutive && tag != count + 1) {
      for (Index k = 0; k < count; ++k) of[k + 1] = k;
      consecutive = false;
    }
    if (!consecutive) of[tag] = count;
    ++count;
  }
  Index find(std::int64_t tag) const {
    if (consecutive) return tag >= 1 && tag <= count ? static_cast<Index>(tag - 1) : -1;
    const auto it = of.find(tag);
    return it == of.end() ? -1 : it->second;
  }
};

// Corners of Gmsh's element types 1 .. 19, to skip what is not a tet.
constexpr std::array<int, 20> kGmshCorners = {0, 2,  3,  4,  4,  8, 6, 5,  3,  6,
                                              9, 10, 27, 18, 14, 1, 8, 20, 15, 13};

bool gmsh_tet(Tokens& in, const NodeNumbers& nodes, std::vector<Index>& corners) {
  for (int k = 0; k < 4; ++k) {
    std::int64_t tag = 0;
    if (!in.integer(tag, "a corner of a tet")) return false;
    const Index v = nodes.find(tag);
    if (v < 0) return in.fail("there is no node " + std::to_string(tag));
    corners.push_back(v);
  }
  return true;
}

bool gmsh_nodes(Tokens& in, bool v41, NodeNumbers& nodes, std::vector<double>& xyz) {
  std::int64_t n = 0, blocks = 1, x = 0;
  const auto point = [&] {
    double c = 0;
    for (int k = 0; k < 3; ++k) {
      if (!in.real(c, "a node")) return false;
      xyz.push_back(c);
    }
    return true;
  };
  if (!v41) {
    if (!in.count(n, 8, "the number of nodes")) return false;
    for (std::int64_t v = 0; v < n; ++v) {
      if (!in.integer(x, "a node number")) return false;
      nodes.add(x);
      if (!point()) return false;
    }
    return true;
  }
  if (!in.integer(blocks, "the number of blocks") || !in.count(n, 8, "the number of nodes") || !in.skip(2))
    return false;
  for (std::int64_t b = 0; b < blocks; ++b) {
    std::int64_t dimension = 0, parametric = 0, in_block = 0;
    if (!in.integer(dimension, "a dimension") || !in.skip(1) || !in.integer(parametric, "a flag") ||
        !in.count(in_block, 8, "the number of nodes of a block"))
      return false;
    for (std::int64_t v = 0; v < in_block; ++v) {
      if (!in.integer(x, "a node number")) return false;
      nodes.add(x);
    }
    for (std::int64_t v = 0; v < in_block; ++v)
      if (!point() || !in.skip(parametric ? dimension : 0)) return false;
  }
  return true;
}

bool gmsh_elements(Tokens& in, bool v41, const NodeNumbers& nodes, std::vector<Index>& corners) {
  std::int64_t n = 0, blocks = 1, type = 0, tags = 0;
  const auto known = [&] {
    return (type > 0 && type < static_cast<std::int64_t>(kGmshCorners.size())) ||
           in.fail("element type " + std::to_string(type) + " is not one that Overtet knows");
  };
  if (!v41) {
    if (!in.count(n, 8, "the number of elements")) return false;
    for (std::int64_t t = 0; t < n; ++t) {
      if (!in.skip(1) || !in.integer(type, "an element type") || !known() ||
          !in.integer(tags, "a number of tags") || !in.skip(tags))
        return false;
      if (type == 4 ? !gmsh_tet(in, nodes, corners) : !in.skip(kGmshCorners[static_cast<std::size_t>(type)]))
        return false;
    }
    return true;
  }
  if (!in.integer(blocks, "the number of blocks") || !in.count(n, 4, "the number of elements") || !in.skip(2))
    return false;
  for (std::int64_t b = 0; b < blocks; ++b) {
    std::int64_t in_block = 0;
    if (!in.skip(2) || !in.integer(type, "an element type") || !known() ||
        !in.count(in_block, 4, "the number of elements of a block"))
      return false;
    for (std::int64_t t = 0; t < in_block; ++t) {
      if (!in.skip(1)) return false;
      if (type == 4 ? !gmsh_tet(in, nodes, corners) : !in.skip(kGmshCorners[static_cast<std::size_t>(type)]))
        return false;
    }
  }
  return true;
}

Result<TetMesh> read_gmsh(Tokens& in, std::string_view name) {
  bool v41 = false;
  NodeNumbers nodes;
  std::vector<double> xyz;
  std::vector<Index> corners;
  std::string_view key;
  while (in.word(key)) {
    if (key == "$MeshFormat") {
      std::string_view version;
      std::int64_t binary = 0;
      if (!in.word(version) || !in.integer(binary, "the file type")) return in.error();
      if (version != "4.1" && version != "2.2")
        return malformed(name, "Gmsh version " + quoted(version) + " is not 2.2 or 4.1");
      if (binary != 0) return malformed(name, "this is a binary Gmsh file; save it as ASCII");
      v41 = version == "4.1";
    } else if (key == "$Nodes") {
      if (!gmsh_nodes(in, v41, nodes, xyz)) return in.error();
    } else if (key == "$Elements") {
      if (!gmsh_elements(in, v41, nodes, corners)) return in.error();
    } else if (key[0] == '$' && key.substr(0, 4) != "$End") {
      const std::string end = "$End" + std::string(key.substr(1));
      while (in.word(key) && key != end) {
      }
    }
  }
  if (nodes.count == 0 || corners.empty()) return malformed(name, "the file has no nodes or no tets");
  TetMesh m;
  m.V = Eigen::Map<const VertexMatrix>(xyz.data(), static_cast<Eigen::Index>(xyz.size() / 3), 3);
  m.T = Eigen::Map<const TetMatrix>(corners.data(), static_cast<Eigen::Index>(corners.size() / 4), 4);
  return m;
}

Result<TetMesh> read_tetgen(const std::string& base) {
  TetMesh m;
  std::int64_t first = 0;
  {
    const Result<std::string> bytes = read_file(base + ".node");
    if (!bytes) return bytes.error();
    const std::string name = base.substr(base.rfind('/') + 1) + ".node";
    Tokens in(name, bytes.value());
    std::int64_t n = 0, dimension = 0, number = 0;
    if (!in.count(n, 8, "the number of nodes") || !in.integer(dimension, "the dimension")) return in.error();
    if (dimension != 3) return malformed(name, "the dimension is not 3");
    in.next_line();
    m.V.resize(n, 3);
    for (std::int64_t v = 0; v < n; ++v) {
      if (!in.integer(number, "a node number")) return in.error();
      if (v == 0) first = number;
      if (number != first + v) return malformed(name, "the nodes are not numbered consecutively");
      for (int k = 0; k < 3; ++k)
        if (!in.real(m.V(v, k), "a node")) return in.error();
      in.next_line();
    }
  }
  const Result<std::string> bytes = read_file(base + ".ele");
  if (!bytes) return bytes.error();
  const std::string name = base.substr(base.rfind('/') + 1) + ".ele";
  Tokens in(name, bytes.value());
  std::int64_t n = 0, nodes_each = 0, number = 0;
  if (!in.count(n, 10, "the number of tets") || !in.integer(nodes_each, "the number of corners"))
    return in.error();
  if (nodes_each != 4)
    return malformed(
        name, "the tets have " + std::to_string(nodes_each) + " corners; Overtet reads tets with four");
  in.next_line();
  m.T.resize(n, 4);
  for (std::int64_t t = 0; t < n; ++t) {
    if (!in.integer(number, "a tet number")) return in.error();
    for (int k = 0; k < 4; ++k)
      if (!corner(in, m.V.rows(), first, m.T(t, k))) return in.error();
    in.next_line();
  }
  return m;
}

}  // namespace

Result<TetMesh> read_tets(const std::string& path, const RunContext& context) {
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  const Result<TetFormat> format = tet_format_of(path);
  if (!format)
    return Error{ErrorCode::usage,
                 "Tet meshes are read from .mesh, .msh, .vtu, .node and .ele files, not from " + path + "."};
  if (format.value() == TetFormat::tetgen) return read_tetgen(path.substr(0, path.rfind('.')));
  const Result<std::string> bytes = read_file(path);
  if (!bytes) return bytes.error();
  const std::string name = path.substr(path.rfind('/') + 1);
  if (bytes.value().empty()) return malformed(name, "the file is empty");
  if (format.value() == TetFormat::vtu) return read_vtu(name, bytes.value());
  if (const std::int64_t line = line_of_nul(bytes.value()))
    return malformed(name, "line " + std::to_string(line) + " contains a NUL byte, so it is not text");
  Tokens in(name, bytes.value());
  return format.value() == TetFormat::medit ? read_medit(in, name) : read_gmsh(in, name);
}

}  // namespace overtet
