#include "src/pipeline/locked_patch.h"

#include <algorithm>
#include <limits>

namespace overtet {

namespace {

constexpr int kRings = 3;

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

  LockedPatch result() const {
    LockedPatch out;
    std::vector<Index> number(static_cast<std::size_t>(surface_.V.rows()), -1);
    for (Index f = 0; f < surface_.F.rows(); ++f) {
      if (!has(f)) continue;
      out.faces.push_back(f);
      for (int k = 0; k < 3; ++k) number[static_cast<std::size_t>(surface_.F(f, k))] = 0;
    }
    Index next = 0;
    for (Index& n : number)
      if (n == 0) n = next++;
    out.surface.V.resize(next, 3);
    for (Index v = 0; v < surface_.V.rows(); ++v)
      if (const Index n = number[static_cast<std::size_t>(v)]; n >= 0)
        out.surface.V.row(n) = surface_.V.row(v);
    out.surface.F.resize(static_cast<Eigen::Index>(out.faces.size()), 3);
    for (std::size_t i = 0; i < out.faces.size(); ++i)
      for (int k = 0; k < 3; ++k)
        out.surface.F(static_cast<Eigen::Index>(i), k) =
            number[static_cast<std::size_t>(surface_.F(out.faces[i], k))];
    return out;
  }

 private:
  const Surface& surface_;
  std::vector<char> in_;
};

}  // namespace

LockedPatch patch_around(const Surface& surface, const std::vector<FacePair>& pairs,
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
