#include <algorithm>
#include <map>
#include <optional>
#include <utility>

#include "kernels/core/tuning.h"
#include "kernels/parallel/parallel.h"
#include "src/mesh/topology.h"
#include "src/prepare/patches.h"
#include "src/prepare/polygon_meshes.h"
#include "src/prepare/steps.h"
#include "src/prepare/surroundings.h"

namespace overtet {

namespace {

struct HoleState {
  std::vector<Index> border;  // half-edges
  bool closed = false;
  bool has_filling = false;  // CGAL found one
};

std::optional<Patch> patch_for(const Surface& s, const Incidence& incidence, const HoleState& hole,
                               Filling filling) {
  std::vector<Index> vertices;
  for (const Index h : hole.border) vertices.push_back(half_edge_source(s.F, h));
  const Surroundings around = of_faces(s, faces_around(s, incidence, vertices, kRings));
  for (Index& v : vertices) v = around.local_vertex(v);
  const std::optional<FilledHole> made = filled(around.surface, vertices, filling);
  if (!made) return std::nullopt;
  Patch patch;
  patch.points = made->points;
  for (std::array<Index, 3> f : made->faces) {
    for (Index& corner : f)
      if (corner >= 0) corner = around.vertex[corner];
    patch.faces.push_back(f);
  }
  patch.face_of.assign(patch.faces.size(), -1);
  return patch;
}

// A border that passes through one place twice is that of two holes that touch there: the clean-up has made
// two vertices of theirs. Both holes get one vertex again, and each is a hole of its own.
void cut_at_touching_places(Surface& s, const Incidence& incidence, const std::vector<Index>& border,
                            std::vector<HoleState>& holes) {
  std::vector<Index> open;                          // half-edges
  std::map<std::array<double, 3>, std::size_t> at;  // the place where one of them begins
  const auto place = [&](Index h) {
    const Index v = half_edge_source(s.F, h);
    return std::array<double, 3>{s.V(v, 0), s.V(v, 1), s.V(v, 2)};
  };
  for (const Index h : border) {
    if (const auto found = at.find(place(h)); found != at.end() && open.size() >= found->second + 3) {
      const Index gone = half_edge_source(s.F, h), stays = half_edge_source(s.F, open[found->second]);
      if (gone != stays)
        for (const Index corner : incidence.at(gone)) s.F(corner / 3, corner % 3) = stays;
      const auto first = open.begin() + static_cast<std::ptrdiff_t>(found->second);
      holes.push_back({{first, open.end()}, false, false});
      for (auto g = first; g != open.end(); ++g) at.erase(place(*g));
      open.erase(first, open.end());
    }
    at.emplace(place(h), open.size());
    open.push_back(h);
  }
  holes.push_back({std::move(open), false, false});
}

// The fewest edges first: of two holes whose fillings would cross, the smaller one is filled.
std::vector<HoleState> holes_of(Surface& s) {
  const Incidence incidence(static_cast<Index>(s.V.rows()), s.F);
  std::vector<HoleState> holes;
  for (const std::vector<Index>& loop : border_loops(s.F, border_half_edges(s.F, incidence)))
    cut_at_touching_places(s, incidence, loop, holes);
  std::stable_sort(holes.begin(), holes.end(),
                   [](const HoleState& a, const HoleState& b) { return a.border.size() < b.border.size(); });
  return holes;
}

// Tries one way to fill all holes that are open still.
Status try_filling(WorkingSurface& working, const Incidence& incidence, std::vector<HoleState>& holes,
                   std::size_t count, Filling filling, const PrepareOptions& options,
                   const RunContext& context) {
  std::vector<std::optional<Patch>> made(count);
  std::atomic<bool> stopped{false};
  parallel_for(static_cast<std::int64_t>(count), 1, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end && !stopped; ++i) {
      if (context.stop()) stopped = true;
      if (!holes[i].closed) made[i] = patch_for(working.surface, incidence, holes[i], filling);
    }
  });
  if (auto stop = context.stop()) return *stop;
  std::vector<Patch> patches;
  std::vector<std::size_t> hole;
  for (std::size_t i = 0; i < count; ++i) {
    if (!made[i]) continue;
    holes[i].has_filling = true;
    patches.push_back(std::move(*made[i]));
    hole.push_back(i);
  }
  const Result<std::vector<PatchFate>> fate = put_patches(working, patches, options.allow_crossings, context);
  if (!fate) return fate.error();
  for (std::size_t p = 0; p < hole.size(); ++p) holes[hole[p]].closed = fate.value()[p] == PatchFate::taken;
  return success();
}

}  // namespace

Result<StepOutcome> fill_holes(WorkingSurface& working, const PrepareOptions& options,
                               const RunContext& context) {
  const Index vertices = static_cast<Index>(working.surface.V.rows()),
              faces = static_cast<Index>(working.surface.F.rows());
  std::vector<HoleState> holes = holes_of(working.surface);
  const Incidence incidence(vertices, working.surface.F);
  const auto fits = [&](const HoleState& h) {
    return h.border.size() <= static_cast<std::size_t>(options.fill_holes);
  };
  const auto count = static_cast<std::size_t>(std::count_if(holes.begin(), holes.end(), fits));
  double done = 0;
  for (const Filling filling : {Filling::faired, Filling::refined, Filling::plain}) {
    context.report("prepare", done, "filling holes");
    done += 1.0 / 3;
    if (Status s = try_filling(working, incidence, holes, count, filling, options, context); !s)
      return s.error();
  }
  StepOutcome out;
  for (const HoleState& hole : holes) {
    if (hole.closed) {
      ++out.done;
      continue;
    }
    ++out.left;
    if (out.places.size() >= static_cast<std::size_t>(options.most_places)) continue;
    PlaceLeft place;
    place.vertex = half_edge_source(working.surface.F, hole.border.front());
    for (int k = 0; k < 3; ++k) place.position[k] = working.surface.V(place.vertex, k);
    place.edges = static_cast<std::int64_t>(hole.border.size());
    place.why = !fits(hole) ? "it has more than " + std::to_string(options.fill_holes) + " edges"
                : hole.has_filling
                    ? "every filling that was found crosses or touches something, or has a face without area"
                    : "no filling was found";
    out.places.push_back(std::move(place));
  }
  out.figures = {{"holes", static_cast<std::int64_t>(holes.size())},
                 {"vertices", std::int64_t{working.surface.V.rows() - vertices}},
                 {"faces", std::int64_t{working.surface.F.rows() - faces}}};
  return out;
}

}  // namespace overtet
