#include <cstdio>

#include "overtet/embed.h"
#include "overtet/io.h"
#include "src/cli/commands.h"
#include "src/cli/memory.h"
#include "src/cli/signals.h"
#include "src/cli/stage_trail.h"

namespace overtet {

namespace {

std::string what_was_made(const EmbedCommand& command, const Embedding& e) {
  const auto range = [](const RatioRange& r) {
    char text[96];
    std::snprintf(text, sizeof text, "%.3f to %.3f times (1 %% to 99 %%; at the worst %.3f and %.3f)", r.p01,
                  r.p99, r.least, r.most);
    return std::string(text);
  };
  std::string text = command.output + ": no faces intersect, checked exactly; " +
                     std::to_string(e.moved.size()) + " of " + std::to_string(e.surface.V.rows()) +
                     " vertices moved. Areas are " + range(e.quality.area) + ", edges " +
                     range(e.quality.edge) + " as large as the input's.";
  if (!e.laid_aside.empty())
    text += " " + std::to_string(e.laid_aside.size()) +
            (e.laid_aside.size() == 1 ? " component that crosses another one was laid aside."
                                      : " components that cross others were laid aside.");
  if (e.quality.collapsed)
    text += " A part of it stays collapsed: a hundredth of the faces has less than a tenth of its area.";
  return text;
}

// Reads, embeds and writes the surface.
Result<Embedding> embedded_surface(const EmbedCommand& command, SurfaceFormat format,
                                   const RunContext& context, Terminal& terminal, Watchdog& watchdog,
                                   Report& report) {
  const Result<InputSurface> loaded = load(command.input, command.clean, context, terminal);
  if (!loaded) return loaded.error();
  const InputSurface& input = loaded.value();
  Result<Embedding> made = Error{};
  if (input.cleanup.problem)
    made = *input.cleanup.problem;
  else
    made = embed(input.surface(), {}, context, &report);
  tell(input, report);
  if (!made) return input.in_file(made.error());
  if (Status s = write_surface(command.output, made.value().surface, format, watchdog.writing(context),
                               &input.attributes.faces);
      !s)
    return s.error();
  return made;
}

void finish(Report& report, const EmbedCommand& command, const CommonOptions& common,
            const Result<Embedding>& made) {
  report.options = {
      {"input", command.input}, {"output", command.output}, {"threads", std::int64_t{common.threads}}};
  if (common.time_limit > 0) report.options.emplace_back("time_limit", common.time_limit);
  if (common.memory_limit > 0) report.options.emplace_back("memory_limit", common.memory_limit);
  report.seconds = std::chrono::duration<double>(RunContext::Clock::now() - common.start).count();
  report.message = made ? what_was_made(command, made.value()) : with_hint(made.error());
  if (!made) {
    report.status = status_of(made.error().code);
    report.embedding.reset();
  }
}

}  // namespace

int run(const EmbedCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<SurfaceFormat> format = surface_format_of(command.output);
  if (!format) return fail(terminal, format.error());
  if (Status s = check_names(command.input, command.output, command.report); !s)
    return fail(terminal, s.error());
  OutputAndReport probes;
  if (Status s = probes.open(command.output, command.report); !s) return fail(terminal, s.error());
  StageTrail trail;
  const RunContext context = trail.follow(common.context(terminal));
  Watchdog watchdog(context, common.start, [&](const Error& error) {
    terminal.last_words(with_hint(error));
    if (error.code == ErrorCode::interrupted || command.report.empty()) return;
    Report late;
    late.stages = trail.records();
    finish(late, command, common, error);
    (void)write_text(command.report, to_json(late)).ok();
  });
  Report report;
  Result<Embedding> made =
      caught([&] { return embedded_surface(command, format.value(), context, terminal, watchdog, report); });
  if (!made) made = explained(made.error());
  if (!made) watchdog.settle(made.error().code);
  finish(report, command, common, made);
  terminal.clear();
  const bool interrupted = !made && made.error().code == ErrorCode::interrupted;
  if (!command.report.empty() && !interrupted)
    if (Status s = write_text(command.report, to_json(report)); !s) {
      if (made) return fail(terminal, s.error());
      terminal.error(s.error().message);
    }
  if (command.json && !interrupted)
    if (const std::string text = to_json(report);
        std::fputs(text.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
      return fail(terminal, {ErrorCode::io, "Cannot write standard output."});
  if (!made) return fail(terminal, made.error());
  if (!command.json) terminal.say(report.message);
  return 0;
}

}  // namespace overtet
