#include "kernels/contact/box_tree.h"

#include <algorithm>
#include <numeric>

#include "kernels/parallel/parallel.h"

namespace overtet {

namespace {
constexpr Index kLeaf = 4;
// Traversals are cut into about this many independent tasks; a constant, so that the order of the result
// does not depend on the machine.
constexpr std::size_t kTasks = 256;
}  // namespace

void BoxTree::build(std::span<const Box> boxes) {
  const Index n = static_cast<Index>(boxes.size());
  item_.resize(n);
  std::iota(item_.begin(), item_.end(), 0);
  node_.clear();
  node_.reserve(2 * static_cast<std::size_t>(n) / 2 + 16);
  std::vector<Eigen::Vector3d> centre(n);
  for (Index i = 0; i < n; ++i)
    for (int k = 0; k < 3; ++k) centre[i][k] = boxes[i].low[k] + boxes[i].high[k];
  if (n > 0) split(0, n, centre);
  refit(boxes);
}

Index BoxTree::split(Index first, Index count, const std::vector<Eigen::Vector3d>& centre) {
  const Index me = static_cast<Index>(node_.size());
  node_.emplace_back();
  node_[me].first = first;
  node_[me].count = count;
  if (count <= kLeaf) return me;
  Eigen::Vector3d low = centre[item_[first]], high = low;
  for (Index i = first; i < first + count; ++i)
    low = low.cwiseMin(centre[item_[i]]), high = high.cwiseMax(centre[item_[i]]);
  int axis = 0;
  (high - low).maxCoeff(&axis);
  const Index half = count / 2;
  std::nth_element(item_.begin() + first, item_.begin() + first + half, item_.begin() + first + count,
                   [&](Index a, Index b) {
                     return centre[a][axis] < centre[b][axis] ||
                            (centre[a][axis] == centre[b][axis] && a < b);
                   });
  const Index left = split(first, half, centre);
  const Index right = split(first + half, count - half, centre);
  node_[me].left = left;
  node_[me].right = right;
  return me;
}

void BoxTree::refit(std::span<const Box> boxes) {
  box_.resize(item_.size());
  for (std::size_t i = 0; i < item_.size(); ++i) box_[i] = boxes[item_[i]];
  for (std::size_t i = node_.size(); i-- > 0;) {
    Node& node = node_[i];
    if (node.left >= 0) {
      node.box = node_[node.left].box;
      node.box.include(node_[node.right].box);
    } else {
      node.box = box_[node.first];
      for (Index k = node.first + 1; k < node.first + node.count; ++k) node.box.include(box_[k]);
    }
  }
}

void BoxTree::self(Index start, std::vector<IndexPair>& out) const {
  const Node& node = node_[start];
  if (node.left < 0) {
    for (Index i = node.first; i < node.first + node.count; ++i)
      for (Index j = i + 1; j < node.first + node.count; ++j)
        if (box_[i].overlaps(box_[j]))
          out.push_back({std::min(item_[i], item_[j]), std::max(item_[i], item_[j])});
    return;
  }
  self(node.left, out);
  self(node.right, out);
  cross(node.left, *this, node.right, true, out);
}

void BoxTree::cross(Index start, const BoxTree& other, Index other_start, bool same,
                    std::vector<IndexPair>& out) const {
  struct Frame {
    Index a, b;
  };
  std::vector<Frame> stack{{start, other_start}};
  while (!stack.empty()) {
    const auto [ia, ib] = stack.back();
    stack.pop_back();
    const Node &a = node_[ia], &b = other.node_[ib];
    if (!a.box.overlaps(b.box)) continue;
    if (a.left < 0 && b.left < 0) {
      for (Index i = a.first; i < a.first + a.count; ++i) {
        if (!box_[i].overlaps(b.box)) continue;
        for (Index j = b.first; j < b.first + b.count; ++j) {
          if (!box_[i].overlaps(other.box_[j])) continue;
          const Index p = item_[i], q = other.item_[j];
          out.push_back(same && q < p ? IndexPair{q, p} : IndexPair{p, q});
        }
      }
    } else if (b.left < 0 || (a.left >= 0 && a.count >= b.count)) {
      stack.push_back({a.right, ib});
      stack.push_back({a.left, ib});
    } else {
      stack.push_back({ia, b.right});
      stack.push_back({ia, b.left});
    }
  }
}

namespace {
struct Task {
  Index a, b;  // b < 0: pairs within a
};
}  // namespace

std::vector<IndexPair> BoxTree::self_pairs() const {
  if (node_.empty()) return {};
  // Breadth first: the largest tasks are replaced by their parts until there are enough.
  std::vector<Task> tasks{{0, -1}};
  for (bool grew = true; grew && tasks.size() < kTasks;) {
    grew = false;
    std::vector<Task> finer;
    for (const Task& t : tasks) {
      const Node& a = node_[t.a];
      if (t.b < 0 && a.left >= 0) {
        finer.insert(finer.end(), {{a.left, -1}, {a.right, -1}, {a.left, a.right}});
        grew = true;
      } else if (t.b >= 0) {
        const Node& b = node_[t.b];
        if (!a.box.overlaps(b.box)) continue;
        if (a.left >= 0 && b.left >= 0) {
          for (Index x : {a.left, a.right})
            for (Index y : {b.left, b.right}) finer.push_back({x, y});
          grew = true;
        } else {
          finer.push_back(t);
        }
      } else {
        finer.push_back(t);
      }
    }
    tasks = std::move(finer);
  }
  return parallel_collect<IndexPair>(static_cast<std::int64_t>(tasks.size()), 1,
                                     [&](std::int64_t begin, std::int64_t end, std::vector<IndexPair>& out) {
                                       for (std::int64_t i = begin; i < end; ++i) {
                                         if (tasks[i].b < 0)
                                           self(tasks[i].a, out);
                                         else
                                           cross(tasks[i].a, *this, tasks[i].b, true, out);
                                       }
                                     });
}

std::vector<IndexPair> BoxTree::pairs_with(const BoxTree& other) const {
  if (node_.empty() || other.node_.empty()) return {};
  std::vector<Task> tasks{{0, 0}};
  for (bool grew = true; grew && tasks.size() < kTasks;) {
    grew = false;
    std::vector<Task> finer;
    for (const Task& t : tasks) {
      const Node &a = node_[t.a], &b = other.node_[t.b];
      if (!a.box.overlaps(b.box)) continue;
      if (a.left >= 0 && (b.left < 0 || a.count >= b.count)) {
        finer.insert(finer.end(), {{a.left, t.b}, {a.right, t.b}});
        grew = true;
      } else if (b.left >= 0) {
        finer.insert(finer.end(), {{t.a, b.left}, {t.a, b.right}});
        grew = true;
      } else {
        finer.push_back(t);
      }
    }
    tasks = std::move(finer);
  }
  return parallel_collect<IndexPair>(static_cast<std::int64_t>(tasks.size()), 1,
                                     [&](std::int64_t begin, std::int64_t end, std::vector<IndexPair>& out) {
                                       for (std::int64_t i = begin; i < end; ++i)
                                         cross(tasks[i].a, other, tasks[i].b, false, out);
                                     });
}

}  // namespace overtet
