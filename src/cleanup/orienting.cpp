#include "src/cleanup/orienting.h"

#include "src/mesh/topology.h"

namespace overtet {

Oriented orient(const TriangleMatrix& F, const RawEdges& edges) {
  Oriented out;
  const Index faces = static_cast<Index>(F.rows());
  out.shell_of.assign(faces, -1);
  out.turned.assign(faces, 0);
  std::vector<Index> shell;  // its faces, as they are reached
  Index shells = 0;
  for (Index start = 0; start < faces; ++start) {
    if (out.shell_of[start] >= 0) continue;
    shell.assign(1, start);
    out.shell_of[start] = shells;
    Index turned = 0;
    bool one_sided = false;
    for (std::size_t i = 0; i < shell.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        const Index f = shell[i], h = 3 * f + k, other = edges.partner[h];
        if (other < 0) continue;
        const Index g = half_edge_face(other);
        const bool along = runs_up(F, edges.place, h) == runs_up(F, edges.place, other);
        const char wanted = static_cast<char>(out.turned[f] != along);
        if (out.shell_of[g] < 0) {
          out.shell_of[g] = shells;
          out.turned[g] = wanted;
          turned += wanted;
          shell.push_back(g);
        } else if (out.turned[g] != wanted && !one_sided) {
          one_sided = true;
          out.one_sided.push_back({f, g});
        }
      }
    const auto size = static_cast<Index>(shell.size());
    if (one_sided)
      for (const Index f : shell) out.turned[f] = 0;
    else if (2 * turned > size) {
      for (const Index f : shell) out.turned[f] = !out.turned[f];
      turned = size - turned;
    }
    if (!one_sided) out.turned_faces += turned;
    ++shells;
  }
  return out;
}

}  // namespace overtet
