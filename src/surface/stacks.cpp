#include "src/surface/stacks.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <utility>

#include "kernels/predicates/predicates.h"
#include "src/surface/exact.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::Vec;

// Points looked at in the overlap of two faces; another one where the one before lies on an edge.
constexpr int kPoints = 3;

// Rounds of the search for moves, for each face of a stack.
constexpr int kRounds = 200;

// Moves are whole numbers up to this one.
constexpr double kLargestMove = 4096;

// A face through a point q: q = sum b_k p_k.
struct Layer {
  Index face;
  std::array<Rational, 3> b;
  bool leaves;  // the inside ends there, along n
};

class StackSearch {
 public:
  StackSearch(const Surface& surface, const TriangleBvh& bvh)
      : surface_(surface), rays_(surface.V, surface.F, bvh) {}

  std::optional<StackWitness> look_at(const FacePair& pair) {
    const auto [f, g] = pair;
    if (!coplanar(f, g)) return std::nullopt;
    const Vec n = rays_.normal(f);
    const std::vector<Vec> ring = overlap(f, g, n);
    for (int k = 0; k < kPoints && ring.size() > 2; ++k) {
      Vec q{};
      Rational sum = 0;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const Rational weight(static_cast<long>(1 + (i + 1) * k * 5 % 7));
        q = q + weight * ring[i];
        sum += weight;
      }
      q = (1 / sum) * q;
      std::vector<Layer> layers;
      if (!find_layers(q, n, layers)) continue;
      std::vector<Index> faces;
      for (const Layer& layer : layers) faces.push_back(layer.face);
      if (!seen_.insert(std::move(faces)).second) return std::nullopt;
      return upset(f, q, n, layers);
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

  // Face g cut at the edges of f.
  std::vector<Vec> overlap(Index f, Index g, const Vec& n) const {
    std::vector<Vec> ring;
    for (int k = 0; k < 3; ++k) ring.push_back(exact::vec(corner(g, k)));
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
  bool find_layers(const Vec& q, const Vec& n, std::vector<Layer>& layers) const {
    for (const Index f : rays_.faces_at(Point(q))) {
      const Vec m = rays_.normal(f);
      const int up = exact::sign(dot(m, n));
      if (up == 0) return false;
      Layer layer{f, {}, up > 0};
      const Rational area = dot(m, m);
      for (int k = 0; k < 3; ++k) {
        const Vec a = exact::vec(corner(f, k + 1)), b = exact::vec(corner(f, k + 2));
        layer.b[k] = dot(m, exact::cross(b - a, q - a)) / area;
        if (exact::sign(layer.b[k]) <= 0) return false;
      }
      layers.push_back(std::move(layer));
    }
    return true;
  }

  // Moves that take faces where the inside ends below those where it begins, if the winding number is
  // negative then.
  std::optional<StackWitness> upset(Index f, const Vec& q, const Vec& n,
                                    const std::vector<Layer>& layers) const {
    std::vector<Index> faces;
    int ends = 0;
    for (const Layer& layer : layers) {
      faces.push_back(layer.face);
      ends += layer.leaves;
    }
    if (ends == static_cast<int>(layers.size())) return std::nullopt;
    const exact::RayCount below = rays_.count(Point(q), Point(Rational(-1) * n), nullptr, faces);
    if (below.status != exact::RayStatus::counted || below.winding >= ends) return std::nullopt;
    const auto moves = find_moves(layers);
    if (!moves) return std::nullopt;
    // Once more, exactly.
    std::map<Rational, int> steps;
    for (const Layer& layer : layers) {
      Rational height = 0;
      for (int k = 0; k < 3; ++k) height += layer.b[k] * moves->at(surface_.F(layer.face, k));
      steps[height] += layer.leaves ? -1 : 1;
    }
    int winding = below.winding, lowest = winding;
    for (const auto& [height, step] : steps) {
      winding += step;
      lowest = std::min(lowest, winding);
    }
    if (lowest >= 0) return std::nullopt;
    StackWitness out;
    out.face = f;
    out.point = exact::approximate(q);
    for (int k = 0; k < 3; ++k) out.exact[k] = exact::fraction(q[k]);
    for (const auto& [v, m] : *moves) {
      if (m == 0) continue;
      out.vertices.push_back(v);
      out.moves.push_back(m);
    }
    out.winding = lowest;
    return out;
  }

  // The perceptron: finds moves that separate the faces where there are any, mostly within a few rounds.
  std::optional<std::map<Index, int>> find_moves(const std::vector<Layer>& layers) const {
    std::map<Index, double> move;
    for (int round = 0; round < kRounds; ++round) {
      bool apart = true;
      for (const Layer& layer : layers) {
        double height = 0;
        for (int k = 0; k < 3; ++k) height += layer.b[k].get_d() * move[surface_.F(layer.face, k)];
        const double side = layer.leaves ? -1 : 1;
        if (side * height > 0.1) continue;
        apart = false;
        for (int k = 0; k < 3; ++k) move[surface_.F(layer.face, k)] += side * layer.b[k].get_d();
      }
      if (!apart) continue;
      double largest = 0;
      for (const auto& [v, m] : move) largest = std::max(largest, std::fabs(m));
      std::map<Index, int> out;
      for (const auto& [v, m] : move) out[v] = static_cast<int>(std::lround(m / largest * kLargestMove));
      return out;
    }
    return std::nullopt;
  }

  const Surface& surface_;
  const exact::Rays rays_;
  std::set<std::vector<Index>> seen_;  // stacks
};

}  // namespace

Result<std::optional<StackWitness>> find_stack_witness(const Surface& surface, const TriangleBvh& bvh,
                                                       const std::vector<FacePair>& pairs,
                                                       const RunContext& context) {
  StackSearch search(surface, bvh);
  std::int64_t looked = 0;
  for (const FacePair& pair : pairs) {
    if (++looked % 64 == 0)
      if (auto stop = context.stop()) return *stop;
    if (auto found = search.look_at(pair)) return found;
  }
  return std::optional<StackWitness>();
}

}  // namespace overtet
