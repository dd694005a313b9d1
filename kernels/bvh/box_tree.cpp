#include "kernels/bvh/box_tree.h"

#include <algorithm>
#include <bit>

#include "kernels/bvh/tuning.h"
#include "kernels/core/assertions.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

namespace {

using bvh_detail::Lanes;

constexpr int kBits = 11, kCells = 1 << kBits;  // of a cell's number along each axis
constexpr int kItemBits = 31;                   // of an item's number

// Where an item lies and which it is: the cell of its centre in a grid of 2^11 cells along the longest side
// of a box, the bits of the three axes interleaved, above the item's number.
using Record = std::uint64_t;

Record code_of(Record r) { return r >> kItemBits; }
Index item_of(Record r) { return static_cast<Index>(r & ((Record{1} << kItemBits) - 1)); }

// Two zeros after every one of the lowest 11 bits.
Record spread(std::uint32_t x) {
  Record r = x;
  r = (r | r << 16) & 0xff0000ff;
  r = (r | r << 8) & 0x0f00f00f;
  r = (r | r << 4) & 0xc30c30c3;
  return (r | r << 2) & 0x49249249;
}

struct Span3 {
  float low[3] = {HUGE_VALF, HUGE_VALF, HUGE_VALF}, high[3] = {-HUGE_VALF, -HUGE_VALF, -HUGE_VALF};
  void add(const float* p) {
    for (int k = 0; k < 3; ++k) low[k] = std::min(low[k], p[k]), high[k] = std::max(high[k], p[k]);
  }
  void add(const Span3& o) { add(o.low), add(o.high); }
};

// Sorts by the whole record. Blocks are counted and moved in their order: the same on any number of threads.
void radix_sort(Record* records, Index n, RawVector<Record>& scratch) {
  scratch.resize(n);
  const std::int64_t block = 16 * kLightGrain;  // a table of cells is worth so many
  const std::int64_t blocks = (n + block - 1) / block;
  std::vector<Index> count(static_cast<std::size_t>(blocks) * kCells);
  Record *from = records, *to = scratch.data();
  // Items ascend already where codes are equal, and the sort is stable.
  for (int pass = 0; pass < 3; ++pass) {
    const int shift = kItemBits + kBits * pass;
    const auto digit = [&](Record r) { return static_cast<std::size_t>(r >> shift & (kCells - 1)); };
    std::fill(count.begin(), count.end(), 0);
    parallel_for(n, block, [&](std::int64_t begin, std::int64_t end) {
      Index* c = count.data() + begin / block * kCells;
      for (std::int64_t i = begin; i < end; ++i) ++c[digit(from[i])];
    });
    Index sum = 0;
    for (int d = 0; d < kCells; ++d)
      for (std::int64_t b = 0; b < blocks; ++b) {
        const Index here = count[static_cast<std::size_t>(b) * kCells + d];
        count[static_cast<std::size_t>(b) * kCells + d] = sum;
        sum += here;
      }
    parallel_for(n, block, [&](std::int64_t begin, std::int64_t end) {
      Index* c = count.data() + begin / block * kCells;
      for (std::int64_t i = begin; i < end; ++i) to[c[digit(from[i])]++] = from[i];
    });
    std::swap(from, to);
  }
  parallel_for(n, block, [&](std::int64_t begin, std::int64_t end) {
    std::copy(from + begin, from + end, records + begin);
  });
}

}  // namespace

struct BoxTree::Builder {
  BoxTree& tree;
  RawVector<FloatBox> box;  // of the items
  RawVector<Record> record, scratch;

  struct Centre {
    float x[3];
  };
  Centre centre(Index item) const {
    Centre c;
    for (int k = 0; k < 3; ++k) c.x[k] = 0.5f * box[item].low[k] + 0.5f * box[item].high[k];
    return c;
  }

  // Codes relative to the box of the centres of a range, sorted.
  void encode(Index begin, Index end) {
    const Index n = end - begin;
    const Span3 span = parallel_reduce(
        n, kLightGrain, Span3(),
        [&](std::int64_t b, std::int64_t e) {
          Span3 s;
          for (std::int64_t i = begin + b; i < begin + e; ++i) s.add(centre(item_of(record[i])).x);
          return s;
        },
        [](Span3 a, const Span3& b) {
          a.add(b);
          return a;
        });
    float extent = 0;
    for (int k = 0; k < 3; ++k) extent = std::max(extent, span.high[k] - span.low[k]);
    const float scale = kCells / extent;
    const bool usable = extent > 0 && std::isfinite(extent) && std::isfinite(scale);
    parallel_for(n, kLightGrain, [&](std::int64_t b, std::int64_t e) {
      for (std::int64_t i = begin + b; i < begin + e; ++i) {
        const Index item = item_of(record[i]);
        const Centre c = centre(item);
        Record code = 0;
        for (int k = 0; k < 3 && usable; ++k) {
          const int cell = static_cast<int>((c.x[k] - span.low[k]) * scale);
          code |= spread(static_cast<std::uint32_t>(std::clamp(cell, 0, kCells - 1))) << (2 - k);
        }
        record[i] = code << kItemBits | static_cast<Record>(item);
      }
    });
    if (n < kLightGrain)
      std::sort(record.begin() + begin, record.begin() + end);
    else
      radix_sort(record.data() + begin, n, scratch);
  }

  // Where a range is cut: at the highest bit in which the codes differ. Items in one cell get finer codes;
  // items at one place are halved.
  Index cut(Index begin, Index end) {
    if (code_of(record[begin]) == code_of(record[end - 1])) encode(begin, end);
    const Record first = code_of(record[begin]), last = code_of(record[end - 1]);
    if (first == last) return begin + (end - begin) / 2;
    const Record bit = std::bit_floor(first ^ last), from = last & ~(bit - 1);
    return static_cast<Index>(
        std::lower_bound(record.begin() + begin, record.begin() + end, from << kItemBits) - record.begin());
  }

  void top(std::int32_t node, Index begin, Index end, int depth) {
    if (end - begin <= kLightGrain) {
      tree.subtrees_.push_back({node, 0, 0, begin, end, depth});
      return;
    }
    const Index middle = cut(begin, end);
    const std::int32_t children = static_cast<std::int32_t>(tree.nodes_.size());
    tree.nodes_.resize(children + 2);
    tree.nodes_[node].first = children;
    tree.nodes_[node].kind = 0;
    top(children, begin, middle, depth + 1);
    top(children + 1, middle, end, depth + 1);
  }

  // nodes[at]; children are numbered within the subtree. Returns the depth.
  int below(RawVector<Node>& nodes, std::size_t at, Index begin, Index end) {
    if (end - begin <= kLeafSize) {
      nodes[at].first = begin;
      nodes[at].kind = end - begin;
      return 1;
    }
    const Index middle = cut(begin, end);
    const std::size_t children = nodes.size();
    nodes.resize(children + 2);
    nodes[at].first = static_cast<std::int32_t>(children);
    nodes[at].kind = 0;
    return 1 + std::max(below(nodes, children, begin, middle), below(nodes, children + 1, middle, end));
  }
};

// The box of a leaf's items or of two children (of which `node.first` is the first, in `children`).
void BoxTree::fit(Node& node, const Node* children) const {
  float lo[4], hi[4];
  if (const int n = node.count()) {
    for (int k = 0; k < 3; ++k) {
      lo[k] = *std::min_element(low(k) + node.first, low(k) + node.first + n);
      hi[k] = *std::max_element(high(k) + node.first, high(k) + node.first + n);
    }
  } else {
    const Node &a = children[0], &b = children[1];
    bvh_detail::min(Lanes::load(a.low), Lanes::load(b.low)).store(lo);
    bvh_detail::max(Lanes::load(a.high), Lanes::load(b.high)).store(hi);
  }
  std::copy(lo, lo + 3, node.low);
  std::copy(hi, hi + 3, node.high);
}

void BoxTree::fill_places(Index begin, Index end, const Fill& fill) {
  FloatBox boxes[kAtATime];
  for (Index at = begin; at < end; at += kAtATime) {
    const Index n = std::min(kAtATime, end - at);
    fill(item_.data() + at, n, boxes);
    for (int k = 0; k < 3; ++k)
      for (Index i = 0; i < n; ++i) {
        bounds_[k * stride_ + at + i] = boxes[i].low[k];
        bounds_[(3 + k) * stride_ + at + i] = boxes[i].high[k];
      }
  }
}

void BoxTree::build_from(Index n, const Fill& fill) {
  nodes_.clear();
  subtrees_.clear();
  active_.clear();
  depth_ = 0;
  item_.resize(n);
  stride_ = static_cast<std::size_t>(n) + 16;
  bounds_.resize(6 * stride_);
  for (int k = 0; k < 6; ++k) std::fill_n(bounds_.begin() + k * stride_ + n, 16, 0.0f);  // read, never used
  if (n == 0) return;

  Builder builder{*this, RawVector<FloatBox>(n), RawVector<Record>(n), {}};
  parallel_for(n, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) {
      item_[i] = static_cast<Index>(i);
      builder.record[i] = static_cast<Record>(i);
    }
    fill(item_.data() + begin, static_cast<Index>(end - begin), builder.box.data() + begin);
    OVERTET_EXPECTS(
        std::all_of(builder.box.begin() + begin, builder.box.begin() + end, [](const FloatBox& b) {
          return b.low[0] <= b.high[0] && b.low[1] <= b.high[1] && b.low[2] <= b.high[2];
        }));
  });
  nodes_.resize(1);
  builder.encode(0, n);
  builder.top(0, 0, n, 1);
  top_nodes_ = static_cast<std::int32_t>(nodes_.size());

  // Subtrees: built on their own, then put one after the other.
  const std::int64_t count = static_cast<std::int64_t>(subtrees_.size());
  std::vector<RawVector<Node>> parts(count);
  std::vector<int> depth(count);
  parallel_for(count, 1, [&](std::int64_t t, std::int64_t) {
    const Subtree& s = subtrees_[t];
    parts[t].reserve((s.end - s.begin) / 4 + 16);
    parts[t].resize(1);
    depth[t] = s.depth + builder.below(parts[t], 0, s.begin, s.end);
    for (Index i = s.begin; i < s.end; ++i) item_[i] = item_of(builder.record[i]);
  });
  std::int32_t at = top_nodes_;
  for (std::int64_t t = 0; t < count; ++t) {
    depth_ = std::max(depth_, depth[t]);
    subtrees_[t].first = at;
    at += static_cast<std::int32_t>(parts[t].size()) - 1;
    subtrees_[t].last = at;
  }
  nodes_.resize(at);
  parallel_for(count, 1, [&](std::int64_t t, std::int64_t) {
    const Subtree& s = subtrees_[t];
    for (std::size_t i = 0; i < parts[t].size(); ++i) {
      Node node = parts[t][i];
      if (node.kind == 0) node.first += s.first - 1;
      nodes_[i == 0 ? s.root : s.first + static_cast<std::int32_t>(i) - 1] = node;
    }
  });
  refit_from([&](const Index* items, Index m, FloatBox* out) {
    for (Index i = 0; i < m; ++i) out[i] = builder.box[items[i]];
  });
}

void BoxTree::refit_from(const Fill& fill) {
  parallel_for(static_cast<std::int64_t>(subtrees_.size()), 1, [&](std::int64_t t, std::int64_t) {
    const Subtree& s = subtrees_[t];
    fill_places(s.begin, s.end, fill);
    for (std::int32_t i = s.last; i-- > s.first;) fit(nodes_[i], nodes_.data() + nodes_[i].first);
    fit(nodes_[s.root], nodes_.data() + nodes_[s.root].first);
  });
  for (std::int32_t i = top_nodes_; i-- > 0;)
    if (nodes_[i].count() == 0 && nodes_[i].first < top_nodes_)
      fit(nodes_[i], nodes_.data() + nodes_[i].first);
}

void BoxTree::set_active(const std::vector<std::uint8_t>& active) {
  active_.clear();
  if (!active.empty()) {
    active_.resize(item_.size());
    for (std::size_t p = 0; p < item_.size(); ++p) active_[p] = active[item_[p]];
  }
  // Children come after their parents, subtrees after everything above them.
  for (std::int32_t i = static_cast<std::int32_t>(nodes_.size()); i-- > 0;) {
    Node& node = nodes_[i];
    bool any = active.empty();
    if (const int n = node.count())
      for (int k = 0; k < n && !any; ++k) any = active_[node.first + k] != 0;
    else
      any = any || !nodes_[node.first].passive() || !nodes_[node.first + 1].passive();
    node.kind = node.count() | (any ? 0 : kPassive);
  }
}

double BoxTree::reach() const {
  double out = 0;
  if (!nodes_.empty())
    for (int k = 0; k < 3; ++k)
      out = std::max({out, std::fabs(double{nodes_[0].low[k]}), std::fabs(double{nodes_[0].high[k]})});
  return out;
}

std::vector<BoxTree::NodePair> BoxTree::self_tasks() const { return tasks_with(*this); }

std::vector<BoxTree::NodePair> BoxTree::tasks_with(const BoxTree& other) const {
  std::vector<NodePair> tasks, next;
  if (nodes_.empty() || other.nodes_.empty()) return tasks;
  if (wanted(other, {0, 0})) tasks.push_back({0, 0});
  while (tasks.size() < kTasks) {
    next.clear();
    bool grew = false;
    for (const NodePair& pair : tasks) {
      if (nodes_[pair.a].count() != 0 && other.nodes_[pair.b].count() != 0) {
        next.push_back(pair);
        continue;
      }
      grew = true;
      split(other, pair, [&](NodePair p) { next.push_back(p); });
    }
    tasks.swap(next);
    if (!grew) break;
  }
  return tasks;
}

}  // namespace overtet
