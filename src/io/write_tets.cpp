#include <limits>
#include <span>

#include "overtet/io.h"
#include "src/io/filled_file.h"
#include "src/io/names.h"
#include "src/io/tet_view.h"

namespace overtet {

namespace {

using namespace io_detail;

struct FormatName {
  TetFormat format;
  std::string_view name, extension;
};
std::span<const FormatName> formats() {
  static constexpr FormatName all[] = {
      {TetFormat::medit, "medit", "mesh"},   {TetFormat::gmsh41, "msh41", "msh"},
      {TetFormat::gmsh22, "msh22", "msh"},   {TetFormat::vtu, "vtu", "vtu"},
      {TetFormat::tetgen, "tetgen", "node"}, {TetFormat::tetgen, "tetgen", "ele"},
      {TetFormat::abaqus, "abaqus", "inp"},  {TetFormat::vtk, "vtk", "vtk"}};
  return all;
}

// The files that a mesh is written to, and what writes each.
struct Part {
  std::string path;
  void (*write)(TextWriter&, const TetView&);
};

std::vector<Part> parts_for(const std::string& path, TetFormat format, bool boundary) {
  NameParts name = parts_of_name(path);
  std::vector<Part> parts;
  switch (format) {
    case TetFormat::medit:
      return {{path, write_medit}};
    case TetFormat::gmsh22:
      return {{path, write_gmsh22}};
    case TetFormat::gmsh41:
      return {{path, write_gmsh41}};
    case TetFormat::abaqus:
      return {{path, write_abaqus}};
    case TetFormat::vtu:
    case TetFormat::vtk:
      parts = {{path, format == TetFormat::vtu ? write_vtu : write_vtk}};
      if (boundary && has_neighbours(path))
        parts.push_back({name.stem + "_boundary.vtp" + name.gz, write_boundary_vtp});
      return parts;
    case TetFormat::tetgen:
      if (!name.extension.empty() && name.extension != "node" && name.extension != "ele")
        name.stem += "." + name.extension;
      parts = {{name.stem + ".node" + name.gz, write_node}, {name.stem + ".ele" + name.gz, write_ele}};
      if (boundary) parts.push_back({name.stem + ".face" + name.gz, write_face});
      return parts;
  }
  return parts;
}

// All files are complete before the first gets its name.
Status write_parts(const std::vector<Part>& parts, const TetView& view, const RunContext& context) {
  std::vector<AtomicFile> files(parts.size());
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (Status s = fill(files[i], parts[i].path, [&](TextWriter& w) { parts[i].write(w, view); }); !s)
      return s;
  for (AtomicFile& file : files)
    if (Status s = file.sync(); !s) return s;
  if (auto why = context.no_name()) return *why;
  for (AtomicFile& file : files)
    if (Status s = file.commit(); !s) return s;
  return success();
}

}  // namespace

Result<TetFormat> tet_format_named(std::string_view name) {
  for (const FormatName& f : formats())
    if (f.name == name || (f.extension == name && f.format != TetFormat::tetgen)) return f.format;
  return Error{ErrorCode::usage, "There is no format named " + std::string(name) +
                                     "; use medit, msh22, msh41, vtu, tetgen, abaqus or vtk."};
}

std::string_view name_of(TetFormat format) {
  for (const FormatName& f : formats())
    if (f.format == format) return f.name;
  return "";
}

bool keeps_layers(TetFormat format) {
  return format == TetFormat::gmsh41 || format == TetFormat::vtu || format == TetFormat::vtk;
}

Result<TetFormat> tet_format_of(const std::string& path) {
  const std::string extension = parts_of_name(path).extension;
  for (const FormatName& f : formats())
    if (f.extension == extension) return f.format;
  return Error{ErrorCode::usage, "The name " + path +
                                     " does not tell the format: use .mesh, .msh, .vtu, .node, .ele, .inp or "
                                     ".vtk, or name the format."};
}

std::vector<std::string> tet_files(const std::string& path, TetFormat format) {
  std::vector<std::string> out;
  for (const Part& part : parts_for(path, format, true)) out.push_back(part.path);
  return out;
}

Status TetWriteOptions::validate() const {
  if (order == 1 || order == 2) return success();
  return Error{ErrorCode::usage, "Tets are of order 1 or 2, not " + std::to_string(order) + "."};
}

Status write_tets(const std::string& path, const TetMesh& mesh, TetFormat format, const RunContext& context) {
  return write_tets(path, mesh, MeshAttributes{}, {format, 1}, context);
}

Status write_tets(const std::string& path, const TetMesh& mesh, const MeshAttributes& attributes,
                  const TetWriteOptions& options, const RunContext& context) {
  if (Status s = options.validate(); !s) return s;
  if (path == "-" && options.format == TetFormat::tetgen)
    return Error{ErrorCode::usage,
                 "TetGen's format takes several files; it cannot be written to standard output."};
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  const TetView view(mesh, attributes, options.order);
  if (view.vertices() > std::int64_t{std::numeric_limits<Index>::max()})
    return Error{ErrorCode::usage, "The mesh of order 2 has more vertices than can be numbered."};
  return write_parts(parts_for(path, options.format, view.triangles() > 0), view, context);
}

}  // namespace overtet
