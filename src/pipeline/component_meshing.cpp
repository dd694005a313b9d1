#include "src/pipeline/component_meshing.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>

#include "kernels/core/assertions.h"
#include "kernels/core/tuning.h"
#include "src/cdt/roofs.h"
#include "src/cdt/star_areas.h"
#include "src/cdt/tetgen.h"
#include "src/cdt/tuning.h"
#include "src/immersion/immersion.h"
#include "src/pipeline/nearby_surface.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/tuning.h"

namespace overtet {

namespace {

struct Box {
  Eigen::RowVector3d low = Eigen::RowVector3d::Constant(1e300), high = Eigen::RowVector3d::Constant(-1e300);

  void add(const Eigen::RowVector3d& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  void add(const Box& b) { low = low.cwiseMin(b.low), high = high.cwiseMax(b.high); }
  bool meets(const Box& b) const {
    return (low.array() <= b.high.array()).all() && (b.low.array() <= high.array()).all();
  }
  bool contains(const Box& b) const {
    return (low.array() <= b.low.array()).all() && (b.high.array() <= high.array()).all();
  }
  double size() const { return (high - low).prod(); }
};

struct Part {
  std::vector<Index> components;
  Box box;
};
using Group = std::vector<Part>;  // meshed together

bool meet(const Group& a, const Group& b) {
  return std::any_of(a.begin(), a.end(), [&](const Part& x) {
    return std::any_of(b.begin(), b.end(), [&](const Part& y) { return x.box.meets(y.box); });
  });
}

// Empty where there is one only, or the components cannot be told apart like this.
std::vector<Part> find_parts(const Surface& surface, const Diagnosis& d) {
  const SurfaceTopology& topology = d.topology.topology;
  const std::size_t n = topology.components.size();
  if (n < 2 || n > kMostParts) return {};
  std::vector<Box> boxes(n);
  for (Index f = 0; f < surface.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) boxes[topology.component_of_face[f]].add(surface.V.row(surface.F(f, k)));
  // A diagnosis that ended early has not measured them.
  const std::vector<double> volume =
      d.component_volume.size() == n ? d.component_volume : component_volumes(surface, topology);
  std::vector<Index> part_of(n, -1);
  std::vector<Part> parts;
  for (std::size_t c = 0; c < n; ++c)
    if (volume[c] > 0) {
      part_of[c] = static_cast<Index>(parts.size());
      parts.push_back({{static_cast<Index>(c)}, boxes[c]});
    }
  for (std::size_t c = 0; c < n; ++c) {
    if (part_of[c] >= 0) continue;
    Index around = -1;
    for (std::size_t o = 0; o < n; ++o)
      if (volume[o] > 0 && boxes[o].contains(boxes[c]) &&
          (around < 0 || boxes[o].size() < boxes[around].size()))
        around = static_cast<Index>(o);
    if (around < 0) return {};
    parts[part_of[around]].components.push_back(static_cast<Index>(c));
  }
  return parts;
}

std::vector<char> flags(const SurfaceTopology& topology, const std::vector<Index>& components) {
  std::vector<char> in(topology.components.size(), 0);
  for (const Index c : components) in[c] = 1;
  return in;
}

class PartsMesher {
 public:
  explicit PartsMesher(const MeshingJob& job) : job_(job) {}

  Result<Draft> run(StageRecord& record) {
    std::vector<Part> parts = find_parts(job_.surface, job_.diagnosis);
    const std::size_t count = parts.size();
    record.figures.emplace_back("parts", static_cast<std::int64_t>(count));
    std::vector<Group> waiting;
    for (Part& part : parts) {
      auto group = std::find_if(waiting.begin(), waiting.end(), [&](const Group& g) {
        return std::none_of(g.begin(), g.end(), [&](const Part& p) { return p.box.meets(part.box); });
      });
      if (group == waiting.end()) group = waiting.emplace(waiting.end());
      group->push_back(std::move(part));
    }
    std::reverse(waiting.begin(), waiting.end());  // the first is taken from the back
    while (!waiting.empty()) {
      if (auto stop = job_.context.stop()) return *stop;
      Group group = std::move(waiting.back());
      waiting.pop_back();
      Result<Piece> piece = mesh(group);
      if (piece) {
        done_.push_back(std::move(piece).value());
        continue;
      }
      const Error& e = piece.error();
      if (ends_run(e)) return e;
      if (group.size() > 1) {
        for (Part& part : group) waiting.push_back({std::move(part)});
        continue;
      }
      // By itself it has none: together with one that surrounds it, or with all that is near it.
      Result<bool> carried = carry(group[0], waiting);
      if (!carried) return carried.error();
      if (carried.value()) continue;
      Group joined = group;
      const auto take = [&](const Group& other) {
        const bool near = meet(group, other);
        if (near) joined.insert(joined.end(), other.begin(), other.end());
        return near;
      };
      std::erase_if(waiting, take);
      std::erase_if(done_, [&](const Piece& p) { return take(p.group); });
      Part whole = as_one(joined);
      if (joined.size() == 1 || whole.components.size() == component_count())
        return Error{
            e.code,
            "The part with component " + std::to_string(group[0].components[0]) +
                " has no mesh by itself (the numbers that follow count its own vertices and faces from 0): " +
                e.message};
      waiting.push_back({std::move(whole)});
    }
    record.figures.emplace_back("groups", static_cast<std::int64_t>(done_.size()));
    record.figures.emplace_back("immersed", immersed_);
    record.figures.emplace_back("by_nearby_surface", nearby_);
    Draft whole = united(job_.surface.V, {done_.begin(), done_.end()});
    record.figures.emplace_back("free_points", std::int64_t{whole.placed});
    record.figures.emplace_back("tets", std::int64_t{whole.mesh.T.rows()});
    return whole;
  }

 private:
  struct Piece : PartMesh {
    Group group;
  };

  std::size_t component_count() const { return job_.diagnosis.topology.topology.components.size(); }

  static Part as_one(const Group& group) {
    Part whole;
    for (const Part& part : group) {
      whole.components.insert(whole.components.end(), part.components.begin(), part.components.end());
      whole.box.add(part.box);
    }
    std::sort(whole.components.begin(), whole.components.end());
    return whole;
  }

  // Meshes a part together with one group that surrounds it, the smallest first. All at once would make more
  // layers than it needs, and a search that may be too long.
  Result<bool> carry(const Part& part, std::vector<Group>& waiting) {
    struct Carrier {
      double size;
      Group group;
    };
    std::vector<Carrier> carriers;
    const auto look_at = [&](const Group& group) {
      for (const Part& other : group)
        if (other.box.contains(part.box)) return carriers.push_back({other.box.size(), group});
    };
    for (const Group& group : waiting) look_at(group);
    for (const Piece& piece : done_) look_at(piece.group);
    std::stable_sort(carriers.begin(), carriers.end(),
                     [](const Carrier& a, const Carrier& b) { return a.size < b.size; });
    if (carriers.size() > kInVain) carriers.resize(kInVain);
    for (const Carrier& carrier : carriers) {
      Group both = carrier.group;
      both.push_back(part);
      Part whole = as_one(both);
      if (whole.components.size() == component_count()) continue;  // the immersion route takes all
      Result<Piece> piece = mesh({std::move(whole)});
      if (!piece) {
        if (ends_run(piece.error())) return piece.error();
        continue;
      }
      const Index component = carrier.group[0].components[0];
      const auto is_carrier = [&](const Group& g) { return g[0].components[0] == component; };
      std::erase_if(waiting, is_carrier);
      std::erase_if(done_, [&](const Piece& p) { return is_carrier(p.group); });
      done_.push_back(std::move(piece).value());
      return true;
    }
    return false;
  }

  Result<Piece> mesh(const Group& group) {
    const SurfaceTopology& topology = job_.diagnosis.topology.topology;
    Piece piece;
    piece.group = group;
    std::vector<Index> components;
    bool single = true;
    for (const Part& part : group) {
      single = single && part.components.size() == 1;
      components.insert(components.end(), part.components.begin(), part.components.end());
    }
    const std::vector<char> in = flags(topology, components);
    const auto is_in = [&](Index f) { return in[topology.component_of_face[f]] != 0; };
    SubSurface part_surface = sub_surface(job_.surface, topology, in);
    const Surface& s = part_surface.surface;
    piece.vertices = std::move(part_surface.vertices);

    const bool crossing = std::any_of(job_.diagnosis.pairs.begin(), job_.diagnosis.pairs.end(),
                                      [&](const FacePair& p) { return is_in(p.first) && is_in(p.second); });
    if (single && !crossing) {
      Result<PlainMesh> plain = mesh_plain(s, job_.context);
      if (!plain && plain.error().code != ErrorCode::unsolved) return plain.error();
      if (plain) {
        piece.mesh = std::move(plain.value().draft.mesh);
        piece.placed = plain.value().draft.placed;
        return piece;
      }
    }
    DiagnoseOptions options;
    options.full_winding_range = false;
    Result<Diagnosis> d = diagnose(s, options, job_.context);
    if (!d) return d.error();
    if (auto refused = refuse(d.value())) return *refused;
    Result<ImmersionResult> r = immerse(s, d.value().pairs, d.value().wound.edges, {}, job_.context);
    if (r) {
      ++immersed_;
      piece.placed = r.value().free_points;
      piece.mesh = std::move(r.value().mesh);
      return piece;
    }
    if (ends_run(r.error()) || group.size() > 1) return r.error();
    std::vector<StageRecord> records;  // of this stage, which has one record
    Result<TetMesh> nearby = mesh_by_nearby_surface({s, job_.box, d.value(), job_.context, records});
    if (!nearby) return ends_run(nearby.error()) ? nearby.error() : r.error();
    ++nearby_;
    piece.mesh = std::move(nearby).value();
    return piece;
  }

  const MeshingJob& job_;
  std::vector<Piece> done_;
  std::int64_t immersed_ = 0, nearby_ = 0;
};

Result<PlainMesh> mesh_directly(const Surface& surface, const RunContext& context) {
  Plc plc;
  plc.V = surface.V;
  plc.F = surface.F;
  TetgenOptions options;
  options.quality = worth_refining(surface.V, surface.F);
  // What it does not fill like this, the immersion route, which may cut the surface's edges on the way, does
  // better.
  options.patience = kShortPatience;
  options.free_points = true;
  Result<TetgenResult> tets = tetrahedralize_stubbornly(plc, options, context);
  if (!tets) return tets.error();
  TetgenResult& t = tets.value();
  PlainMesh out;
  out.draft.mesh.V = std::move(t.V);
  out.draft.mesh.T = std::move(t.T);
  out.draft.mesh.surface_vertices = static_cast<Index>(surface.V.rows());
  out.draft.placed = t.free_points;
  out.missing_facets = t.missing_facets;
  out.tetgen_facets = t.tetgen_facets;
  out.tetgen_parts = t.parts;
  return out;
}

// Where needles lie in flat areas. Errors: unsolved also where there is none.
Result<PlainMesh> mesh_under_roofs(const Surface& surface, const RunContext& context) {
  const Result<std::vector<StarArea>> areas = find_star_areas(surface, context);
  if (!areas) return areas.error();
  if (areas.value().empty()) return Error{ErrorCode::unsolved, "No needles lie in flat areas."};
  Result<RoofedSurface> roofed = raise_roofs(surface, areas.value(), context);
  if (!roofed) return roofed.error();
  RoofedSurface& r = roofed.value();
  context.note(LogLevel::debug, "Roofs over " + std::to_string(r.hubs.rows()) + " of " +
                                    std::to_string(areas.value().size()) + " flat areas of needles.");
  if (r.hubs.rows() == 0) return Error{ErrorCode::unsolved, "No roof can be raised over the needles."};
  Result<PlainMesh> below = mesh_directly(r.surface, context);
  if (!below) return below.error();
  // First the surface's vertices, then free points, then those of roofs, hubs, and TetGen's own.
  const TetMesh inner = std::move(below.value().draft.mesh);
  const auto n = static_cast<Index>(surface.V.rows()), kept = static_cast<Index>(r.vertex.size());
  const Index hubs = static_cast<Index>(r.hubs.rows()), free = below.value().draft.placed,
              own = static_cast<Index>(inner.V.rows()) - inner.surface_vertices - free;
  const Index begin_roofs = n + free, begin_hubs = begin_roofs + r.roof_vertices,
              begin_own = begin_hubs + hubs;
  TetMesh& out = below.value().draft.mesh;
  out = {};
  out.surface_vertices = n;
  out.V.resize(begin_own + own, 3);
  out.V << surface.V, inner.V.middleRows(inner.surface_vertices, free),
      inner.V.middleRows(kept, r.roof_vertices), r.hubs, inner.V.bottomRows(own);
  const auto number_inside = [&](Index v) {
    if (v < kept) return r.vertex[v];
    if (v < inner.surface_vertices) return begin_roofs + v - kept;
    const Index i = v - inner.surface_vertices;
    return i < free ? n + i : begin_own + i - free;
  };
  const auto number_of_slab = [&](Index v) { return v < n ? v : v + free; };
  out.T.resize(inner.T.rows() + r.slabs.rows(), 4);
  for (Eigen::Index t = 0; t < inner.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) out.T(t, k) = number_inside(inner.T(t, k));
  for (Eigen::Index t = 0; t < r.slabs.rows(); ++t)
    for (int k = 0; k < 4; ++k) out.T(inner.T.rows() + t, k) = number_of_slab(r.slabs(t, k));
  return below;
}

}  // namespace

bool is_plain(const Diagnosis& d) {
  return d.complete() && d.pairs.empty() && d.winding.min == 0 && d.winding.max == 1 &&
         std::all_of(d.component_volume.begin(), d.component_volume.end(), [](double v) { return v > 0; });
}

Result<PlainMesh> mesh_plain(const Surface& surface, const RunContext& context) {
  {
    Result<PlainMesh> roofed = mesh_under_roofs(surface, context);
    if (roofed || roofed.error().code != ErrorCode::unsolved) return roofed;
  }
  return mesh_directly(surface, context);
}

std::vector<SubSurface> parts_of(const Surface& surface, const Diagnosis& d) {
  std::vector<SubSurface> out;
  const std::vector<Part> parts = find_parts(surface, d);
  if (parts.size() < 2) return out;
  const SurfaceTopology& topology = d.topology.topology;
  for (const Part& part : parts)
    out.push_back(sub_surface(surface, topology, flags(topology, part.components)));
  return out;
}

Draft united(const VertexMatrix& V, const std::vector<PartMesh>& parts) {
  Draft draft;
  TetMesh& out = draft.mesh;
  out.surface_vertices = static_cast<Index>(V.rows());
  Eigen::Index vertices = out.surface_vertices, tets = 0;
  for (const PartMesh& p : parts) {
    vertices += p.mesh.V.rows() - static_cast<Eigen::Index>(p.vertices.size());
    tets += p.mesh.T.rows();
    draft.placed += p.placed;
  }
  out.V.resize(vertices, 3);
  out.T.resize(tets, 4);
  out.V.topRows(out.surface_vertices) = V;
  Index next_placed = out.surface_vertices, next_other = next_placed + draft.placed;
  Eigen::Index next_tet = 0;
  for (const PartMesh& p : parts) {
    const Index own = static_cast<Index>(p.vertices.size()), begin_others = own + p.placed,
                others = static_cast<Index>(p.mesh.V.rows()) - begin_others;
    out.V.middleRows(next_placed, p.placed) = p.mesh.V.middleRows(own, p.placed);
    out.V.middleRows(next_other, others) = p.mesh.V.bottomRows(others);
    for (Eigen::Index t = 0; t < p.mesh.T.rows(); ++t, ++next_tet)
      for (int k = 0; k < 4; ++k) {
        const Index v = p.mesh.T(t, k);
        out.T(next_tet, k) = v < own            ? p.vertices[v]
                             : v < begin_others ? next_placed + v - own
                                                : next_other + v - begin_others;
      }
    next_placed += p.placed;
    next_other += others;
  }
  return draft;
}

bool has_parts(const Surface& surface, const Diagnosis& d) {
  const std::vector<Part> parts = find_parts(surface, d);
  for (std::size_t i = 0; i < parts.size(); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (parts[i].box.meets(parts[j].box)) return true;
  return false;
}

Result<Draft> mesh_by_parts(const MeshingJob& job) {
  OVERTET_EXPECTS(has_parts(job.surface, job.diagnosis));
  return timed_stage("parts", job.records, job.context,
                     [&](StageRecord& record) { return PartsMesher(job).run(record); });
}

}  // namespace overtet
