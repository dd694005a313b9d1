#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <filesystem>
#include <optional>

#include "overtet/diagnosis.h"
#include "overtet/io.h"
#include "overtet/view.h"
#include "src/cli/commands.h"
#include "src/cli/signals.h"

namespace overtet {

namespace {

// Tets if there are any: files of several formats may hold either.
Status write_view(const ViewCommand& command, const RunContext& context, const RunContext& writing,
                  Terminal& terminal) {
  PageOptions options;
  options.title = std::filesystem::path(command.input).filename();
  if (tet_format_of(command.input)) {
    const Result<LabelledTetMesh> mesh = read_labelled_tets(command.input, context);
    if (mesh) return write_page(command.output, mesh.value(), options, writing);
    // A surface of the same format? If it is none either, what is wrong with the tets is said.
    if (!read_surface(command.input, nullptr, context)) return mesh.error();
  }
  const Result<InputSurface> loaded = load(command.input, {}, context, terminal);
  if (!loaded) return loaded.error();
  const InputSurface& input = loaded.value();
  // What cannot be diagnosed can be looked at.
  std::optional<Curves> curves;
  if (!input.cleanup.problem) {
    Result<SurfaceDiagnosis> diagnosis = diagnose(input.surface(), context);
    if (!diagnosis) return diagnosis.error();
    for (const HingeDiagnosis& h : diagnosis.value().hinges) {
      const auto p = input.surface().V.row(h.vertex);
      options.marks.push_back({p[0], p[1], p[2]});
    }
    curves = std::move(diagnosis.value().curves);
    options.curves = &*curves;
  }
  return write_page(command.output, input.surface(),
                    input.cleanup.problem ? SurfaceAttributes{} : input.attributes, options, writing);
}

// By the desktop's own means; false where there is none.
bool open_in_browser(const std::string& path) {
  std::string program = "xdg-open", argument = std::filesystem::absolute(path);
  char* const words[] = {program.data(), argument.data(), nullptr};
  pid_t id = -1;
  if (::posix_spawnp(&id, program.c_str(), nullptr, nullptr, words, environ) != 0) return false;
  int status = 0;
  return ::waitpid(id, &status, 0) == id && WIFEXITED(status) && WEXITSTATUS(status) == 0;
}

}  // namespace

int run(const ViewCommand& command, const CommonOptions& common, Terminal& terminal) {
  if (same_file(command.input, command.output))
    return fail(terminal, {ErrorCode::usage, "The page would overwrite the input; choose another name."});
  OutputProbe probe;
  if (Status s = probe.open(command.output); !s) return fail(terminal, s.error());
  const RunContext context = common.context(terminal);
  Watchdog watchdog(context, common.start,
                    [&](const Error& error) { terminal.last_words(with_hint(error)); });
  context.report("read", 0);
  if (Status s = write_view(command, context, watchdog.writing(context), terminal); !s)
    return fail(watchdog, terminal, s.error());
  terminal.clear();
  terminal.say(command.output + ": open it in any browser.");
  if (command.open && !open_in_browser(command.output))
    return fail(terminal, {ErrorCode::io,
                           "Cannot open " + command.output + ": xdg-open did not work; open it by hand."});
  return 0;
}

}  // namespace overtet
