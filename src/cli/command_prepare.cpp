#include <charconv>
#include <cstdio>
#include <iterator>
#include <nlohmann/json.hpp>
#include <variant>

#include "overtet/io.h"
#include "overtet/prepare.h"
#include "overtet/version.h"
#include "src/cli/commands.h"
#include "src/cli/memory.h"
#include "src/cli/signals.h"

namespace overtet {

namespace {

using Json = nlohmann::ordered_json;

struct Prepared {
  SurfaceReadInfo info;
  Index given_vertices = 0, given_faces = 0;
  Preparation preparation;
};

// Every second one of these is read or written; no two may be one file.
Status check(const PrepareCommand& c) {
  const std::string* const files[] = {&c.input, &c.output, &c.report, &c.save_map};
  for (std::size_t i = 1; i < std::size(files); ++i)
    for (std::size_t j = 0; j < i; ++j)
      if (same_file(*files[i], *files[j]))
        return Error{ErrorCode::usage, "Two files that are read or written are both called " + *files[i] +
                                           "; choose another name for one of them."};
  return success();
}

// The numbers that vertices and faces have in the file, -1: new ones.
std::string map_text(const Prepared& p) {
  const Cleanup& r = p.preparation.result;
  const SurfaceSource& source = p.info.source;
  std::string text = "{\n";
  const auto list = [&](const char* name, const std::vector<Index>& map, const auto& in_file,
                        const char* end) {
    text += std::string("  \"") + name + "\": [";
    char digits[16];
    for (std::size_t i = 0; i < map.size(); ++i) {
      if (i > 0) text += ", ";
      text.append(digits, std::to_chars(digits, std::end(digits), map[i] < 0 ? -1 : in_file(map[i])).ptr);
    }
    text += std::string("]") + end;
  };
  list(
      "vertices", r.vertex_of, [&](Index v) { return source.vertex_in_file(v); }, ",\n");
  list(
      "faces", r.face_of, [&](Index f) { return source.face_in_file(f); }, "\n}\n");
  return text;
}

// What comes with the faces; the new ones have label 0.
SurfaceAttributes attributes_of(const Prepared& p) {
  SurfaceAttributes a =
      carried(p.info.attributes, p.preparation.result.vertex_of, p.preparation.result.face_of);
  for (std::size_t f = 0; f < a.faces.of.size(); ++f)
    if (p.preparation.result.face_of[f] < 0) a.faces.of[f] = 0;
  return a;
}

Result<Prepared> prepared(const PrepareCommand& command, SurfaceFormat format, const RunContext& context,
                          Terminal& terminal, Watchdog& watchdog) {
  Prepared out;
  {
    Result<Surface> read = read_surface(command.input, &out.info, context);
    if (!read) return read.error();
    const Surface given = std::move(read).value();
    out.given_vertices = static_cast<Index>(given.V.rows());
    out.given_faces = static_cast<Index>(given.F.rows());
    for (const std::string& note : out.info.notes) terminal.say(note);
    Result<Preparation> made = prepare(given, command.options, out.info.source, context);
    if (!made) return made.error();
    out.preparation = std::move(made).value();
  }
  terminal.clear();
  const Cleanup& result = out.preparation.result;
  if (const std::string done = result.summary(); !done.empty()) terminal.say(done);
  for (const PrepareRecord& step : out.preparation.steps) terminal.say(step.message);
  if (result.surface.F.rows() == 0)
    return Error{ErrorCode::bad_input, "No face is left, and nothing was written."};
  const SurfaceAttributes attributes = attributes_of(out);
  if (Status s =
          write_surface(command.output, result.surface, format, watchdog.writing(context), &attributes.faces);
      !s)
    return s.error();
  if (!command.save_map.empty())
    if (Status s = write_text(command.save_map, map_text(out)); !s) return s.error();
  return out;
}

std::string message_of(const PrepareCommand& command, const Prepared& p) {
  const Surface& s = p.preparation.result.surface;
  std::string text = command.output + ": " + std::to_string(s.V.rows()) + " vertices, " +
                     std::to_string(s.F.rows()) + " faces, ";
  if (p.preparation.remaining.empty()) return text + "closed, oriented and manifold.";
  return text + "not closed yet: " + p.preparation.remaining.front().message;
}

Json to_json(const PrepareRecord& step, const SurfaceSource& source) {
  Json j = {
      {"step", name_of(step.step)}, {"seconds", step.seconds}, {"done", step.done}, {"left", step.left}};
  j["figures"] = Json::object();
  for (const Figure& figure : step.figures)
    std::visit([&](const auto& value) { j["figures"][figure.first] = value; }, figure.second);
  j["places"] = Json::array();
  for (const PlaceLeft& p : step.places) {
    Json place = {{"position", p.position}, {"why", p.why}};
    if (p.vertex >= 0) place["vertex"] = source.vertex_in_file(p.vertex) + source.first;
    if (p.edges > 0) place["edges"] = p.edges;
    j["places"].push_back(place);
  }
  j["message"] = step.message;
  return j;
}

Json runs(const std::vector<NumberRun>& list) {
  Json j = Json::array();
  for (const NumberRun& r : list) j.push_back({r.first, r.in_file, r.count, r.each});
  return j;
}

Json to_json(const PrepareOptions& o) {
  return {{"weld", 100 * o.weld},
          {"close_cracks", o.close_cracks},
          {"remove_small", o.remove_small},
          {"largest", o.largest},
          {"fill_holes", o.fill_holes},
          {"collapse_needles", o.collapse_needles},
          {"tolerance", 100 * o.tolerance},
          {"needle_angle", o.needle_degrees},
          {"allow_crossings", o.allow_crossings}};
}

Json report_of(const PrepareCommand& command, const CommonOptions& common, const Result<Prepared>& result,
               const std::string& message) {
  Json j = {{"version", version()}, {"command", "prepare"}};
  j["status"] = result ? "prepared" : name_of(status_of(result.error().code));
  j["message"] = message;
  j["options"] = to_json(command.options);
  j["options"]["input"] = command.input;
  j["options"]["output"] = command.output;
  j["seconds"] = std::chrono::duration<double>(RunContext::Clock::now() - common.start).count();
  if (!result) return j;
  const Prepared& p = result.value();
  const Preparation& r = p.preparation;
  const CleanupRecord record = record_of(r.result, p.info.source);
  j["input"] = {{"format", p.info.format},
                {"notes", p.info.notes},
                {"vertices", p.given_vertices},
                {"faces", p.given_faces}};
  j["input"]["clean_up"] = Json::object();
  for (const auto& [kind, count] : record.steps) j["input"]["clean_up"][kind] = count;
  j["steps"] = Json::array();
  for (const PrepareRecord& step : r.steps) j["steps"].push_back(to_json(step, p.info.source));
  j["result"] = {{"vertices", r.result.surface.V.rows()},
                 {"faces", r.result.surface.F.rows()},
                 {"closed", r.remaining.empty()},
                 {"moved", r.moved}};
  j["result"]["map"] = {{"vertices", runs(record.vertices)}, {"faces", runs(record.faces)}};
  j["remaining"] = Json::array();
  for (const Defect& d : r.remaining)
    j["remaining"].push_back({{"kind", name_of(d.kind)}, {"count", d.count}, {"message", d.message}});
  return j;
}

}  // namespace

int run(const PrepareCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<SurfaceFormat> format = surface_format_of(command.output);
  if (!format) return fail(terminal, format.error());
  if (Status s = check(command); !s) return fail(terminal, s.error());
  if (!command.options.any())
    return fail(terminal,
                {ErrorCode::usage,
                 "Say what is to be done: --weld, --close-cracks, --remove-small, --largest, --fill-holes, "
                 "--collapse-needles or --all (overtet help prepare explains them)."});
  OutputAndReport probes;
  if (Status s = probes.open(command.output, command.report); !s) return fail(terminal, s.error());
  const RunContext context = common.context(terminal);
  const auto write_report = [&](const Result<Prepared>& of, const std::string& message) {
    const Json report = report_of(command, common, of, message);
    return write_text(command.report, report.dump(2, ' ', false, Json::error_handler_t::replace) + "\n");
  };
  Watchdog watchdog(context, common.start, [&](const Error& error) {
    terminal.last_words(with_hint(error));
    if (error.code == ErrorCode::interrupted || command.report.empty()) return;
    (void)write_report(error, with_hint(error)).ok();
  });
  Result<Prepared> result =
      caught([&] { return prepared(command, format.value(), context, terminal, watchdog); });
  if (!result) result = explained(result.error());
  if (!result) watchdog.settle(result.error().code);
  terminal.clear();
  const std::string message = result ? message_of(command, result.value()) : with_hint(result.error());
  const bool interrupted = !result && result.error().code == ErrorCode::interrupted;
  if (!command.report.empty() && !interrupted) {
    if (Status s = write_report(result, message); !s) {
      if (result) return fail(terminal, s.error());
      terminal.error(s.error().message);
    }
  }
  if (!result) return fail(terminal, result.error());
  terminal.say(message);
  return 0;
}

}  // namespace overtet
