#include <optional>
#include <utility>

#include "overtet/io.h"
#include "src/io/file.h"
#include "src/io/mesh_parts.h"
#include "src/io/names.h"
#include "src/io/text.h"

namespace overtet {

namespace {

using namespace io_detail;

Result<MeshParts> parse(std::string_view kind, std::string_view name, std::string_view bytes) {
  if (bytes.empty()) return malformed(name, "the file is empty");
  if (kind == "vtk_xml") return parse_vtk_xml(name, bytes);
  if (kind == "vtk") return parse_vtk(name, bytes);
  if (const std::int64_t line = line_of_nul(bytes))
    return malformed(name, "line " + std::to_string(line) + " contains a NUL byte, so it is not text");
  if (kind == "medit") return parse_medit(name, bytes);
  return kind == "gmsh" ? parse_gmsh(name, bytes) : parse_abaqus(name, bytes);
}

std::string_view kind_of(TetFormat format) {
  switch (format) {
    case TetFormat::medit:
      return "medit";
    case TetFormat::gmsh22:
    case TetFormat::gmsh41:
      return "gmsh";
    case TetFormat::vtu:
      return "vtk_xml";
    case TetFormat::vtk:
      return "vtk";
    case TetFormat::abaqus:
      return "abaqus";
    case TetFormat::tetgen:
      break;
  }
  return "tetgen";
}

Result<LabelledTetMesh> read_as(const std::string& path, std::optional<TetFormat> format,
                                const RunContext& context) {
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  const std::string name = file_name(path);
  if (format == TetFormat::tetgen) {
    NameParts parts = parts_of_name(path);
    if (parts.extension != "node" && parts.extension != "ele" && !parts.extension.empty())
      parts.stem += "." + parts.extension;
    Result<MeshParts> read = read_tetgen(parts.stem, parts.gz);
    return read ? tet_mesh_of(name, std::move(read).value()) : Result<LabelledTetMesh>(read.error());
  }
  const Result<std::string> bytes = read_file(path);
  if (!bytes) return bytes.error();
  return parse_tets(name, format, bytes.value());
}

}  // namespace

Result<LabelledTetMesh> io_detail::parse_tets(std::string_view name, std::optional<TetFormat> format,
                                              std::string_view bytes) {
  const std::string_view kind = format ? kind_of(*format) : mesh_kind(bytes);
  if (kind.empty())
    return Error{ErrorCode::usage,
                 "Neither its name nor what it begins with tells the format of " + std::string(name) +
                     ": tet meshes are read from .mesh, .msh, .vtu, .node, .ele, .inp and .vtk files."};
  Result<MeshParts> read = parse(kind, name, bytes);
  return read ? tet_mesh_of(name, std::move(read).value()) : Result<LabelledTetMesh>(read.error());
}

Result<LabelledTetMesh> read_labelled_tets(const std::string& path, const RunContext& context) {
  const Result<TetFormat> format = tet_format_of(path);
  return read_as(path, format ? std::optional(format.value()) : std::nullopt, context);
}

Result<LabelledTetMesh> read_labelled_tets(const std::string& path, TetFormat format,
                                           const RunContext& context) {
  return read_as(path, format, context);
}

Result<TetMesh> read_tets(const std::string& path, const RunContext& context) {
  Result<LabelledTetMesh> read = read_labelled_tets(path, context);
  if (!read) return read.error();
  return std::move(std::move(read).value().mesh);
}

}  // namespace overtet
