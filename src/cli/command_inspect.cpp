#include <cstdio>
#include <nlohmann/json.hpp>

#include "kernels/parallel/parallel.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"
#include "src/io/surface_io.h"
#include "src/pipeline/inspection.h"
#include "src/surface/topology.h"

namespace overtet {

namespace {

using Json = nlohmann::ordered_json;

struct Findings {
  const Surface& surface;
  const SurfaceReadInfo& info;
  const Inspection& found;
  bool list_pairs;
};

const char* yes(bool x) { return x ? "yes" : "no"; }

Json to_json(const Findings& f) {
  const Inspection& r = f.found;
  const InputRecord input = input_record(f.surface, r);
  Json j = {{"version", version()}, {"format", f.info.format}, {"notes", f.info.notes}};
  j["vertices"] = input.vertices;
  j["faces"] = input.faces;
  j["closed"] = r.topology.closed;
  j["manifold"] =
      r.topology.manifold_edges && r.topology.manifold_vertices && r.topology.duplicate_faces.empty();
  j["oriented"] = r.topology.oriented;
  j["problems"] = r.topology.problems;
  j["components"] = Json::array();
  if (r.topology.ok()) {
    const auto& components = r.topology.topology.components;
    for (std::size_t c = 0; c < components.size(); ++c) {
      Json one = {{"faces", components[c].faces},
                  {"vertices", components[c].vertices},
                  {"genus", components[c].genus}};
      if (c < r.inward.size()) one["inward"] = static_cast<bool>(r.inward[c]);
      j["components"].push_back(one);
    }
  }
  j["faces_without_area"] = r.faces_without_area;
  j["pairs"] = input.pairs;
  if (f.list_pairs) {
    j["pair_list"] = Json::array();
    for (const auto& [a, b] : r.pairs) j["pair_list"].push_back({a, b});
  }
  j["hinges"] = Json::array();
  for (const Hinge& h : r.hinges)
    j["hinges"].push_back(
        {{"vertex", h.vertex}, {"b0", h.B0 ? Json(*h.B0) : Json()}, {"covering", h.covering}});
  j["winding_min"] = input.winding_min ? Json(*input.winding_min) : Json();
  j["winding_max"] = input.winding_max ? Json(*input.winding_max) : Json();
  j["feasible"] = r.problem ? Json(false) : Json();
  if (r.witness) {
    Json& w = j["witness"] = Json::object();
    if (r.witness->point) w = {{"point", *r.witness->point}, {"winding", r.witness->winding}};
    if (r.witness->vertex) w = {{"vertex", *r.witness->vertex}, {"b0", r.witness->b0}};
  }
  j["advice"] = advice(r);
  return j;
}

void print(const Findings& f) {
  const Inspection& r = f.found;
  const InputRecord input = input_record(f.surface, r);
  std::printf("file        %s\n", f.info.format.c_str());
  for (const std::string& note : f.info.notes) std::printf("note        %s\n", note.c_str());
  std::printf("size        %lld vertices, %lld faces\n", static_cast<long long>(input.vertices),
              static_cast<long long>(input.faces));
  std::printf(
      "closed      %s\nmanifold    %s\noriented    %s\n", yes(r.topology.closed),
      yes(r.topology.manifold_edges && r.topology.manifold_vertices && r.topology.duplicate_faces.empty()),
      yes(r.topology.oriented));
  for (const std::string& problem : r.topology.problems) std::printf("problem     %s\n", problem.c_str());
  if (r.topology.ok()) {
    const auto& components = r.topology.topology.components;
    for (std::size_t c = 0; c < components.size() && c < 20; ++c)
      std::printf("component   %d faces, genus %d%s\n", components[c].faces, components[c].genus,
                  c < r.inward.size() && r.inward[c] ? ", oriented inward" : "");
    if (components.size() > 20) std::printf("            and %zu components more\n", components.size() - 20);
  }
  if (!r.faces_without_area.empty())
    std::printf("degenerate  %zu faces without area, the first is %d\n", r.faces_without_area.size(),
                r.faces_without_area[0]);
  if (input.winding_min) {
    std::printf("crossings   %lld pairs of faces\n", static_cast<long long>(input.pairs));
    std::printf("hinges      %lld vertices whose one-ring crosses itself\n",
                static_cast<long long>(input.hinges));
    for (std::size_t h = 0; h < r.hinges.size() && h < 20; ++h)
      std::printf("            vertex %d, B0 %s\n", r.hinges[h].vertex,
                  r.hinges[h].B0 ? std::to_string(*r.hinges[h].B0).c_str() : "not defined");
    if (r.hinges.size() > 20) std::printf("            and %zu hinges more\n", r.hinges.size() - 20);
    std::printf("winding     %d to %d\n", *input.winding_min, *input.winding_max);
  }
  if (f.list_pairs)
    for (const auto& [a, b] : r.pairs) std::printf("pair        %d %d\n", a, b);
  std::printf("advice      %s\n", advice(r).c_str());
}

}  // namespace

int run(const InspectCommand& command, const CommonOptions& common, Terminal& terminal) {
  const RunContext context = common.context(terminal);
  const ScopedThreads threads(common.threads);
  Watchdog watchdog(context.deadline, [&](int code) {
    terminal.error(code == 130 ? "Interrupted."
                               : "The time limit was reached; allow more with --time-limit.");
  });
  SurfaceReadInfo info;
  const Result<Surface> surface = read_surface(command.input, &info);
  if (!surface) return fail(terminal, surface.error());
  const Result<Inspection> found = inspect(surface.value(), context);
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
