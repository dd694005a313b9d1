#include "src/pipeline/flow_series.h"

#include <filesystem>
#include <system_error>

#include "overtet/io.h"
#include "src/io/file.h"

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
  AtomicFile file;
  if (Status s = file.open(folder_ + "/" + name() + ".pvd"); !s) return s;
  std::string text = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"0.1\">\n<Collection>\n";
  for (std::size_t i = 0; i < frames_; ++i)
    text += "<DataSet timestep=\"" + std::to_string(i) + "\" file=\"" + numbered(name(), i) + "\"/>\n";
  if (Status s = file.write(text + "</Collection>\n</VTKFile>\n"); !s) return s;
  return file.commit();
}

}  // namespace overtet
