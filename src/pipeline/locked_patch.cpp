#include "src/pipeline/locked_patch.h"

#include <algorithm>
#include <limits>

#include "kernels/core/tuning.h"

namespace overtet {

namespace {

class Grower {
 public:
  explicit Grower(const Surface& s) : surface_(s), in_(static_cast<std::size_t>(s.F.rows()), 0) {}

  void add(Index face) { in_[static_cast<std::size_t>(face)] = 1; }
  bool has(Index face) const { return in_[static_cast<std::size_t>(face)] != 0; }

  // Adds all faces that share a vertex with one that is in.
  void grow() {
    std::vector<char> touched(static_cast<std::size_t>(surface_.V.rows()), 0);
    for (Index f = 0; f < surface_.F.rows(); ++f)
      if (has(f))
        for (int k = 0; k < 3; ++k) touched[static_cast<std::size_t>(surface_.F(f, k))] = 1;
    for (Index f = 0; f < surface_.F.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        if (touched[static_cast<std::size_t>(surface_.F(f, k))]) add(f);
  }

  SubSurface result() const {
    std::vector<Index> faces;
    for (Index f = 0; f < surface_.F.rows(); ++f)
      if (has(f)) faces.push_back(f);
    return sub_surface(surface_, std::move(faces));
  }

 private:
  const Surface& surface_;
  std::vector<char> in_;
};

}  // namespace

SubSurface patch_around(const Surface& surface, const std::vector<FacePair>& pairs,
                        const Eigen::Vector3d& place) {
  Grower patch(surface);
  // Nearest by its corners' mean distance: a place on the surface is near some face's corners.
  Index nearest = 0;
  double best = std::numeric_limits<double>::infinity();
  for (Index f = 0; f < surface.F.rows(); ++f) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += (Eigen::Vector3d(surface.V.row(surface.F(f, k))) - place).norm();
    if (sum < best) best = sum, nearest = f;
  }
  patch.add(nearest);
  for (int ring = 0; ring < kRings; ++ring) patch.grow();
  std::vector<Index> crossed;
  for (const auto& [f, g] : pairs) {
    if (patch.has(f)) crossed.push_back(g);
    if (patch.has(g)) crossed.push_back(f);
  }
  for (const Index f : crossed) patch.add(f);
  patch.grow();
  return patch.result();
}

}  // namespace overtet
