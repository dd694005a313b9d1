#include <cstdio>
#include <nlohmann/json.hpp>

#include "overtet/io.h"
#include "overtet/verification.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"

namespace overtet {

int run(const VerifyCommand& command, const CommonOptions& common, Terminal& terminal) {
  const RunContext context = common.context(terminal);
  Watchdog watchdog(context.deadline, context.memory_limit_bytes,
                    [&](const Error& error) { terminal.error(with_hint(error)); });
  const Result<InputSurface> loaded = load(command.surface, command.clean, context, terminal);
  if (!loaded) return fail(terminal, loaded.error());
  const InputSurface& input = loaded.value();
  const Result<TetMesh> mesh = read_tets(command.mesh, context);
  if (!mesh) return fail(terminal, mesh.error());
  VerifyOptions options;
  options.allow_branches = command.allow_branches;
  options.geometry_only = !input.info.has_vertex_order;
  options.max_move = command.max_move / 100;
  const VerifyResult r = verify(input.surface(), mesh.value(), options, context);
  if (!r.complete)
    return fail(terminal, context.stop().value_or(Error{ErrorCode::interrupted, "Interrupted."}));
  const bool readable = !r.fails(Rule::R1);
  const TetQuality q = readable ? tet_quality(mesh.value(), context) : TetQuality{};
  watchdog.dismiss();
  if (command.json) {
    nlohmann::ordered_json j = {{"ok", r.ok()},
                                {"surface_vertices", r.surface_vertices},
                                {"surface_faces", r.surface_faces},
                                {"vertices", r.vertices},
                                {"tets", r.tets},
                                {"boundary_faces", r.boundary_faces},
                                {"moved", {{"vertices", r.moved_vertices}, {"max_relative", r.max_move}}}};
    if (command.allow_branches) j["branch_edges"] = r.branch_edges;
    j["failures"] = nlohmann::ordered_json::array();
    for (const VerifyFailure& f : r.failures)
      j["failures"].push_back({{"rule", "R" + std::to_string(static_cast<int>(f.rule))},
                               {"message", f.message},
                               {"count", f.count},
                               {"first", f.first}});
    if (readable)
      j["quality"] = {{"dihedral_min", q.dihedral_min},
                      {"dihedral_p01", q.dihedral_p01},
                      {"dihedral_max", q.dihedral_max},
                      {"volume", q.volume},
                      {"coincident_vertices", q.coincident_vertices},
                      {"closest_pair", q.closest_pair}};
    std::puts(j.dump(2).c_str());
  } else {
    std::printf("surface   %lld vertices, %lld faces\n", static_cast<long long>(r.surface_vertices),
                static_cast<long long>(r.surface_faces));
    std::printf("tet mesh  %lld vertices, %lld tets, %lld boundary faces\n",
                static_cast<long long>(r.vertices), static_cast<long long>(r.tets),
                static_cast<long long>(r.boundary_faces));
    if (readable)
      std::printf("dihedral  %.3g to %.4g degrees, 1 %% below %.3g\n", q.dihedral_min, q.dihedral_max,
                  q.dihedral_p01);
    if (!r.branch_edges.empty())
      std::printf("branches  %zu interior edges with two turns or more\n", r.branch_edges.size());
    if (readable)
      std::printf("points    %lld coincide, closest pair %.3g of the diagonal (vertices %d and %d)\n",
                  static_cast<long long>(q.coincident_vertices), q.closest_pair, q.closest[0], q.closest[1]);
    for (const VerifyFailure& f : r.failures) std::printf("FAILED    %s\n", f.message.c_str());
    std::puts(r.ok() ? "accepted" : "rejected");
  }
  if (std::fflush(stdout) != 0) return fail(terminal, {ErrorCode::io, "Cannot write to standard output."});
  if (r.ok()) return 0;
  return fail(terminal, {ErrorCode::unsolved, "The tet mesh is wrong: " + r.failures[0].message});
}

}  // namespace overtet
