// Which label a face of a surface has. Internal to src/labels.
#pragma once

#include <vector>

#include "kernels/core/union_find.h"
#include "overtet/types.h"

namespace overtet::labels_detail {

// Of each group (a component, known by one of its members' sets): its number, from `first` on, in the order
// in which groups are met. member(i), i < n, is a member of the group that item i belongs to.
template <class Member>
std::vector<Index> numbered(UnionFind& sets, Index n, Index first, Member&& member) {
  std::vector<Index> number(sets.size(), -1), of(static_cast<std::size_t>(n));
  for (Index i = 0; i < n; ++i) {
    Index& mine = number[static_cast<std::size_t>(sets.root(member(i)))];
    if (mine < 0) mine = first++;
    of[static_cast<std::size_t>(i)] = mine;
  }
  return of;
}

}  // namespace overtet::labels_detail
