// What handles must be, and where poses take them.
#include <cmath>
#include <set>
#include <string>

#include "overtet/weights.h"

namespace overtet {

namespace {

Error refused(const std::string& what) { return {ErrorCode::usage, what}; }

template <class T>
bool in_range(int i, const std::vector<T>& list) {
  return i >= 0 && i < std::ssize(list);
}

}  // namespace

Status Handles::validate() const {
  if (handles.empty()) return refused("There are no handles.");
  std::set<std::string> names;
  std::set<int> points;
  for (const Handle& h : handles) {
    if (h.name.empty()) return refused("A handle has no name.");
    if (!names.insert(h.name).second) return refused("Two handles are named '" + h.name + "'.");
    if (!in_range(h.place, places) || (h.bone() && !in_range(h.tail, places)))
      return refused("Handle '" + h.name + "' is at a place that does not exist.");
    if (h.parent != -1 && !in_range(h.parent, handles))
      return refused("The parent of handle '" + h.name + "' does not exist.");
    if (!h.bone()) points.insert(h.place);
  }
  for (std::size_t i = 0; i < handles.size(); ++i) {
    std::size_t steps = 0;
    for (int p = handles[i].parent; p >= 0; p = handles[static_cast<std::size_t>(p)].parent)
      if (++steps > handles.size())
        return refused("Handle '" + handles[i].name + "' is among its own parents' parents.");
  }
  for (const HandlePlace& p : places)
    if (!p.position.allFinite()) return refused("A handle's position is not finite.");
  const auto cage = [&](const auto& corners) {
    std::set<int> different;
    for (const int c : corners) {
      if (!points.contains(c)) return false;
      different.insert(c);
    }
    return different.size() == corners.size();
  };
  for (const auto& e : cage_edges)
    if (!cage(e)) return refused("The edges of a cage join two different point handles.");
  for (const auto& f : cage_faces)
    if (!cage(f)) return refused("The faces of a cage join three different point handles.");
  return success();
}

Status WeightOptions::validate() const { return success(); }

Result<std::vector<AffineMatrix>> pose_transforms(const Handles& handles, const VertexMatrix& V,
                                                  const std::vector<HandlePose>& poses) {
  if (poses.size() != handles.handles.size())
    return refused("There are " + std::to_string(poses.size()) + " poses for " +
                   std::to_string(handles.handles.size()) + " handles.");
  const std::size_t n = poses.size();
  std::vector<AffineMatrix> own(n);
  for (std::size_t h = 0; h < n; ++h) {
    const Handle& handle = handles.handles[h];
    const HandlePose& pose = poses[h];
    if (pose.matrix) {
      own[h] = *pose.matrix;
    } else {
      const HandlePlace& place = handles.places[static_cast<std::size_t>(handle.place)];
      if (place.vertex && (*place.vertex < 0 || *place.vertex >= V.rows()))
        return refused("Handle '" + handle.name + "' is at vertex " + std::to_string(*place.vertex) +
                       " (counted from 0), which does not exist.");
      const Eigen::Vector3d head = place.vertex ? Eigen::Vector3d(V.row(*place.vertex)) : place.position;
      const double length = pose.rotation.norm();
      if (!(length > 0 && std::isfinite(length)))
        return refused("The rotation of handle '" + handle.name + "' is none.");
      const Eigen::Matrix3d R = Eigen::Quaterniond(pose.rotation.coeffs() / length).toRotationMatrix();
      own[h].leftCols<3>() = R;
      // Written so that the identity stays one.
      own[h].col(3) = (head - R * head) + pose.translation;
    }
    if (!own[h].allFinite()) return refused("The motion of handle '" + handle.name + "' is not finite.");
  }
  std::vector<AffineMatrix> all(n);
  for (std::size_t h = 0; h < n; ++h) {
    AffineMatrix m = own[h];
    for (int p = handles.handles[h].parent; p >= 0; p = handles.handles[static_cast<std::size_t>(p)].parent) {
      const AffineMatrix& up = own[static_cast<std::size_t>(p)];
      const Eigen::Vector3d t = up.leftCols<3>() * m.col(3) + up.col(3);
      m.leftCols<3>() = (up.leftCols<3>() * m.leftCols<3>()).eval();
      m.col(3) = t;
    }
    all[h] = m;
  }
  return all;
}

}  // namespace overtet
