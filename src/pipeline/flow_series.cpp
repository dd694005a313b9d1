#include "src/pipeline/flow_series.h"

#include <filesystem>
#include <system_error>

#include "overtet/io.h"

namespace overtet {

namespace {

std::string numbered(const std::string& name, std::size_t frame) {
  const std::string digits = std::to_string(frame);
  return name + "_" + std::string(digits.size() < 4 ? 4 - digits.size() : 0, '0') + digits + ".vtp";
}

}  // namespace

Result<FlowSeries> FlowSeries::create(const std::string& folder, UnitBox box) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed)
    return Error{ErrorCode::io, "Cannot create the folder " + folder + ": " + failed.message() + "."};
  FlowSeries series;
  series.folder_ = folder;
  series.box_ = box;
  return series;
}

std::string FlowSeries::name() const { return flow_ < 2 ? "flow" : "flow_" + std::to_string(flow_); }

void FlowSeries::begin() {
  ++flow_;
  frames_ = 0;
}

Status FlowSeries::add(VertexMatrix V, const TriangleMatrix& F) {
  out_of_unit_box(V, box_);
  return write_surface(folder_ + "/" + numbered(name(), frames_++), {std::move(V), F}, SurfaceFormat::vtp);
}

Status FlowSeries::write_list() const {
  std::vector<FileAtTime> files;
  for (std::size_t i = 0; i < frames_; ++i) files.push_back({static_cast<double>(i), numbered(name(), i)});
  return write_collection(folder_ + "/" + name() + ".pvd", files);
}

}  // namespace overtet
