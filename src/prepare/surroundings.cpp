#include "src/prepare/surroundings.h"

#include <algorithm>
#include <utility>

namespace overtet {

namespace {

void make_unique(std::vector<Index>& list) {
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
}

}  // namespace

Index Surroundings::local_vertex(Index v) const {
  return static_cast<Index>(std::lower_bound(vertex.begin(), vertex.end(), v) - vertex.begin());
}

Surroundings of_faces(const Surface& whole, std::vector<Index> faces) {
  Surroundings out;
  out.face = std::move(faces);
  for (const Index f : out.face)
    for (int k = 0; k < 3; ++k) out.vertex.push_back(whole.F(f, k));
  make_unique(out.vertex);
  out.surface.V.resize(static_cast<Index>(out.vertex.size()), 3);
  for (std::size_t v = 0; v < out.vertex.size(); ++v)
    out.surface.V.row(static_cast<Index>(v)) = whole.V.row(out.vertex[v]);
  out.surface.F.resize(static_cast<Index>(out.face.size()), 3);
  for (std::size_t f = 0; f < out.face.size(); ++f)
    for (int k = 0; k < 3; ++k)
      out.surface.F(static_cast<Index>(f), k) = out.local_vertex(whole.F(out.face[f], k));
  return out;
}

std::vector<Index> faces_around(const Surface& whole, const Incidence& incidence, std::vector<Index> vertices,
                                int rings) {
  std::vector<Index> faces;
  for (int ring = 0; ring < rings; ++ring) {
    make_unique(vertices);
    faces.clear();
    for (const Index v : vertices)
      for (const Index h : incidence.at(v)) faces.push_back(h / 3);
    make_unique(faces);
    if (ring + 1 == rings) break;
    vertices.clear();
    for (const Index f : faces)
      for (int k = 0; k < 3; ++k) vertices.push_back(whole.F(f, k));
  }
  return faces;
}

}  // namespace overtet
