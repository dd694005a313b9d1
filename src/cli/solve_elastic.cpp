#include <algorithm>
#include <array>
#include <charconv>
#include <cstdio>
#include <string_view>
#include <utility>

#include "overtet/elastic.h"
#include "overtet/io.h"
#include "src/cli/places.h"
#include "src/cli/solve_kinds.h"

namespace overtet {

namespace {

Error wrong_word(const std::string& what) { return {ErrorCode::usage, what}; }

// "1,2,3": so many numbers.
template <std::size_t N>
Result<std::array<double, N>> numbers_of(const std::string& text, const char* option, const char* form) {
  std::array<double, N> out{};
  const char *at = text.data(), *const end = at + text.size();
  for (std::size_t i = 0; i < N; ++i) {
    const auto [next, wrong] = std::from_chars(at, end, out[i]);
    if (wrong != std::errc() || (i + 1 < N ? next == end || *next != ',' : next != end))
      return wrong_word(std::string(option) + ": '" + text + "' is not of the form " + form + ".");
    at = next + 1;
  }
  return out;
}

Status add_conditions(const ElasticWords& words, const LabelledTetMesh& mesh, ElasticOptions& o) {
  for (const std::string& word : words.fixed) {
    Result<BoundaryValue> place = place_in(word, mesh);
    if (!place) return place.error();
    o.held.push_back({place.value().label, std::move(place.value().vertices), {}});
  }
  Result<std::vector<ElasticCondition>> pulled = vector_conditions_in(words.pulled, mesh),
                                        tractions = vector_conditions_in(words.tractions, mesh),
                                        forces = vector_conditions_in(words.forces, mesh);
  for (const auto* list : {&pulled, &tractions, &forces})
    if (!*list) return list->error();
  std::move(pulled.value().begin(), pulled.value().end(), std::back_inserter(o.held));
  o.tractions = std::move(tractions).value();
  o.forces = std::move(forces).value();
  return success();
}

Status add_rest(const ElasticWords& words, const LabelledTetMesh& mesh, const RunContext& context,
                ElasticOptions& o) {
  if (words.rest.empty()) return success();
  Result<TetMesh> rest = read_tets(words.rest, context);
  if (!rest) return rest.error();
  if (rest.value().V.rows() != mesh.mesh.V.rows() || rest.value().T.rows() != mesh.mesh.T.rows() ||
      rest.value().T != mesh.mesh.T)
    return wrong_word(words.rest + " is no rest shape of the mesh: its tets are others.");
  o.rest = std::move(rest.value().V);
  return success();
}

Result<ElasticOptions> options_of(const ElasticWords& words, const LabelledTetMesh& mesh,
                                  const RunContext& context) {
  ElasticOptions o;
  o.material = words.material == "st-venant-kirchhoff" ? ElasticMaterial::st_venant_kirchhoff
               : words.material == "corotated"         ? ElasticMaterial::corotated
                                                       : ElasticMaterial::neo_hookean;
  o.young = words.young, o.poisson = words.poisson, o.density = words.density;
  if (!words.gravity.empty()) {
    const auto g = numbers_of<3>(words.gravity, "--gravity", "X,Y,Z");
    if (!g) return g.error();
    o.gravity = Eigen::Vector3d(g.value()[0], g.value()[1], g.value()[2]);
  }
  if (!words.damping.empty()) {
    const auto d = numbers_of<2>(words.damping, "--damping", "MASS,STIFFNESS");
    if (!d) return d.error();
    o.mass_damping = d.value()[0], o.stiffness_damping = d.value()[1];
  }
  o.dynamic = words.dynamic;
  o.integrator = words.integrator == "bdf2" ? ElasticIntegrator::bdf2 : ElasticIntegrator::implicit_euler;
  o.time_step = words.step, o.frames = words.frames;
  if (!words.method.empty())
    o.method = words.method == "newton" ? ElasticMethod::newton : ElasticMethod::quasi_newton;
  o.tolerance = words.tolerance, o.most_iterations = words.iterations;
  if (Status s = add_conditions(words, mesh, o); !s) return s.error();
  if (Status s = add_rest(words, mesh, context, o); !s) return s.error();
  return o;
}

// The mesh where it is now, with what is known of it, in one file or in one a frame.
class FrameWriter {
 public:
  FrameWriter(const SolveCommand& command, LabelledTetMesh mesh, const RunContext& writing)
      : command_(command), mesh_(std::move(mesh)), start_(mesh_.mesh.V), writing_(writing) {}

  // Errors: usage.
  Status open() {
    const std::string& output = command_.output;
    series_ = output.ends_with(".pvd");
    format_ = TetFormat::vtu;
    if (!series_) {
      const Result<TetFormat> format = tet_format_of(output);
      if (!format) return format.error();
      if (format.value() != TetFormat::vtu && format.value() != TetFormat::vtk)
        return wrong_word("What is elastic is written as .vtu or .vtk, or all frames as .pvd.");
      format_ = format.value();
      return success();
    }
    for (int frame = 0; frame <= command_.elastic.frames; ++frame)
      if (same_file(command_.input, name(frame)))
        return wrong_word("The file of frame " + std::to_string(frame) +
                          " would overwrite the input; choose another name.");
    return success();
  }

  bool is_series() const { return series_; }

  Status write(const Elastic& body, const std::string& path) {
    mesh_.mesh.V = body.places();
    const VertexMatrix u = body.places() - start_;
    const Eigen::VectorXd s = body.von_mises_at_vertices();
    put_vertex_data(mesh_.attributes, "displacement", 3, {u.data(), u.data() + u.size()});
    put_vertex_data(mesh_.attributes, "von_mises", 1, {s.data(), s.data() + s.size()});
    if (command_.elastic.dynamic) {
      const VertexMatrix& v = body.velocities();
      put_vertex_data(mesh_.attributes, "velocity", 3, {v.data(), v.data() + v.size()});
    }
    most_displacement_ = u.rowwise().norm().maxCoeff();
    most_stress_ = s.maxCoeff();
    TetWriteOptions options;
    options.format = format_;
    return write_tets(path, mesh_.mesh, mesh_.attributes, options, writing_);
  }

  // The list names complete files only, and all that there are.
  Status add(const Elastic& body) {
    const std::string path = name(static_cast<int>(files_.size()));
    if (Status s = write(body, path); !s) return s;
    files_.push_back({body.time(), path.substr(path.rfind('/') + 1)});
    return write_collection(command_.output, files_, writing_);
  }

  double most_displacement() const { return most_displacement_; }
  double most_stress() const { return most_stress_; }

 private:
  std::string name(int frame) const {
    char number[24];
    std::snprintf(number, sizeof number, "_%04d.vtu", frame);
    return command_.output.substr(0, command_.output.size() - 4) + number;
  }

  const SolveCommand& command_;
  LabelledTetMesh mesh_;
  VertexMatrix start_;
  const RunContext& writing_;
  TetFormat format_ = TetFormat::vtu;
  bool series_ = false;
  std::vector<FileAtTime> files_;
  double most_displacement_ = 0, most_stress_ = 0;
};

SolveSummary summary_of(const LabelledTetMesh& mesh, const std::vector<ElasticStep>& steps, double seconds,
                        const FrameWriter& writer) {
  int iterations = 0, unconverged = 0;
  double residual = 0, least = steps.front().least_ratio;
  nlohmann::ordered_json list = nlohmann::ordered_json::array();
  for (const ElasticStep& s : steps) {
    iterations += s.iterations, unconverged += !s.converged;
    residual = std::max(residual, s.residual), least = std::min(least, s.least_ratio);
    list.push_back({{"time", s.time},
                    {"parts", s.parts},
                    {"iterations", s.iterations},
                    {"line_search_steps", s.line_search_steps},
                    {"factorisations", s.factorisations},
                    {"elastic_energy", s.elastic_energy},
                    {"kinetic_energy", s.kinetic_energy},
                    {"residual", s.residual},
                    {"converged", s.converged},
                    {"least_ratio", s.least_ratio},
                    {"seconds", s.seconds}});
  }
  SolveSummary out;
  const double rate = static_cast<double>(steps.size()) / seconds;
  out.figures = {{"vertices", mesh.mesh.V.rows()},
                 {"tets", mesh.mesh.T.rows()},
                 {"end", unconverged == 0 ? "converged" : "iterations"},
                 {"frames", steps.size()},
                 {"frames_a_second", rate},
                 {"iterations", iterations},
                 {"residual", residual},
                 {"most_displacement", writer.most_displacement()},
                 {"most_von_mises", writer.most_stress()},
                 {"least_ratio", least},
                 {"steps", list}};
  char text[240];
  int length = std::snprintf(
      text, sizeof text, "%zu frame%s of %lld tets, %.3g a second; displacements up to %.6g, residual %.2g",
      steps.size(), steps.size() == 1 ? "" : "s", static_cast<long long>(mesh.mesh.T.rows()), rate,
      writer.most_displacement(), residual);
  if (unconverged > 0)
    std::snprintf(text + length, sizeof text - static_cast<std::size_t>(length),
                  " (%d frames have used all their iterations)", unconverged);
  out.sentence = text;
  return out;
}

}  // namespace

Result<SolveSummary> solve_for_elastic(const SolveCommand& command, const RunContext& context,
                                       const RunContext& writing) {
  context.report("read", 0);
  Result<LabelledTetMesh> read = read_labelled_tets(command.input, context);
  if (!read) return read.error();
  const LabelledTetMesh& mesh = read.value();
  const Result<ElasticOptions> options = options_of(command.elastic, mesh, context);
  if (!options) return options.error();
  FrameWriter writer(command, mesh, writing);
  if (Status s = writer.open(); !s) return s.error();
  context.report("elastic", 0);
  Result<Elastic> prepared = Elastic::prepare(mesh, options.value(), context);
  if (!prepared) return prepared.error();
  Elastic& body = prepared.value();
  if (writer.is_series())
    if (Status s = writer.add(body); !s) return s.error();
  std::vector<ElasticStep> steps;
  double seconds = 0;  // without writing
  for (int frame = 0; frame < options.value().frames; ++frame) {
    context.report("elastic", static_cast<double>(frame) / options.value().frames);
    const Result<ElasticStep> step = body.step(context);
    if (!step) return step.error();
    steps.push_back(step.value());
    seconds += step.value().seconds;
    if (writer.is_series())
      if (Status s = writer.add(body); !s) return s.error();
  }
  if (!writer.is_series())
    if (Status s = writer.write(body, command.output); !s) return s.error();
  return summary_of(mesh, steps, seconds, writer);
}

}  // namespace overtet
