#include <cstdio>
#include <nlohmann/json.hpp>

#include "kernels/parallel/parallel.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"
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
  bool list_pairs;
};

const char* yes(bool x) { return x ? "yes" : "no"; }

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
  for (const Hinge& h : d.hinges)
    j["hinges"].push_back(
        {{"vertex", h.vertex}, {"B0", h.B0 ? Json(*h.B0) : Json()}, {"covering", h.covering}});
  j["wound_edges"] = Json::array();
  for (const WoundEdge& e : d.wound.edges) j["wound_edges"].push_back({{"a", e.a}, {"b", e.b}, {"k", e.k}});
  j["winding_min"] = input.winding_min ? Json(*input.winding_min) : Json();
  j["winding_max"] = input.winding_max ? Json(*input.winding_max) : Json();
  if (f.found.witness) j["witness"] = Json::parse(to_json(*f.found.witness));
  j["advice"] = d.advice;
  return j;
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
    for (std::size_t h = 0; h < d.hinges.size() && h < kListed; ++h)
      std::printf("            vertex %d, B0 %s\n", d.hinges[h].vertex,
                  d.hinges[h].B0 ? std::to_string(*d.hinges[h].B0).c_str() : "not defined");
    if (d.hinges.size() > kListed)
      std::printf("            and %zu hinges more\n", d.hinges.size() - kListed);
    std::printf("winding     %d to %d\n", *input.winding_min, *input.winding_max);
  }
  if (f.list_pairs)
    for (const auto& [a, b] : d.pairs) std::printf("pair        %d %d\n", a, b);
  std::printf("verdict     %s: %s\n", verdict_name(d.verdict),
              (f.found.problem ? f.found.problem->message : d.message).c_str());
  for (const std::string& advice : d.advice) std::printf("advice      %s\n", advice.c_str());
}

}  // namespace

int run(const InspectCommand& command, const CommonOptions& common, Terminal& terminal) {
  const RunContext context = common.context(terminal);
  const ScopedThreads threads(common.threads);
  Watchdog watchdog(context.deadline, context.memory_limit_bytes,
                    [&](const Error& error) { terminal.error(error.message); });
  SurfaceReadInfo info;
  const Result<Surface> surface = read_surface(command.input, &info);
  if (!surface) return fail(terminal, surface.error());
  const Result<Inspection> found = inspect(surface.value(), true, context);
  watchdog.dismiss();
  if (!found) return fail(terminal, found.error());
  terminal.clear();
  const Findings findings{surface.value(), info, found.value(), command.pairs};
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
