#include "src/tet_mesh/tet_mesh.h"

#include <algorithm>
#include <array>
#include <compare>
#include <cstring>
#include <string>
#include <utility>
#include <vector>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/core/triangles.h"
#include "kernels/predicates/predicates.h"
#include "src/mesh/local_operations.h"
#include "src/mesh/tet_complex.h"

namespace overtet {

namespace {

using Edge = std::array<Index, 2>;

Edge edge(Index a, Index b) { return {std::min(a, b), std::max(a, b)}; }

void sort_unique(std::vector<Edge>& edges) {
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
}

// Interior edges between two boundary vertices, sorted.
std::vector<Edge> chords(const TetComplex& mesh, const LocalOperations& work) {
  std::vector<Edge> on_surface, all;
  for (const auto& f : mesh.boundary())
    for (int k = 0; k < 3; ++k) on_surface.push_back(edge(f[k], f[(k + 1) % 3]));
  sort_unique(on_surface);
  for (Index t = 0; t < mesh.tet_capacity(); ++t) {
    if (!mesh.alive(t)) continue;
    const auto& c = mesh.tet(t);
    for (int i = 0; i < 4; ++i)
      for (int j = i + 1; j < 4; ++j)
        if (work.fixed(c[i]) && work.fixed(c[j])) all.push_back(edge(c[i], c[j]));
  }
  sort_unique(all);
  std::vector<Edge> inside;
  std::set_difference(all.begin(), all.end(), on_surface.begin(), on_surface.end(),
                      std::back_inserter(inside));
  return inside;
}

// An interior face with three boundary vertices, as its tet and corner.
int fixed_face(const TetComplex& mesh, const LocalOperations& work, Index t) {
  const auto& c = mesh.tet(t);
  for (int k = 0; k < 4; ++k)
    if (mesh.neighbour(t, k) >= 0 && work.fixed(c[(k + 1) % 4]) && work.fixed(c[(k + 2) % 4]) &&
        work.fixed(c[(k + 3) % 4]))
      return k;
  return -1;
}

bool fixed_tet(const TetComplex& mesh, const LocalOperations& work, Index t) {
  const auto& c = mesh.tet(t);
  return work.fixed(c[0]) && work.fixed(c[1]) && work.fixed(c[2]) && work.fixed(c[3]);
}

// The tets that cannot be reached from the outer side of a face of the surface, without passing through
// another one: TetGen fills cavities, too. Facets of `filled` are the faces, as vertex sets. Errors: unsolved
// where a face has no tet left on its inner side.
Result<TetMatrix> without_cavities(const TetgenResult& filled, const TriangleMatrix& F) {
  struct Facet {
    std::array<Index, 3> corners;  // sorted
    Index face;
    auto operator<=>(const Facet&) const = default;
  };
  std::vector<Facet> facets;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    std::array<Index, 3> corners{F(f, 0), F(f, 1), F(f, 2)};
    std::sort(corners.begin(), corners.end());
    facets.push_back({corners, static_cast<Index>(f)});
  }
  std::sort(facets.begin(), facets.end());
  const auto face_at = [&](std::array<Index, 3> corners) {
    std::sort(corners.begin(), corners.end());
    const auto found = std::lower_bound(facets.begin(), facets.end(), Facet{corners, 0});
    return found != facets.end() && found->corners == corners ? found->face : -1;
  };
  const TetMatrix& T = filled.T;
  std::vector<char> gone(static_cast<std::size_t>(T.rows()), 0);
  std::vector<Index> stack;
  const auto remove = [&](Index t) {
    if (t < 0 || std::exchange(gone[static_cast<std::size_t>(t)], 1)) return;
    stack.push_back(t);
  };
  for (Index t = 0; t < T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      const std::array<Index, 3> outward = tet_face(T.row(t), k);
      const Index f = face_at(outward);
      if (f >= 0 && rotated(outward) != rotated(std::array<Index, 3>{F(f, 0), F(f, 1), F(f, 2)})) remove(t);
    }
  while (!stack.empty()) {
    const Index t = stack.back();
    stack.pop_back();
    for (int k = 0; k < 4; ++k)
      if (face_at(tet_face(T.row(t), k)) < 0) remove(filled.neighbours(t, k));
  }
  TetMatrix kept(std::count(gone.begin(), gone.end(), 0), 4);
  Eigen::Index next = 0;
  std::vector<char> has_tet(static_cast<std::size_t>(F.rows()), 0);
  for (Index t = 0; t < T.rows(); ++t) {
    if (gone[static_cast<std::size_t>(t)]) continue;
    kept.row(next++) = T.row(t);
    for (int k = 0; k < 4; ++k)
      if (const Index f = face_at(tet_face(T.row(t), k)); f >= 0) has_tet[static_cast<std::size_t>(f)] = 1;
  }
  const auto bare = std::find(has_tet.begin(), has_tet.end(), 0);
  if (bare != has_tet.end())
    return Error{
        ErrorCode::unsolved,
        "There is no solid behind face " + std::to_string(bare - has_tet.begin()) +
            " (counted from 0) of the embedding: its component faces inwards, as a cavity does, but lies in "
            "no other one."};
  return kept;
}

Status pre_split(TetComplex& mesh, TetMeshResult& result, const RunContext& context) {
  LocalOperations work(mesh);
  const auto failed = [](const char* what) {
    return Error{ErrorCode::unsolved,
                 std::string("An interior ") + what +
                     " between boundary vertices is too small to split in double precision."};
  };
  for (const auto& [a, b] : chords(mesh, work)) {
    if (auto error = context.stop()) return *error;
    if (!work.split_edge(a, b, (mesh.position(a) + mesh.position(b)) / 2)) return failed("edge");
    ++result.edges_split;
  }
  // A split leaves other such faces of its tets alone, so one look at every tet, new ones included, and
  // again until nothing is found.
  for (bool again = true; again;) {
    again = false;
    for (Index t = 0; t < mesh.tet_capacity(); ++t) {
      if (!mesh.alive(t)) continue;
      const int k = fixed_face(mesh, work, t);
      if (k < 0) continue;
      const auto& c = mesh.tet(t);
      const Eigen::Vector3d middle =
          (mesh.position(c[(k + 1) % 4]) + mesh.position(c[(k + 2) % 4]) + mesh.position(c[(k + 3) % 4])) / 3;
      if (!work.split_face(t, k, middle)) return failed("face");
      ++result.faces_split;
      again = true;
    }
  }
  for (Index t = 0, n = mesh.tet_capacity(); t < n; ++t) {
    if (!mesh.alive(t) || !fixed_tet(mesh, work, t)) continue;
    const auto& c = mesh.tet(t);
    const Eigen::Vector3d middle =
        (mesh.position(c[0]) + mesh.position(c[1]) + mesh.position(c[2]) + mesh.position(c[3])) / 4;
    if (!work.split_tet(t, middle)) return failed("tet");
    ++result.tets_split;
  }
  return success();
}

}  // namespace

Status TetMeshOptions::validate() const {
  TetgenOptions tetgen;
  tetgen.quality = quality;
  tetgen.radius_edge = radius_edge;
  return tetgen.validate();
}

Result<TetMeshResult> tet_mesh(const Surface& embedded, const TetMeshOptions& options,
                               const RunContext& context) {
  if (auto status = options.validate(); !status.ok()) return status.error();
  const auto begin = RunContext::Clock::now();
  TetgenOptions tetgen;
  tetgen.quality = options.quality;
  tetgen.radius_edge = options.radius_edge;
  const Plc plc{embedded.V, embedded.F, {}, {}};
  TetMeshResult result;
  auto filled = tetrahedralize(plc, tetgen, context);
  if (!filled.ok() && filled.error().code == ErrorCode::unsolved && options.quality) {
    context.note(LogLevel::warning, "TetGen failed while refining for quality; trying again without that.");
    tetgen.quality = false;
    result.without_quality = true;
    filled = tetrahedralize(plc, tetgen, context);
  }
  if (!filled.ok()) return filled.error();
  result.tetgen_seconds = filled.value().seconds;
  result.tetgen_peak_rss_bytes = filled.value().peak_rss_bytes;

  const Result<TetMatrix> solid = without_cavities(filled.value(), embedded.F);
  if (!solid) return solid.error();
  TetComplex mesh(filled.value().V, solid.value());
  if (options.pre_splits)
    if (auto status = pre_split(mesh, result, context); !status.ok()) return status.error();
  const Index n = static_cast<Index>(embedded.V.rows());
  mesh.compact(n);
  result.mesh = mesh.to_mesh(n);
  result.seconds = std::chrono::duration<double>(RunContext::Clock::now() - begin).count();
  OVERTET_ENSURES(check_postconditions(result, embedded, options));
  return result;
}

Status check_postconditions(const TetMeshResult& result, const Surface& embedded,
                            const TetMeshOptions& options) {
  const auto broken = [](const std::string& what) {
    return Error{ErrorCode::internal, "The tet mesh of the embedding is wrong: " + what + "."};
  };
  const TetMesh& m = result.mesh;
  if (m.surface_vertices != embedded.V.rows() || m.V.rows() < embedded.V.rows() ||
      std::memcmp(m.V.data(), embedded.V.data(), sizeof(double) * embedded.V.size()) != 0)
    return broken("a surface vertex moved");
  if (const Index t = first_not_positive(m); t >= 0)
    return broken("tet " + std::to_string(t) + " is not positive");
  const TetComplex mesh(m.V, m.T);
  std::vector<std::array<Index, 3>> want, have;
  for (Eigen::Index f = 0; f < embedded.F.rows(); ++f)
    want.push_back(rotated(std::array<Index, 3>{embedded.F(f, 0), embedded.F(f, 1), embedded.F(f, 2)}));
  for (const auto& f : mesh.boundary()) have.push_back(rotated(f));
  std::sort(want.begin(), want.end());
  std::sort(have.begin(), have.end());
  if (want != have) return broken("its boundary is not the surface");
  if (!options.pre_splits) return success();
  TetComplex copy = mesh;
  const LocalOperations work(copy);
  if (!chords(mesh, work).empty()) return broken("an interior edge joins two boundary vertices");
  for (Index t = 0; t < mesh.tet_capacity(); ++t)
    if (fixed_face(mesh, work, t) >= 0 || fixed_tet(mesh, work, t))
      return broken("tet " + std::to_string(t) + " has an interior face of boundary vertices");
  return success();
}

}  // namespace overtet
