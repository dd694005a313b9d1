#include "src/certificates/stacks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "kernels/core/assertions.h"
#include "kernels/core/tuning.h"
#include "kernels/predicates/predicates.h"
#include "src/certificates/tuning.h"
#include "src/exact/rays.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::Vec;

// A face through a point q: q = sum b_k p_k.
struct Layer {
  Index face;
  std::array<Rational, 3> b;
  bool leaves;  // the inside ends there, along n
};

using Moves = std::map<Index, int>;

class StackSearch {
 public:
  StackSearch(const Surface& surface, const TriangleBvh& bvh)
      : surface_(surface), rays_(surface.V, surface.F, bvh) {}

  std::optional<StackCertificate> look_at(const FacePair& pair) {
    const auto [f, g] = pair;
    if (!coplanar(f, g)) return std::nullopt;
    const Vec n = rays_.normal(f);
    const std::vector<Vec> ring = overlap(f, g, n);
    for (int k = 0; k < kInVain && ring.size() > 2; ++k) {
      Vec q{};
      Rational sum = 0;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Rational weight(static_cast<long>(1 + (i + 1) * k * 5 % 7));
        q = q + weight * ring[i];
        sum += weight;
      }
      q = (1 / sum) * q;
      std::vector<Layer> layers;
      const Point place(q);
      if (!find_layers(place, n, layers)) continue;
      std::vector<Index> faces;
      for (const Layer& layer : layers) faces.push_back(layer.face);
      if (!seen_.insert(std::move(faces)).second) return std::nullopt;
      return upset(f, place, n, layers);
    }
    return std::nullopt;
  }

 private:
  const double* corner(Index f, int k) const { return rays_.corner(f, k % 3); }

  bool coplanar(Index f, Index g) const {
    for (int k = 0; k < 3; ++k)
      if (orient3d(corner(f, 0), corner(f, 1), corner(f, 2), corner(g, k)) != 0) return false;
    return true;
  }

  bool same_place(Index f, Index g) const {
    const auto corners = [&](Index t) {
      std::array<std::array<double, 3>, 3> out;
      for (int k = 0; k < 3; ++k) std::copy_n(corner(t, k), 3, out[k].begin());
      std::sort(out.begin(), out.end());
      return out;
    };
    return corners(f) == corners(g);
  }

  // Face g cut at the edges of f.
  std::vector<Vec> overlap(Index f, Index g, const Vec& n) const {
    std::vector<Vec> ring;
    for (int k = 0; k < 3; ++k) ring.push_back(exact::vec(corner(g, k)));
    if (same_place(f, g)) return ring;
    for (int k = 0; k < 3; ++k) {
      const Vec a = exact::vec(corner(f, k)), wall = exact::cross(n, exact::vec(corner(f, k + 1)) - a);
      std::vector<Vec> kept;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Vec &p = ring[i], &q = ring[(i + 1) % ring.size()];
        const Rational hp = dot(wall, p - a), hq = dot(wall, q - a);
        if (exact::sign(hp) >= 0) kept.push_back(p);
        if (exact::sign(hp) * exact::sign(hq) < 0) kept.push_back(p + (hp / (hp - hq)) * (q - p));
      }
      ring = std::move(kept);
    }
    return ring;
  }

  // The faces through q; false where one of them has q on its border, or n in its plane.
  bool find_layers(const Point& q, const Vec& n, std::vector<Layer>& layers) const {
    const Point up(n);
    for (const Index f : rays_.faces_at(q)) {
      const int passes = rays_.passes(q, up, f);
      if (passes == exact::Rays::kGrazes) return false;
      layers.push_back({f, {}, passes > 0});
    }
    return true;
  }

  void find_places(const Vec& q, std::vector<Layer>& layers) const {
    for (Layer& layer : layers) {
      const Vec m = rays_.normal(layer.face);
      const Rational area = dot(m, m);
      for (int k = 0; k < 3; ++k) {
        const Vec a = exact::vec(corner(layer.face, k + 1)), b = exact::vec(corner(layer.face, k + 2));
        layer.b[k] = dot(m, exact::cross(b - a, q - a)) / area;
      }
    }
  }

  // Moves that take faces where the inside ends below those where it begins, if the winding number is
  // negative then.
  std::optional<StackCertificate> upset(Index f, const Point& q, const Vec& n,
                                        std::vector<Layer>& layers) const {
    std::vector<Index> faces;
    int ends = 0;
    for (const Layer& layer : layers) {
      faces.push_back(layer.face);
      ends += layer.leaves;
    }
    if (ends == 0 || ends == static_cast<int>(layers.size())) return std::nullopt;
    const exact::RayCount below = rays_.count(q, Point(Rational(-1) * n), nullptr, faces);
    if (below.status != exact::RayStatus::counted || below.winding >= ends) return std::nullopt;
    find_places(q.x, layers);
    const Moves moves = moves_apart(layers);
    const int lowest = lowest_winding(layers, below.winding, moves);
    if (lowest >= 0) return std::nullopt;
    StackCertificate out;
    out.face = f;
    out.point = q.near;
    for (int k = 0; k < 3; ++k) out.exact[k] = exact::fraction(q.x[k]);
    for (const auto& [v, m] : moves) {
      if (m == 0) continue;
      out.vertices.push_back(v);
      out.moves.push_back(m);
    }
    out.winding = lowest;
    return out;
  }

  int lowest_winding(const std::vector<Layer>& layers, int winding, const Moves& moves) const {
    std::map<Rational, int> steps;
    for (const Layer& layer : layers) {
      Rational height = 0;
      for (int k = 0; k < 3; ++k) height += layer.b[k] * moves.at(surface_.F(layer.face, k));
      steps[height] += layer.leaves ? -1 : 1;
    }
    int lowest = winding;
    for (const auto& [height, step] : steps) lowest = std::min(lowest, winding += step);
    return lowest;
  }

  // What belongs only to faces where the inside ends moves down, to those where it begins up.
  Moves moves_apart(const std::vector<Layer>& layers) const {
    Moves out;
    for (const Layer& layer : layers)
      for (const Index v : surface_.F.row(layer.face)) {
        const int move = layer.leaves ? -1 : 1;
        const auto [at, added] = out.try_emplace(v, move);
        if (!added && at->second != move) at->second = 0;
      }
    return out;
  }

  const Surface& surface_;
  const exact::Rays rays_;
  std::set<std::vector<Index>> seen_;  // stacks
};

}  // namespace

Result<std::optional<StackCertificate>> find_stack_certificate(const Surface& surface, const TriangleBvh& bvh,
                                                               const std::vector<FacePair>& pairs,
                                                               const RunContext& context) {
  OVERTET_EXPECTS(degenerate_faces(surface).empty());
  OVERTET_EXPECTS(std::is_sorted(pairs.begin(), pairs.end()));
  StackSearch search(surface, bvh);
  std::int64_t looked = 0;
  for (const FacePair& pair : pairs) {
    if (++looked % 64 == 0)
      if (auto stop = context.stop()) return *stop;
    if (auto found = search.look_at(pair)) return found;
  }
  return std::optional<StackCertificate>();
}

}  // namespace overtet
