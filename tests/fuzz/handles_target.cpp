#include <string>
#include <vector>

#include "overtet/weights.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/targets.h"

namespace overtet::fuzz {

void handles(std::string_view bytes) {
  const std::vector<std::string_view> parts = parts_of(bytes, 3);
  const std::string_view given = parts[0], pose = parts[1], rest = parts[2];
  for (const char* name : {"handles.json", "handles.tgf"}) {
    const Result<Handles> read = parse_handles(name, given);
    if (!read) {
      check_error(read.error());
      continue;
    }
    const Handles& h = read.value();
    require(h.validate().ok(), "handles that are not valid were read");
    require(h.handles.size() <= bytes.size(), "there are more handles than the file has room for");
    const Result<std::vector<HandlePose>> moved = parse_pose("pose.json", pose, h);
    if (moved) {
      const auto transforms = pose_transforms(h, VertexMatrix::Zero(4, 3), moved.value());
      if (!transforms) check_error(transforms.error());
    } else {
      check_error(moved.error());
    }
    const Result<Eigen::MatrixXd> weights = parse_weights_csv("weights.csv", rest, h);
    if (weights)
      require(weights.value().allFinite(), "weights that are not finite were read");
    else
      check_error(weights.error());
  }
}

}  // namespace overtet::fuzz
