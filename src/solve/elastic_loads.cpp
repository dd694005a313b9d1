#include "src/solve/elastic_loads.h"

#include <Eigen/Geometry>
#include <string>
#include <utility>

#include "kernels/fem/elements.h"
#include "kernels/predicates/predicates.h"
#include "src/solve/parts.h"

namespace overtet::solve_detail {

namespace {

Status in_range(const std::vector<Index>& vertices, const LabelledTetMesh& mesh) {
  for (const Index v : vertices)
    if (v < 0 || v >= mesh.mesh.V.rows())
      return Error{ErrorCode::usage, "Vertex " + std::to_string(v) + " (counted from 0) does not exist."};
  return success();
}

// Errors: usage, where in a component of the tets fewer than three vertices are held, or all on one line.
Status cannot_move(const TetMesh& mesh, const std::vector<int>& held) {
  const Components components = components_of(mesh.V, mesh.T);
  struct Held {
    std::vector<Index> corners;  // at most three, the third beside the line through the others
  };
  std::vector<Held> of(components.first_tet.size());
  for (Index v = 0; v < mesh.V.rows(); ++v) {
    const Index c = components.of_vertex[static_cast<std::size_t>(v)];
    if (c < 0 || held[static_cast<std::size_t>(v)] < 0) continue;
    std::vector<Index>& corners = of[static_cast<std::size_t>(c)].corners;
    const auto place = [&](Index i) { return mesh.V.data() + 3 * static_cast<std::ptrdiff_t>(i); };
    if (corners.size() < 2 ||
        (corners.size() == 2 && !collinear(place(corners[0]), place(corners[1]), place(v))))
      corners.push_back(v);
  }
  for (std::size_t c = 0; c < of.size(); ++c)
    if (of[c].corners.size() < 3)
      return Error{ErrorCode::usage,
                   "The component of tet " + std::to_string(components.first_tet[c]) +
                       " (counted from 0) can still " + (of[c].corners.empty() ? "move" : "turn") +
                       ": an equilibrium needs three held vertices, not on a line, in each component."};
  return success();
}

}  // namespace

Result<ElasticLoads> ElasticLoads::prepare(const LabelledTetMesh& mesh, const ElasticOptions& options) {
  ElasticLoads loads(mesh, options, options.rest.rows() > 0 ? options.rest : mesh.mesh.V);
  if (Status s = loads.find_held(); !s) return s.error();
  for (const ElasticCondition& f : options.forces)
    if (Status s = in_range(f.vertices, mesh); !s) return s.error();
  for (const ElasticCondition& t : options.tractions)
    if (Result<std::vector<Index>> found = triangles_with(mesh, t.label); !found) return found.error();
  if (!options.dynamic)
    if (Status s = cannot_move(mesh.mesh, loads.held_); !s) return s.error();
  return loads;
}

Status ElasticLoads::find_held() {
  held_.assign(static_cast<std::size_t>(mesh_->mesh.V.rows()), -1);
  for (std::size_t i = 0; i < options_->held.size(); ++i) {
    const ElasticCondition& h = options_->held[i];
    if (Status s = in_range(h.vertices, *mesh_); !s) return s;
    for (const Index v : h.vertices) held_[static_cast<std::size_t>(v)] = static_cast<int>(i);
    if (!h.vertices.empty() && !h.label) continue;
    Result<std::vector<Index>> triangles = triangles_with(*mesh_, h.label);
    if (!triangles) return triangles.error();
    for (const Index f : triangles.value())
      for (int k = 0; k < 3; ++k)
        held_[static_cast<std::size_t>(mesh_->attributes.triangles(f, k))] = static_cast<int>(i);
  }
  return success();
}

Result<VertexMatrix> ElasticLoads::targets(double time) const {
  VertexMatrix out = mesh_->mesh.V;
  for (Eigen::Index v = 0; v < out.rows(); ++v) {
    if (held_[static_cast<std::size_t>(v)] < 0) continue;
    const ElasticCondition& h = options_->held[static_cast<std::size_t>(held_[static_cast<std::size_t>(v)])];
    if (!h.function) continue;
    const Eigen::Vector3d place = mesh_->mesh.V.row(v).transpose(), u = h.function(place, time);
    if (!u.allFinite()) return not_finite("given displacement", place);
    out.row(v) += u.transpose();
  }
  return out;
}

Status ElasticLoads::add_traction(const ElasticCondition& traction, double time, VertexMatrix& to) const {
  static const Eigen::MatrixXd reference = reference_mass(2, 1);
  const TriangleMatrix& F = mesh_->attributes.triangles;
  const Result<std::vector<Index>> triangles = triangles_with(*mesh_, traction.label);
  if (!triangles) return triangles.error();
  for (const Index f : triangles.value()) {
    const auto rest = [&](int k) -> Eigen::Vector3d { return rest_->row(F(f, k)).transpose(); };
    const double area = (rest(1) - rest(0)).cross(rest(2) - rest(0)).norm() / 2;
    Eigen::Matrix3d given;  // a corner a row
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3d place = mesh_->mesh.V.row(F(f, k)).transpose();
      given.row(k) = traction.function(place, time).transpose();
      if (!given.row(k).allFinite()) return not_finite("given traction", place);
    }
    const Eigen::Matrix3d part = area * (reference * given);
    for (int k = 0; k < 3; ++k) to.row(F(f, k)) += part.row(k);
  }
  return success();
}

Result<VertexMatrix> ElasticLoads::forces(double time) const {
  VertexMatrix out = VertexMatrix::Zero(mesh_->mesh.V.rows(), 3);
  for (const ElasticCondition& t : options_->tractions)
    if (Status s = add_traction(t, time, out); !s) return s.error();
  for (const ElasticCondition& c : options_->forces)
    for (const Index v : c.vertices) {
      const Eigen::Vector3d place = mesh_->mesh.V.row(v).transpose(), f = c.function(place, time);
      if (!f.allFinite()) return not_finite("given force", place);
      out.row(v) += f.transpose();
    }
  return out;
}

}  // namespace overtet::solve_detail
