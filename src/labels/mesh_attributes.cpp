#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <utility>

#include "kernels/bvh/bvh.h"
#include "kernels/core/assertions.h"
#include "kernels/core/tuning.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"
#include "overtet/attributes.h"
#include "src/exact/winding.h"
#include "src/labels/face_labels.h"
#include "src/labels/tuning.h"

namespace overtet {

namespace {

std::vector<Index> picked(const std::vector<Index>& values, const std::vector<Index>& old) {
  std::vector<Index> out;
  if (values.empty()) return out;
  out.reserve(old.size());
  for (const Index o : old) out.push_back(o < 0 ? -1 : values[static_cast<std::size_t>(o)]);
  return out;
}

// Where nothing is known.
double no_value(const Attribute& a) {
  const bool real = a.type == NumberType::float32 || a.type == NumberType::float64;
  return real ? std::numeric_limits<double>::quiet_NaN() : 0.0;
}

std::vector<Attribute> picked(const std::vector<Attribute>& data, const std::vector<Index>& old) {
  std::vector<Attribute> out;
  for (const Attribute& a : data) {
    Attribute b{a.name, a.type, a.width, {}};
    const auto width = static_cast<std::size_t>(a.width);
    b.values.reserve(old.size() * width);
    for (const Index o : old)
      for (std::size_t k = 0; k < width; ++k)
        b.values.push_back(o < 0 ? no_value(a) : a.values[static_cast<std::size_t>(o) * width + k]);
    out.push_back(std::move(b));
  }
  return out;
}

bool is_identity(const std::vector<Index>& old, std::size_t count) {
  if (old.size() != count) return false;
  for (std::size_t i = 0; i < count; ++i)
    if (old[i] != static_cast<Index>(i)) return false;
  return true;
}

// Components by shared vertices: in a manifold with boundary, those by shared faces.
UnionFind components_of(const TetMesh& mesh) {
  UnionFind sets(static_cast<std::size_t>(mesh.V.rows()));
  for (Eigen::Index t = 0; t < mesh.T.rows(); ++t)
    for (int k = 1; k < 4; ++k) sets.join_smaller(mesh.T(t, 0), mesh.T(t, k));
  return sets;
}

// Number and name of each component's region.
Labels regions_of(const Surface& surface, const Labels& solids, const TetMesh& mesh) {
  UnionFind sets = components_of(mesh);
  const auto faces = static_cast<Index>(surface.F.rows()), tets = static_cast<Index>(mesh.T.rows());
  // By smallest face; what no face belongs to comes last.
  const std::vector<Index> component = labels_detail::numbered(
      sets, faces + tets, 0, [&](Index i) { return i < faces ? surface.F(i, 0) : mesh.T(i - faces, 0); });
  const Index count = 1 + *std::max_element(component.begin(), component.end());
  std::vector<Index> number(static_cast<std::size_t>(count));
  Labels regions;
  const bool several =
      std::any_of(solids.of.begin(), solids.of.end(), [&](Index s) { return s != solids.of[0]; });
  if (!several) {
    for (Index c = 0; c < count; ++c) number[static_cast<std::size_t>(c)] = c + 1;
    if (count == 1 && !solids.of.empty() && solids.names.contains(solids.of[0]))
      regions.names[1] = solids.names.at(solids.of[0]);
  } else {
    constexpr Index none = std::numeric_limits<Index>::min(), mixed = none + 1;
    std::vector<Index> solid(number.size(), none);
    Index next = 1;
    for (Index f = 0; f < faces; ++f) {
      Index& s = solid[static_cast<std::size_t>(component[static_cast<std::size_t>(f)])];
      const Index mine = solids.of[static_cast<std::size_t>(f)];
      s = s == none || s == mine ? mine : mixed;
      next = std::max(next, mine + 1);
    }
    for (std::size_t c = 0; c < solid.size(); ++c) {
      const bool named = solid[c] != none && solid[c] != mixed;
      number[c] = named ? solid[c] : next++;
      if (const auto name = solids.names.find(number[c]); named && name != solids.names.end())
        regions.names.insert(*name);
    }
  }
  regions.of.resize(static_cast<std::size_t>(tets));
  for (Index t = 0; t < tets; ++t)
    regions.of[static_cast<std::size_t>(t)] =
        number[static_cast<std::size_t>(component[static_cast<std::size_t>(faces + t)])];
  return regions;
}

// How many layers there are at a tet. Between tets that no face comes near nothing changes, so one of them
// answers for all.
class LayerCount {
 public:
  LayerCount(const Surface& surface, const TetMesh& mesh)
      : surface_(surface), mesh_(mesh), bvh_(surface.V, surface.F), winding_(surface, bvh_) {}

  Result<std::vector<Index>> all(const RunContext& context) {
    const auto tets = static_cast<std::size_t>(mesh_.T.rows());
    std::vector<std::uint8_t> alone(tets);
    // Where there are few inner tets, nearly all are near a face, and to look costs half as much as to ask.
    const bool many = mesh_.T.rows() / kManyTets > surface_.F.rows();
    parallel_for(many ? mesh_.T.rows() : 0, kMediumGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t t = begin; t < end; ++t) alone[static_cast<std::size_t>(t)] = !near_a_face(t);
    });
    UnionFind sets(static_cast<std::size_t>(mesh_.V.rows()));
    for (std::size_t t = 0; t < tets; ++t)
      for (int k = 1; alone[t] && k < 4; ++k)
        sets.join_smaller(mesh_.T(static_cast<Eigen::Index>(t), 0), mesh_.T(static_cast<Eigen::Index>(t), k));
    std::vector<Index> asked(sets.size(), -1), asks(tets);
    for (std::size_t t = 0; t < tets; ++t) {
      asks[t] = static_cast<Index>(t);
      if (!alone[t]) continue;
      Index& one = asked[static_cast<std::size_t>(sets.root(mesh_.T(static_cast<Eigen::Index>(t), 0)))];
      asks[t] = one = one < 0 ? asks[t] : one;
    }
    std::vector<Index> layers(tets);
    std::atomic<bool> stopped{false};
    parallel_for(mesh_.T.rows(), kHeavyGrain, [&](std::int64_t begin, std::int64_t end) {
      if (stopped || context.stop()) {
        stopped = true;
        return;
      }
      for (std::int64_t t = begin; t < end; ++t)
        if (asks[static_cast<std::size_t>(t)] == t) layers[static_cast<std::size_t>(t)] = at(t);
    });
    if (stopped) return context.stop().value_or(Error{ErrorCode::interrupted, "Interrupted."});
    for (std::size_t t = 0; t < tets; ++t) layers[t] = layers[static_cast<std::size_t>(asks[t])];
    return layers;
  }

 private:
  bool near_a_face(std::int64_t t) const {
    double low[3], high[3];
    for (int k = 0; k < 3; ++k) {
      low[k] = high[k] = mesh_.V(mesh_.T(t, 0), k);
      for (int c = 1; c < 4; ++c) {
        low[k] = std::min(low[k], mesh_.V(mesh_.T(t, c), k));
        high[k] = std::max(high[k], mesh_.V(mesh_.T(t, c), k));
      }
    }
    bool near = false;
    bvh_.query_box(low, high, [&](Index) { near = true; });
    return near;
  }

  // How often the surface encloses a point: crossings of it by a way out, almost along an axis. None where
  // the way meets an edge or a vertex, or begins on the surface.
  std::optional<int> on_the_way_out(const double* p) const {
    const double length = 4 * bvh_.reach();
    if (!std::isfinite(length)) return std::nullopt;
    const double q[3] = {p[0] + length, p[1] + 0x1.3p-9 * length, p[2] - 0x1.9p-10 * length};
    const double direction[3] = {q[0] - p[0], q[1] - p[1], q[2] - p[2]};
    int crossings = 0;
    bool sure = true;
    bvh_.query_ray(p, direction, kRounding * length, [&](Index f) {
      if (!sure) return;
      const double* c[3];
      for (int k = 0; k < 3; ++k) c[k] = &surface_.V(surface_.F(f, k), 0);
      int s[3];
      for (int k = 0; k < 3; ++k) {
        s[k] = orient3d(p, q, c[k], c[(k + 1) % 3]);
        if (k > 0 && s[k] * s[k - 1] < 0) return;
      }
      if (s[0] * s[2] < 0) return;
      const int side = orient3d(c[0], c[1], c[2], p);
      if (side != 0 && side == orient3d(c[0], c[1], c[2], q)) return;
      if (s[0] == 0 || s[1] == 0 || s[2] == 0 || side == 0)
        sure = false;
      else
        crossings += side < 0 ? 1 : -1;
    });
    return sure ? std::optional(crossings) : std::nullopt;
  }

  // At the centroid; where that lies on the surface, at points beside it.
  Index at(std::int64_t t) const {
    static constexpr double weights[][4] = {
        {.25, .25, .25, .25}, {.4, .3, .2, .1}, {.1, .4, .2, .3}, {.3, .1, .2, .4}, {.2, .3, .4, .1}};
    for (const auto& w : weights) {
      double p[3];
      for (int k = 0; k < 3; ++k) {
        p[k] = 0;
        for (int c = 0; c < 4; ++c) p[k] += w[c] * mesh_.V(mesh_.T(t, c), k);
      }
      std::optional<int> n = on_the_way_out(p);
      if (!n) n = winding_.at(p);
      if (n) return std::max(*n, 1);  // rounded out of the tet: 0
    }
    return 1;
  }

  const Surface& surface_;
  const TetMesh& mesh_;
  TriangleBvh bvh_;
  WindingNumber winding_;
};

// Values for the surface's vertices, and nothing for the inner ones.
std::vector<Attribute> with_inner_vertices(const std::vector<Attribute>& data, std::size_t vertices) {
  std::vector<Attribute> out = data;
  for (Attribute& a : out) a.values.resize(vertices * static_cast<std::size_t>(a.width), no_value(a));
  return out;
}

}  // namespace

SurfaceAttributes carried(const SurfaceAttributes& a, const std::vector<Index>& old_vertex,
                          const std::vector<Index>& old_face) {
  SurfaceAttributes out = a;
  if (!old_vertex.empty()) {
    out.vertex_data = picked(a.vertex_data, old_vertex);
    out.input_vertex = a.input_vertex.empty() ? old_vertex : picked(a.input_vertex, old_vertex);
    if (is_identity(out.input_vertex, old_vertex.size())) out.input_vertex.clear();
  }
  if (!old_face.empty()) {
    out.faces.of = picked(a.faces.of, old_face);
    out.solids.of = picked(a.solids.of, old_face);
    out.face_data = picked(a.face_data, old_face);
    out.input_face = a.input_face.empty() ? old_face : picked(a.input_face, old_face);
    if (is_identity(out.input_face, old_face.size())) out.input_face.clear();
  }
  return out;
}

Labels labels_of_faces(const Surface& surface, const SurfaceAttributes& attributes) {
  if (!attributes.faces.of.empty()) return attributes.faces;
  UnionFind sets(static_cast<std::size_t>(surface.V.rows()));
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f)
    for (int k = 1; k < 3; ++k) sets.join_smaller(surface.F(f, 0), surface.F(f, k));
  return {labels_detail::numbered(sets, static_cast<Index>(surface.F.rows()), 1,
                                  [&](Index f) { return surface.F(f, 0); }),
          {}};
}

Result<MeshAttributes> mesh_attributes(const Surface& surface, const SurfaceAttributes& attributes,
                                       const TetMesh& mesh, const MeshAttributeOptions& options,
                                       const RunContext& context) {
  OVERTET_EXPECTS(mesh.surface_vertices == surface.V.rows() && mesh.V.rows() >= surface.V.rows());
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  const Surface in_place{mesh.V.topRows(surface.V.rows()), surface.F};
  const auto vertices = static_cast<std::size_t>(surface.V.rows()),
             faces = static_cast<std::size_t>(surface.F.rows()),
             all = static_cast<std::size_t>(mesh.V.rows());
  MeshAttributes out;
  out.triangles = surface.F;
  out.labels = labels_of_faces(surface, attributes);
  out.regions = regions_of(surface, attributes.solids, mesh);
  out.input_face = attributes.input_face;
  if (out.input_face.empty()) {
    out.input_face.resize(faces);
    std::iota(out.input_face.begin(), out.input_face.end(), 0);
  }
  out.input_vertex = attributes.input_vertex;
  if (out.input_vertex.empty()) {
    out.input_vertex.resize(vertices);
    std::iota(out.input_vertex.begin(), out.input_vertex.end(), 0);
  }
  out.input_vertex.resize(all, -1);
  out.vertex_data = with_inner_vertices(attributes.vertex_data, all);
  out.triangle_data = attributes.face_data;
  if (!options.layers) return out;
  if (options.winding_max == 1) {
    out.layers.assign(static_cast<std::size_t>(mesh.T.rows()), 1);
    return out;
  }
  Result<std::vector<Index>> layers = LayerCount(in_place, mesh).all(context);
  if (!layers) return layers.error();
  out.layers = std::move(layers).value();
  return out;
}

}  // namespace overtet
