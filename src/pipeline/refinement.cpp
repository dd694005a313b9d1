#include "src/pipeline/refinement.h"

#include <algorithm>
#include <iterator>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <tuple>
#include <utility>
#include <variant>

#include "overtet/verification.h"
#include "src/covering/covered_network.h"
#include "src/exact/ordinary_size.h"
#include "src/mesh/subdivision.h"
#include "src/pipeline/coarsening.h"
#include "src/pipeline/finishing.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/surface_run.h"
#include "src/pipeline/tuning.h"

namespace overtet {

namespace {

// With any size at the vertices that were added.
TetSizes sizes_of(const Surface& refined, TetSizes sizes) {
  if (!sizes.at_vertex.empty())
    sizes.at_vertex.resize(refined.V.rows(), std::numeric_limits<double>::infinity());
  return sizes;
}

using Link = CoveredNetwork::Link;

// Looks for a subdivision that has a mesh.
class SubdivisionSearch {
 public:
  SubdivisionSearch(const Surface& surface, const Diagnosis& diagnosis, const CoveredNetwork& network,
                    const MeshingOptions& options, const RunContext& context)
      : surface_(surface),
        diagnosis_(diagnosis),
        topology_(diagnosis.topology.topology),
        network_(network),
        options_(options),
        context_(context) {
    options_.on_infeasible = OnInfeasible::reject;
    options_.improve_degrees = 0;
    options_.sizes = {};
  }

  // None: not found. why: of the surface as it is. The records of the attempt that led to it are kept.
  Result<std::optional<MeshedSubdivision>> run(const Error& why, std::vector<StageRecord>& records,
                                               StageRecord& record) {
    for (const Hinge& h : diagnosis_.hinges)
      if (h.B0 && *h.B0 % 2 != 0) odd_.push_back(h.vertex);
    const std::vector<Link> ways = links_between(surface_, network_, odd_);
    if (why.certificate) find_spots(*why.certificate, nullptr);
    if (why.place) spot_near(Eigen::Vector3d((*why.place)[0], (*why.place)[1], (*why.place)[2]));
    bool zone = ways.empty();
    for (int round = 0; round < kRounds; ++round) {
      if (auto stop = context_.stop()) return *stop;
      // Links pulled tight may cross others.
      std::vector<Link> links = zone ? ways : pulled_tight(surface_, topology_, network_, ways);
      if (zone && !add_zone(links)) break;
      ++record.iterations;
      Result<std::optional<MeshedSubdivision>> made = attempt(links, records);
      if (!made) return made;
      if (made.value()) return zone ? with_fewer(std::move(*made.value()), links, records, record) : made;
      zone = true;
    }
    return std::optional<MeshedSubdivision>();
  }

 private:
  // All links around the spots; those met again are looked at further around. False: nothing new.
  bool add_zone(std::vector<Link>& links) {
    if (spots_.empty())
      for (const Hinge& h : diagnosis_.hinges) spots_.emplace(h.vertex, 1);
    std::set<Index> faces;
    for (const auto& [v, rings] : spots_) {
      std::set<Index> near{v};
      for (int r = 0; r < rings; ++r) {
        std::set<Index> next;
        for (const Index u : near)
          for (const Index h : half_edges_around(topology_, u)) {
            faces.insert(h / 3);
            next.insert(half_edge_target(surface_.F, h));
          }
        near.insert(next.begin(), next.end());
      }
    }
    for (const Link& l : network_.links)
      if (l.face >= 0 && faces.count(l.face)) links.push_back(l);
    for (auto& [v, rings] : spots_) rings *= 2;
    const bool grown = links.size() > tried_;
    tried_ = links.size();
    return grown;
  }

  void spot(Index v) {
    if (v >= 0 && v < static_cast<Index>(surface_.V.rows())) spots_.emplace(v, 1);
  }
  void spot_near(const Eigen::Vector3d& place) {
    Index nearest = -1;
    (surface_.V.rowwise() - place.transpose()).rowwise().squaredNorm().minCoeff(&nearest);
    spot(nearest);
  }

  // Where a certificate says that there is none. cut: it is of this subdivision; null: of the surface.
  void find_spots(const Certificate& certificate, const MeshedSubdivision* cut) {
    const auto add_face = [&](Index f) {
      for (const Index v : surface_.F.row(cut ? cut->cut.face[f] : f)) spot(v);
    };
    const auto add = [&](Index v) {
      const Index n = static_cast<Index>(surface_.V.rows());
      if (v < n)
        spot(v);
      else if (cut)
        for (const Index u : surface_.F.row(cut->points[static_cast<std::size_t>(v - n)].face)) spot(u);
    };
    for (const Index v : named_vertices(certificate)) add(v);
    std::visit(
        [&](const auto& c) {
          if constexpr (requires { c.crossings; })
            for (const auto& crossing : c.crossings)
              for (const Index f : crossing.faces) add_face(f);
          if constexpr (requires { c.edges; })
            for (const auto& e : c.edges) add(e[0]), add(e[1]);
        },
        certificate);
  }

  // The same with only those links that were wound, and fewer nodes on them, where that has a mesh, too.
  Result<std::optional<MeshedSubdivision>> with_fewer(MeshedSubdivision made, const std::vector<Link>& links,
                                                      std::vector<StageRecord>& records,
                                                      StageRecord& record) {
    const Index n = static_cast<Index>(surface_.V.rows());
    const std::vector<Index> nodes = additions(surface_, network_, links).nodes;
    std::set<std::pair<Index, Index>> wound;
    for (const auto& [a, b] : wound_edges(made)) {
      const auto node = [&](Index v) { return v < n ? v : nodes[static_cast<std::size_t>(v - n)]; };
      wound.insert(std::minmax({node(a), node(b)}));
    }
    std::vector<Link> used;
    for (const Link& l : links)
      if (wound.count(std::minmax({l.a, l.b}))) used.push_back(l);
    const std::vector<Link> tight = pulled_tight(surface_, topology_, network_, used);
    const std::vector<Link> open = without_loops(surface_, tight);
    for (const std::vector<Link>* few : {&open, &tight}) {
      if (few->size() >= used.size() || (few == &tight && open.size() == tight.size())) continue;
      ++record.iterations;
      std::vector<StageRecord> own;
      Result<std::optional<MeshedSubdivision>> fewer = attempt(*few, own);
      if (!fewer) return fewer;
      if (!fewer.value()) continue;
      records = std::move(own);
      return fewer;
    }
    return std::optional(std::move(made));
  }

  Result<std::optional<MeshedSubdivision>> attempt(const std::vector<Link>& links,
                                                   std::vector<StageRecord>& records) {
    MeshedSubdivision made;
    Additions added = additions(surface_, network_, links);
    made.points = std::move(added.points);
    Result<Subdivision> cut = subdivide(surface_, topology_, made.points, added.edges);
    if (!cut) {
      context_.note(LogLevel::info, "Subdivision: " + cut.error().message);
      return std::optional<MeshedSubdivision>();
    }
    made.cut = std::move(cut).value();
    context_.note(LogLevel::info,
                  "Subdivision: " + std::to_string(made.cut.pieced.size()) + " faces subdivided.");
    std::vector<StageRecord> own;
    SurfaceRun run(made.cut.surface, {SurfaceRunSetup::Origin::refined}, options_, context_, own);
    Result<TetMesh> mesh = run.go();
    if (mesh) {
      made.mesh = std::move(mesh).value();
      std::move(own.begin(), own.end(), std::back_inserter(records));
      return std::optional(std::move(made));
    }
    const ErrorCode code = mesh.error().code;
    if (code != ErrorCode::infeasible && code != ErrorCode::unsolved && code != ErrorCode::bad_input)
      return mesh.error();
    context_.note(LogLevel::info, "Subdivision: " + mesh.error().message);
    if (run.certificate()) find_spots(*run.certificate(), &made);
    if (run.unglued()) spot_near(*run.unglued());
    return std::optional<MeshedSubdivision>();
  }

  const Surface& surface_;
  const Diagnosis& diagnosis_;
  const SurfaceTopology& topology_;
  const CoveredNetwork& network_;
  MeshingOptions options_;
  const RunContext& context_;
  std::vector<Index> odd_;
  std::map<Index, int> spots_;  // vertices, and how many rings around them
  std::size_t tried_ = 0;       // links
};

RefinedSurface shape_of(Subdivision cut) {
  return {std::move(cut.surface), std::move(cut.face), std::move(cut.pieced)};
}

Error not_found(const Error& why, const std::string& what) {
  Error e = why;
  e.message += " " + what;
  return e;
}

// The subdivision that has a mesh. Errors: as of mesh_refined.
Result<MeshedSubdivision> find_subdivision(const Surface& surface, const Diagnosis& diagnosis,
                                           const Error& why, const MeshingOptions& options,
                                           const RunContext& context, std::vector<StageRecord>& records) {
  std::vector<StageRecord> own;
  Result<MeshedSubdivision> found =
      timed_stage("subdivision", records, context, [&](StageRecord& record) -> Result<MeshedSubdivision> {
        const OrdinarySize sized(surface, *diagnosis.bvh);
        Result<CoveredNetwork> network = find_covered_network(sized.surface(), diagnosis.topology.topology,
                                                              sized.bvh(), *diagnosis.graph, context);
        if (!network) return network.error();
        if (!network.value().problem.empty())
          return not_found(why, "Subdividing faces could not be tried: " + network.value().problem + ".");
        Result<std::optional<MeshedSubdivision>> made =
            SubdivisionSearch(surface, diagnosis, network.value(), options, context).run(why, own, record);
        if (!made) return made.error();
        if (!made.value())
          return not_found(why,
                           "Subdividing faces, along all covered ways near there, did not lead to a mesh; "
                           "that there is none with other branch lines is not proved.");
        record.figures = {{"added_vertices", static_cast<std::int64_t>(made.value()->points.size())},
                          {"subdivided", static_cast<std::int64_t>(made.value()->cut.pieced.size())}};
        return std::move(*made.value());
      });
  std::move(own.begin(), own.end(), std::back_inserter(records));
  return found;
}

// Into the unit box, which the mesh was made in, or out of it: both are exact.
void scale(MeshedSubdivision& made, const UnitBox& box, void (*how)(VertexMatrix&, const UnitBox&)) {
  how(made.mesh.V, box);
  how(made.cut.surface.V, box);
}

}  // namespace

bool refinable(const Error& why, const Diagnosis& d) {
  if (why.code != ErrorCode::infeasible && why.code != ErrorCode::unsolved) return false;
  if (!d.graph || d.winding.min < 0) return false;
  if (std::any_of(d.hinges.begin(), d.hinges.end(), [](const Hinge& h) { return h.B0 && *h.B0 < 0; }))
    return false;
  return !why.certificate || !forbids_branch_lines(*why.certificate);
}

Result<RefinedMesh> mesh_refined(const Surface& surface, const Diagnosis& diagnosis, const Error& why,
                                 const MeshingOptions& options, const RunContext& context,
                                 std::vector<StageRecord>& records) {
  const bool branch = options.on_infeasible == OnInfeasible::branch;
  Result<MeshedSubdivision> found = find_subdivision(surface, diagnosis, why, options, context, records);
  if (!found) return found.error();
  MeshedSubdivision& made = found.value();
  Surface input = surface;
  Result<UnitBox> box = into_unit_box(input.V);
  if (!box) return box.error();
  scale(made, box.value(), back_into_unit_box);
  const Status dropped = timed_stage("coarsening", records, context, [&](StageRecord& record) -> Status {
    if (Status s = drop_needless(input, diagnosis.topology.topology, made, context); !s) return s;
    record.figures = {{"added_vertices", static_cast<std::int64_t>(made.points.size())},
                      {"subdivided", static_cast<std::int64_t>(made.cut.pieced.size())}};
    if (!branch) return success();
    const Result<bool> all = drop_all(input, diagnosis.topology.topology, made, context);
    if (!all) return all.error();
    if (!all.value())
      return not_found(why, "A mesh of the surface with " + std::to_string(made.cut.pieced.size()) +
                                " faces subdivided was found, but the added vertices could not be moved "
                                "inside.");
    return success();
  });
  if (!dropped) return dropped.error();
  TetMesh mesh = std::move(made.mesh);
  if (!branch) out_of_unit_box(made.cut.surface.V, box.value());
  const Surface& of = branch ? surface : made.cut.surface;
  Result<TetMesh> finished = finish({.input = of,
                                     .improve_degrees = options.improve_degrees,
                                     .context = context,
                                     .records = records,
                                     .sizes = sizes_of(of, options.sizes),
                                     .allow_branches = branch},
                                    box.value(), std::move(mesh));
  if (!finished) return finished.error();
  RefinedMesh out{{}, std::move(finished).value(), {}};
  if (!branch) {
    if (!made.cut.pieced.empty()) out.shape = shape_of(std::move(made.cut));
    return out;
  }
  VerifyOptions lines;
  lines.allow_branches = true;
  out.branch_edges = verify(surface, out.mesh, lines, context).branch_edges;
  return out;
}

}  // namespace overtet
