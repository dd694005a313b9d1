#include <charconv>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <sstream>

#include "overtet/io.h"
#include "overtet/solve.h"
#include "src/cli/commands.h"
#include "src/cli/expression.h"
#include "src/cli/memory.h"
#include "src/cli/signals.h"

namespace overtet {

namespace {

Error bad_words(const std::string& what) { return {ErrorCode::usage, what}; }

// Numbers of vertices, counted from 0, with commas, blanks or line ends between them.
Result<std::vector<Index>> numbers_in(const std::string& text, const std::string& where) {
  std::vector<Index> out;
  std::string spaced = text;
  for (char& c : spaced)
    if (c == ',') c = ' ';
  std::istringstream words(spaced);
  for (std::string word; words >> word;) {
    Index n = 0;
    const auto [end, wrong] = std::from_chars(word.data(), word.data() + word.size(), n);
    if (wrong != std::errc() || end != word.data() + word.size() || n < 0)
      return bad_words(where + ": '" + word + "' is no number of a vertex.");
    out.push_back(n);
  }
  if (out.empty()) return bad_words(where + ": no vertex is named.");
  return out;
}

// A label by its number or its name.
Result<Index> label_in(const std::string& text, const LabelledTetMesh& mesh) {
  for (const auto& [number, name] : mesh.attributes.labels.names)
    if (name == text) return number;
  Index n = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), n);
  if (wrong == std::errc() && end == text.data() + text.size()) return n;
  return bad_words("The mesh has no label named '" + text + "'.");
}

// all, label:L, vertices:N,N or vertices:@FILE; as a condition without a function.
Result<BoundaryValue> place_in(const std::string& text, const LabelledTetMesh& mesh) {
  BoundaryValue out;
  if (text == "all") return out;
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon),
                    rest = colon == std::string::npos ? "" : text.substr(colon + 1);
  if (kind == "label" && !rest.empty()) {
    const Result<Index> label = label_in(rest, mesh);
    if (!label) return label.error();
    out.label = label.value();
    return out;
  }
  if (kind == "vertices" && !rest.empty()) {
    std::string list = rest;
    if (rest.starts_with('@')) {
      Result<std::string> read = text_of(rest.substr(1));
      if (!read) return read.error();
      list = std::move(read).value();
    }
    Result<std::vector<Index>> numbers = numbers_in(list, text);
    if (!numbers) return numbers.error();
    out.vertices = std::move(numbers).value();
    return out;
  }
  return bad_words("'" + text +
                   "' is no place; write all, label:NUMBER, label:NAME, vertices:N,N,... or vertices:@FILE.");
}

Result<std::vector<BoundaryValue>> conditions_in(const std::vector<std::string>& words,
                                                 const LabelledTetMesh& mesh) {
  std::vector<BoundaryValue> out;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) return bad_words("'" + word + "' gives no value; write WHERE=FORMULA.");
    Result<BoundaryValue> place = place_in(word.substr(0, equals), mesh);
    if (!place) return place.error();
    Result<ScalarFunction> function = function_of(word.substr(equals + 1));
    if (!function) return function.error();
    out.push_back(std::move(place).value());
    out.back().function = std::move(function).value();
  }
  return out;
}

// What is written, and what is said of it.
struct Solution {
  std::string name;  // of the data
  Eigen::VectorXd values;
  nlohmann::ordered_json figures = nlohmann::ordered_json::object();
};

Result<Solution> field_of(const SolveCommand& c, const LabelledTetMesh& mesh, const RunContext& context) {
  FieldOptions o;
  o.equation = c.equation == "poisson"      ? FieldEquation::poisson
               : c.equation == "biharmonic" ? FieldEquation::biharmonic
                                            : FieldEquation::laplace;
  o.order = c.order;
  Result<std::vector<BoundaryValue>> values = conditions_in(c.values, mesh),
                                     fluxes = conditions_in(c.fluxes, mesh);
  if (!values) return values.error();
  if (!fluxes) return fluxes.error();
  o.values = std::move(values).value();
  o.fluxes = std::move(fluxes).value();
  if (!c.source.empty()) {
    Result<ScalarFunction> source = function_of(c.source);
    if (!source) return source.error();
    o.source = std::move(source).value();
  }
  Result<Field> solved = solve_field(mesh, o, context);
  if (!solved) return solved.error();
  Field& f = solved.value();
  return Solution{"u",
                  std::move(f.values),
                  {{"energy", f.energy},
                   {"residual", f.residual},
                   {"factor_entries", f.factor_entries},
                   {"seconds_assembly", f.seconds_assembly},
                   {"seconds_factor", f.seconds_factor},
                   {"seconds_solve", f.seconds_solve}}};
}

// The vertices of the places named.
Result<std::vector<Index>> sources_of(const SolveCommand& c, const LabelledTetMesh& mesh) {
  std::vector<Index> out;
  for (const std::string& word : c.from) {
    const Result<BoundaryValue> place = place_in(word, mesh);
    if (!place) return place.error();
    const BoundaryValue& p = place.value();
    out.insert(out.end(), p.vertices.begin(), p.vertices.end());
    if (!p.vertices.empty()) continue;
    const TriangleMatrix& F = mesh.attributes.triangles;
    const std::size_t before = out.size();
    for (Eigen::Index f = 0; f < F.rows(); ++f)
      if (!p.label || mesh.attributes.labels.of[static_cast<std::size_t>(f)] == *p.label)
        for (int k = 0; k < 3; ++k) out.push_back(F(f, k));
    if (out.size() == before) return bad_words("No triangle of the mesh is in " + word + ".");
  }
  return out;
}

Result<Solution> distances_of(const SolveCommand& c, const LabelledTetMesh& mesh, const RunContext& context) {
  const Result<std::vector<Index>> sources = sources_of(c, mesh);
  if (!sources) return sources.error();
  DistanceOptions options;
  options.smoothing = c.smoothing;
  const Result<Distances> prepared = Distances::prepare(mesh.mesh, options, context);
  if (!prepared) return prepared.error();
  Result<Eigen::VectorXd> found = prepared.value().from(sources.value(), context);
  if (!found) return found.error();
  return Solution{"distance", std::move(found).value()};
}

Status check(const SolveCommand& c) {
  const bool distances = c.equation == "geodesic";
  if (distances && c.from.empty()) return bad_words("Distances need a source: --from WHERE.");
  if (distances && (!c.values.empty() || !c.fluxes.empty() || !c.source.empty() || c.order != 1))
    return bad_words("Of geodesic distances, only --from and --smoothing are given.");
  if (!distances && !c.from.empty()) return bad_words("--from is the source of geodesic distances.");
  if (same_file(c.input, c.output))
    return bad_words("The output would overwrite the input; choose another name.");
  return success();
}

Result<Solution> solve_and_write(const SolveCommand& c, TetFormat format, const RunContext& context,
                                 const RunContext& writing) {
  context.report("read", 0);
  Result<LabelledTetMesh> read = read_labelled_tets(c.input, context);
  if (!read) return read.error();
  LabelledTetMesh& mesh = read.value();
  context.report("solve", 0);
  Result<Solution> solved =
      c.equation == "geodesic" ? distances_of(c, mesh, context) : field_of(c, mesh, context);
  if (!solved) return solved;
  const Eigen::VectorXd& u = solved.value().values;
  mesh.attributes.vertex_data.push_back(
      {solved.value().name, NumberType::float64, 1, std::vector<double>(u.data(), u.data() + u.size())});
  TetWriteOptions options;
  options.format = format;
  options.order = c.order;
  if (Status s = write_tets(c.output, mesh.mesh, mesh.attributes, options, writing); !s) return s.error();
  return solved;
}

}  // namespace

int run(const SolveCommand& command, const CommonOptions& common, Terminal& terminal) {
  const Result<TetFormat> format = tet_format_of(command.output);
  if (!format) return fail(terminal, format.error());
  if (format.value() != TetFormat::vtu && format.value() != TetFormat::vtk)
    return fail(terminal,
                bad_words("Fields are written as .vtu or .vtk; the other formats have no place for them."));
  if (Status s = check(command); !s) return fail(terminal, s.error());
  OutputProbe probe;
  if (Status s = probe.open(command.output); !s) return fail(terminal, s.error());
  const RunContext context = common.context(terminal);
  Watchdog watchdog(context, common.start,
                    [&](const Error& error) { terminal.last_words(with_hint(error)); });
  Result<Solution> solved =
      caught([&] { return solve_and_write(command, format.value(), context, watchdog.writing(context)); });
  if (!solved) return fail(watchdog, terminal, solved.error());
  terminal.clear();
  const double seconds = std::chrono::duration<double>(RunContext::Clock::now() - common.start).count();
  const Solution& s = solved.value();
  nlohmann::ordered_json j = {{"equation", command.equation},
                              {"nodes", s.values.size()},
                              {"least", s.values.minCoeff()},
                              {"most", s.values.maxCoeff()}};
  j.update(s.figures);
  j["seconds"] = seconds;
  if (command.json) {
    const std::string printed = j.dump(2) + "\n";
    if (std::fputs(printed.c_str(), stdout) < 0 || std::fflush(stdout) != 0)
      return fail(terminal, {ErrorCode::io, "Cannot write standard output."});
    return 0;
  }
  char text[160];
  std::snprintf(text, sizeof text, ": %s at %lld nodes, from %.6g to %.6g, %.1f s.", s.name.c_str(),
                static_cast<long long>(s.values.size()), s.values.minCoeff(), s.values.maxCoeff(), seconds);
  terminal.say(command.output + text);
  return 0;
}

}  // namespace overtet
