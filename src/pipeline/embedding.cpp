#include "src/pipeline/embedding.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <string>
#include <utility>

#include "kernels/bvh/self_intersections.h"
#include "kernels/core/box.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/parallel.h"
#include "src/forward_flow/forward_flow.h"
#include "src/mesh/topology.h"
#include "src/pipeline/flow_stages.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/unit_box.h"
#include "src/reverse_flow/reverse_flow.h"
#include "src/run/run_monitor.h"

namespace overtet {

namespace {

// Of what is sorted.
RatioRange range_of(std::vector<double> x) {
  if (x.empty()) return {};
  std::sort(x.begin(), x.end());
  const auto at = [&](double share) {
    return x[static_cast<std::size_t>(share * static_cast<double>(x.size() - 1))];
  };
  return {x.front(), at(0.01), at(0.5), at(0.99), x.back()};
}

EmbeddingQuality quality_of(const VertexMatrix& U, const Surface& rest) {
  std::vector<double> area, edge;
  std::int64_t within = 0;
  for (Index f = 0; f < rest.F.rows(); ++f) {
    const auto double_area = [&](const VertexMatrix& X) {
      const Eigen::RowVector3d a = X.row(rest.F(f, 0));
      return (X.row(rest.F(f, 1)) - a).cross(X.row(rest.F(f, 2)) - a).norm();
    };
    area.push_back(double_area(U) / double_area(rest.V));
    within += area.back() >= 0.8 && area.back() <= 1.2;
    for (int k = 0; k < 3; ++k) {
      const Index a = rest.F(f, k), b = rest.F(f, (k + 1) % 3);
      if (a < b) edge.push_back((U.row(a) - U.row(b)).norm() / (rest.V.row(a) - rest.V.row(b)).norm());
    }
  }
  EmbeddingQuality q;
  q.area_within_20 = static_cast<double>(within) / static_cast<double>(std::max<std::size_t>(area.size(), 1));
  q.area = range_of(std::move(area));
  q.edge = range_of(std::move(edge));
  q.collapsed = q.area.p01 < ReverseFlowOptions().locked_area_p01;
  return q;
}

// Components that cross others, all of a group but the largest one.
std::vector<Index> to_lay_aside(const Surface& s, const SurfaceTopology& topology,
                                const std::vector<FacePair>& pairs) {
  const std::size_t n = topology.components.size();
  UnionFind groups(n);
  bool any = false;
  for (const auto& [f, g] : pairs)
    any = groups.join_smaller(topology.component_of_face[f], topology.component_of_face[g]) || any;
  if (!any) return {};
  std::vector<double> area(n, 0);
  for (Index f = 0; f < s.F.rows(); ++f) {
    const Eigen::RowVector3d a = s.V.row(s.F(f, 0));
    area[topology.component_of_face[f]] += (s.V.row(s.F(f, 1)) - a).cross(s.V.row(s.F(f, 2)) - a).norm();
  }
  std::vector<Index> largest(n, -1), out;
  for (std::size_t c = 0; c < n; ++c)
    if (Index& best = largest[groups.root(static_cast<Index>(c))]; best < 0 || area[c] > area[best])
      best = static_cast<Index>(c);
  for (std::size_t c = 0; c < n; ++c)
    if (largest[groups.root(static_cast<Index>(c))] != static_cast<Index>(c))
      out.push_back(static_cast<Index>(c));
  return out;
}

// Moves components into the cells of a square grid beside everything. V: of s, changed.
void lay_aside(const Surface& s, const SurfaceTopology& topology, const std::vector<Index>& components,
               double gap, VertexMatrix& V) {
  const Eigen::RowVector3d high = s.V.colwise().maxCoeff(), low = s.V.colwise().minCoeff();
  gap *= diagonal_of(s.V);
  std::vector<Index> number(topology.components.size(), -1);
  for (std::size_t i = 0; i < components.size(); ++i) number[components[i]] = static_cast<Index>(i);
  std::vector<Index> of_vertex(static_cast<std::size_t>(s.V.rows()), -1);
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) of_vertex[s.F(f, k)] = number[topology.component_of_face[f]];
  std::vector<Eigen::RowVector3d> corner(components.size(), high);
  Eigen::RowVector3d cell = Eigen::RowVector3d::Zero();
  for (Index v = 0; v < s.V.rows(); ++v)
    if (of_vertex[v] >= 0) corner[of_vertex[v]] = corner[of_vertex[v]].cwiseMin(s.V.row(v));
  for (Index v = 0; v < s.V.rows(); ++v)
    if (of_vertex[v] >= 0) cell = cell.cwiseMax(s.V.row(v) - corner[of_vertex[v]]);
  const auto columns = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(components.size()))));
  for (Index v = 0; v < s.V.rows(); ++v) {
    if (of_vertex[v] < 0) continue;
    const auto i = static_cast<std::size_t>(of_vertex[v]);
    const Eigen::RowVector3d place(high[0] + gap + static_cast<double>(i % columns) * (cell[0] + gap),
                                   low[1] + static_cast<double>(i / columns) * (cell[1] + gap), low[2]);
    V.row(v) += place - corner[i];
  }
}

Status check_shape_for_embedding(const Surface& s, Report& report, SurfaceTopology& topology) {
  report.input.vertices = s.V.rows();
  report.input.faces = s.F.rows();
  Result<SurfaceTopology> found = require_topology(s);
  if (!found) return found.error();
  topology = std::move(found).value();
  report.input.components = static_cast<std::int64_t>(topology.components.size());
  for (const SurfaceComponent& c : topology.components) report.input.genus.push_back(c.genus);
  if (const std::vector<Index> flat = degenerate_faces(s); !flat.empty()) {
    Error error{ErrorCode::bad_input, "Face " + std::to_string(flat[0]) +
                                          " has no area, so it has no shape to keep; move a corner of it, or "
                                          "collapse its shortest edge."};
    error.face = flat[0];
    return error;
  }
  return success();
}

// A unit box that keeps the metric: all axes are scaled alike. Errors: unsolved where that would lose bits.
Result<UnitBox> into_uniform_box(VertexMatrix& V) {
  int exponent = 0;
  std::frexp(V.cwiseAbs().maxCoeff(), &exponent);
  UnitBox box;
  box.exponent.fill(-exponent);
  VertexMatrix scaled = V;
  back_into_unit_box(scaled, box);
  VertexMatrix again = scaled;
  out_of_unit_box(again, box);
  if (again != V)
    return Error{
        ErrorCode::unsolved,
        "A coordinate is so much smaller than the model that scaling the model would lose bits; set it to "
        "zero."};
  V = std::move(scaled);
  return box;
}

// Both flows with one setting after the other, until nothing stays collapsed; the best of them.
Result<VertexMatrix> best_flow(const MeshingJob& job) {
  const std::vector<ForwardFlowOptions> forward_ladder = forward_flow_ladder();
  const std::vector<ReverseFlowOptions> reverse_ladder = reverse_flow_ladder();
  std::optional<ReverseFlowResult> best;
  Error last{ErrorCode::unsolved, "No flow was tried."};
  for (std::size_t rung = 0; rung < std::min(forward_ladder.size(), reverse_ladder.size()); ++rung) {
    Result<ForwardFlowResult> forward = flow_forward(job, forward_ladder[rung]);
    if (!forward) {
      if (ends_run(forward.error())) return forward.error();
      last = {ErrorCode::unsolved, "No embedding was found: " + forward.error().message,
              forward.error().place};
      continue;
    }
    Result<ReverseFlowResult> back = flow_back(job, forward.value(), reverse_ladder[rung]);
    if (!back) {
      if (ends_run(back.error())) return back.error();
      last = {ErrorCode::unsolved, "No embedding was found: " + back.error().message, back.error().place};
      continue;
    }
    if (!best || back.value().quality.area_p01 > best->quality.area_p01) best = std::move(back).value();
    if (!best->locked) break;
  }
  if (!best) return last;
  return std::move(best->U0);
}

void note_moves(const VertexMatrix& before, const Embedding& e, Report& report) {
  report.moved_vertices = static_cast<std::int64_t>(e.moved.size());
  report.moved_ids.assign(e.moved.begin(), e.moved.end());
  const double diagonal = diagonal_of(before);
  double sum = 0;
  for (const Index v : e.moved) {
    const double move = (e.surface.V.row(v) - before.row(v)).norm() / diagonal;
    sum += move;
    report.max_relative_move = std::max(report.max_relative_move, move);
  }
  if (!e.moved.empty()) report.mean_relative_move = sum / static_cast<double>(e.moved.size());
}

Result<Embedding> embedded(const Surface& surface, const EmbedOptions& options, const RunContext& context,
                           Report& report) {
  Embedding out{surface, {}, {}, {}};
  SurfaceTopology topology;
  Surface start = surface;
  std::vector<FacePair> pairs;
  const Status looked = timed_stage("look", report.stages, context, [&](StageRecord& record) -> Status {
    if (Status s = check_shape_for_embedding(surface, report, topology); !s) return s;
    pairs = find_self_intersections(surface.V, surface.F);
    report.input.pairs = static_cast<std::int64_t>(pairs.size());
    record.figures = {{"pairs", report.input.pairs}};
    out.laid_aside = to_lay_aside(surface, topology, pairs);
    if (!out.laid_aside.empty()) {
      lay_aside(surface, topology, out.laid_aside, options.gap, start.V);
      pairs = find_self_intersections(start.V, start.F);
    }
    record.figures.emplace_back("laid_aside", static_cast<std::int64_t>(out.laid_aside.size()));
    return context.stop() ? Status(*context.stop()) : success();
  });
  if (!looked) return looked.error();
  out.surface.V = start.V;
  if (!pairs.empty()) {
    Result<UnitBox> box = into_uniform_box(start.V);
    if (!box) return box.error();
    Diagnosis known;
    known.pairs = pairs;
    Result<VertexMatrix> U0 = best_flow({start, box.value(), known, context, report.stages});
    if (!U0) {
      Error e = U0.error();
      e.place.reset();  // of another space
      return e;
    }
    out.surface.V = std::move(U0).value();
    out_of_unit_box(out.surface.V, box.value());
  }
  const Status right = timed_stage("check", report.stages, context, [&](StageRecord&) -> Status {
    const std::size_t left = find_self_intersections(out.surface.V, out.surface.F).size();
    if (!out.surface.V.allFinite() || left > 0)
      return Error{ErrorCode::unsolved, "No embedding was found: by rounding to the input's coordinates " +
                                            std::to_string(left) + " pairs of faces intersect again."};
    return success();
  });
  if (!right) return right.error();
  for (Index v = 0; v < surface.V.rows(); ++v)
    if (out.surface.V.row(v) != surface.V.row(v)) out.moved.push_back(v);
  out.quality = quality_of(out.surface.V, surface);
  report.status = RunStatus::embedded;
  report.embedding = out.quality;
  report.laid_aside = static_cast<std::int64_t>(out.laid_aside.size());
  note_moves(surface.V, out, report);
  return out;
}

}  // namespace

Status EmbedOptions::validate() const {
  if (!(gap > 0 && gap <= 10))
    return Error{ErrorCode::usage, "The gap must be more than 0 and at most 10 diagonals."};
  return success();
}

Result<Embedding> embed_surface(const Surface& surface, const EmbedOptions& options, const RunContext& outer,
                                Report& report) {
  const auto start = RunContext::Clock::now();
  Result<Embedding> out = Error{};
  if (Status valid = options.validate(); !valid) {
    out = valid.error();
  } else {
    RunMonitor watch(outer);
    const ScopedThreads threads(outer.threads);
    try {
      out = embedded(surface, options, watch.context(), report);
      if (!out) out = watch.explained(out.error());
    } catch (...) {
      out = watch.explained(error_of_exception());
    }
    report.peak_rss_bytes = watch.peak_bytes();
  }
  if (!out) report.status = status_of(out.error().code), report.message = out.error().message;
  report.seconds = std::chrono::duration<double>(RunContext::Clock::now() - start).count();
  return out;
}

}  // namespace overtet
