// Where poses take handles.
#include <cmath>
#include <string>

#include "overtet/weights.h"

namespace overtet {

namespace {

Error refused(const std::string& what) { return {ErrorCode::usage, what}; }

}  // namespace

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
  // Parents first.
  std::vector<AffineMatrix> all = own;
  std::vector<char> done(n, 0);
  for (std::size_t h = 0; h < n; ++h) {
    std::vector<std::size_t> way;
    for (std::size_t i = h; !done[i];) {
      way.push_back(i);
      done[i] = 1;
      if (handles.handles[i].parent < 0) break;
      i = static_cast<std::size_t>(handles.handles[i].parent);
    }
    for (; !way.empty(); way.pop_back()) {
      const int parent = handles.handles[way.back()].parent;
      if (parent < 0) continue;
      const AffineMatrix &up = all[static_cast<std::size_t>(parent)], &m = own[way.back()];
      AffineMatrix& out = all[way.back()];
      out.leftCols<3>() = up.leftCols<3>() * m.leftCols<3>();
      out.col(3) = up.leftCols<3>() * m.col(3) + up.col(3);
    }
  }
  return all;
}

}  // namespace overtet
