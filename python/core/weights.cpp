#include "python/core/weights.h"

#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "overtet/weights.h"
#include "python/core/arrays.h"
#include "python/core/calls.h"
#include "python/core/records.h"

namespace overtet::python {

namespace {

using namespace py::literals;
using Rows = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

// path: of a file; else json.
Result<Handles> handles_of(const std::string& path, const std::string& json) {
  return path.empty() ? parse_handles("handles", json) : read_handles(path);
}

py::dict skinning_weights_(const py::handle& V, const py::handle& T, const std::string& path,
                           const std::string& json, bool cut_bones, const py::dict& run) {
  const TetMesh mesh = tets_of(V, T);
  const Handles handles = value_of(handles_of(path, json));
  WeightOptions options;
  options.cut_bones = cut_bones;
  SkinningWeights w = value_of(call(
      run, [&](const RunContext& context) { return skinning_weights(mesh, handles, options, context); }));
  py::list names, energy, residual, end, held, cut_at;
  for (std::size_t h = 0; h < w.handles.size(); ++h) {
    const HandleWeights& x = w.handles[h];
    names.append(name_text(handles.handles[h].name));
    energy.append(x.energy);
    residual.append(x.residual);
    end.append(x.end == WeightsEnd::exact ? "exact" : x.end == WeightsEnd::gap ? "gap" : "stalled");
    held.append(x.held);
    cut_at.append(x.cut_at);
  }
  Rows rows = w.weights;
  const auto vertices = static_cast<py::ssize_t>(rows.rows()), count = static_cast<py::ssize_t>(rows.cols());
  return py::dict("names"_a = names, "weights"_a = owned<double>(std::move(rows), {vertices, count}),
                  "energy"_a = energy, "residual"_a = residual, "end"_a = end, "held"_a = held,
                  "cut_at"_a = cut_at, "shared"_a = w.shared);
}

// given_weights: #V * #H numbers, by vertex.
py::dict skinned_(const py::handle& V, const py::handle& T, const std::string& path, const std::string& json,
                  const py::handle& given_weights, const std::string& pose, const py::dict& run) {
  const TetMesh mesh = tets_of(V, T);
  const Handles handles = value_of(handles_of(path, json));
  const std::vector<HandlePose> poses = value_of(parse_pose("pose", pose, handles));
  const std::vector<double> weights = vector_of<double>(given_weights);
  const auto count = static_cast<Eigen::Index>(handles.handles.size());
  const auto rows = static_cast<Eigen::Index>(weights.size()) / count;
  SkinnedMesh s = value_of(call(run, [&](const RunContext&) -> Result<SkinnedMesh> {
    const Result<std::vector<AffineMatrix>> transforms = pose_transforms(handles, mesh.V, poses);
    if (!transforms) return transforms.error();
    return skinned(mesh, Eigen::Map<const Rows>(weights.data(), rows, count), transforms.value());
  }));
  return py::dict("V"_a = array_of(std::move(s.mesh.V)), "flipped"_a = s.flipped,
                  "first_flipped"_a = s.first_flipped);
}

}  // namespace

void add_weights(py::module_& module) {
  module.def("skinning_weights", &skinning_weights_);
  module.def("skinned", &skinned_);
}

}  // namespace overtet::python
