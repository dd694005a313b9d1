#include "src/opening/opening.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "kernels/core/assertions.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/parallel.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/opening/patch_opening.h"

namespace overtet {

namespace {

std::vector<char> moved_vertices(const TetMesh& mesh, const VertexMatrix& home) {
  std::vector<char> moved(static_cast<std::size_t>(mesh.V.rows()), 0);
  for (Index v = 0; v < home.rows(); ++v) moved[v] = mesh.V.row(v) != home.row(v);
  return moved;
}

// Tets within some layers of the moved vertices, those that have a vertex in common with the same number.
struct Places {
  std::vector<int> part_of;  // -1: far away
  int count = 0;
};

Places places_around(const TetMesh& mesh, std::vector<char> near, int layers) {
  Places out;
  const auto tets = mesh.T.rows();
  std::vector<char> chosen(static_cast<std::size_t>(tets), 0);
  for (int layer = 0; layer < layers; ++layer) {
    for (Index t = 0; t < tets; ++t)
      for (int k = 0; k < 4; ++k)
        if (near[mesh.T(t, k)]) chosen[t] = 1;
    for (Index t = 0; t < tets; ++t)
      for (int k = 0; k < 4; ++k)
        if (chosen[t]) near[mesh.T(t, k)] = 1;
  }
  UnionFind joined(near.size());
  for (Index t = 0; t < tets; ++t)
    for (int k = 1; k < 4; ++k)
      if (chosen[t]) joined.join(mesh.T(t, 0), mesh.T(t, k));
  out.part_of.assign(static_cast<std::size_t>(tets), -1);
  std::vector<int> number(near.size(), -1);
  for (Index t = 0; t < tets; ++t) {
    if (!chosen[t]) continue;
    int& n = number[joined.root(mesh.T(t, 0))];
    if (n < 0) n = out.count++;
    out.part_of[t] = n;
  }
  return out;
}

}  // namespace

Status OpeningOptions::validate() const {
  if (!(target_degrees > 0 && target_degrees < 60))
    return Error{ErrorCode::usage, "target_degrees must be above 0 and below 60."};
  if (!(usable_degrees > 0 && usable_degrees <= target_degrees))
    return Error{ErrorCode::usage, "usable_degrees must be above 0 and not above target_degrees."};
  if (!(most_tets >= 1 && power > 0 && first_cut > 0 && first_cut < 1) || home_halvings < 1)
    return Error{
        ErrorCode::usage,
        "most_tets and home_halvings must be at least 1, power positive, and first_cut between 0 and 1."};
  if (!(largest_move > 0)) return Error{ErrorCode::usage, "largest_move must be positive."};
  if (!(edges > 0 && further > 0)) return Error{ErrorCode::usage, "edges and further must be positive."};
  if (!(growth > 1)) return Error{ErrorCode::usage, "growth must be above 1."};
  if (layers < 1 || idle_rounds < 1 || energy_sweeps < 0 || worst_sweeps < 0 || home_sweeps < 0 ||
      most_helps < 0 || least_tries < 0)
    return Error{
        ErrorCode::usage,
        "layers and idle_rounds must be at least 1, and numbers of sweeps, helps and tries not negative."};
  if (!(worthwhile >= 1 && gain >= 1))
    return Error{ErrorCode::usage, "worthwhile and gain must be at least 1."};
  return success();
}

double least_angle_at_moved(const TetMesh& mesh, const VertexMatrix& home) {
  const std::vector<char> moved = moved_vertices(mesh, home);
  double least = 1;
  for (Index t = 0; t < mesh.T.rows(); ++t) {
    const auto c = mesh.T.row(t);
    if (!moved[c[0]] && !moved[c[1]] && !moved[c[2]] && !moved[c[3]]) continue;
    least = std::min(
        least, min_dihedral_sine(mesh.V.row(c[0]), mesh.V.row(c[1]), mesh.V.row(c[2]), mesh.V.row(c[3])));
  }
  return std::asin(least) * 180 / EIGEN_PI;
}

Result<OpeningResult> open_up(TetMesh& mesh, const VertexMatrix& home, const OpeningOptions& options,
                              const RunContext& context) {
  OVERTET_EXPECTS(mesh.surface_vertices == home.rows());
  if (Status s = options.validate(); !s) return s.error();
  const std::vector<char> moved = moved_vertices(mesh, home);
  const Places places = places_around(mesh, moved, options.layers);
  OpeningResult out;
  if (places.count == 0) return out;
  std::vector<MeshPart> parts = take_parts(mesh, places.part_of, places.count);
  out.places.resize(parts.size());
  parallel_tasks(places.count, [&](std::int64_t p) {
    MeshPart& part = parts[p];
    std::vector<HomeOfMoved> list;
    for (Index v = 0; v < static_cast<Index>(part.vertex.size()); ++v)
      if (moved[part.vertex[v]]) list.push_back({v, home.row(part.vertex[v]).transpose()});
    out.places[p] = open_place(part, list, options, context);
  });
  if (auto stop = context.stop()) return *stop;
  bool any = false;
  for (const OpenedPlace& place : out.places) {
    any |= place.opened;
    out.degrees_before = std::min(out.degrees_before, place.degrees_before);
    out.degrees_after = std::min(out.degrees_after, place.degrees_after);
  }
  if (any) put_parts(mesh, places.part_of, parts);
  return out;
}

}  // namespace overtet
