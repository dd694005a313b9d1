#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <variant>

#include "overtet/diagnosis.h"
#include "overtet/io.h"
#include "overtet/version.h"
#include "src/cli/commands.h"
#include "src/cli/mending.h"
#include "src/cli/signals.h"
#include "src/cli/tuning.h"

namespace overtet {

namespace {

using Json = nlohmann::ordered_json;

struct Findings {
  const InputSurface& input;
  const Surface& surface;
  const SurfaceReadInfo& info;
  const SurfaceDiagnosis& diagnosis;
  bool list_pairs, list_curves;
  std::size_t most_places;
};

const char* yes(bool x) { return x ? "yes" : "no"; }

const char* name_of(Curve::End end) {
  switch (end) {
    case Curve::End::none:
      return "none";
    case Curve::End::hinge:
      return "hinge";
    case Curve::End::contact:
      return "contact";
  }
  return "";
}

const char* name_of(CurveNode::Kind kind) {
  switch (kind) {
    case CurveNode::Kind::edge:
      return "edge";
    case CurveNode::Kind::vertex:
      return "vertex";
    case CurveNode::Kind::hinge:
      return "hinge";
    case CurveNode::Kind::triple:
      return "triple";
  }
  return "";
}

const CurveNode& end_of(const Curve& curve, int k) {
  return k == 0 ? curve.nodes.front() : curve.nodes.back();
}

Json to_json(const Curve& curve, bool every_point) {
  Json j = {{"closed", curve.closed}, {"length", curve.length}, {"segments", curve.segments.size()}};
  j["winding_min"] = curve.winding_min;
  j["winding_max"] = curve.winding_max;
  if (curve.closed) {
    j["sheets_swap"] = curve.sheets_swap;
  } else {
    j["ends"] = Json::array();
    for (const int k : {0, 1}) {
      Json end = {{"kind", name_of(curve.ends[k])}, {"position", end_of(curve, k).position}};
      if (curve.ends[k] == Curve::End::hinge) end["vertex"] = end_of(curve, k).vertex;
      j["ends"].push_back(end);
    }
  }
  if (!every_point) return j;
  j["points"] = Json::array();
  for (const CurveNode& node : curve.nodes) {
    Json point = {{"kind", name_of(node.kind)}, {"position", node.position}};
    point["on"] = Json::array();
    for (const SurfacePoint& p : node.on)
      point["on"].push_back({{"face", p.face}, {"barycentric", p.barycentric}});
    if (node.vertex >= 0) point["vertex"] = node.vertex;
    if (node.junction >= 0) point["junction"] = node.junction;
    j["points"].push_back(point);
  }
  j["faces"] = Json::array();
  j["winding"] = Json::array();
  for (const CurveSegment& s : curve.segments) {
    j["faces"].push_back(s.faces);
    j["winding"].push_back(s.winding_known ? Json({s.winding_min, s.winding_max}) : Json());
  }
  return j;
}

std::string text_of(const std::array<double, 3>& p) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", p[0], p[1], p[2]);
  return text;
}

std::array<double, 3> position(const Surface& s, Index v) { return {s.V(v, 0), s.V(v, 1), s.V(v, 2)}; }

// Numbers as the file counts, and the lines of a text.
Json to_json(const DefectPlace& p, const SurfaceSource& source) {
  Json place = {{"position", p.position}, {"vertices", Json::array()}, {"faces", Json::array()}};
  const auto add = [&](const char* numbers, const char* lines, Index in_file, const auto& line_of) {
    place[numbers].push_back(in_file + source.first);
    if (!line_of.empty()) place[lines].push_back(line_of[static_cast<std::size_t>(in_file)]);
  };
  for (const Index v : p.vertices)
    add("vertices", "vertex_lines", source.vertex_in_file(v), source.vertex_line);
  for (const Index f : p.faces) add("faces", "face_lines", source.face_in_file(f), source.face_line);
  return place;
}

Json to_json(const Defect& d, const InputSurface& input) {
  Json j = {{"kind", name_of(d.kind)},
            {"count", d.count},
            {"mended", is_mended(d.kind) && !input.cleanup.problem},
            {"message", d.message},
            {"mend", mend_of(d, input.cleanup.problem.has_value())}};
  j["places"] = Json::array();
  for (const DefectPlace& p : d.places) {
    j["places"].push_back(to_json(p, input.info.source));
    if (d.kind != DefectKind::hole) continue;
    j["places"].back()["edges"] = p.edges;
    j["places"].back()["length"] = p.length;
  }
  return j;
}

Json to_json(const ComponentDiagnosis& c) {
  Json j = {{"faces", c.faces}, {"vertices", c.vertices}};
  if (c.genus >= 0) j["genus"] = c.genus;
  if (!c.signed_volume) return j;
  j["signed_volume"] = *c.signed_volume;
  j["faces_inwards"] = *c.signed_volume < 0;
  return j;
}

// Faces as the file counts.
Json thin_spots_of(const Findings& f) {
  const std::vector<ThinSpot>& spots = f.diagnosis.thin_spots;
  Json j = {{"count", spots.size()}, {"limit", f.diagnosis.thin_limit}, {"spots", Json::array()}};
  if (!spots.empty()) j["mend"] = mend_of_thin_spots();
  for (std::size_t i = 0; i < spots.size() && i < f.most_places; ++i) {
    const ThinSpot& spot = spots[i];
    DefectPlace place;
    place.faces = {spot.face, spot.across};
    place.position = spot.position;
    Json one = to_json(place, f.input.source);
    one.erase("vertices");
    one["thickness"] = spot.thickness;
    one["size"] = spot.faces;
    j["spots"].push_back(one);
  }
  return j;
}

Json to_json(const Findings& f) {
  const SurfaceDiagnosis& d = f.diagnosis;
  Json j = {{"version", version()}, {"format", f.info.format}, {"notes", f.info.notes}};
  j["verdict"] = verdict_name(d.verdict);
  j["message"] = d.message;
  j["vertices"] = d.vertices;
  j["faces"] = d.faces;
  j["closed"] = d.closed;
  j["manifold"] = d.manifold;
  j["oriented"] = d.oriented;
  j["problems"] = d.problems;
  j["defects"] = Json::array();
  for (const Defect& defect : f.input.cleanup.defects) j["defects"].push_back(to_json(defect, f.input));
  j["components"] = Json::array();
  for (const ComponentDiagnosis& c : d.components) j["components"].push_back(to_json(c));
  j["thin_spots"] = d.winding_min ? thin_spots_of(f) : Json();
  j["degenerate_faces"] = d.degenerate_faces;
  j["pairs"] = d.pairs.size();
  j["pairs_sharing_vertex"] = d.pairs_sharing_vertex;
  j["pairs_sharing_edge"] = d.pairs_sharing_edge;
  if (f.list_pairs) j["pair_list"] = d.pairs;
  j["hinges"] = Json::array();
  for (const HingeDiagnosis& h : d.hinges) {
    Json hinge = {{"vertex", h.vertex},
                  {"position", position(f.surface, h.vertex)},
                  {"B0", h.B0 ? Json(*h.B0) : Json()},
                  {"covering", h.covering}};
    hinge["crossings"] = h.crossings;
    hinge["edges"] = Json::array();
    for (const EdgeAtHinge& e : h.edges)
      hinge["edges"].push_back({{"to", e.to}, {"levels", e.levels ? Json(*e.levels) : Json()}});
    j["hinges"].push_back(hinge);
  }
  j["odd_groups"] = d.odd_groups;
  j["crowded"] = d.crowded;
  j["unfillable"] = d.unfillable;
  j["unmet_hinges"] = d.unmet;
  j["wound_edges"] = Json::array();
  for (const ExtraTurns& e : d.wound_edges)
    j["wound_edges"].push_back({{"a", e.a},
                                {"b", e.b},
                                {"k", e.k},
                                {"positions", {position(f.surface, e.a), position(f.surface, e.b)}}});
  const Curves& curves = d.curves;
  j["curves"] = Json::array();
  for (const Curve& curve : curves.curves) j["curves"].push_back(to_json(curve, f.list_curves));
  j["curve_length"] = curves.length;
  j["junctions"] = Json::array();
  for (const Junction& junction : curves.junctions) {
    Json one = {{"position", junction.position}};
    one["strands"] = Json::array();
    for (const auto& [curve, node] : junction.strands)
      one["strands"].push_back({{"curve", curve}, {"point", node}});
    j["junctions"].push_back(one);
  }
  j["touching_pairs"] = curves.touching_pairs;
  j["coplanar_pairs"] = curves.coplanar_pairs;
  j["winding_min"] = d.winding_min ? Json(*d.winding_min) : Json();
  j["winding_max"] = d.winding_max ? Json(*d.winding_max) : Json();
  if (d.certificate) j["witness"] = Json::parse(to_json(*d.certificate));
  j["advice"] = d.advice;
  return j;
}

void print_hinges(const Findings& f) {
  const SurfaceDiagnosis& d = f.diagnosis;
  for (std::size_t h = 0; h < d.hinges.size() && h < kListed; ++h) {
    const HingeDiagnosis& hinge = d.hinges[h];
    std::printf(
        "            vertex %d at %s: B0 %s, %zu crossings in its link, winding number at least %d "
        "around it; levels along its edges",
        hinge.vertex, text_of(position(f.surface, hinge.vertex)).c_str(),
        hinge.B0 ? std::to_string(*hinge.B0).c_str() : "not defined", hinge.crossings.size(), hinge.covering);
    const char* comma = "";
    for (const EdgeAtHinge& e : hinge.edges) {
      std::printf("%s to %d:", comma, e.to);
      comma = ",";
      if (!e.levels) std::printf(" not defined");
      if (e.levels)
        for (const int level : *e.levels) std::printf(" %d", level);
    }
    std::printf("\n");
  }
  if (d.hinges.size() > kListed)
    std::printf("            and %zu more hinges (--json lists all)\n", d.hinges.size() - kListed);
  for (std::size_t i = 0; i < d.odd_groups.size() && i < kListed; ++i) {
    std::printf("unpaired   ");
    for (const Index v : d.odd_groups[i]) std::printf(" %d", v);
    std::printf("\n");
  }
  for (std::size_t i = 0; i < d.crowded.size() && i < kListed; ++i)
    std::printf("crowded     %d\n", d.crowded[i]);
  for (std::size_t i = 0; i < d.unfillable.size() && i < kListed; ++i)
    std::printf("unfillable  %d\n", d.unfillable[i]);
  if (d.wound_edges.empty()) return;
  std::printf("wound       %zu edges with one extra turn, unless another number is given:",
              d.wound_edges.size());
  for (std::size_t i = 0; i < d.wound_edges.size() && i < kListed; ++i) {
    const ExtraTurns& e = d.wound_edges[i];
    std::printf("%s %d-%d from %s to %s", i > 0 ? "," : "", e.a, e.b,
                text_of(position(f.surface, e.a)).c_str(), text_of(position(f.surface, e.b)).c_str());
    if (e.k > 1) std::printf(" (%d extra turns)", e.k);
  }
  std::printf("%s\n", d.wound_edges.size() > kListed ? ", ..." : "");
}

void print_points(const Curve& curve) {
  for (std::size_t n = 0; n < curve.nodes.size(); ++n) {
    const CurveNode& node = curve.nodes[n];
    std::printf("              point %zu: %s at %s", n, name_of(node.kind), text_of(node.position).c_str());
    for (const SurfacePoint& p : node.on)
      std::printf(", face %d at %s", p.face, text_of(p.barycentric).c_str());
    std::printf("\n");
  }
}

void print_curves(const Curves& curves, bool every_point) {
  const std::size_t n = curves.curves.size();
  std::printf(
      "curves      %zu in which the surface crosses itself, %.6g long: %d closed, %d from hinge to hinge\n",
      n, curves.length, curves.closed(), curves.hinge_to_hinge());
  const std::size_t shown = every_point ? n : std::min(n, kListed);
  for (std::size_t c = 0; c < shown; ++c) {
    const Curve& curve = curves.curves[c];
    std::string ends = curve.closed ? "closed" : "from";
    if (!curve.closed)
      for (const int k : {0, 1}) {
        const CurveNode& end = end_of(curve, k);
        ends += (k == 0 ? " " : " to ") + (curve.ends[k] == Curve::End::hinge
                                               ? "vertex " + std::to_string(end.vertex)
                                               : "a contact at " + text_of(end.position));
      }
    std::printf(
        "            curve %zu: %s, %zu segments, %.6g long, winding %d to %d, faces %d and %d at %s\n", c,
        ends.c_str(), curve.segments.size(), curve.length, curve.winding_min, curve.winding_max,
        curve.segments[0].faces[0], curve.segments[0].faces[1], text_of(curve.nodes[0].position).c_str());
    if (every_point) print_points(curve);
  }
  if (n > shown) std::printf("            and %zu more curves (--json lists all)\n", n - shown);
  if (curves.triple_points() > 0)
    std::printf("junctions   %d points where three or more strands meet, the first at %s\n",
                curves.triple_points(),
                text_of(std::find_if(curves.junctions.begin(), curves.junctions.end(),
                                     [](const Junction& j) { return j.strands.size() > 2; })
                            ->position)
                    .c_str());
}

// What the lines above have not said.
std::string verdict_text(const SurfaceDiagnosis& d) {
  if (d.verdict == Verdict::feasible) return "nothing found rules out a mesh that overlaps itself.";
  if (d.verdict == Verdict::embedded) return "any mesh generator for solids will do.";
  return d.message;
}

bool unclean(const Cleanup& cleanup, const SurfaceDiagnosis& d) {
  return !cleanup.defects.empty() || !d.closed || !d.manifold || !d.oriented || !d.degenerate_faces.empty() ||
         !d.problems.empty();
}

// What the defect's sentence has not said: more places, and what would mend it.
void print_more(const Defect& d, const Findings& f) {
  const bool refused = f.input.cleanup.problem.has_value();
  if (is_mended(d.kind) && !refused) return;
  const SurfaceSource& source = f.info.source;
  for (std::size_t i = 1; i < d.places.size(); ++i) {
    const DefectPlace& p = d.places[i];
    std::printf("            %s", i == 1 ? "also " : "     ");
    if (d.kind == DefectKind::hole)
      std::printf("%lld edges, %.6g long, ", static_cast<long long>(p.edges), p.length);
    if (!p.vertices.empty()) std::printf("%s, ", source.vertex_name(p.vertices[0]).c_str());
    if (!p.faces.empty()) std::printf("%s, ", source.face_name(p.faces[0]).c_str());
    std::printf("at %s\n", text_of(p.position).c_str());
  }
  std::printf("mend        %s\n", mend_of(d, refused).c_str());
}

void print_components(const SurfaceDiagnosis& d) {
  const std::size_t components = d.components.size();
  for (std::size_t c = 0; c < components && c < kListed; ++c) {
    const ComponentDiagnosis& one = d.components[c];
    std::printf("component   %d faces, %d vertices", one.faces, one.vertices);
    if (one.genus >= 0) std::printf(", genus %d", one.genus);
    if (one.signed_volume)
      std::printf(", faces %s, volume %.6g", *one.signed_volume < 0 ? "inwards" : "outwards",
                  std::abs(*one.signed_volume));
    std::printf("\n");
  }
  if (components > kListed) std::printf("            and %zu more components\n", components - kListed);
}

void print_thin_spots(const Findings& f) {
  const std::vector<ThinSpot>& spots = f.diagnosis.thin_spots;
  if (spots.empty()) return;
  std::printf("thin        %zu %s where the solid is thinner than %.6g, a thousandth of the diagonal\n",
              spots.size(), spots.size() == 1 ? "spot" : "spots", f.diagnosis.thin_limit);
  const std::size_t shown = std::min({spots.size(), f.most_places, kListed});
  for (std::size_t i = 0; i < shown; ++i)
    std::printf("            %.6g at %s, between %s and %s; %d faces\n", spots[i].thickness,
                text_of(spots[i].position).c_str(), f.input.source.face_name(spots[i].face).c_str(),
                f.input.source.face_name(spots[i].across).c_str(), spots[i].faces);
  if (spots.size() > shown) std::printf("            and %zu more spots\n", spots.size() - shown);
  std::printf("mend        %s\n", mend_of_thin_spots().c_str());
}

void print(const Findings& f) {
  const SurfaceDiagnosis& d = f.diagnosis;
  std::printf("file        %s\n", f.info.format.c_str());
  for (const std::string& note : f.info.notes) std::printf("note        %s\n", note.c_str());
  for (const Defect& defect : f.input.cleanup.defects) {
    std::printf("%s      %s\n", is_mended(defect.kind) && !f.input.cleanup.problem ? "mended" : "defect",
                defect.message.c_str());
    print_more(defect, f);
  }
  std::printf("size        %d vertices, %d faces\n", d.vertices, d.faces);
  std::printf("closed      %s\nmanifold    %s\noriented    %s\n", yes(d.closed), yes(d.manifold),
              yes(d.oriented));
  if (!f.input.cleanup.problem)
    for (const std::string& problem : d.problems) std::printf("problem     %s\n", problem.c_str());
  print_components(d);
  if (!d.degenerate_faces.empty())
    std::printf("degenerate  %zu faces without area, the first of them face %d\n", d.degenerate_faces.size(),
                d.degenerate_faces[0]);
  if (!d.degenerate_faces.empty()) std::printf("mend        %s\n", mend_of_flat_faces().c_str());
  if (d.winding_min) {
    std::printf("crossings   %zu pairs of faces\n", d.pairs.size());
    std::printf("hinges      %zu vertices whose one-ring crosses itself\n", d.hinges.size());
    print_hinges(f);
    print_curves(d.curves, f.list_curves);
    print_thin_spots(f);
    std::printf("winding     %d to %d\n", *d.winding_min, *d.winding_max);
  }
  if (f.list_pairs)
    for (const auto& [a, b] : d.pairs) std::printf("pair        %d %d\n", a, b);
  const auto said = [&](const std::string& sentence) {
    return std::find(d.problems.begin(), d.problems.end(), sentence) != d.problems.end();
  };
  std::printf("verdict     %s%s\n", verdict_name(d.verdict),
              said(d.message) ? "" : (": " + verdict_text(d)).c_str());
  if (f.input.cleanup.problem) return;  // the defects say it, in numbers of the file
  for (const std::string& advice : d.advice)
    if (!said(advice) && advice != d.message) std::printf("advice      %s\n", advice.c_str());
}

// Of a surface that cannot be cleaned: what hangs together once it is cleaned as far as that goes.
Status find_open_components(const InputSurface& input, SurfaceDiagnosis& d, const RunContext& context) {
  if (!input.cleanup.problem) return success();
  CleanupOptions options;
  options.allow_open = true;
  const Result<Cleanup> open = clean_up(input.surface(), options, {}, context);
  if (!open) return open.error();
  if (open.value().problem) return success();
  Result<SurfaceDiagnosis> found = diagnose(open.value().surface, context);
  if (!found) return found.error();
  d.components = std::move(found.value().components);
  return success();
}

// The verdict on a surface that cannot be cleaned, and the file's numbers of a face without area.
void explain_in_file(const InputSurface& input, SurfaceDiagnosis& d) {
  Error error{ErrorCode::bad_input, d.message};
  if (input.cleanup.problem) {
    error = *input.cleanup.problem;
    d.verdict = Verdict::bad_input;
  } else if (d.certificate) {
    if (const auto* area = std::get_if<AreaCertificate>(&*d.certificate)) error.face = area->face;
  }
  d.message = input.in_file(error).message;
}

}  // namespace

int run(const InspectCommand& command, const CommonOptions& common, Terminal& terminal) {
  CurveFormat format = CurveFormat::vtp;
  if (!command.save_curves.empty()) {
    const Result<CurveFormat> named = curve_format_of(command.save_curves);
    if (!named) return fail(terminal, named.error());
    format = named.value();
    if (command.save_curves == command.input)
      return fail(terminal,
                  {ErrorCode::usage, "The curves would overwrite the input; choose another name for them."});
  }
  const RunContext context = common.context(terminal);
  Watchdog watchdog(context, common.start,
                    [&](const Error& error) { terminal.last_words(with_hint(error)); });
  const Result<InputSurface> loaded = load(command.input, command.clean, context, terminal);
  if (!loaded) return fail(watchdog, terminal, loaded.error());
  const InputSurface& input = loaded.value();
  Result<SurfaceDiagnosis> found = diagnose(input.surface(), context);
  if (!found) return fail(watchdog, terminal, found.error());
  SurfaceDiagnosis& diagnosis = found.value();
  explain_in_file(input, diagnosis);
  if (Status s = find_open_components(input, diagnosis, context); !s)
    return fail(watchdog, terminal, s.error());
  if (!command.save_curves.empty())
    if (Status s = write_curves(command.save_curves, diagnosis.curves, format, context); !s)
      return fail(watchdog, terminal, s.error());
  terminal.clear();
  const Findings findings{input,
                          input.surface(),
                          input.info,
                          diagnosis,
                          command.pairs,
                          command.curves,
                          static_cast<std::size_t>(command.clean.most_places)};
  if (command.json)
    std::puts(to_json(findings).dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  else
    print(findings);
  if (std::fflush(stdout) != 0)
    return fail(watchdog, terminal, {ErrorCode::io, "Cannot write to standard output."});
  // A surface that cannot be used is bad input here too; one that no mesh exists for was inspected well. The
  // text has said why.
  const auto fails_on = [&](const char* what) {
    return std::find(command.fail_on.begin(), command.fail_on.end(), what) != command.fail_on.end();
  };
  if (diagnosis.verdict == Verdict::bad_input || (fails_on("unclean") && unclean(input.cleanup, diagnosis))) {
    if (command.json && diagnosis.verdict == Verdict::bad_input)
      return fail(watchdog, terminal, {ErrorCode::bad_input, diagnosis.message});
    return static_cast<int>(ErrorCode::bad_input);
  }
  if (diagnosis.verdict == Verdict::infeasible && fails_on("infeasible"))
    return static_cast<int>(ErrorCode::infeasible);
  return 0;
}

}  // namespace overtet
