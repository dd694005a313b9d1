#include "kernels/bvh/self_intersections.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/bvh/tuning.h"
#include "kernels/core/assertions.h"
#include "kernels/core/indices.h"
#include "kernels/parallel/counts.h"
#include "kernels/parallel/grouping.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"

namespace overtet {

namespace {

// For every vertex whether its faces, all around it, can be seen at once from some direction without covering
// each other. Then no two of them intersect beyond what they share, and their pairs, which are nearly all
// pairs whose boxes overlap, need no test of their own.
class FlatVertices {
 public:
  FlatVertices(const VertexMatrix& V, const TriangleMatrix& F) : points_(V.data()), faces_(F.data()) {
    const Index vertices = static_cast<Index>(V.rows());
    flat_.resize(vertices);
    if (3 * F.rows() > std::int64_t{std::numeric_limits<std::uint32_t>::max()}) {
      std::fill(flat_.begin(), flat_.end(), 0);
      return;
    }
    const std::int64_t faces = F.rows();
    group_items(vertices, start_, ring_, [&](auto visit) {
      for (const Index* f = faces_; f != faces_ + 3 * faces; f += 3) {
        visit(f[0], Sector{f[1], f[2]});
        visit(f[1], Sector{f[2], f[0]});
        visit(f[2], Sector{f[0], f[1]});
      }
    });
    parallel_for(vertices, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t v = begin; v < end; ++v) {
        // The points of the vertices to come lie anywhere in memory.
        if (const std::int64_t soon = v + 8; soon < end)
          for (std::uint32_t c = start_[soon]; c < start_[soon + 1]; ++c)
            __builtin_prefetch(points_ + 3 * std::int64_t{ring_[c].next});
        flat_[v] = is_flat(static_cast<Index>(v));
      }
    });
  }

  bool operator[](Index v) const { return flat_[v] != 0; }

 private:
  // A face (v, next, after).
  struct Sector {
    Index next, after;
  };

  bool is_flat(Index v) const {
    const int n = static_cast<int>(start_[v + 1] - start_[v]);
    if (n < 3 || n > kAtATime) return false;
    const Sector* ring = ring_.data() + start_[v];
    double x[kAtATime], y[kAtATime], z[kAtATime], size = 0;  // of `next`, seen from v
    const double* at = points_ + 3 * std::int64_t{v};
    for (int i = 0; i < n; ++i) {
      const double* p = points_ + 3 * std::int64_t{ring[i].next};
      x[i] = p[0] - at[0];
      y[i] = p[1] - at[1];
      z[i] = p[2] - at[2];
      size = std::max(size, std::max(std::fabs(x[i]), std::max(std::fabs(y[i]), std::fabs(z[i]))));
    }
    if (!(size > 1e-40 && size < 1e60)) return false;  // so that nothing below leaves the range of doubles
    // In closed rings every `after` is the `next` of one other face.
    int following[kAtATime];
    std::uint32_t seen = 0;
    for (int i = 0; i < n; ++i) {
      std::uint32_t found = 0;
      for (int j = 0; j < n; ++j) found |= std::uint32_t{ring[j].next == ring[i].after} << j;
      if (found == 0 || (found & (found - 1)) != 0 || (seen & found) != 0) return false;
      seen |= found;
      following[i] = __builtin_ctz(found);
    }
    double nx[kAtATime], ny[kAtATime], nz[kAtATime], sx = 0, sy = 0, sz = 0;
    for (int i = 0; i < n; ++i) {
      const int j = following[i];
      sx += nx[i] = y[i] * z[j] - z[i] * y[j];
      sy += ny[i] = z[i] * x[j] - x[i] * z[j];
      sz += nz[i] = x[i] * y[j] - y[i] * x[j];
    }
    // From the direction of their sum every face is seen from its front: sum . (p x q) > 0 with certainty.
    // Each of the six products is at most |sum| size^2; the rounding of its factors and of the sums together
    // is less than 14 ulp of |sum|_1 size^2.
    const double length = std::fabs(sx) + std::fabs(sy) + std::fabs(sz);
    if (!(length > 1e-40 * size * size)) return false;
    const double bound = 1e-14 * length * size * size;
    bool front = true;
    for (int i = 0; i < n; ++i) front &= sx * nx[i] + sy * ny[i] + sz * nz[i] > bound;
    if (!front) return false;
    // Then they turn a whole number of times, as often as the ring crosses a half-line. The line is along an
    // axis, seen from that direction: a point is on the side that the sign of (sum x axis) . point says.
    return turns(n, following, y, z, sy, sz, length * size) == 1 ||
           turns(n, following, z, x, sz, sx, length * size) == 1 ||
           turns(n, following, x, y, sx, sy, length * size) == 1;
  }

  // -1 when a point is too close to the line to tell.
  static int turns(int n, const int* following, const double* y, const double* z, double sy, double sz,
                   double size) {
    double side[kAtATime], nearest = HUGE_VAL;
    for (int i = 0; i < n; ++i) {
      side[i] = sz * y[i] - sy * z[i];
      nearest = std::min(nearest, std::fabs(side[i]));
    }
    if (!(nearest > 4e-15 * size)) return -1;
    int out = 0;
    for (int i = 0; i < n; ++i) out += int{side[i] < 0} & int{side[following[i]] > 0};
    return out;
  }

  const double* points_;
  const Index* faces_;
  RawVector<std::uint32_t> start_;
  RawVector<Sector> ring_;  // ring_[start_[v] .. start_[v + 1]): of the faces at v
  RawVector<std::uint8_t> flat_;
};

// The corners of a face, for pairs that need no test when they have one of these numbers in common: corners
// that are not flat get numbers of their own.
struct Corners {
  std::int32_t v[3], unused;
};

bool share(const Corners& f, const Corners& g) {
#if defined(__SSE2__)
  const __m128i other = _mm_loadu_si128(reinterpret_cast<const __m128i*>(&g));
  const __m128i a = _mm_cmpeq_epi32(other, _mm_set1_epi32(f.v[0])),
                b = _mm_cmpeq_epi32(other, _mm_set1_epi32(f.v[1])),
                c = _mm_cmpeq_epi32(other, _mm_set1_epi32(f.v[2]));
  return (_mm_movemask_ps(_mm_castsi128_ps(_mm_or_si128(_mm_or_si128(a, b), c))) & 7) != 0;
#else
  bool any = false;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) any |= f.v[i] == g.v[j];
  return any;
#endif
}

}  // namespace

bool all_finite(const VertexMatrix& V) {
  const double* x = V.data();
  const std::int64_t n = V.size();
  return parallel_reduce(
      n, std::int64_t{1} << 16, true,
      [&](std::int64_t begin, std::int64_t end) {
        bool finite = true;
        for (std::int64_t i = begin; i < end; ++i) finite = finite && std::isfinite(x[i]);
        return finite;
      },
      [](bool a, bool b) { return a && b; });
}

std::vector<FacePair> find_self_intersections(const VertexMatrix& V, const TriangleMatrix& F,
                                              const SelfIntersectionOptions& options) {
  TriangleBvh bvh(V, F);
  return find_self_intersections(V, F, bvh, options);
}

std::vector<FacePair> find_self_intersections(const VertexMatrix& V, const TriangleMatrix& F,
                                              TriangleBvh& bvh, const SelfIntersectionOptions& options) {
  OVERTET_EXPECTS(all_finite(V) && all_below(F, V.rows()));
  if (!options.active.empty()) bvh.set_active(options.active);
  const double* points = V.data();
  const Index* faces = F.data();
  const auto order = bvh.order();
  RawVector<Corners> corners(order.size());
  {
    const FlatVertices flat(V, F);
    parallel_for(bvh.size(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t place = begin; place < end; ++place) {
        const Index* face = faces + 3 * std::int64_t{order[place]};
        for (int k = 0; k < 3; ++k)
          corners[place].v[k] = flat[face[k]] ? face[k] : static_cast<Index>(-1 - place);
        // Two corners of one face with the same number do no harm.
        corners[place].unused = 0;
      }
    });
  }
  const auto visit = [&](Index p, Index q, std::vector<FacePair>& out) {
    if (share(corners[p], corners[q])) return;
    const Index f = std::min(order[p], order[q]), g = std::max(order[p], order[q]);
    count(Count::tested_pairs);
    if (faces_intersect(points, faces + 3 * std::int64_t{f}, faces + 3 * std::int64_t{g}))
      out.emplace_back(f, g);
  };
  std::vector<FacePair> pairs = options.stop_at_first ? bvh.find_self_places<FacePair>(visit)
                                                      : bvh.collect_self_places<FacePair>(visit);
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

}  // namespace overtet
