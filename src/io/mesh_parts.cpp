#include "src/io/mesh_parts.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

// New numbers of the vertices that are kept, -1 for the others; and the old ones of those.
struct Kept {
  std::vector<Index> new_of_old, old_of_new;
};

Kept kept(std::size_t vertices, std::initializer_list<const std::vector<Index>*> used_by) {
  Kept k;
  k.new_of_old.assign(vertices, -1);
  for (const std::vector<Index>* corners : used_by)
    for (const Index v : *corners) k.new_of_old[static_cast<std::size_t>(v)] = 0;
  for (std::size_t v = 0; v < vertices; ++v) {
    if (k.new_of_old[v] < 0) continue;
    k.new_of_old[v] = static_cast<Index>(k.old_of_new.size());
    k.old_of_new.push_back(static_cast<Index>(v));
  }
  return k;
}

template <class T>
void pick(std::vector<T>& values, const std::vector<Index>& old, std::size_t width = 1) {
  if (values.empty()) return;
  std::vector<T> out;
  out.reserve(old.size() * width);
  for (const Index o : old)
    for (std::size_t k = 0; k < width; ++k) out.push_back(values[static_cast<std::size_t>(o) * width + k]);
  values = std::move(out);
}

void leave_out_unused(MeshParts& p, const Kept& k) {
  pick(p.xyz, k.old_of_new, 3);
  pick(p.input_vertex, k.old_of_new);
  for (Attribute& a : p.vertex_data) pick(a.values, k.old_of_new, static_cast<std::size_t>(a.width));
  for (std::vector<Index>* list : {&p.tets, &p.corners})
    for (Index& v : *list) v = k.new_of_old[static_cast<std::size_t>(v)];
}

Status check_finite(std::string_view name, const MeshParts& p) {
  for (std::size_t i = 0; i < p.xyz.size(); ++i)
    if (!std::isfinite(p.xyz[i]))
      return malformed(name, "a coordinate of vertex " + std::to_string(i / 3) + " is not a finite number");
  return success();
}

template <class Matrix>
Matrix matrix_of(const std::vector<typename Matrix::Scalar>& values) {
  constexpr int width = Matrix::ColsAtCompileTime;
  return Eigen::Map<const Matrix>(values.data(), static_cast<Eigen::Index>(values.size() / width), width);
}

// Polygons of a mesh are left out of its boundary where they are no triangles.
void keep_triangles(MeshParts& p) {
  std::vector<Index> triangles, corners;
  std::size_t at = 0;
  for (std::size_t f = 0; f < p.sizes.size(); at += static_cast<std::size_t>(p.sizes[f++]))
    if (p.sizes[f] == 3) {
      triangles.push_back(static_cast<Index>(f));
      corners.insert(corners.end(), &p.corners[at], &p.corners[at] + 3);
    }
  if (triangles.size() == p.sizes.size()) return;
  p.corners = std::move(corners);
  pick(p.sizes, triangles);
  pick(p.labels.of, triangles);
  pick(p.input_face, triangles);
  for (Attribute& a : p.polygon_data) pick(a.values, triangles, static_cast<std::size_t>(a.width));
}

}  // namespace

std::string_view mesh_kind(std::string_view bytes) {
  TextCursor in("", bytes.substr(0, 4096), false);
  const std::string_view first = in.to_token() ? in.token() : std::string_view();
  if (first == "$MeshFormat" || first == "$Comments") return "gmsh";
  if (first == "MeshVersionFormatted") return "medit";
  if (first == "<?xml" || first == "<VTKFile") return "vtk_xml";
  if (bytes.starts_with("# vtk DataFile")) return "vtk";
  if (first.size() > 1 && first[0] == '*') return "abaqus";
  TextCursor commented("", bytes.substr(0, 4096), true);
  if (commented.to_token() && commented.token() == "MeshVersionFormatted") return "medit";
  return "";
}

Result<LabelledTetMesh> tet_mesh_of(std::string_view name, MeshParts&& p) {
  if (p.xyz.empty() || p.tets.empty()) return malformed(name, "the file has no vertices or no tets");
  if (Status s = check_finite(name, p); !s) return s.error();
  keep_triangles(p);
  if (p.second_order) leave_out_unused(p, kept(p.xyz.size() / 3, {&p.tets, &p.corners}));
  LabelledTetMesh out;
  MeshAttributes& a = out.attributes;
  out.mesh.V = matrix_of<VertexMatrix>(p.xyz);
  out.mesh.T = matrix_of<TetMatrix>(p.tets);
  a.triangles = matrix_of<TriangleMatrix>(p.corners);
  const auto triangles = static_cast<std::size_t>(a.triangles.rows()), vertices = p.xyz.size() / 3;
  a.labels = std::move(p.labels);
  if (a.labels.of.empty()) a.labels.of.assign(triangles, 0);
  a.regions = std::move(p.regions);
  a.layers = std::move(p.layers);
  a.input_face = std::move(p.input_face);
  a.input_vertex = std::move(p.input_vertex);
  if (triangles > 0) {
    if (a.input_face.empty())
      for (std::size_t f = 0; f < triangles; ++f) a.input_face.push_back(static_cast<Index>(f));
    if (a.input_vertex.empty()) {
      a.input_vertex.assign(vertices, -1);
      for (const Index v : p.corners) a.input_vertex[static_cast<std::size_t>(v)] = v;
    }
  }
  a.vertex_data = std::move(p.vertex_data);
  a.triangle_data = std::move(p.polygon_data);
  return out;
}

Result<Polygons> polygons_of(std::string_view name, MeshParts&& p, SurfaceReadInfo& info) {
  info.format = p.format;
  if (p.sizes.empty()) return malformed(name, "the file has no triangles");
  p.tets.clear();
  if (Status s = check_finite(name, p); !s) return s.error();
  Polygons out;
  const Kept k = kept(p.xyz.size() / 3, {&p.corners});
  if (k.old_of_new.size() != k.new_of_old.size()) {
    leave_out_unused(p, k);
    info.notes.push_back(std::to_string(k.new_of_old.size() - k.old_of_new.size()) +
                         " vertices that no face has were left out.");
    out.attributes.input_vertex = info.source.vertex = k.old_of_new;
  }
  if (p.format.starts_with("MEDIT")) info.source.first = 1;
  out.xyz = std::move(p.xyz);
  out.corners = std::move(p.corners);
  out.sizes = std::move(p.sizes);
  out.attributes.faces = std::move(p.labels);
  out.attributes.vertex_data = std::move(p.vertex_data);
  out.attributes.face_data = std::move(p.polygon_data);
  return out;
}

}  // namespace overtet::io_detail
