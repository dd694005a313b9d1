#include <chrono>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "overtet/fused.h"
#include "overtet/io.h"
#include "src/cli/commands.h"
#include "src/cli/input.h"
#include "src/cli/memory.h"
#include "src/cli/signals.h"

namespace overtet {

namespace {

Result<FusedMesh> fuse_and_write(const CompareCommand& command, TetFormat format, const RunContext& context,
                                 const RunContext& writing, Terminal& terminal) {
  const Result<InputSurface> loaded = load(command.input, command.clean, context, terminal);
  if (!loaded) return loaded.error();
  const InputSurface& input = loaded.value();
  if (input.cleanup.problem) return input.in_file(*input.cleanup.problem);
  Result<FusedMesh> made = fused_mesh(input.surface(), input.attributes, {}, context);
  if (!made) return input.in_file(made.error());
  TetWriteOptions options;
  options.format = format;
  const LabelledTetMesh& mesh = made.value().mesh;
  if (Status s = write_tets(command.output, mesh.mesh, mesh.attributes, options, writing); !s)
    return s.error();
  return made;
}

nlohmann::ordered_json figures(const FusedMesh& m) {
  return {{"vertices", m.mesh.mesh.V.rows()},
          {"tets", m.mesh.mesh.T.rows()},
          {"surface_components", m.surface_components},
          {"components", m.components},
          {"cut_faces", m.cut_faces},
          {"inner_vertices", m.inner_vertices},
          {"solid_volume", m.solid_volume},
          {"volume", m.volume}};
}

std::string sentence(const FusedMesh& m) {
  char text[400];
  std::snprintf(
      text, sizeof text,
      "the fused mesh, %lld tets. Its volume is %.6g; that of the solid, in which a place counts as often "
      "as it is covered, %.6g. %lld faces of the surface are cut, %lld of its vertices lie inside.",
      static_cast<long long>(m.mesh.mesh.T.rows()), m.volume, m.solid_volume,
      static_cast<long long>(m.cut_faces), static_cast<long long>(m.inner_vertices));
  return text;
}

}  // namespace

int run(const CompareCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<TetFormat> format = tet_format_of(command.output);
  if (!format) return fail(terminal, format.error());
  if (same_file(command.input, command.output))
    return fail(terminal, {ErrorCode::usage, "The output would overwrite the input; choose another name."});
  OutputProbe probe;
  if (Status s = probe.open(command.output); !s) return fail(terminal, s.error());
  const RunContext context = common.context(terminal);
  Watchdog watchdog(context, common.start,
                    [&](const Error& error) { terminal.last_words(with_hint(error)); });
  const Result<FusedMesh> made = caught(
      [&] { return fuse_and_write(command, format.value(), context, watchdog.writing(context), terminal); });
  if (!made) return fail(watchdog, terminal, made.error());
  terminal.clear();
  if (!command.json) {
    terminal.say(command.output + ": " + sentence(made.value()));
    return 0;
  }
  nlohmann::ordered_json j = figures(made.value());
  j["seconds"] = std::chrono::duration<double>(RunContext::Clock::now() - common.start).count();
  const std::string printed = j.dump(2) + "\n";
  if (std::fputs(printed.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
    return fail(terminal, {ErrorCode::io, "Cannot write standard output."});
  return 0;
}

}  // namespace overtet
