#include <utility>

#include "src/io/file.h"
#include "src/io/mesh_parts.h"
#include "src/io/names.h"
#include "src/io/tokens.h"

namespace overtet::io_detail {

namespace {

// The numbers of a line up to its end. What is no number ends them.
bool rest(Tokens& in, std::vector<double>& out) {
  out.clear();
  double x = 0;
  while (!in.at_line_end()) {
    if (!in.real(x, "a number")) return false;
    out.push_back(x);
  }
  in.next_line();
  return true;
}

}  // namespace

Status parse_tetgen_nodes(std::string_view name, std::string_view bytes, MeshParts& out,
                          std::int64_t& first) {
  Tokens in(name, bytes);
  std::int64_t n = 0, dimension = 0, number = 0;
  if (!in.count(n, 8, "the number of nodes") || !in.integer(dimension, "the dimension")) return in.error();
  if (dimension != 3) return malformed(name, "the dimension is not 3");
  in.next_line();
  out.xyz.resize(static_cast<std::size_t>(3 * n));
  for (std::int64_t v = 0; v < n; ++v) {
    if (!in.integer(number, "a node number")) return in.error();
    if (v == 0) first = number;
    if (first < -kMaxCount || first > kMaxCount || number != first + v)
      return malformed(name, "the nodes are not numbered consecutively");
    for (int k = 0; k < 3; ++k)
      if (!in.real(out.xyz[static_cast<std::size_t>(3 * v + k)], "a node")) return in.error();
    in.next_line();
  }
  return success();
}

Status parse_tetgen_tets(std::string_view name, std::string_view bytes, MeshParts& out, std::int64_t& first) {
  Tokens in(name, bytes);
  std::int64_t n = 0, nodes_each = 0, number = 0;
  if (!in.count(n, 10, "the number of tets") || !in.integer(nodes_each, "the number of corners"))
    return in.error();
  if (nodes_each != 4 && nodes_each != 10)
    return malformed(name, "the tets have " + std::to_string(nodes_each) +
                               " corners; Overtet reads tets with four or ten");
  in.next_line();
  out.second_order = nodes_each == 10;
  const auto vertices = static_cast<std::int64_t>(out.xyz.size() / 3);
  std::vector<double> more;
  for (std::int64_t t = 0; t < n; ++t) {
    if (!in.integer(number, "a tet number")) return in.error();
    Index v = 0;
    for (std::int64_t k = 0; k < nodes_each; ++k) {
      if (!in.vertex(v, vertices, first, "a corner of a tet")) return in.error();
      if (k < 4) out.tets.push_back(v);
    }
    if (!rest(in, more)) return in.error();
    if (!more.empty()) out.regions.of.push_back(as_index(more[0]));
  }
  if (out.regions.of.size() != static_cast<std::size_t>(n)) out.regions.of.clear();
  return success();
}

Status parse_tetgen_faces(std::string_view name, std::string_view bytes, MeshParts& out,
                          std::int64_t& first) {
  Tokens in(name, bytes);
  std::int64_t n = 0, number = 0;
  if (!in.count(n, 8, "the number of faces")) return in.error();
  in.next_line();
  std::vector<double> more;
  for (std::int64_t f = 0; f < n; ++f) {
    if (!in.integer(number, "a face number")) return in.error();
    Index v = 0;
    for (int k = 0; k < 3; ++k) {
      if (!in.vertex(v, static_cast<std::int64_t>(out.xyz.size() / 3), first, "a corner of a face"))
        return in.error();
      out.corners.push_back(v);
    }
    out.sizes.push_back(3);
    if (!rest(in, more)) return in.error();
    if (!more.empty()) out.labels.of.push_back(as_index(more.back()));
  }
  if (out.labels.of.size() != out.sizes.size()) out.labels.of.clear();
  return success();
}

Result<MeshParts> read_tetgen(const std::string& base, const std::string& gz) {
  MeshParts out;
  out.format = "TetGen";
  std::int64_t first = 0;
  const auto with = [&](const char* extension, auto&& read) -> Status {
    const std::string path = base + extension + gz;
    const Result<std::string> bytes = read_file(path);
    if (!bytes) return bytes.error();
    return read(file_name(path), bytes.value(), out, first);
  };
  if (Status s = with(".node", parse_tetgen_nodes); !s) return s.error();
  if (Status s = with(".ele", parse_tetgen_tets); !s) return s.error();
  if (file_exists(base + ".face" + gz))
    if (Status s = with(".face", parse_tetgen_faces); !s) return s.error();
  return out;
}

}  // namespace overtet::io_detail
