#include "overtet/io.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <vector>

#include "src/io/filled_file.h"

namespace overtet {

namespace {

static_assert(std::endian::native == std::endian::little,
              "the VTU writer stores native bytes as little endian");

TextBuffer& coordinates(TextBuffer& out, const TetMesh& m, Eigen::Index v) {
  return out.number(m.V(v, 0)).character(' ').number(m.V(v, 1)).character(' ').number(m.V(v, 2));
}

TextBuffer& corners(TextBuffer& out, const TetMesh& m, Eigen::Index t, Index first) {
  out.number(m.T(t, 0) + first).character(' ').number(m.T(t, 1) + first).character(' ');
  return out.number(m.T(t, 2) + first).character(' ').number(m.T(t, 3) + first);
}

void write_medit(TextWriter& out, const TetMesh& m) {
  out.text("MeshVersionFormatted 2\nDimension 3\nVertices\n").number(std::int64_t{m.V.rows()}).end_line();
  out.lines(m.V.rows(), [&](TextBuffer& line, std::int64_t v) { coordinates(line, m, v).text(" 0\n"); });
  out.text("Tetrahedra\n").number(std::int64_t{m.T.rows()}).end_line();
  out.lines(m.T.rows(), [&](TextBuffer& line, std::int64_t t) { corners(line, m, t, 1).text(" 1\n"); });
  out.text("End\n");
}

void write_gmsh22(TextWriter& out, const TetMesh& m) {
  out.text("$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n").number(std::int64_t{m.V.rows()}).end_line();
  out.lines(m.V.rows(), [&](TextBuffer& line, std::int64_t v) {
    coordinates(line.number(v + 1).character(' '), m, v).end_line();
  });
  out.text("$EndNodes\n$Elements\n").number(std::int64_t{m.T.rows()}).end_line();
  out.lines(m.T.rows(), [&](TextBuffer& line, std::int64_t t) {
    corners(line.number(t + 1).text(" 4 2 1 1 "), m, t, 1).end_line();
  });
  out.text("$EndElements\n");
}

// "1 count 1 count": one block of elements, numbered from 1.
void one_block(TextWriter& out, std::int64_t count) {
  out.text("1 ").number(count).text(" 1 ").number(count).end_line();
}

void write_gmsh41(TextWriter& out, const TetMesh& m) {
  const std::int64_t vertices = m.V.rows(), tets = m.T.rows();
  out.text("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Entities\n0 0 0 1\n1");
  for (const bool high : {false, true})
    for (int k = 0; k < 3; ++k)
      out.character(' ').number(vertices == 0 ? 0.0 : high ? m.V.col(k).maxCoeff() : m.V.col(k).minCoeff());
  out.text(" 0 0\n$EndEntities\n$Nodes\n");
  one_block(out, vertices);
  out.text("3 1 0 ").number(vertices).end_line();
  out.lines(vertices, [&](TextBuffer& line, std::int64_t v) { line.number(v + 1).end_line(); });
  out.lines(vertices, [&](TextBuffer& line, std::int64_t v) { coordinates(line, m, v).end_line(); });
  out.text("$EndNodes\n$Elements\n");
  one_block(out, tets);
  out.text("3 1 4 ").number(tets).end_line();
  out.lines(tets, [&](TextBuffer& line, std::int64_t t) {
    corners(line.number(t + 1).character(' '), m, t, 1).end_line();
  });
  out.text("$EndElements\n");
}

// Base64 of a byte count (64 bit) and the bytes: VTK's "binary" data array.
void base64(TextWriter& out, const void* data, std::size_t size) {
  static constexpr char kDigits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  const std::uint64_t count = size;
  const auto* head = reinterpret_cast<const unsigned char*>(&count);
  const auto* body = static_cast<const unsigned char*>(data);
  const std::size_t total = sizeof count + size;
  const auto byte = [&](std::size_t i) -> std::uint32_t {
    return i < sizeof count ? head[i] : body[i - sizeof count];
  };
  std::string block;
  for (std::size_t i = 0; i < total; i += 3) {
    const std::size_t have = std::min<std::size_t>(3, total - i);
    const std::uint32_t bits =
        byte(i) << 16 | (have > 1 ? byte(i + 1) << 8 : 0) | (have > 2 ? byte(i + 2) : 0);
    for (std::size_t k = 0; k < 4; ++k) block += k <= have ? kDigits[bits >> (18 - 6 * k) & 63] : '=';
    if (block.size() >= 3072) out.text(block), block.clear();
  }
  out.text(block).end_line();
}

void write_vtu(TextWriter& out, const TetMesh& m) {
  out.text(
      "<?xml version=\"1.0\"?>\n"
      "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\" "
      "header_type=\"UInt64\">\n"
      "<UnstructuredGrid>\n<Piece NumberOfPoints=\"");
  out.number(std::int64_t{m.V.rows()}).text("\" NumberOfCells=\"").number(std::int64_t{m.T.rows()});
  out.text("\">\n<Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"binary\">\n");
  base64(out, m.V.data(), sizeof(double) * static_cast<std::size_t>(m.V.size()));
  out.text(
      "</DataArray>\n</Points>\n<Cells>\n<DataArray type=\"Int32\" Name=\"connectivity\" "
      "format=\"binary\">\n");
  base64(out, m.T.data(), sizeof(Index) * static_cast<std::size_t>(m.T.size()));
  out.text("</DataArray>\n<DataArray type=\"Int64\" Name=\"offsets\" format=\"binary\">\n");
  std::vector<std::int64_t> offsets(static_cast<std::size_t>(m.T.rows()));
  for (std::size_t t = 0; t < offsets.size(); ++t) offsets[t] = 4 * static_cast<std::int64_t>(t + 1);
  base64(out, offsets.data(), sizeof(std::int64_t) * offsets.size());
  out.text("</DataArray>\n<DataArray type=\"UInt8\" Name=\"types\" format=\"binary\">\n");
  const std::vector<std::uint8_t> types(offsets.size(), 10);  // VTK_TETRA
  base64(out, types.data(), types.size());
  out.text("</DataArray>\n</Cells>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n");
}

void write_node(TextWriter& out, const TetMesh& m) {
  out.number(std::int64_t{m.V.rows()}).text(" 3 0 0\n");
  out.lines(m.V.rows(), [&](TextBuffer& line, std::int64_t v) {
    coordinates(line.number(v).character(' '), m, v).end_line();
  });
}

void write_ele(TextWriter& out, const TetMesh& m) {
  out.number(std::int64_t{m.T.rows()}).text(" 4 0\n");
  out.lines(m.T.rows(), [&](TextBuffer& line, std::int64_t t) {
    corners(line.number(t).character(' '), m, t, 0).end_line();
  });
}

std::string_view extension(std::string_view path) {
  const auto dot = path.rfind('.');
  const auto slash = path.rfind('/');
  if (dot == std::string_view::npos || (slash != std::string_view::npos && dot < slash)) return "";
  return path.substr(dot);
}

}  // namespace

Result<TetFormat> tet_format_named(std::string_view name) {
  if (name == "medit" || name == "mesh") return TetFormat::medit;
  if (name == "msh22") return TetFormat::gmsh22;
  if (name == "msh41" || name == "msh") return TetFormat::gmsh41;
  if (name == "vtu") return TetFormat::vtu;
  if (name == "tetgen") return TetFormat::tetgen;
  return Error{ErrorCode::usage,
               "There is no format named " + std::string(name) + "; use medit, msh22, msh41, vtu or tetgen."};
}

Result<TetFormat> tet_format_of(const std::string& path) {
  const std::string_view e = extension(path);
  if (e == ".mesh") return TetFormat::medit;
  if (e == ".msh") return TetFormat::gmsh41;
  if (e == ".vtu") return TetFormat::vtu;
  if (e == ".node" || e == ".ele") return TetFormat::tetgen;
  return Error{ErrorCode::usage,
               "The name " + path +
                   " does not tell the format: use .mesh, .msh, .vtu, .node or .ele, or name the format."};
}

Status write_tets(const std::string& path, const TetMesh& mesh, TetFormat format, const RunContext& context) {
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  switch (format) {
    case TetFormat::medit:
      return io_detail::write_file(path, [&](TextWriter& w) { write_medit(w, mesh); });
    case TetFormat::gmsh22:
      return io_detail::write_file(path, [&](TextWriter& w) { write_gmsh22(w, mesh); });
    case TetFormat::gmsh41:
      return io_detail::write_file(path, [&](TextWriter& w) { write_gmsh41(w, mesh); });
    case TetFormat::vtu:
      return io_detail::write_file(path, [&](TextWriter& w) { write_vtu(w, mesh); });
    case TetFormat::tetgen: {
      const std::string_view e = extension(path);
      const std::string base = e == ".node" || e == ".ele" ? path.substr(0, path.size() - e.size()) : path;
      AtomicFile file, second;
      const auto nodes = [&](TextWriter& w) { write_node(w, mesh); };
      const auto elements = [&](TextWriter& w) { write_ele(w, mesh); };
      if (Status s = io_detail::fill(file, base + ".node", nodes); !s) return s;
      if (Status s = io_detail::fill(second, base + ".ele", elements); !s) return s;
      if (Status s = file.sync(); !s) return s;
      if (Status s = second.sync(); !s) return s;
      if (Status s = file.commit(); !s) return s;
      return second.commit();
    }
  }
  return Error{ErrorCode::internal, "There is no such format."};
}

}  // namespace overtet
