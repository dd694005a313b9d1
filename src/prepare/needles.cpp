#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include "kernels/core/tuning.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/mesh/topology.h"
#include "src/prepare/patches.h"
#include "src/prepare/polygon_meshes.h"
#include "src/prepare/steps.h"
#include "src/prepare/surroundings.h"

namespace overtet {

namespace {

// Of a face; 0 where it has no area.
double smallest_angle(const Surface& s, Index f) {
  double least = std::numbers::pi;
  for (int k = 0; k < 3; ++k) {
    const Eigen::Vector3d a = s.V.row(s.F(f, k)), u = Eigen::Vector3d(s.V.row(s.F(f, (k + 1) % 3))) - a,
                          w = Eigen::Vector3d(s.V.row(s.F(f, (k + 2) % 3))) - a;
    least = std::min(least, std::atan2(u.cross(w).norm(), u.dot(w)));
  }
  return least;
}

std::vector<Index> needles_of(const Surface& s, double degrees) {
  const double angle = degrees * std::numbers::pi / 180;
  return parallel_collect<Index>(s.F.rows(), kMediumGrain,
                                 [&](std::int64_t begin, std::int64_t end, std::vector<Index>& out) {
                                   for (auto f = static_cast<Index>(begin); f < end; ++f)
                                     if (smallest_angle(s, f) < angle) out.push_back(f);
                                 });
}

// Needles whose surroundings have a vertex in common are one place: its faces, ascending.
std::vector<std::vector<Index>> places_of(const Surface& s, const Incidence& incidence,
                                          const std::vector<Index>& needles) {
  std::vector<Index> vertices;
  for (const Index f : needles)
    for (int k = 0; k < 3; ++k) vertices.push_back(s.F(f, k));
  const std::vector<Index> faces = faces_around(s, incidence, std::move(vertices), kRings);
  const Surroundings around = of_faces(s, faces);
  UnionFind sets(around.vertex.size());
  for (Index f = 0; f < around.surface.F.rows(); ++f)
    for (int k = 1; k < 3; ++k) sets.join_smaller(around.surface.F(f, 0), around.surface.F(f, k));
  std::vector<Index> number(around.vertex.size(), -1);
  std::vector<std::vector<Index>> places;
  for (Index f = 0; f < around.surface.F.rows(); ++f) {
    Index& place = number[sets.root(around.surface.F(f, 0))];
    if (place < 0) {
      place = static_cast<Index>(places.size());
      places.emplace_back();
    }
    places[place].push_back(faces[f]);
  }
  return places;
}

// What changes at the place; nothing where CGAL finds nothing to do.
std::optional<Patch> mended(const WorkingSurface& working, const std::vector<Index>& faces,
                            const NeedleLimits& limits) {
  const Surroundings around = of_faces(working.surface, faces);
  const TriangleMatrix& F = around.surface.F;
  const Incidence incidence(static_cast<Index>(around.vertex.size()), F);
  std::vector<char> fixed(around.vertex.size(), 0);
  for (const Index h : border_half_edges(F, incidence))
    fixed[half_edge_source(F, h)] = fixed[half_edge_target(F, h)] = 1;
  const std::vector<std::array<Index, 3>> now = without_needles(around.surface, fixed, limits);
  Patch patch;
  for (Index f = 0; f < static_cast<Index>(now.size()); ++f) {
    std::array<Index, 3> before{F(f, 0), F(f, 1), F(f, 2)}, after = now[f];
    std::rotate(before.begin(), std::min_element(before.begin(), before.end()), before.end());
    std::rotate(after.begin(), std::min_element(after.begin(), after.end()), after.end());
    if (before == after) continue;
    patch.old_faces.push_back(faces[f]);
    if (after[0] < 0) continue;
    for (Index& corner : after) corner = around.vertex[corner];
    patch.faces.push_back(after);
    patch.face_of.push_back(working.face_of[faces[f]]);
  }
  if (patch.old_faces.empty()) return std::nullopt;
  return patch;
}

void list_those_left(const Surface& s, const std::vector<Index>& needles, std::int64_t places_crossing,
                     int most, StepOutcome& out) {
  for (std::size_t i = 0; i < needles.size() && i < static_cast<std::size_t>(most); ++i) {
    PlaceLeft place;
    place.vertex = s.F(needles[i], 0);
    for (int k = 0; k < 3; ++k) place.position[k] = s.V(place.vertex, k);
    place.why = places_crossing > 0
                    ? "collapsing it would move the surface farther than allowed, turn a face over, or cross "
                      "something"
                    : "collapsing it would move the surface farther than allowed, or turn a face over";
    out.places.push_back(std::move(place));
  }
}

}  // namespace

Result<StepOutcome> collapse_needles(WorkingSurface& working, const PrepareOptions& options, double length,
                                     const RunContext& context) {
  StepOutcome out;
  std::int64_t crossing = 0, collapsed = 0;
  const std::vector<Index> needles = needles_of(working.surface, options.needle_degrees);
  if (!needles.empty()) {
    const Incidence incidence(static_cast<Index>(working.surface.V.rows()), working.surface.F);
    const auto places = places_of(working.surface, incidence, needles);
    std::vector<std::optional<Patch>> made(places.size());
    parallel_for(static_cast<std::int64_t>(places.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end && !context.stop(); ++i)
        made[i] = mended(working, places[i], {options.needle_degrees, length});
    });
    if (auto stop = context.stop()) return *stop;
    std::vector<Patch> patches;
    for (std::optional<Patch>& patch : made)
      if (patch) patches.push_back(std::move(*patch));
    const Result<std::vector<PatchFate>> fate = put_patches(working, patches, false, context);
    if (!fate) return fate.error();
    for (std::size_t p = 0; p < patches.size(); ++p) {
      if (fate.value()[p] != PatchFate::taken)
        ++crossing;
      else
        collapsed += static_cast<std::int64_t>(patches[p].old_faces.size() - patches[p].faces.size());
    }
  }
  const std::vector<Index> still = needles_of(working.surface, options.needle_degrees);
  out.left = static_cast<std::int64_t>(still.size());
  out.done = std::max<std::int64_t>(0, static_cast<std::int64_t>(needles.size()) - out.left);
  list_those_left(working.surface, still, crossing, options.most_places, out);
  out.figures = {{"needles", static_cast<std::int64_t>(needles.size())},
                 {"faces_gone", collapsed},
                 {"places_that_would_cross", crossing}};
  return out;
}

}  // namespace overtet
