// What handles must be, whether they come from a file or not.
#include <set>
#include <string>

#include "overtet/weights.h"

namespace overtet {

namespace {

Error no_handles(const std::string& what) { return {ErrorCode::usage, what}; }

template <class T>
bool in_range(int i, const std::vector<T>& list) {
  return i >= 0 && i < std::ssize(list);
}

}  // namespace

Status Handles::validate() const {
  if (handles.empty()) return no_handles("There are no handles.");
  std::set<std::string> names;
  std::set<int> points;
  for (const Handle& h : handles) {
    if (h.name.empty()) return no_handles("A handle has no name.");
    if (!names.insert(h.name).second) return no_handles("Two handles are named '" + h.name + "'.");
    if (!in_range(h.place, places) || (h.bone() && !in_range(h.tail, places)))
      return no_handles("Handle '" + h.name + "' is at a place that does not exist.");
    if (h.parent != -1 && !in_range(h.parent, handles))
      return no_handles("The parent of handle '" + h.name + "' does not exist.");
    if (!h.bone()) points.insert(h.place);
  }
  // Every handle looks at its parents' parents as far as no other one has.
  std::vector<std::size_t> seen_from(handles.size(), handles.size());
  for (std::size_t i = 0; i < handles.size(); ++i)
    for (std::size_t h = i; seen_from[h] != i;) {
      if (seen_from[h] != handles.size()) break;
      seen_from[h] = i;
      if (handles[h].parent < 0) break;
      h = static_cast<std::size_t>(handles[h].parent);
      if (seen_from[h] == i)
        return no_handles("Handle '" + handles[h].name + "' is among its own parents' parents.");
    }
  for (const HandlePlace& p : places)
    if (!p.position.allFinite()) return no_handles("A handle's position is not finite.");
  const auto cage = [&](const auto& corners) {
    std::set<int> different;
    for (const int c : corners) {
      if (!points.contains(c)) return false;
      different.insert(c);
    }
    return different.size() == corners.size();
  };
  for (const auto& e : cage_edges)
    if (!cage(e)) return no_handles("The edges of a cage join two different point handles.");
  for (const auto& f : cage_faces)
    if (!cage(f)) return no_handles("The faces of a cage join three different point handles.");
  return success();
}

}  // namespace overtet
