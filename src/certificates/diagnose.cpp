#include "src/certificates/diagnose.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <chrono>
#include <cstdio>

#include "src/arrangement/intersection_graph.h"
#include "src/certificates/separated.h"
#include "src/exact/exact.h"
#include "src/exact/ordinary_size.h"

namespace overtet {

namespace {

constexpr double kCheckableOpening = 1e-9;  // radians; see Hinge::opening

class Stopwatch {
 public:
  explicit Stopwatch(double& into) : into_(into), start_(std::chrono::steady_clock::now()) {}
  ~Stopwatch() { into_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  double& into_;
  std::chrono::steady_clock::time_point start_;
};

std::string number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

std::string count(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

// From the copy of ordinary size to the surface.
void take_back(const Surface& surface, const OrdinarySize& sized, Diagnosis& d) {
  for (double& volume : d.component_volume) volume = sized.back(volume, 3);
  if (d.winding.witness) {
    WindingWitness& w = *d.winding.witness;
    w.point = sized.back(w.point);
    w.exact = sized.back(w.exact);
    // Far from 1 it may be no doubles any more.
    for (std::size_t k = 0; k < 3; ++k)
      w.doubles_suffice = w.doubles_suffice && exact::fraction(exact::Rational(w.point[k])) == w.exact[k];
  }
  if (d.stack) {
    d.stack->point = sized.back(d.stack->point);
    d.stack->exact = sized.back(d.stack->exact);
  }
  auto bvh = std::make_shared<TriangleBvh>();
  bvh->build(surface.V, surface.F);
  d.bvh = bvh;
}

void count_shared(const Surface& surface, Diagnosis& d) {
  for (const auto& [f, g] : d.pairs) {
    int shared = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) shared += surface.F(f, i) == surface.F(g, j);
    d.pairs_sharing_vertex += shared == 1;
    d.pairs_sharing_edge += shared == 2;
  }
}

// The vertex with B0 < 0 that is easiest to check: the one farthest from a fold, where rounded angles give
// the same integer.
void find_vertex_witness(Diagnosis& d) {
  double opening = kCheckableOpening;
  for (const Hinge& h : d.hinges) {
    if (!h.B0 || *h.B0 >= 0) continue;
    if (h.opening > opening) {
      opening = h.opening;
      d.vertex_witness = VertexWitness{h.vertex, *h.B0};
    } else if (h.opening <= kCheckableOpening) {
      d.fold_witness = VertexWitness{h.vertex, *h.B0};
    }
  }
}

// The verdict of a surface whose topology and faces are fine.
void decide(Diagnosis& d) {
  if (d.winding.witness) {
    const WindingWitness& w = *d.winding.witness;
    d.verdict = Verdict::infeasible;
    d.message = "No positive mesh exists: the winding number at (" + number(w.point[0]) + ", " +
                number(w.point[1]) + ", " + number(w.point[2]) + ") is " + std::to_string(w.winding) +
                ", and positive tets only ever add winding.";
    return;
  }
  if (d.winding.min < 0) {
    d.verdict = Verdict::infeasible;
    d.message =
        "No positive mesh exists: the winding number is negative somewhere, but no point could be named.";
  }
  if (d.vertex_witness) {
    d.verdict = Verdict::infeasible;
    d.message = "No positive mesh exists: at vertex " + std::to_string(d.vertex_witness->vertex) +
                " the integer B0 is " + std::to_string(d.vertex_witness->B0) +
                ", and no positive tets fill the space around such a vertex.";
    return;
  }
  if (d.verdict == Verdict::infeasible) return;
  if (d.fold_witness) {
    d.verdict = Verdict::obstructed;
    d.message = "No positive mesh exists: at vertex " + std::to_string(d.fold_witness->vertex) +
                " two faces lie flat on each other (or as good as), with no room for a tet between them.";
    return;
  }
  if (d.stack) {
    const StackWitness& w = *d.stack;
    d.verdict = Verdict::obstructed;
    d.message = "No positive mesh exists: at (" + number(w.point[0]) + ", " + number(w.point[1]) + ", " +
                number(w.point[2]) + ") face " + std::to_string(w.face) +
                " and others lie on each other so that moves of their vertices, however small, turn what is "
                "between them inside out.";
    return;
  }
  if (d.wound.forbidden()) {
    d.verdict = Verdict::obstructed;
    d.message = d.wound.explanation;
    return;
  }
  if (d.pairs.empty()) {
    d.verdict = Verdict::embedded;
    d.message = "No two faces intersect.";
    return;
  }
  d.verdict = Verdict::feasible;
  d.message = count(d.pairs.size(), "pair of faces intersects", "pairs of faces intersect") +
              "; nothing forbids a mesh that overlaps itself there.";
}

void advise(Diagnosis& d) {
  const auto say = [&](std::string text) { d.advice.push_back(std::move(text)); };
  if (d.verdict == Verdict::bad_input) {
    for (const std::string& problem : d.topology.problems) say(problem);
    if (!d.degenerate_faces.empty())
      say("Move a corner of each face without area, or remove the face by collapsing its shortest edge.");
    return;
  }
  for (std::size_t c = 0; c < d.component_volume.size(); ++c)
    if (d.component_volume[c] < 0)
      say("Component " + std::to_string(c) + " (face " +
          std::to_string(d.topology.topology.components[c].first_face) +
          " is in it) faces inwards: right for a cavity inside another component, else reverse its faces.");
  if (d.verdict == Verdict::infeasible && d.winding.negative_pairs > 0)
    say("The surface is inside out in " + std::to_string(d.winding.negative_pairs) +
        " places where faces cross: one part pokes out through the far side of another, or a crease is "
        "turned "
        "inside out. Move it back until it stays inside.");
  if (d.verdict == Verdict::infeasible && d.winding.negative_pairs == 0 && d.winding.witness)
    say("A whole component faces inwards where nothing surrounds it: reverse its faces.");
  if (d.verdict == Verdict::infeasible && d.vertex_witness)
    say("Around vertex " + std::to_string(d.vertex_witness->vertex) +
        " the surface folds back on itself. Smooth its one-ring until its faces stop crossing.");
  if (d.wound.forbidden())
    say("The faces at these vertices cross each other, and no edge there can take the extra turn. Smooth the "
        "one-ring until its faces stop crossing, or split its edges where other faces cross them.");
  if (d.stack)
    say("Move the faces apart that lie on each other there; where a part was pressed flat, its folds have no "
        "thickness.");
  if (d.verdict == Verdict::feasible && !d.hinges.empty())
    say(count(d.hinges.size(), "vertex has", "vertices have") +
        " a one-ring that crosses itself (hinges): the hard case. Where it is an accident, smooth it.");
  if (d.verdict == Verdict::feasible && !d.wound.complete())
    say("No assignment of the extra turns was found at " + count(d.wound.unmet.size(), "hinge", "hinges") +
        "; a mesh is unlikely there.");
  if (d.pairs_sharing_edge > 0)
    say(count(d.pairs_sharing_edge, "pair of neighbouring faces lies", "pairs of neighbouring faces lie") +
        " flat on each other: open these folds a little.");
}

}  // namespace

const char* verdict_name(Verdict verdict) {
  switch (verdict) {
    case Verdict::bad_input:
      return "bad-input";
    case Verdict::embedded:
      return "embedded";
    case Verdict::feasible:
      return "feasible";
    case Verdict::infeasible:
      return "infeasible";
    case Verdict::obstructed:
      return "obstructed";
  }
  return "";
}

Result<Diagnosis> diagnose(const Surface& surface, const DiagnoseOptions& options,
                           const RunContext& context) {
  if (Status valid = options.validate(); !valid.ok()) return valid.error();
  const ScopedThreads threads(context.threads);
  Diagnosis d;
  d.vertices = static_cast<Index>(surface.V.rows());
  d.faces = static_cast<Index>(surface.F.rows());
  {
    const Stopwatch time(d.times.topology);
    d.topology = check_topology(surface);
    if (d.topology.indices_valid && d.topology.finite) d.degenerate_faces = degenerate_faces(surface);
  }
  if (!d.topology.ok() || !d.degenerate_faces.empty()) {
    if (!d.topology.ok()) {
      d.message = d.topology.problems.front();
    } else {
      const Index f = d.degenerate_faces.front();
      d.message =
          "Face " + std::to_string(f) + " (vertices " + std::to_string(surface.F(f, 0)) + ", " +
          std::to_string(surface.F(f, 1)) + ", " + std::to_string(surface.F(f, 2)) +
          ", counted from 0) has no area, and no tet of positive volume has such a face" +
          (d.degenerate_faces.size() > 1 ? "; there are " + std::to_string(d.degenerate_faces.size()) + "."
                                         : ".");
    }
    advise(d);
    return d;
  }
  if (auto stop = context.stop()) return *stop;
  context.report("diagnose", 0.1, "looking for faces that intersect");
  const OrdinarySize sized(surface);
  const Surface& own = sized.surface();
  const SurfaceTopology& topology = d.topology.topology;
  d.component_volume = component_volumes(own, topology);
  auto bvh = std::make_shared<TriangleBvh>();
  {
    const Stopwatch time(d.times.pairs);
    bvh->build(own.V, own.F);
    d.pairs = find_self_intersections(own.V, own.F, *bvh);
    d.bvh = bvh;
    count_shared(surface, d);
  }
  if (auto stop = context.stop()) return *stop;
  context.report("diagnose", 0.4, std::to_string(d.pairs.size()) + " pairs");
  {
    const Stopwatch time(d.times.hinges);
    d.hinges = find_hinges(own, topology, *bvh, d.pairs);
    find_vertex_witness(d);
  }
  context.report("diagnose", 0.5, std::to_string(d.hinges.size()) + " hinges");
  {
    const Stopwatch time(d.times.winding);
    WindingRangeOptions range;
    range.stop_at_first_negative = !options.full_winding_range;
    d.graph = std::make_shared<IntersectionGraph>(own, topology, *bvh, d.pairs);
    auto winding = find_winding_range(own, topology, *bvh, *d.graph, context, range);
    if (!winding.ok()) return winding.error();
    d.winding = std::move(winding).value();
  }
  {
    const Stopwatch time(d.times.wound_edges);
    d.pierced_edges = find_pierced_edges(own, topology, d.pairs);
    const bool open = !d.winding.witness && !d.vertex_witness && !d.fold_witness;
    if (open) {
      auto stack = find_stack_witness(own, *bvh, d.pairs, context);
      if (!stack.ok()) return stack.error();
      d.stack = std::move(stack).value();
    }
    if (options.wound_edges && open && !d.stack && !d.hinges.empty()) {
      auto wound = assign_wound_edges(own, topology, *bvh, d.hinges, d.pierced_edges, context);
      if (!wound.ok()) return wound.error();
      d.wound = std::move(wound).value();
      if (!d.wound.forbidden()) {
        auto apart = find_apart(own, topology, d.hinges, context);
        if (!apart.ok()) return apart.error();
        if (apart.value()) d.wound = std::move(*apart.value());
      }
    }
  }
  if (sized.scaled()) take_back(surface, sized, d);
  decide(d);
  advise(d);
  context.report("diagnose", 1, d.message);
  return d;
}

std::vector<double> component_volumes(const Surface& surface, const SurfaceTopology& topology) {
  std::vector<double> volume(topology.components.size(), 0);
  const Eigen::RowVector3d centre = surface.V.colwise().mean();
  for (Index f = 0; f < surface.F.rows(); ++f) {
    const Eigen::RowVector3d a = surface.V.row(surface.F(f, 0)) - centre,
                             b = surface.V.row(surface.F(f, 1)) - centre,
                             c = surface.V.row(surface.F(f, 2)) - centre;
    volume[topology.component_of_face[f]] += a.dot(b.cross(c)) / 6;
  }
  return volume;
}

std::optional<Error> refuse(const Diagnosis& d) {
  if (d.verdict == Verdict::bad_input) return Error{ErrorCode::bad_input, d.message};
  if (d.verdict == Verdict::infeasible || d.verdict == Verdict::obstructed)
    return Error{ErrorCode::infeasible, d.message};
  return std::nullopt;
}

}  // namespace overtet
