#include <algorithm>
#include <cstdio>
#include <utility>

#include "overtet/io.h"
#include "overtet/weights.h"
#include "src/cli/commands.h"
#include "src/cli/solve_kinds.h"

namespace overtet {

namespace {

bool ends_in(const std::string& path, const char* ending) { return path.ends_with(ending); }

Result<TetFormat> field_format(const std::string& path, const char* otherwise) {
  const Result<TetFormat> format = tet_format_of(path);
  if (format && (format.value() == TetFormat::vtu || format.value() == TetFormat::vtk)) return format;
  return Error{ErrorCode::usage, otherwise};
}

nlohmann::ordered_json figures_of(const SkinningWeights& w, const Handles& handles) {
  nlohmann::ordered_json out = {{"vertices", w.weights.rows()},
                                {"least_sum", w.least_sum},
                                {"most_sum", w.most_sum},
                                {"shared_vertices", w.shared},
                                {"factor_entries", w.factor_entries},
                                {"seconds_prepare", w.seconds_prepare},
                                {"seconds_solve", w.seconds_solve}};
  out["handles"] = nlohmann::ordered_json::array();
  for (std::size_t h = 0; h < w.handles.size(); ++h) {
    const HandleWeights& x = w.handles[h];
    out["handles"].push_back({{"name", handles.handles[h].name},
                              {"energy", x.energy},
                              {"residual", x.residual},
                              {"interior_steps", x.interior_steps},
                              {"active_set_steps", x.active_set_steps},
                              {"end", x.end == WeightsEnd::exact ? "exact"
                                      : x.end == WeightsEnd::gap ? "gap"
                                                                 : "stalled"},
                              {"held_vertices", x.held},
                              {"cut_at", x.cut_at}});
  }
  return out;
}

// The boundary as a skin.
Status write_glb(const SolveCommand& c, const TetMesh& mesh, const Handles& handles, const SkinningWeights& w,
                 const RunContext& writing, SolveSummary& out) {
  const Result<SkinFigures> skin = write_skin(c.output, mesh, handles, w.weights, writing);
  if (!skin) return skin.error();
  out.figures["joint_sets"] = skin.value().sets;
  out.figures["dropped"] = skin.value().dropped;
  char text[120];
  std::snprintf(text, sizeof text,
                "; at most %d handles a vertex, what was left out is at most %.2g of its weights",
                4 * skin.value().sets, skin.value().dropped);
  out.sentence += text;
  return success();
}

Status write_with_weights(const SolveCommand& c, TetFormat format, LabelledTetMesh& mesh,
                          const Handles& handles, const SkinningWeights& w, const RunContext& writing) {
  for (std::size_t h = 0; h < handles.handles.size(); ++h) {
    const auto column = w.weights.col(static_cast<Eigen::Index>(h));
    put_vertex_data(mesh.attributes, handles.handles[h].name, 1,
                    std::vector<double>(column.begin(), column.end()));
  }
  TetWriteOptions options;
  options.format = format;
  return write_tets(c.output, mesh.mesh, mesh.attributes, options, writing);
}

// Of a .csv file, or of data of vertices named as the handles.
Result<Eigen::MatrixXd> weights_in(const std::string& path, const Handles& handles,
                                   const RunContext& context) {
  if (ends_in(path, ".csv") || ends_in(path, ".csv.gz")) return read_weights_csv(path, handles);
  const Result<LabelledTetMesh> read = read_labelled_tets(path, context);
  if (!read) return read.error();
  const std::vector<Attribute>& data = read.value().attributes.vertex_data;
  Eigen::MatrixXd out(read.value().mesh.V.rows(), std::ssize(handles.handles));
  for (std::size_t h = 0; h < handles.handles.size(); ++h) {
    const auto found = std::find_if(data.begin(), data.end(), [&](const Attribute& a) {
      return a.name == handles.handles[h].name && a.width == 1;
    });
    if (found == data.end())
      return Error{ErrorCode::bad_input,
                   path + " has no weights of '" + handles.handles[h].name + "' at its vertices."};
    for (Eigen::Index v = 0; v < out.rows(); ++v)
      out(v, static_cast<Eigen::Index>(h)) = found->values[static_cast<std::size_t>(v)];
  }
  return out;
}

}  // namespace

Result<SolveSummary> solve_for_weights(const SolveCommand& c, const RunContext& context,
                                       const RunContext& writing) {
  const bool glb = ends_in(c.output, ".glb"), csv = ends_in(c.output, ".csv") || ends_in(c.output, ".csv.gz");
  TetFormat format = TetFormat::vtu;
  if (!glb && !csv) {
    const Result<TetFormat> named =
        field_format(c.output, "Weights are written as .vtu, .vtk, .glb or .csv.");
    if (!named) return named.error();
    format = named.value();
  }
  if (same_file(c.skinning.handles, c.output))
    return Error{ErrorCode::usage, "The output would overwrite the handles; choose another name."};
  context.report("read", 0);
  const Result<Handles> handles = read_handles(c.skinning.handles);
  if (!handles) return handles.error();
  Result<LabelledTetMesh> read = read_labelled_tets(c.input, context);
  if (!read) return read.error();
  context.report("solve", 0);
  WeightOptions options;
  options.cut_bones = c.skinning.cut_bones;
  const Result<SkinningWeights> solved =
      skinning_weights(read.value().mesh, handles.value(), options, context);
  if (!solved) return solved.error();
  const SkinningWeights& w = solved.value();
  SolveSummary out;
  out.figures = figures_of(w, handles.value());
  const auto stalled = std::count_if(w.handles.begin(), w.handles.end(),
                                     [](const HandleWeights& h) { return h.end == WeightsEnd::stalled; });
  out.sentence = "weights of " + std::to_string(w.weights.cols()) + " handles at " +
                 std::to_string(w.weights.rows()) + " vertices";
  if (w.shared > 0) out.sentence += ", of which several handles share " + std::to_string(w.shared);
  if (stalled > 0)
    out.sentence += "; " + std::to_string(stalled) + " of them are less exact than usual (see --json)";
  Status done = glb   ? write_glb(c, read.value().mesh, handles.value(), w, writing, out)
                : csv ? write_weights_csv(c.output, handles.value(), w.weights, writing)
                      : write_with_weights(c, format, read.value(), handles.value(), w, writing);
  if (!done) return done.error();
  return out;
}

Result<SolveSummary> solve_for_skin(const SolveCommand& c, const RunContext& context,
                                    const RunContext& writing) {
  const Result<TetFormat> format = tet_format_of(c.output);
  if (!format) return format.error();
  for (const std::string* input : {&c.skinning.handles, &c.skinning.weights, &c.skinning.pose})
    if (same_file(*input, c.output))
      return Error{ErrorCode::usage, "The output would overwrite " + *input + "; choose another name."};
  context.report("read", 0);
  const Result<Handles> handles = read_handles(c.skinning.handles);
  if (!handles) return handles.error();
  const Result<std::vector<HandlePose>> pose = read_pose(c.skinning.pose, handles.value());
  if (!pose) return pose.error();
  Result<LabelledTetMesh> read = read_labelled_tets(c.input, context);
  if (!read) return read.error();
  LabelledTetMesh& mesh = read.value();
  const Result<Eigen::MatrixXd> weights = weights_in(c.skinning.weights, handles.value(), context);
  if (!weights) return weights.error();
  context.report("solve", 0);
  const Result<std::vector<AffineMatrix>> transforms =
      pose_transforms(handles.value(), mesh.mesh.V, pose.value());
  if (!transforms) return transforms.error();
  Result<SkinnedMesh> posed = skinned(mesh.mesh, weights.value(), transforms.value());
  if (!posed) return posed.error();
  const SkinnedMesh& s = posed.value();
  TetWriteOptions options;
  options.format = format.value();
  if (Status done = write_tets(c.output, s.mesh, mesh.attributes, options, writing); !done)
    return done.error();
  SolveSummary out;
  out.figures = {{"vertices", s.mesh.V.rows()}, {"tets", s.mesh.T.rows()}, {"flipped_tets", s.flipped}};
  if (s.flipped > 0) out.figures["first_flipped_tet"] = s.first_flipped;
  out.sentence = std::to_string(s.mesh.V.rows()) + " vertices in the pose, " +
                 (s.flipped == 0 ? "all tets positive"
                                 : std::to_string(s.flipped) + " of " + std::to_string(s.mesh.T.rows()) +
                                       " tets flipped, the first is " + std::to_string(s.first_flipped) +
                                       " (counted from 0)");
  return out;
}

}  // namespace overtet
