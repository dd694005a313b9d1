#include "src/mesh/submesh.h"

#include <utility>

namespace overtet {

SubSurface sub_surface(const Surface& whole, std::vector<Index> faces) {
  SubSurface sub;
  std::vector<Index> number(static_cast<std::size_t>(whole.V.rows()), -1);
  for (const Index f : faces)
    for (const Index v : whole.F.row(f)) number[v] = 0;
  for (Index v = 0; v < whole.V.rows(); ++v)
    if (number[v] == 0) {
      number[v] = static_cast<Index>(sub.vertices.size());
      sub.vertices.push_back(v);
    }
  sub.surface.V = whole.V(sub.vertices, Eigen::all);
  sub.surface.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (int k = 0; k < 3; ++k) sub.surface.F(static_cast<Eigen::Index>(i), k) = number[whole.F(faces[i], k)];
  sub.faces = std::move(faces);
  return sub;
}

SubSurface sub_surface(const Surface& whole, const SurfaceTopology& topology,
                       const std::vector<char>& wanted) {
  std::vector<Index> faces;
  for (Index f = 0; f < whole.F.rows(); ++f)
    if (wanted[topology.component_of_face[f]]) faces.push_back(f);
  return sub_surface(whole, std::move(faces));
}

}  // namespace overtet
