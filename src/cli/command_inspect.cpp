#include <algorithm>
#include <array>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "kernels/parallel/parallel.h"
#include "overtet/version.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"
#include "src/io/polylines_io.h"
#include "src/io/surface_io.h"
#include "src/pipeline/inspection.h"

namespace overtet {

namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kListed = 20;  // of each kind in the text

struct Findings {
  const Surface& surface;
  const SurfaceReadInfo& info;
  const Inspection& found;
  const CloseLook& look;
  bool list_pairs, list_curves;
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

// One cell a segment: the two faces and the winding numbers change along a curve.
Polylines lines_of(const Curves& curves) {
  Polylines out;
  const auto field = [](std::vector<Polylines::Field>& into, const char* name, int components = 1,
                        bool whole = true) -> std::size_t {
    into.push_back({name, {}, components, whole});
    return into.size() - 1;
  };
  auto& on_segments = out.segment_data;
  auto& on_points = out.point_data;
  const auto number = field(on_segments, "curve"), closed = field(on_segments, "closed"),
             faces = field(on_segments, "faces", 2), crossing = field(on_segments, "crossing"),
             low = field(on_segments, "winding_min"), high = field(on_segments, "winding_max"),
             hinges = field(on_segments, "end_hinges", 2);
  const auto kind = field(on_points, "kind"), vertex = field(on_points, "vertex"),
             junction = field(on_points, "junction"), on = field(on_points, "on_faces", 2),
             first = field(on_points, "barycentric_0", 3, false),
             second = field(on_points, "barycentric_1", 3, false);
  const auto add = [](Polylines::Field& f, double x) { f.values.push_back(x); };
  for (std::size_t c = 0; c < curves.curves.size(); ++c) {
    const Curve& curve = curves.curves[c];
    Polylines::Line line;
    line.name = "curve_" + std::to_string(c) + (curve.closed ? "_closed" : "");
    const Index begin = static_cast<Index>(out.points.size());
    for (const CurveNode& node : curve.nodes) {
      line.points.push_back(static_cast<Index>(out.points.size()));
      out.points.push_back(node.position);
      add(on_points[kind], static_cast<int>(node.kind));
      add(on_points[vertex], node.vertex);
      add(on_points[junction], node.junction);
      for (const SurfacePoint& p : node.on) add(on_points[on], p.face);
      for (const double x : node.on[0].barycentric) add(on_points[first], x);
      for (const double x : node.on[1].barycentric) add(on_points[second], x);
    }
    if (curve.closed) line.points.push_back(begin);
    for (const CurveSegment& s : curve.segments) {
      add(on_segments[number], static_cast<double>(c));
      add(on_segments[closed], curve.closed);
      for (const Index f : s.faces) add(on_segments[faces], f);
      add(on_segments[crossing], s.crossing);
      add(on_segments[low], s.winding_min);
      add(on_segments[high], s.winding_max);
      for (const int k : {0, 1})
        add(on_segments[hinges], curve.ends[k] == Curve::End::hinge ? end_of(curve, k).vertex : -1);
    }
    out.lines.push_back(std::move(line));
  }
  return out;
}

std::string text_of(const std::array<double, 3>& p) {
  char text[96];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", p[0], p[1], p[2]);
  return text;
}

std::array<double, 3> position(const Surface& s, Index v) { return {s.V(v, 0), s.V(v, 1), s.V(v, 2)}; }

bool manifold(const TopologyCheck& t) {
  return t.manifold_edges && t.manifold_vertices && t.duplicate_faces.empty();
}

Json to_json(const Findings& f) {
  const Diagnosis& d = f.found.diagnosis;
  const TopologyCheck& t = d.topology;
  const InputRecord input = input_record(f.found);
  Json j = {{"version", version()}, {"format", f.info.format}, {"notes", f.info.notes}};
  j["verdict"] = verdict_name(d.verdict);
  j["message"] = f.found.problem ? f.found.problem->message : d.message;
  j["vertices"] = d.vertices;
  j["faces"] = d.faces;
  j["closed"] = t.closed;
  j["manifold"] = manifold(t);
  j["oriented"] = t.oriented;
  j["problems"] = t.problems;
  j["components"] = Json::array();
  if (t.ok()) {
    const auto& components = t.topology.components;
    for (std::size_t c = 0; c < components.size(); ++c) {
      Json one = {{"faces", components[c].faces},
                  {"vertices", components[c].vertices},
                  {"genus", components[c].genus}};
      if (c < d.component_volume.size()) one["signed_volume"] = d.component_volume[c];
      j["components"].push_back(one);
    }
  }
  j["degenerate_faces"] = d.degenerate_faces;
  j["pairs"] = input.pairs;
  j["pairs_sharing_vertex"] = d.pairs_sharing_vertex;
  j["pairs_sharing_edge"] = d.pairs_sharing_edge;
  if (f.list_pairs) {
    j["pair_list"] = Json::array();
    for (const auto& [a, b] : d.pairs) j["pair_list"].push_back({a, b});
  }
  j["hinges"] = Json::array();
  for (std::size_t i = 0; i < d.hinges.size(); ++i) {
    const Hinge& h = d.hinges[i];
    Json hinge = {{"vertex", h.vertex},
                  {"position", position(f.surface, h.vertex)},
                  {"B0", h.B0 ? Json(*h.B0) : Json()},
                  {"covering", h.covering}};
    hinge["crossings"] = Json::array();
    for (const auto& [a, b] : h.crossings) hinge["crossings"].push_back({a, b});
    hinge["edges"] = Json::array();
    for (const EdgeAtHinge& e : f.look.edges[i])
      hinge["edges"].push_back({{"to", e.to}, {"levels", e.levels ? Json(*e.levels) : Json()}});
    j["hinges"].push_back(hinge);
  }
  j["odd_groups"] = d.wound.odd_groups;
  j["crowded"] = d.wound.crowded;
  j["unfillable"] = d.wound.unfillable;
  j["unmet_hinges"] = d.wound.unmet;
  j["wound_edges"] = Json::array();
  for (const WoundEdge& e : d.wound.edges)
    j["wound_edges"].push_back({{"a", e.a},
                                {"b", e.b},
                                {"k", e.k},
                                {"positions", {position(f.surface, e.a), position(f.surface, e.b)}}});
  const Curves& curves = f.look.curves;
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
  j["winding_min"] = input.winding_min ? Json(*input.winding_min) : Json();
  j["winding_max"] = input.winding_max ? Json(*input.winding_max) : Json();
  if (d.certificate) j["witness"] = Json::parse(to_json(*d.certificate));
  j["advice"] = d.advice;
  return j;
}

void print_hinges(const Findings& f) {
  const Diagnosis& d = f.found.diagnosis;
  for (std::size_t h = 0; h < d.hinges.size() && h < kListed; ++h) {
    const Hinge& hinge = d.hinges[h];
    std::printf(
        "            vertex %d at %s: B0 %s, %zu crossings in its link, covering %d; levels outside its "
        "edges",
        hinge.vertex, text_of(position(f.surface, hinge.vertex)).c_str(),
        hinge.B0 ? std::to_string(*hinge.B0).c_str() : "not defined", hinge.crossings.size(), hinge.covering);
    const char* comma = "";
    for (const EdgeAtHinge& e : f.look.edges[h]) {
      std::printf("%s to %d:", comma, e.to);
      comma = ",";
      if (!e.levels) std::printf(" not defined");
      if (e.levels)
        for (const int level : *e.levels) std::printf(" %d", level);
    }
    std::printf("\n");
  }
  if (d.hinges.size() > kListed)
    std::printf("            and %zu hinges more (--json lists all)\n", d.hinges.size() - kListed);
  for (std::size_t i = 0; i < d.wound.odd_groups.size() && i < kListed; ++i) {
    std::printf("unpaired   ");
    for (const Index v : d.wound.odd_groups[i]) std::printf(" %d", v);
    std::printf("\n");
  }
  for (std::size_t i = 0; i < d.wound.crowded.size() && i < kListed; ++i)
    std::printf("crowded     %d\n", d.wound.crowded[i]);
  for (std::size_t i = 0; i < d.wound.unfillable.size() && i < kListed; ++i)
    std::printf("unfillable  %d\n", d.wound.unfillable[i]);
  if (d.wound.edges.empty()) return;
  std::printf("wound       %zu edges with one turn more than they show, or as many as said:",
              d.wound.edges.size());
  for (std::size_t i = 0; i < d.wound.edges.size() && i < kListed; ++i) {
    const WoundEdge& e = d.wound.edges[i];
    std::printf("%s %d-%d from %s to %s", i > 0 ? "," : "", e.a, e.b,
                text_of(position(f.surface, e.a)).c_str(), text_of(position(f.surface, e.b)).c_str());
    if (e.k > 1) std::printf(" (%d turns)", e.k);
  }
  std::printf("%s\n", d.wound.edges.size() > kListed ? ", ..." : "");
}

void print_curves(const Curves& curves) {
  const std::size_t n = curves.curves.size();
  std::printf(
      "curves      %zu in which the surface crosses itself, %.6g long: %d closed, %d from hinge to hinge\n",
      n, curves.length, curves.closed(), curves.hinge_to_hinge());
  for (std::size_t c = 0; c < n && c < kListed; ++c) {
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
  }
  if (n > kListed) std::printf("            and %zu curves more (--json lists all)\n", n - kListed);
  if (curves.triple_points() > 0)
    std::printf("junctions   %d points where three strands or more meet, the first at %s\n",
                curves.triple_points(),
                text_of(std::find_if(curves.junctions.begin(), curves.junctions.end(),
                                     [](const Junction& j) { return j.strands.size() > 2; })
                            ->position)
                    .c_str());
}

void print(const Findings& f) {
  const Diagnosis& d = f.found.diagnosis;
  const TopologyCheck& t = d.topology;
  const InputRecord input = input_record(f.found);
  std::printf("file        %s\n", f.info.format.c_str());
  for (const std::string& note : f.info.notes) std::printf("note        %s\n", note.c_str());
  std::printf("size        %d vertices, %d faces\n", d.vertices, d.faces);
  std::printf("closed      %s\nmanifold    %s\noriented    %s\n", yes(t.closed), yes(manifold(t)),
              yes(t.oriented));
  for (const std::string& problem : t.problems) std::printf("problem     %s\n", problem.c_str());
  if (t.ok()) {
    const auto& components = t.topology.components;
    for (std::size_t c = 0; c < components.size() && c < kListed; ++c)
      std::printf("component   %d faces, genus %d%s\n", components[c].faces, components[c].genus,
                  c < d.component_volume.size() && d.component_volume[c] < 0 ? ", faces inwards" : "");
    if (components.size() > kListed)
      std::printf("            and %zu components more\n", components.size() - kListed);
  }
  if (!d.degenerate_faces.empty())
    std::printf("degenerate  %zu faces without area, the first is %d\n", d.degenerate_faces.size(),
                d.degenerate_faces[0]);
  if (input.winding_min) {
    std::printf("crossings   %lld pairs of faces\n", static_cast<long long>(input.pairs));
    std::printf("hinges      %lld vertices whose one-ring crosses itself\n",
                static_cast<long long>(input.hinges));
    print_hinges(f);
    print_curves(f.look.curves);
    std::printf("winding     %d to %d\n", *input.winding_min, *input.winding_max);
  }
  if (f.list_pairs)
    for (const auto& [a, b] : d.pairs) std::printf("pair        %d %d\n", a, b);
  std::printf("verdict     %s: %s\n", verdict_name(d.verdict),
              (f.found.problem ? f.found.problem->message : d.message).c_str());
  if (d.certificate) std::printf("witness     %s\n", to_json(*d.certificate).c_str());
  for (const std::string& advice : d.advice) std::printf("advice      %s\n", advice.c_str());
}

}  // namespace

int run(const InspectCommand& command, const CommonOptions& common, Terminal& terminal) {
  PolylinesFormat format = PolylinesFormat::vtp;
  if (!command.save_curves.empty()) {
    const Result<PolylinesFormat> named = polylines_format_of(command.save_curves);
    if (!named) return fail(terminal, named.error());
    format = named.value();
    if (command.save_curves == command.input)
      return fail(terminal, {ErrorCode::usage, "The input would be overwritten by the curves."});
  }
  const RunContext context = common.context(terminal);
  const ScopedThreads threads(common.threads);
  Watchdog watchdog(context.deadline, context.memory_limit_bytes,
                    [&](const Error& error) { terminal.error(with_hint(error)); });
  SurfaceReadInfo info;
  const Result<Surface> surface = read_surface(command.input, &info);
  if (!surface) return fail(terminal, surface.error());
  const Result<Inspection> found = inspect(surface.value(), InspectionDepth::everything, context);
  if (!found) return fail(terminal, found.error());
  CloseLook look;
  if (found.value().usable()) {
    Result<CloseLook> looked = look_closely(surface.value(), found.value(), context);
    if (!looked) return fail(terminal, looked.error());
    look = std::move(looked).value();
  }
  watchdog.dismiss();
  if (!command.save_curves.empty())
    if (Status s = write_polylines(command.save_curves, lines_of(look.curves), format); !s)
      return fail(terminal, s.error());
  terminal.clear();
  const Findings findings{surface.value(), info, found.value(), look, command.pairs, command.curves};
  if (command.json)
    std::puts(to_json(findings).dump(2, ' ', false, Json::error_handler_t::replace).c_str());
  else
    print(findings);
  if (std::fflush(stdout) != 0) return fail(terminal, {ErrorCode::io, "Cannot write to standard output."});
  // A surface that cannot be used is bad input here too; one that no mesh exists for was inspected well.
  const auto& problem = found.value().problem;
  return problem && problem->code == ErrorCode::bad_input ? fail(terminal, *problem) : 0;
}

}  // namespace overtet
