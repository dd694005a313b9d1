#include <algorithm>
#include <array>
#include <tuple>
#include <utility>

#include "kernels/core/indices.h"
#include "kernels/core/triangles.h"
#include "overtet/attributes.h"

namespace overtet {

namespace {

using Corners = std::array<Index, 3>;

// Vertices of the mesh as the surface numbers them, by their places; -1: none there. Where the surface has
// several vertices in one place, their smallest number stands for all.
struct Places {
  std::vector<Index> surface, mesh;
};

Places places_of(const VertexMatrix& surface, const VertexMatrix& mesh) {
  const auto count = static_cast<Index>(surface.rows());
  const auto key = [&](Index v) {
    const double* p = v < count ? &surface(v, 0) : &mesh(v - count, 0);
    return std::array<double, 3>{p[0] + 0.0, p[1] + 0.0, p[2] + 0.0};  // -0 is 0
  };
  std::vector<Index> order(static_cast<std::size_t>(count + mesh.rows()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return key(a) < key(b); });
  Places out{std::vector<Index>(static_cast<std::size_t>(count), -1),
             std::vector<Index>(static_cast<std::size_t>(mesh.rows()), -1)};
  for (std::size_t i = 0; i < order.size();) {
    std::size_t end = i + 1;
    while (end < order.size() && key(order[end]) == key(order[i])) ++end;
    const Index first = order[i] < count ? order[i] : -1;
    for (; i < end; ++i)
      (order[i] < count ? out.surface[static_cast<std::size_t>(order[i])]
                        : out.mesh[static_cast<std::size_t>(order[i] - count)]) = first;
  }
  return out;
}

struct Labelled {
  Corners corners;
  Index label, number;
  bool operator<(const Labelled& o) const {
    return std::tie(corners, label, number) < std::tie(o.corners, o.label, o.number);
  }
};

std::vector<Labelled> sorted_faces(const TriangleMatrix& F, const std::vector<Index>& labels,
                                   const std::vector<Index>* place) {
  std::vector<Labelled> out(static_cast<std::size_t>(F.rows()));
  for (std::size_t f = 0; f < out.size(); ++f) {
    Corners c;
    for (int k = 0; k < 3; ++k) {
      const Index v = F(static_cast<Eigen::Index>(f), k);
      c[static_cast<std::size_t>(k)] = place ? (*place)[static_cast<std::size_t>(v)] : v;
    }
    out[f] = {rotated(c), labels.empty() ? 0 : labels[f], static_cast<Index>(f)};
  }
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace

std::vector<VerifyFailure> verify_attributes(const Surface& surface, const SurfaceAttributes& attributes,
                                             const LabelledTetMesh& labelled, bool geometry_only) {
  const MeshAttributes& m = labelled.attributes;
  std::vector<VerifyFailure> failures;
  if (m.triangles.rows() == 0) return failures;
  const auto fail = [&](const std::string& what, std::vector<Index> which) {
    const auto count = static_cast<std::int64_t>(which.size());
    constexpr std::size_t shown = 8;
    which.resize(std::min(which.size(), shown));
    std::string text = what;
    for (const Index w : which) text += (w == which[0] ? " " : ", ") + std::to_string(w);
    text += count > static_cast<std::int64_t>(which.size()) ? ", ... (" + std::to_string(count) + ")." : ".";
    failures.push_back({Rule::R7, text, count, std::move(which)});
  };
  if (!all_below(m.triangles, labelled.mesh.V.rows())) {
    fail("The file has boundary triangles with vertices that do not exist", {});
    return failures;
  }
  Places places;
  if (geometry_only) places = places_of(surface.V, labelled.mesh.V);
  const std::vector<Labelled> have =
      sorted_faces(m.triangles, m.labels.of, geometry_only ? &places.mesh : nullptr);
  const std::vector<Labelled> want = sorted_faces(surface.F, labels_of_faces(surface, attributes).of,
                                                  geometry_only ? &places.surface : nullptr);
  std::vector<Index> missing, extra, relabelled;
  std::size_t h = 0, w = 0;
  while (h < have.size() || w < want.size()) {
    if (w == want.size() || (h < have.size() && have[h].corners < want[w].corners)) {
      extra.push_back(have[h++].number);
    } else if (h == have.size() || want[w].corners < have[h].corners) {
      missing.push_back(want[w++].number);
    } else {
      if (!m.labels.of.empty() && have[h].label != want[w].label) relabelled.push_back(want[w].number);
      ++h, ++w;
    }
  }
  for (std::vector<Index>* list : {&missing, &extra, &relabelled}) std::sort(list->begin(), list->end());
  if (!missing.empty()) fail("The file's boundary triangles lack faces of the surface:", std::move(missing));
  if (!extra.empty())
    fail("The file has boundary triangles that are not faces of the surface: triangles", std::move(extra));
  if (!relabelled.empty())
    fail("Boundary triangles have other labels than the surface: faces", std::move(relabelled));
  return failures;
}

}  // namespace overtet
