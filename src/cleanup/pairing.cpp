#include "src/cleanup/pairing.h"

#include <algorithm>
#include <tuple>

#include "kernels/predicates/predicates.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

// A face at the edge from a to b. Going around that by the right-hand rule, the solid begins at a face that
// opens and ends at one that closes: at one that runs from a to b, for the normal of such a face points
// ahead.
struct Spoke {
  Index half_edge, shell;
  const double* tip;
  bool closes;
  int sector = 0;  // 0: with the first spoke, 1: up to half a turn from it, 2: opposite, 3: beyond
};

class Wheel {
 public:
  Wheel(const double* a, const double* b) : a_(a), b_(b) {}

  // False where a face has no area: it has no angle.
  bool sort(std::vector<Spoke>& spokes) const {
    const double* first = spokes[0].tip;
    for (Spoke& s : spokes) {
      if (collinear(a_, b_, s.tip)) return false;
      const int side = orient3d(a_, b_, first, s.tip);
      s.sector = side > 0 ? 1 : side < 0 ? 3 : same_side(first, s.tip) ? 0 : 2;
    }
    std::sort(spokes.begin(), spokes.end(), [&](const Spoke& s, const Spoke& t) {
      if (s.sector != t.sector) return s.sector < t.sector;
      if (const int turn = s.sector % 2 == 1 ? orient3d(a_, b_, s.tip, t.tip) : 0; turn != 0) return turn > 0;
      if (s.closes != t.closes) return s.closes;
      // What opens last closes first, so that copies pair with their own.
      const auto key = [](const Spoke& x) { return std::tie(x.shell, x.half_edge); };
      return s.closes ? key(t) < key(s) : key(s) < key(t);
    });
    return true;
  }

 private:
  // Of the line ab. pre: a, b, p and q are coplanar, and neither p nor q is on the line.
  bool same_side(const double* p, const double* q) const {
    for (const auto& [i, j] : {std::pair{0, 1}, {1, 2}, {2, 0}}) {
      const auto turn = [&, i = i, j = j](const double* x) {
        return orient2d(a_[i], a_[j], b_[i], b_[j], x[i], x[j]);
      };
      if (const int s = turn(p); s != 0) return turn(q) == s;
    }
    return true;
  }

  const double *a_, *b_;
};

using Pairs = std::vector<std::array<Index, 2>>;

// Matching brackets around a circle. pre: as many close as open.
void match(const std::vector<Spoke>& spokes, Pairs& pairs) {
  // Starts behind the place where most are closed: from there on nothing closes that has not been opened.
  int depth = 0, least = 0;
  std::size_t start = 0;
  for (std::size_t i = 0; i < spokes.size(); ++i) {
    depth += spokes[i].closes ? -1 : 1;
    if (depth < least) least = depth, start = i + 1;
  }
  std::vector<Index> open;
  for (std::size_t i = 0; i < spokes.size(); ++i) {
    const Spoke& s = spokes[(start + i) % spokes.size()];
    if (!s.closes) {
      open.push_back(s.half_edge);
    } else {
      pairs.push_back({open.back(), s.half_edge});
      open.pop_back();
    }
  }
}

bool is_balanced(const std::vector<Spoke>& spokes) {
  const auto closing = std::count_if(spokes.begin(), spokes.end(), [](const Spoke& s) { return s.closes; });
  return 2 * closing == static_cast<std::ptrdiff_t>(spokes.size());
}

// False where that cannot be done.
bool pair_up(const Wheel& wheel, std::vector<Spoke>& spokes, Pairs& pairs) {
  if (spokes.empty()) return true;
  if (!is_balanced(spokes)) return false;
  if (spokes.size() > 2 && !wheel.sort(spokes)) return false;
  match(spokes, pairs);
  return true;
}

}  // namespace

std::vector<std::array<Index, 2>> pair_around(const VertexMatrix& V, const TriangleMatrix& F,
                                              const RawEdges& edges, const Oriented& oriented,
                                              const EdgeGroup& edge, Sector sector) {
  const auto point = [&](Index v) { return V.data() + 3 * std::int64_t{v}; };
  const Index first = edges.list[edge.begin];
  const auto [low, high] =
      std::minmax(edges.place[half_edge_source(F, first)], edges.place[half_edge_target(F, first)]);
  const Wheel wheel(point(low), point(high));
  std::vector<Spoke> all;
  for (Index i = edge.begin; i < edge.begin + edge.count; ++i) {
    const Index h = edges.list[i], f = half_edge_face(h);
    all.push_back(
        {h, oriented.shell_of[f], point(half_edge_opposite(F, h)),
         (runs_up(F, edges.place, h) != static_cast<bool>(oriented.turned[f])) == (sector == Sector::solid)});
  }
  std::stable_sort(all.begin(), all.end(), [](const Spoke& s, const Spoke& t) { return s.shell < t.shell; });
  Pairs pairs;
  std::vector<Spoke> shell, rest;
  for (std::size_t i = 0, j = 0; i < all.size(); i = j) {
    for (j = i; j < all.size() && all[j].shell == all[i].shell;) ++j;
    shell.assign(all.begin() + static_cast<std::ptrdiff_t>(i), all.begin() + static_cast<std::ptrdiff_t>(j));
    if (!is_balanced(shell))
      rest.insert(rest.end(), shell.begin(), shell.end());
    else if (!pair_up(wheel, shell, pairs))
      return {};
  }
  if (!pair_up(wheel, rest, pairs)) return {};
  return pairs;
}

}  // namespace overtet
