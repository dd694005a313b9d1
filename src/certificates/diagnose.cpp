#include "src/certificates/diagnose.h"

#include <memory>
#include <utility>

#include "kernels/parallel/parallel.h"
#include "src/arrangement/intersection_graph.h"
#include "src/certificates/separated.h"
#include "src/certificates/tuning.h"
#include "src/exact/ordinary_size.h"
#include "src/exact/rational.h"
#include "src/run/stopwatch.h"

namespace overtet {

namespace {

std::string count(std::size_t n, const char* one, const char* many) {
  return std::to_string(n) + " " + (n == 1 ? one : many);
}

// The first that objects of the rules that are wanted.
template <class Wanted>
Status try_rules(rules::Case& c, const std::vector<rules::Rule>& list, Wanted&& wanted, Diagnosis& d) {
  for (const rules::Rule& rule : list) {
    if (!wanted(rule)) continue;
    rules::Finding found = rule.find(c);
    if (!found.ok()) return found.error();
    if (!found.value()) continue;
    d.certificate.emplace(std::move(*found.value()));
    break;
  }
  return success();
}

// From the copy of ordinary size to the surface.
void take_back(const OrdinarySize& sized, Certificate& certificate) {
  std::visit(
      [&](auto& c) {
        if constexpr (requires { c.point; }) c.point = sized.back(c.point);
        if constexpr (requires { c.exact; }) c.exact = sized.back(c.exact);
        if constexpr (requires { c.position; }) c.position = sized.back(c.position);
        if constexpr (requires { c.positions; })
          for (auto& p : c.positions) p = sized.back(p);
        // Far from 1 it may be no doubles any more.
        if constexpr (requires { c.doubles_suffice; })
          for (std::size_t k = 0; k < 3; ++k)
            c.doubles_suffice =
                c.doubles_suffice && exact::fraction(exact::Rational(c.point[k])) == c.exact[k];
      },
      certificate);
}

void take_back(const Surface& surface, const OrdinarySize& sized, Diagnosis& d) {
  for (double& volume : d.component_volume) volume = sized.back(volume, 3);
  if (d.winding.witness) {
    Certificate witness = *d.winding.witness;
    take_back(sized, witness);
    d.winding.witness = std::get<WindingCertificate>(witness);
  }
  if (d.certificate) take_back(sized, *d.certificate);
  auto bvh = std::make_shared<TriangleBvh>();
  bvh->build(surface.V, surface.F);
  d.bvh = bvh;
}

void conclude(Diagnosis& d) {
  if (d.certificate) {
    d.verdict = Verdict::infeasible;
    d.message = explain(*d.certificate);
  } else if (d.winding.min < 0) {
    d.verdict = Verdict::infeasible;
    d.message =
        "No mesh exists: the winding number is negative somewhere, but Overtet could not name a point there.";
  } else if (d.pairs.empty()) {
    d.verdict = Verdict::embedded;
    d.message = "No two faces intersect.";
  } else {
    d.verdict = Verdict::feasible;
    d.message = count(d.pairs.size(), "pair of faces intersects", "pairs of faces intersect") +
                "; nothing found rules out a mesh that overlaps itself there.";
  }
}

template <class C>
bool holds(const Diagnosis& d) {
  return d.certificate && std::holds_alternative<C>(*d.certificate);
}

void advise(Diagnosis& d) {
  const auto say = [&](std::string text) { d.advice.push_back(std::move(text)); };
  if (d.verdict == Verdict::bad_input) {
    for (const std::string& problem : d.topology.problems) say(problem);
    return;
  }
  if (!d.degenerate_faces.empty())
    say("Move a corner of each face without area (" + std::to_string(d.degenerate_faces.size()) +
        " in all), or collapse the shortest edge of the face.");
  for (std::size_t c = 0; c < d.component_volume.size(); ++c)
    if (d.component_volume[c] < 0)
      say("Component " + std::to_string(c) + " (face " +
          std::to_string(d.topology.topology.components[c].first_face) +
          " is in it) faces inwards. For a cavity inside another component this is right; otherwise reverse "
          "its faces.");
  if (d.verdict == Verdict::infeasible && d.winding.negative_pairs > 0)
    say("The surface is inside out in " + std::to_string(d.winding.negative_pairs) +
        " places where faces cross: one part pokes out through the far side of another, or a crease is "
        "turned inside out. Move it back inside.");
  if (d.verdict == Verdict::infeasible && d.winding.negative_pairs == 0 && holds<WindingCertificate>(d))
    say("A whole component faces inwards where nothing surrounds it: reverse its faces.");
  if (const Hinge* hinge = clearest_negative(d.hinges))
    say("Around vertex " + std::to_string(hinge->vertex) +
        " the surface folds back on itself. Smooth its one-ring until its faces no longer cross.");
  if (d.wound.forbidden())
    say("At the hinges that forbid a mesh, no edges can take the extra turns. Smooth their one-rings until "
        "the "
        "faces no longer cross, or split their edges where other faces cross them.");
  if (holds<StackCertificate>(d))
    say("Move apart the faces that lie on each other there; if something was pressed flat, give its folds "
        "some "
        "thickness.");
  if (d.verdict == Verdict::feasible && !d.hinges.empty())
    say(count(d.hinges.size(), "vertex has", "vertices have") +
        " a one-ring that crosses itself (a hinge), which is the hard case. Smooth it if it is there by "
        "accident.");
  if (d.verdict == Verdict::feasible && !d.wound.complete())
    say("No edges were found for the extra turns of " + count(d.wound.unmet.size(), "hinge", "hinges") +
        "; a mesh is unlikely.");
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
  }
  return "";
}

Status rules::Case::find_wound_edges() {
  if (facts.wound_is_known || facts.hinges.empty()) return success();
  auto wound = assign_wound_edges(surface, facts.topology.topology, *facts.bvh, facts.hinges,
                                  facts.pierced_edges, context);
  if (!wound.ok()) return wound.error();
  facts.wound = std::move(wound).value();
  facts.wound_is_known = true;
  return success();
}

Result<Diagnosis> diagnose(const Surface& surface, const DiagnoseOptions& options,
                           const RunContext& context) {
  if (Status valid = options.validate(); !valid.ok()) return valid.error();
  const ScopedThreads threads(context.threads);
  Diagnosis d;
  static_cast<Facts&>(d) = check_shape(surface);
  if (!d.topology.ok()) {
    d.message = d.topology.problems.front();
    advise(d);
    return d;
  }
  if (!d.well_formed()) {
    rules::Case c(surface, d, context);
    const auto of_shape = [](const rules::Rule& rule) { return rule.of_shape; };
    if (Status s = try_rules(c, options.rules, of_shape, d); !s.ok()) return s.error();
    conclude(d);
    advise(d);
    return d;
  }
  const OrdinarySize sized(surface);
  if (Status s = gather_facts(sized.surface(), options.full_winding_range, context, d); !s.ok())
    return s.error();
  {
    const Stopwatch time(d.times.wound_edges);
    rules::Case c(sized.surface(), d, context);
    if (Status s = try_rules(
            c, options.rules, [](const rules::Rule& r) { return !r.on_request; }, d);
        !s.ok())
      return s.error();
  }
  if (sized.scaled()) take_back(surface, sized, d);
  conclude(d);
  advise(d);
  context.report("diagnose", 1, d.message);
  return d;
}

Status diagnose_further(const Surface& surface, const DiagnoseOptions& options, Diagnosis& d,
                        const RunContext& context) {
  if (d.verdict != Verdict::embedded && d.verdict != Verdict::feasible) return success();
  const ScopedThreads threads(context.threads);
  rules::Case c(surface, d, context);
  if (Status s = try_rules(
          c, options.rules, [](const rules::Rule& r) { return r.on_request; }, d);
      !s.ok())
    return s;
  conclude(d);
  return success();
}

std::optional<Error> refuse(const Diagnosis& d) {
  if (d.verdict == Verdict::bad_input) return Error{ErrorCode::bad_input, d.message};
  if (d.verdict != Verdict::infeasible) return std::nullopt;
  Error error{ErrorCode::infeasible, d.message};
  if (!d.certificate) return error;
  error.certificate = std::make_shared<const Certificate>(*d.certificate);
  if (const auto* flat = std::get_if<AreaCertificate>(&*d.certificate)) error.face = flat->face;
  return error;
}

std::vector<Index> named_vertices(const Certificate& certificate) {
  return std::visit(
      [](const auto& c) -> std::vector<Index> {
        if constexpr (requires { c.vertices; })
          return c.vertices;
        else if constexpr (requires { c.vertex; })
          return {c.vertex};
        else
          return {};
      },
      certificate);
}

}  // namespace overtet
