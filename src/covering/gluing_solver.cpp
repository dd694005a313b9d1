#include "src/covering/gluing_solver.h"

#include <algorithm>

namespace overtet {

std::vector<Named> name_layers(const std::vector<Index>& regions,
                               const std::vector<std::array<Index, 2>>& cells,
                               const std::vector<int>& layers) {
  std::vector<Named> named(regions.size(), Named::neither);
  std::map<Index, std::vector<std::size_t>> at_cell;  // the regions' places in the list
  for (std::size_t i = 0; i < regions.size(); ++i)
    for (const Index c : cells[regions[i]])
      if (c >= 0) at_cell[c].push_back(i);
  std::vector<Index> order;
  for (const auto& [cell, list] : at_cell) order.push_back(cell);
  std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return layers[a] < layers[b]; });
  std::set<Index> known;
  std::vector<Index> queue;
  for (const Index c : order)
    if (layers[c] <= 1) known.insert(c), queue.push_back(c);
  for (std::size_t head = 0, root = 0;;) {
    for (; head < queue.size(); ++head)
      for (const std::size_t i : at_cell[queue[head]]) {
        const auto [front, back] = cells[regions[i]];
        const bool here_is_front = front == queue[head];
        const Index other = here_is_front ? back : front;
        if (other < 0 || !known.insert(other).second) continue;
        named[i] = here_is_front ? Named::back : Named::front;
        queue.push_back(other);
      }
    while (root < order.size() && known.count(order[root])) ++root;
    if (root == order.size()) return named;
    known.insert(order[root]);
    queue.push_back(order[root]);
  }
}

}  // namespace overtet
