#include "src/view/checks.h"

namespace overtet::view {

namespace {

Error wrong(const std::string& what) { return {ErrorCode::bad_input, "Cannot show this: " + what + "."}; }

template <class Matrix>
Status check_elements(const VertexMatrix& V, const Matrix& elements, const char* what) {
  if (!V.allFinite()) return wrong("a coordinate is not finite");
  if (elements.size() > 0 && (elements.minCoeff() < 0 || elements.maxCoeff() >= V.rows()))
    return wrong(std::string("a ") + what + " has a vertex that there is not");
  return success();
}

Status check_size(std::size_t size, Eigen::Index wanted, const char* what) {
  if (size == 0 || static_cast<Eigen::Index>(size) == wanted) return success();
  return wrong(std::string("there are ") + std::to_string(size) + " " + what + " for " +
               std::to_string(wanted) + " elements");
}

}  // namespace

Status check(const LabelledTetMesh& m) {
  const auto& [mesh, a] = m;
  if (Status s = check_elements(mesh.V, mesh.T, "tet"); !s) return s;
  if (Status s = check_elements(mesh.V, a.triangles, "triangle"); !s) return s;
  if (Status s = check_size(a.labels.of.size(), a.triangles.rows(), "labels"); !s) return s;
  if (Status s = check_size(a.regions.of.size(), mesh.T.rows(), "regions"); !s) return s;
  return check_size(a.layers.size(), mesh.T.rows(), "numbers of layers");
}

Status check(const Surface& surface, const SurfaceAttributes& attributes) {
  if (Status s = check_elements(surface.V, surface.F, "face"); !s) return s;
  return check_size(attributes.faces.of.size(), surface.F.rows(), "labels");
}

}  // namespace overtet::view
