#include "kernels/bvh/bvh.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace overtet {

namespace {

constexpr Index kLeafSize = 4;
constexpr int kBins = 16;
constexpr Index kParallelBuild = 8192;  // faces; smaller subtrees are built by one thread
constexpr std::int64_t kFaceGrain = 4096;
constexpr std::size_t kSelfTasks = 1024;  // enough to keep any number of cores busy to the end

using Box = TriangleBvh::Box;

float round_down(double x) {
  const float f = static_cast<float>(x);
  return f > x ? std::nextafterf(f, -std::numeric_limits<float>::infinity()) : f;
}
float round_up(double x) {
  const float f = static_cast<float>(x);
  return f < x ? std::nextafterf(f, std::numeric_limits<float>::infinity()) : f;
}

#if defined(__SSE__)
// The fourth lane carries whatever a Box keeps there and is never read.
struct Bounds {
  __m128 low = _mm_set1_ps(HUGE_VALF), high = _mm_set1_ps(-HUGE_VALF);
  void add(const Box& x) {
    low = _mm_min_ps(_mm_loadu_ps(x.lo), low);  // on a NaN in the fourth lane: keeps the second
    high = _mm_max_ps(_mm_loadu_ps(x.hi), high);
  }
  void add(const Bounds& x) {
    low = _mm_min_ps(x.low, low);
    high = _mm_max_ps(x.high, high);
  }
  void add_centre(const Box& x) {
    const __m128 c = _mm_add_ps(_mm_loadu_ps(x.lo), _mm_loadu_ps(x.hi));
    low = _mm_min_ps(c, low);
    high = _mm_max_ps(c, high);
  }
  void get(float* lo, float* hi) const {
    alignas(16) float l[4], h[4];
    _mm_store_ps(l, low);
    _mm_store_ps(h, high);
    std::copy(l, l + 3, lo);
    std::copy(h, h + 3, hi);
  }
#else
struct Bounds {
  float low[3] = {HUGE_VALF, HUGE_VALF, HUGE_VALF}, high[3] = {-HUGE_VALF, -HUGE_VALF, -HUGE_VALF};
  void add(const Box& x) {
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], x.lo[k]), high[k] = std::max(high[k], x.hi[k]);
  }
  void add(const Bounds& x) {
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], x.low[k]), high[k] = std::max(high[k], x.high[k]);
  }
  void add_centre(const Box& x) {
    for (int k = 0; k < 3; ++k) {
      low[k] = std::min(low[k], x.lo[k] + x.hi[k]);
      high[k] = std::max(high[k], x.lo[k] + x.hi[k]);
    }
  }
  void get(float* lo, float* hi) const {
    std::copy(low, low + 3, lo);
    std::copy(high, high + 3, hi);
  }
#endif
  double area() const {
    float lo[3], hi[3];
    get(lo, hi);
    const double x = double(hi[0]) - lo[0], y = double(hi[1]) - lo[1], z = double(hi[2]) - lo[2];
    return x < 0 ? 0 : x * y + y * z + z * x;
  }
};

// Twice the centre of a box.
float centre(const Box& x, int axis) { return x.lo[axis] + x.hi[axis]; }

// One subtree over item[begin, end), the boxes of the faces, which are moved about so that every pass reads
// them in a row. Written with gaps: the subtree of n faces at node s owns the slots [s, s + 2 n - 1), so
// that two threads can write at once; the gaps are squeezed out afterwards.
struct Builder {
  std::vector<Box>& item;  // a: the face
  std::vector<Box>& slot;
  std::vector<char>& used;

  void run(Index begin, Index end, std::int64_t s, int depth) {
    const Index n = end - begin;
    used[s] = 1;
    if (n <= kLeafSize) {
      slot[s].a = begin;
      slot[s].b = n;
      return;
    }
    const Index middle = split(begin, end, depth);
    const std::int64_t right = s + 2 * std::int64_t{middle - begin};
    slot[s].a = static_cast<std::int32_t>(right);
    slot[s].b = 0;
    if (n > kParallelBuild) {
      parallel_invoke([&] { run(begin, middle, s + 1, depth + 1); },
                      [&] { run(middle, end, right, depth + 1); });
    } else {
      run(begin, middle, s + 1, depth + 1);
      run(middle, end, right, depth + 1);
    }
  }

  Index split(Index begin, Index end, int depth) {
    const Index half = begin + (end - begin) / 2;
    Bounds spread;
    for (Index i = begin; i < end; ++i) spread.add_centre(item[i]);
    float least[3], most[3];
    spread.get(least, most);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (most[k] - least[k] > most[axis] - least[axis]) axis = k;
    const float low = least[axis], extent = most[axis] - low;
    // Infinite boxes (coordinates beyond floats), equal centres, or a degenerating tree: halve the list.
    if (!(extent > 0) || !std::isfinite(extent) || depth > 64) {
      std::nth_element(item.begin() + begin, item.begin() + half, item.begin() + end,
                       [&](const Box& x, const Box& y) {
                         const float cx = centre(x, axis), cy = centre(y, axis);
                         return cx != cy ? cx < cy : x.a < y.a;
                       });
      return half;
    }
    const float scale = kBins / extent;
    const auto bin_of = [&](const Box& x) {
      return std::clamp(static_cast<int>((centre(x, axis) - low) * scale), 0, kBins - 1);
    };
    Bounds bounds[kBins];
    Index count[kBins] = {};
    for (Index i = begin; i < end; ++i) {
      const int b = bin_of(item[i]);
      ++count[b];
      bounds[b].add(item[i]);
    }
    double right_cost[kBins];
    Bounds sum;
    Index seen = 0;
    for (int b = kBins - 1; b > 0; --b) {
      sum.add(bounds[b]);
      seen += count[b];
      right_cost[b] = sum.area() * seen;
    }
    sum = {};
    seen = 0;
    int best = -1;
    double best_cost = HUGE_VAL;
    for (int b = 1; b < kBins; ++b) {
      sum.add(bounds[b - 1]);
      seen += count[b - 1];
      const double cost = sum.area() * seen + right_cost[b];
      if (seen > 0 && seen < end - begin && cost < best_cost) best_cost = cost, best = b;
    }
    if (best < 0) return half;
    return static_cast<Index>(std::partition(item.begin() + begin, item.begin() + end,
                                             [&](const Box& x) { return bin_of(x) < best; }) -
                              item.begin());
  }
};

// p: rows of three doubles.
void bound(const double* p, const double* q, const double* r, double pad, Box& box) {
  for (int k = 0; k < 3; ++k) {
    box.lo[k] = round_down(std::min(std::min(p[k], q[k]), r[k]) - pad);
    box.hi[k] = round_up(std::max(std::max(p[k], q[k]), r[k]) + pad);
  }
}

}  // namespace

void TriangleBvh::build(const VertexMatrix& V, const TriangleMatrix& F) {
  const Index n = static_cast<Index>(F.rows());
  nodes_.clear();
  boxes_.clear();
  face_.resize(n);
  corners_.resize(n);
  if (n == 0) return;
  boxes_.resize(n);
  parallel_for(n, kFaceGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t f = begin; f < end; ++f) {
      bound(V.data() + 3 * std::int64_t{F(f, 0)}, V.data() + 3 * std::int64_t{F(f, 1)},
            V.data() + 3 * std::int64_t{F(f, 2)}, 0, boxes_[f]);
      boxes_[f].a = static_cast<Index>(f);
      boxes_[f].b = 0;
    }
  });
  std::vector<Box> slot(2 * static_cast<std::size_t>(n));
  std::vector<char> used(slot.size(), 0);
  Builder{boxes_, slot, used}.run(0, n, 0, 0);
  // Squeeze out the gaps; slots are in depth-first order, so the left child stays next to its parent.
  std::vector<std::int32_t> place(slot.size(), -1);
  std::int32_t count = 0;
  for (std::size_t s = 0; s < slot.size(); ++s)
    if (used[s]) place[s] = count++;
  nodes_.resize(count);
  for (std::size_t s = 0; s < slot.size(); ++s) {
    if (!used[s]) continue;
    Box& node = nodes_[place[s]];
    node = slot[s];
    if (node.b == 0) node.a = place[node.a];
  }
  for (Index i = 0; i < n; ++i) {
    face_[i] = boxes_[i].a;
    for (int k = 0; k < 3; ++k) corners_[i][k] = F(face_[i], k);
  }
  refit_nodes();
}

template <class FaceBox>
void TriangleBvh::set_face_boxes(FaceBox&& face_box) {
  parallel_for(faces(), kFaceGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) face_box(i, boxes_[i]);
  });
  refit_nodes();
}

void TriangleBvh::refit(const VertexMatrix& V, const double* pad) {
  const double* p = V.data();
  set_face_boxes([&](std::int64_t i, Box& box) {
    const auto& c = corners_[i];
    bound(p + 3 * std::int64_t{c[0]}, p + 3 * std::int64_t{c[1]}, p + 3 * std::int64_t{c[2]},
          pad ? pad[face_[i]] : 0, box);
  });
}

void TriangleBvh::refit_swept(const VertexMatrix& V0, const VertexMatrix& V1, const double* pad) {
  const double *p = V0.data(), *q = V1.data();
  set_face_boxes([&](std::int64_t i, Box& box) {
    const auto& c = corners_[i];
    const std::int64_t x = 3 * std::int64_t{c[0]}, y = 3 * std::int64_t{c[1]}, z = 3 * std::int64_t{c[2]};
    const double inflate = pad ? pad[face_[i]] : 0;
    Box end;
    bound(p + x, p + y, p + z, inflate, box);
    bound(q + x, q + y, q + z, inflate, end);
    for (int k = 0; k < 3; ++k) {
      box.lo[k] = std::min(box.lo[k], end.lo[k]);
      box.hi[k] = std::max(box.hi[k], end.hi[k]);
    }
  });
}

void TriangleBvh::refit_nodes() {
  for (std::int64_t s = static_cast<std::int64_t>(nodes_.size()) - 1; s >= 0; --s) {
    Box& node = nodes_[s];
    Bounds sum;
    if (const int n = leaf_count(node)) {
      for (int i = 0; i < n; ++i) sum.add(boxes_[node.a + i]);
    } else {
      sum.add(nodes_[s + 1]);
      sum.add(nodes_[node.a]);
    }
    sum.get(node.lo, node.hi);
  }
}

void TriangleBvh::set_active(const std::vector<std::uint8_t>& active) {
  for (Box& box : boxes_) box.b = active.empty() || active[box.a] ? 0 : kPassive;
  for (std::int64_t s = static_cast<std::int64_t>(nodes_.size()) - 1; s >= 0; --s) {
    Box& node = nodes_[s];
    bool any = false;
    if (const int n = leaf_count(node)) {
      for (int i = 0; i < n; ++i) any = any || !passive(boxes_[node.a + i]);
    } else {
      any = !passive(nodes_[s + 1]) || !passive(nodes_[node.a]);
    }
    node.b = leaf_count(node) | (any ? 0 : kPassive);
  }
}

double TriangleBvh::cost() const {
  if (nodes_.empty()) return 0;
  const auto area = [](const Box& x) {
    const double a = double(x.hi[0]) - x.lo[0], b = double(x.hi[1]) - x.lo[1], c = double(x.hi[2]) - x.lo[2];
    return a * b + b * c + c * a;
  };
  double sum = 0;
  for (const Box& node : nodes_) sum += area(node);
  const double root = area(nodes_[0]);
  return root > 0 ? sum / root : 0;
}

std::vector<TriangleBvh::NodePair> TriangleBvh::self_tasks() const {
  std::vector<NodePair> tasks, next;
  if (nodes_.empty()) return tasks;
  tasks.push_back({0, 0});
  while (tasks.size() < kSelfTasks) {
    next.clear();
    bool grew = false;
    for (const NodePair& pair : tasks) {
      if (leaf_count(nodes_[pair.a]) != 0 || leaf_count(nodes_[pair.b]) != 0) {
        next.push_back(pair);
        continue;
      }
      grew = true;
      split(pair, [&](NodePair p) {
        if (wanted(p)) next.push_back(p);
      });
    }
    tasks.swap(next);
    if (!grew) break;
  }
  return tasks;
}

}  // namespace overtet
