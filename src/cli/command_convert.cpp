#include <optional>

#include "overtet/io.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"

namespace overtet {

int run(const ConvertCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<TetFormat> format = output_format(command.output, command.format, terminal);
  if (!format) return fail(terminal, format.error());
  const std::vector<std::string> outputs = tet_files(command.output, format.value());
  for (const std::string& output : outputs)
    if (same_file(command.input, output))
      return fail(terminal, {ErrorCode::usage, "The output would overwrite the input; choose another name."});
  std::vector<OutputProbe> probes(outputs.size());
  for (std::size_t i = 0; i < outputs.size(); ++i)
    if (Status s = probes[i].open(outputs[i]); !s) return fail(terminal, s.error());
  const RunContext context = common.context(terminal);
  Watchdog watchdog(context, common.start,
                    [&](const Error& error) { terminal.last_words(with_hint(error)); });
  context.report("read", 0);
  Result<LabelledTetMesh> read = Error{};
  if (command.from.empty()) {
    read = read_labelled_tets(command.input, context);
  } else {
    const Result<TetFormat> from = tet_format_named(command.from);
    if (!from) return fail(watchdog, terminal, from.error());
    read = read_labelled_tets(command.input, from.value(), context);
  }
  if (!read) return fail(watchdog, terminal, read.error());
  const auto& [mesh, attributes] = read.value();
  context.report("write", 0);
  if (Status s = write_tets(command.output, mesh, attributes, {format.value(), command.order},
                            watchdog.writing(context));
      !s)
    return fail(watchdog, terminal, s.error());
  terminal.clear();
  terminal.say(command.output + ": " + std::to_string(mesh.V.rows()) + " vertices, " +
               std::to_string(mesh.T.rows()) + " tets, " + std::to_string(attributes.triangles.rows()) +
               " boundary triangles, to the last bit.");
  return 0;
}

}  // namespace overtet
