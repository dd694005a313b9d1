#include <utility>

#include "src/io/mesh_parts.h"
#include "tests/fuzz/checks.h"
#include "tests/fuzz/targets.h"

namespace overtet::fuzz {

namespace {

void both(const std::string& path, std::string_view bytes) {
  check_as_mesh(path, bytes);
  check_as_surface("/no/such/folder/" + path, bytes);
}

}  // namespace

void medit(std::string_view bytes) { both("x.mesh", bytes); }
void gmsh(std::string_view bytes) { both("x.msh", bytes); }
void vtk_xml(std::string_view bytes) { both("x.vtu", bytes); }
void vtk(std::string_view bytes) { both("x.vtk", bytes); }
void abaqus(std::string_view bytes) { check_as_mesh("x.inp", bytes); }

void tetgen(std::string_view bytes) {
  using namespace io_detail;
  const std::vector<std::string_view> files = parts_of(bytes, 3);
  const MemoryUse memory;
  MeshParts parts;
  std::int64_t first = 0;
  Status s = parse_tetgen_nodes("x.node", files[0], parts, first);
  if (s) s = parse_tetgen_tets("x.ele", files[1], parts, first);
  if (s && !files[2].empty()) s = parse_tetgen_faces("x.face", files[2], parts, first);
  const Result<LabelledTetMesh> mesh =
      s ? tet_mesh_of("x.node", std::move(parts)) : Result<LabelledTetMesh>(s.error());
  memory.check(bytes.size());
  if (!mesh) return check_error(mesh.error());
  check_mesh(mesh.value());
  check_round_trip(mesh.value(), mixed(bytes));
}

}  // namespace overtet::fuzz
