// Intermediate states in a folder, for looking at (ParaView, MeshLab) and for continuing from.
//
// stages.json names the input by the hash of its vertices and faces; states of another input, or of another
// version of Overtet, are refused. Coordinates are those of the input's space, exactly.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "overtet/result.h"
#include "overtet/types.h"
#include "src/pipeline/draft.h"
#include "src/pipeline/unit_box.h"

namespace overtet {

class StageFiles {
 public:
  // Creates the folder if it is not there. States that it holds of another input are forgotten.
  static Result<StageFiles> create(const std::string& folder, const std::string& input_hash, UnitBox box);
  // Errors: bad_input when the folder belongs to another input or version.
  static Result<StageFiles> open(const std::string& folder, const std::string& input_hash, UnitBox box);

  // name: without extension. Geometry in the unit box; written as NAME.ply, NAME.vtu. Remembered in
  // stages.json, which is written anew each time.
  Status save(const std::string& name, Surface surface);
  Status save(const std::string& name, TetMesh mesh);
  Status save(const std::string& name, const Draft& draft);  // of one draft at most

  // A problem of its own in the folder NAME, to be resumed there: the surface as NAME/input.ply, and the last
  // states of a flow that ends at it, `mesh` with the surface's vertices first.
  Status save_problem(const std::string& name, Surface surface, const TetMesh& mesh) const;

  bool has(const std::string& name) const;
  Result<Surface> load_surface(const std::string& name) const;
  Result<TetMesh> load_mesh(const std::string& name, Index surface_vertices) const;
  Result<Draft> load_draft(const std::string& name, Index surface_vertices) const;

 private:
  Status remember(const std::string& name);

  std::string folder_, input_hash_;
  UnitBox box_;
  std::vector<std::string> names_;
  Index placed_ = 0;  // Draft
};

}  // namespace overtet
