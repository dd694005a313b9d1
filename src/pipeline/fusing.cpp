#include "src/pipeline/fusing.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kernels/bvh/bvh.h"
#include "kernels/bvh/self_intersections.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/exact/winding.h"
#include "src/immersion/fused.h"
#include "src/improve/improve.h"
#include "src/mesh/flat_faces.h"
#include "src/mesh/topology.h"
#include "src/pipeline/unit_box.h"

namespace overtet {

namespace {

double volume_inside(const VertexMatrix& V, const std::vector<std::array<Index, 3>>& faces) {
  double sum = 0;
  const Eigen::Vector3d origin = V.row(0);
  const auto at = [&](Index v) -> Eigen::Vector3d { return V.row(v).transpose() - origin; };
  for (const auto& f : faces) sum += at(f[0]).dot(at(f[1]).cross(at(f[2])));
  return sum / 6;
}

// Numbers from 1, by the smallest tet.
Index number_components(const TetMesh& mesh, std::vector<Index>& of) {
  UnionFind sets(static_cast<std::size_t>(mesh.V.rows()));
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 1; k < 4; ++k) sets.join_smaller(mesh.T(t, 0), mesh.T(t, k));
  std::vector<Index> number(static_cast<std::size_t>(mesh.V.rows()), 0);
  Index count = 0;
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t) {
    Index& n = number[static_cast<std::size_t>(sets.root(mesh.T(t, 0)))];
    if (n == 0) n = ++count;
    of.push_back(n);
  }
  return count;
}

// The exact winding number in the middle of each tet. One that lies on the surface counts as covered once.
std::vector<Index> layers_of(const TetMesh& mesh, const Surface& surface) {
  const WindingNumber winding(surface);
  std::vector<Index> layers(static_cast<std::size_t>(mesh.T.rows()));
  parallel_for(mesh.T.rows(), kHeavyGrain, [&](std::int64_t begin, std::int64_t end) {
    for (auto t = static_cast<Index>(begin); t < end; ++t) {
      Eigen::RowVector3d p = Eigen::RowVector3d::Zero();
      for (int k = 0; k < 4; ++k) p += mesh.V.row(mesh.T(t, k)) / 4;
      layers[static_cast<std::size_t>(t)] = std::max(1, winding.at(p.data()).value_or(1));
    }
  });
  return layers;
}

// Inner vertices may move or go, those of the boundary stay: input_vertex then tells of those that are where
// they were.
Status improve_inside(FusedCells& cells, double degrees, const RunContext& context) {
  if (degrees == 0) return success();
  std::map<std::array<double, 3>, Index> source_at;
  const auto key = [](const TetMesh& m, Index v) { return std::array{m.V(v, 0), m.V(v, 1), m.V(v, 2)}; };
  for (Index v = 0; v < cells.mesh.V.rows(); ++v)
    if (cells.input_vertex[v] >= 0) source_at.emplace(key(cells.mesh, v), cells.input_vertex[v]);
  ImproveOptions options;
  options.target_degrees = degrees;
  // The boundary has needles where the surface crosses itself, which nothing improves: the dear means are for
  // meshes that others go on with.
  options.insert_vertices = false;
  const Result<ImproveResult> improved = improve(cells.mesh, options, context);
  if (!improved) return improved.error();
  cells.input_vertex.assign(static_cast<std::size_t>(cells.mesh.V.rows()), -1);
  for (Index v = 0; v < cells.mesh.V.rows(); ++v)
    if (const auto found = source_at.find(key(cells.mesh, v)); found != source_at.end())
      cells.input_vertex[v] = found->second;
  return success();
}

void describe(const Surface& surface, const SurfaceAttributes& given, FusedCells cells, FusedMesh& out) {
  MeshAttributes& told = out.mesh.attributes;
  const Labels labels = labels_of_faces(surface, given);
  const auto faces = static_cast<Index>(cells.boundary.size());
  told.labels.names = labels.names;
  told.triangles.resize(faces, 3);
  for (Index f = 0; f < faces; ++f) {
    const Index source = cells.input_face[f];
    for (int k = 0; k < 3; ++k) told.triangles(f, k) = cells.boundary[f][k];
    told.labels.of.push_back(labels.of[source]);
    told.input_face.push_back(given.input_face.empty() ? source : given.input_face[source]);
  }
  for (const Index source : cells.input_vertex)
    told.input_vertex.push_back(source < 0 || given.input_vertex.empty() ? source
                                                                         : given.input_vertex[source]);
  out.mesh.mesh = std::move(cells.mesh);
  out.components = number_components(out.mesh.mesh, told.regions.of);
}

}  // namespace

Result<FusedMesh> fuse_surface(const Surface& surface, const SurfaceAttributes& attributes,
                               const FusedOptions& options, const RunContext& context) {
  const Result<SurfaceTopology> topology = require_topology(surface);
  if (!topology) return topology.error();
  Surface boxed = surface;
  const Result<UnitBox> box = into_unit_box(boxed.V);
  if (!box) return box.error();
  if (const std::vector<Index> flat = degenerate_faces(boxed); !flat.empty())
    return Error{ErrorCode::bad_input, "Face " + std::to_string(flat[0]) + " has no area."};
  TriangleBvh bvh;
  bvh.build(boxed.V, boxed.F);
  const std::vector<FacePair> pairs = find_self_intersections(boxed.V, boxed.F, bvh);
  if (auto stop = context.stop()) return *stop;
  Result<FusedCells> cells = fuse_cells(boxed, pairs, context);
  if (!cells) return cells.error();
  FusedMesh out;
  for (auto v = static_cast<std::size_t>(cells.value().mesh.surface_vertices);
       v < cells.value().input_vertex.size(); ++v)
    out.inner_vertices += cells.value().input_vertex[v] >= 0;
  if (Status s = improve_inside(cells.value(), options.improve_degrees, context); !s) return s.error();
  out.mesh.attributes.layers = layers_of(cells.value().mesh, boxed);
  out_of_unit_box(cells.value().mesh.V, box.value());
  std::vector<Index> crossed;
  for (const auto& [a, b] : pairs) crossed.insert(crossed.end(), {a, b});
  std::sort(crossed.begin(), crossed.end());
  out.cut_faces = static_cast<Index>(std::unique(crossed.begin(), crossed.end()) - crossed.begin());
  out.surface_components = static_cast<Index>(topology.value().components.size());
  std::vector<std::array<Index, 3>> faces;
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f)
    faces.push_back({surface.F(f, 0), surface.F(f, 1), surface.F(f, 2)});
  out.solid_volume = volume_inside(surface.V, faces);
  out.volume = volume_inside(cells.value().mesh.V, cells.value().boundary);
  describe(surface, attributes, std::move(cells).value(), out);
  return out;
}

}  // namespace overtet
