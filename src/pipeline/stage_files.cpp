#include "src/pipeline/stage_files.h"

#include <algorithm>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "overtet/io.h"
#include "overtet/report.h"
#include "overtet/version.h"
#include "src/io/file.h"
#include "src/io/text.h"
#include "src/pipeline/result_hash.h"

namespace overtet {

namespace {

using Json = nlohmann::ordered_json;

std::string index_of(const std::string& folder) { return folder + "/stages.json"; }

}  // namespace

Result<StageFiles> StageFiles::create(const std::string& folder, const std::string& input_hash, UnitBox box) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed)
    return Error{ErrorCode::io, "Cannot create the folder " + folder + ": " + failed.message() + "."};
  // States of the same input that are there already stay known.
  if (Result<StageFiles> known = open(folder, input_hash, box)) return known;
  StageFiles files;
  files.folder_ = folder;
  files.input_hash_ = input_hash;
  files.box_ = box;
  return files;
}

Result<StageFiles> StageFiles::open(const std::string& folder, const std::string& input_hash, UnitBox box) {
  Result<std::string> text = read_file(index_of(folder));
  if (!text)
    return Error{ErrorCode::io, "There is nothing to resume from in " + folder + ": " + text.error().message};
  StageFiles files;
  files.folder_ = folder;
  files.input_hash_ = input_hash;
  files.box_ = box;
  const Json j = Json::parse(text.value(), nullptr, false);
  if (!j.is_object() || !j.contains("input_hash") || !j["input_hash"].is_string() || !j.contains("version") ||
      !j["version"].is_string() || !j.contains("stages") || !j["stages"].is_array())
    return Error{ErrorCode::bad_input, index_of(folder) + " is not a record of saved stages."};
  if (j["version"].get<std::string>() != version())
    return Error{ErrorCode::bad_input, "The stages in " + folder + " come from Overtet " +
                                           overtet::quoted(j["version"].get<std::string>()) + "; this is " +
                                           version() + "."};
  if (j["input_hash"].get<std::string>() != input_hash)
    return Error{ErrorCode::bad_input, "The stages in " + folder + " belong to another input."};
  for (const Json& name : j["stages"])
    if (name.is_string()) files.names_.push_back(name.get<std::string>());
  if (j.contains("placed") && j["placed"].is_number_integer()) files.placed_ = j["placed"].get<Index>();
  return files;
}

Status StageFiles::remember(const std::string& name) {
  if (!has(name)) names_.push_back(name);
  AtomicFile file;
  if (Status s = file.open(index_of(folder_)); !s) return s;
  const Json j = {
      {"version", version()}, {"input_hash", input_hash_}, {"stages", names_}, {"placed", placed_}};
  if (Status s = file.write(j.dump(2) + "\n"); !s) return s;
  return file.commit();
}

Status StageFiles::save(const std::string& name, Surface surface) {
  out_of_unit_box(surface.V, box_);
  if (Status s = write_surface(folder_ + "/" + name + ".ply", surface, SurfaceFormat::ply); !s) return s;
  return remember(name);
}

Status StageFiles::save(const std::string& name, TetMesh mesh) {
  out_of_unit_box(mesh.V, box_);
  if (Status s = write_tets(folder_ + "/" + name + ".vtu", mesh, TetFormat::vtu); !s) return s;
  return remember(name);
}

Status StageFiles::save(const std::string& name, const Draft& draft) {
  placed_ = draft.placed;
  return save(name, draft.mesh);
}

Status StageFiles::save_problem(const std::string& name, Surface surface, const TetMesh& mesh) const {
  out_of_unit_box(surface.V, box_);
  const std::string folder = folder_ + "/" + name;
  Result<StageFiles> files = create(folder, hash_of(surface), box_);
  if (!files) return files.error();
  StageFiles& f = files.value();
  if (Status s = write_surface(folder + "/input.ply", surface, SurfaceFormat::ply); !s) return s;
  if (Status s = f.save("embedded", Surface{mesh.V.topRows(surface.V.rows()), surface.F}); !s) return s;
  return f.save("tet_mesh", mesh);
}

bool StageFiles::has(const std::string& name) const {
  return std::find(names_.begin(), names_.end(), name) != names_.end();
}

Result<Surface> StageFiles::load_surface(const std::string& name) const {
  Result<Surface> s = read_surface(folder_ + "/" + name + ".ply");
  if (s.ok()) back_into_unit_box(s.value().V, box_);
  return s;
}

Result<TetMesh> StageFiles::load_mesh(const std::string& name, Index surface_vertices) const {
  Result<TetMesh> m = read_tets(folder_ + "/" + name + ".vtu");
  if (m.ok()) {
    back_into_unit_box(m.value().V, box_);
    m.value().surface_vertices = surface_vertices;
  }
  return m;
}

Result<Draft> StageFiles::load_draft(const std::string& name, Index surface_vertices) const {
  Result<TetMesh> mesh = load_mesh(name, surface_vertices);
  if (!mesh) return mesh.error();
  const Index inside = static_cast<Index>(mesh.value().V.rows()) - surface_vertices;
  return Draft{std::move(mesh).value(), std::clamp<Index>(placed_, 0, std::max<Index>(inside, 0))};
}

}  // namespace overtet
