// Boundary values and meshes for the tests of fields.
#pragma once

#include <Eigen/Geometry>

#include "overtet/solve.h"
#include "src/mesh/tet_complex.h"

namespace overtet::test {

using Point = Eigen::Vector3d;

// With its boundary triangles, each of which has its number as its label.
inline LabelledTetMesh with_boundary(const TetMesh& mesh) {
  LabelledTetMesh m;
  m.mesh = mesh;
  const auto faces = TetComplex(mesh.V, mesh.T).boundary();
  m.attributes.triangles.resize(std::ssize(faces), 3);
  for (std::size_t f = 0; f < faces.size(); ++f) {
    for (int k = 0; k < 3; ++k) m.attributes.triangles(static_cast<Eigen::Index>(f), k) = faces[f][k];
    m.attributes.labels.of.push_back(static_cast<Index>(f));
  }
  return m;
}

inline BoundaryValue everywhere(ScalarFunction u) {
  return {.label = std::nullopt, .vertices = {}, .function = std::move(u)};
}

// Triangle f alone. pre: the mesh is from with_boundary().
inline BoundaryValue on_triangle(Index f, ScalarFunction u) {
  return {.label = f, .vertices = {}, .function = std::move(u)};
}

inline Point outer_normal(const LabelledTetMesh& m, Index f) {
  const auto corner = [&](int k) -> Point { return m.mesh.V.row(m.attributes.triangles(f, k)); };
  return (corner(1) - corner(0)).cross(corner(2) - corner(0)).normalized();
}

}  // namespace overtet::test
