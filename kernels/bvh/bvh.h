// A bounding volume hierarchy of triangles that is built once and refitted as the surface moves.
//
// Guaranteed:
//  1. Boxes are conservative: rounded outwards to floats, so no pair, box or ray query misses a face
//     (extra candidates are possible, the caller decides exactly).
//  2. Visiting order and results do not depend on the number of threads.
//  3. Queries are const and may run from several threads.
//
// Why not Embree: a refit costs a third of Embree's rebuild and its REFIT quality costs as much as a
// build; self pairs come once each instead of twice; and one traversal serves the intersection test and
// the contact search. A binned-SAH binary tree over at most four faces a leaf.
//
// Usage:
//   TriangleBvh bvh(V, F);
//   bvh.refit(moved_V);
//   auto hits = bvh.collect_self_pairs<Hit>([&](Index f, Index g, std::vector<Hit>& out) { ... });
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#if defined(__SSE__)
#include <xmmintrin.h>
#endif

#include "kernels/parallel/parallel.h"
#include "overtet/types.h"

namespace overtet {

class TriangleBvh {
 public:
  TriangleBvh() = default;
  // pre: indices of F are valid, V is finite. O(F log F), parallel.
  TriangleBvh(const VertexMatrix& V, const TriangleMatrix& F) { build(V, F); }
  void build(const VertexMatrix& V, const TriangleMatrix& F);

  // New boxes for new positions of the same faces. pad: per face, how far its box is inflated on every
  // side (#F, >= 0), or null. Two faces closer than pad[f] + pad[g] are then candidates.
  void refit(const VertexMatrix& V, const double* pad = nullptr);
  // Boxes of the motion from V0 to V1 (straight lines).
  void refit_swept(const VertexMatrix& V0, const VertexMatrix& V1, const double* pad = nullptr);

  // Self pairs are reported only when at least one of the two faces is active (#F, 0 or 1); an empty
  // mask means all. Kept until the next build or set_active.
  void set_active(const std::vector<std::uint8_t>& active);

  Index faces() const { return static_cast<Index>(face_.size()); }

  // The largest coordinate in absolute value, rounded up; 0 without faces, infinity beyond floats.
  double reach() const {
    if (nodes_.empty()) return 0;
    double out = 0;
    for (int k = 0; k < 3; ++k) {
      const double lo = nodes_[0].lo[k] < 0 ? -nodes_[0].lo[k] : nodes_[0].lo[k];
      const double hi = nodes_[0].hi[k] < 0 ? -nodes_[0].hi[k] : nodes_[0].hi[k];
      out = lo > out ? lo : out;
      out = hi > out ? hi : out;
    }
    return out;
  }

  // The sum of the areas of inner boxes over that of the root. Rebuild when a refit made it much larger
  // than after build.
  double cost() const;

  // visit(f, g, out) for every two different faces whose boxes overlap, each pair once, f < g. Parallel;
  // what the visits of a block append to `out` comes in an order that does not depend on threads.
  template <class T, class Visit>
  std::vector<T> collect_self_pairs(Visit&& visit) const {
    const std::vector<NodePair> tasks = self_tasks();
    return parallel_collect<T>(static_cast<std::int64_t>(tasks.size()), kTaskGrain,
                               [&](std::int64_t begin, std::int64_t end, std::vector<T>& out) {
                                 for (std::int64_t i = begin; i < end; ++i)
                                   traverse(tasks[i], [&](Index f, Index g) {
                                     visit(f, g, out);
                                     return true;
                                   });
                               });
  }

  // As above, but the search ends soon after a visit returned true ("found"). Returns whether one did.
  // `wave` blocks are finished together, so what was appended does not depend on threads either.
  template <class T, class Visit>
  bool find_self_pair(std::vector<T>& found, Visit&& visit) const {
    const std::vector<NodePair> tasks = self_tasks();
    const std::int64_t n = static_cast<std::int64_t>(tasks.size());
    constexpr std::int64_t wave = 64;
    for (std::int64_t first = 0; first < n && found.empty(); first += wave) {
      const std::int64_t last = first + wave < n ? first + wave : n;
      found = parallel_collect<T>(last - first, kTaskGrain,
                                  [&](std::int64_t begin, std::int64_t end, std::vector<T>& out) {
                                    for (std::int64_t i = begin; i < end && out.empty(); ++i)
                                      traverse(tasks[first + i], [&](Index f, Index g) {
                                        visit(f, g, out);
                                        return out.empty();
                                      });
                                  });
    }
    return !found.empty();
  }

  // visit(f) for every face whose box meets [lo, hi]. Serial.
  template <class Visit>
  void query_box(const double* lo, const double* hi, Visit&& visit) const;

  // visit(f) for every face whose box, inflated by slack, meets the ray origin + t direction, t >= 0.
  template <class Visit>
  void query_ray(const double* origin, const double* direction, double slack, Visit&& visit) const;

  struct Box {
    float lo[3];
    std::int32_t a;  // node: index of the right child (the left one follows), or of the first face
    float hi[3];
    std::int32_t b;  // node: 0 for inner ones, else number of faces; bit 30: nothing in it is active
  };

 private:
  struct NodePair {
    std::int32_t a, b;
  };
  static constexpr std::int64_t kTaskGrain = 1;
  static constexpr std::int32_t kPassive = 1 << 30;

  static bool overlap(const Box& x, const Box& y) {
#if defined(__SSE__)
    const __m128 xl = _mm_loadu_ps(x.lo), xh = _mm_loadu_ps(x.hi);
    const __m128 yl = _mm_loadu_ps(y.lo), yh = _mm_loadu_ps(y.hi);
    return (_mm_movemask_ps(_mm_and_ps(_mm_cmple_ps(xl, yh), _mm_cmple_ps(yl, xh))) & 7) == 7;
#else
    for (int k = 0; k < 3; ++k)
      if (!(x.lo[k] <= y.hi[k] && y.lo[k] <= x.hi[k])) return false;
    return true;
#endif
  }
  static float size(const Box& x) { return (x.hi[0] - x.lo[0]) + (x.hi[1] - x.lo[1]) + (x.hi[2] - x.lo[2]); }
  static int leaf_count(const Box& x) { return x.b & ~kPassive; }
  static bool passive(const Box& x) { return (x.b & kPassive) != 0; }

  std::vector<NodePair> self_tasks() const;
  void refit_nodes();
  template <class FaceBox>
  void set_face_boxes(FaceBox&& box);
  // Calls push(NodePair) for what a pair of overlapping nodes splits into.
  template <class Push>
  void split(NodePair pair, Push&& push) const {
    const Box &x = nodes_[pair.a], &y = nodes_[pair.b];
    if (pair.a == pair.b) {
      const std::int32_t left = pair.a + 1, right = x.a;
      push(NodePair{right, right});
      push(NodePair{left, right});
      push(NodePair{left, left});
      return;
    }
    const bool split_first = leaf_count(y) != 0 || (leaf_count(x) == 0 && size(x) >= size(y));
    if (split_first) {
      push(NodePair{x.a, pair.b});
      push(NodePair{pair.a + 1, pair.b});
    } else {
      push(NodePair{pair.a, y.a});
      push(NodePair{pair.a, pair.b + 1});
    }
  }
  bool wanted(NodePair pair) const {
    const Box &x = nodes_[pair.a], &y = nodes_[pair.b];
    if (passive(x) && passive(y)) return false;
    return pair.a == pair.b || overlap(x, y);
  }
  template <class Visit>
  void traverse(NodePair task, Visit&& visit) const {
    // A binary tree over n faces is at most n deep; in practice about 60, so that the vector never grows.
    std::vector<NodePair> stack;
    stack.reserve(256);
    if (wanted(task)) stack.push_back(task);
    while (!stack.empty()) {
      const NodePair pair = stack.back();
      stack.pop_back();
      const Box &x = nodes_[pair.a], &y = nodes_[pair.b];
      const int nx = leaf_count(x), ny = leaf_count(y);
      if (nx == 0 || ny == 0) {
        split(pair, [&](NodePair p) {
          if (wanted(p)) stack.push_back(p);
        });
        continue;
      }
      for (int i = 0; i < nx; ++i) {
        const Box& f = boxes_[x.a + i];
        for (int j = pair.a == pair.b ? i + 1 : 0; j < ny; ++j) {
          const Box& g = boxes_[y.a + j];
          if (!overlap(f, g) || (passive(f) && passive(g))) continue;
          if (!(f.a < g.a ? visit(f.a, g.a) : visit(g.a, f.a))) return;
        }
      }
    }
  }

  std::vector<Box> nodes_;                     // depth first, children after parents
  std::vector<Box> boxes_;                     // of the faces, in leaf order; a: the face
  std::vector<Index> face_;                    // leaf order -> face
  std::vector<std::array<Index, 3>> corners_;  // in leaf order
};

template <class Visit>
void TriangleBvh::query_box(const double* lo, const double* hi, Visit&& visit) const {
  if (nodes_.empty()) return;
  const auto meets = [&](const Box& x) {
    for (int k = 0; k < 3; ++k)
      if (!(x.lo[k] <= hi[k] && lo[k] <= x.hi[k])) return false;
    return true;
  };
  std::vector<std::int32_t> stack;
  stack.reserve(128);
  stack.push_back(0);
  while (!stack.empty()) {
    const std::int32_t at = stack.back();
    stack.pop_back();
    const Box& x = nodes_[at];
    if (!meets(x)) continue;
    if (const int n = leaf_count(x)) {
      for (int i = 0; i < n; ++i)
        if (meets(boxes_[x.a + i])) visit(boxes_[x.a + i].a);
    } else {
      stack.push_back(x.a);
      stack.push_back(at + 1);
    }
  }
}

template <class Visit>
void TriangleBvh::query_ray(const double* origin, const double* direction, double slack,
                            Visit&& visit) const {
  if (nodes_.empty()) return;
  const auto meets = [&](const Box& x) {
    double near = 0, far = 1e308;
    for (int k = 0; k < 3; ++k) {
      const double lo = x.lo[k] - slack - origin[k], hi = x.hi[k] + slack - origin[k];
      if (direction[k] == 0) {
        if (lo > 0 || hi < 0) return false;
        continue;
      }
      double enter = lo / direction[k], leave = hi / direction[k];
      if (enter > leave) std::swap(enter, leave);
      near = enter > near ? enter : near;
      far = leave < far ? leave : far;
    }
    // Rounding of the quotients: a few ulp, on the safe side.
    return near <= far + 1e-14 * (near < 0 ? -near : near);
  };
  std::vector<std::int32_t> stack;
  stack.reserve(128);
  stack.push_back(0);
  while (!stack.empty()) {
    const std::int32_t at = stack.back();
    stack.pop_back();
    const Box& x = nodes_[at];
    if (!meets(x)) continue;
    if (const int n = leaf_count(x)) {
      for (int i = 0; i < n; ++i)
        if (meets(boxes_[x.a + i])) visit(boxes_[x.a + i].a);
    } else {
      stack.push_back(x.a);
      stack.push_back(at + 1);
    }
  }
}

}  // namespace overtet
