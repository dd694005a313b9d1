// consumer SURFACE TETMESH [HELPER]: meshes a surface. Built against an installed Overtet only.
#include <overtet/overtet.h>

#include <cstdio>

int main(int argc, char** argv) {
  if (argc < 3) return 2;
  overtet::RunContext context;  // all cores, no limits
  if (argc > 3) context.tetgen_helper = argv[3];
  const auto surface = overtet::read_surface(argv[1], nullptr, context);
  if (!surface) {
    std::puts(surface.error().message.c_str());
    return 1;
  }
  const auto made = overtet::tetrahedralize(surface.value(), {}, context);
  if (!made) {
    const overtet::Error& error = made.error();
    std::puts(error.message.c_str());
    if (error.certificate) std::puts(overtet::to_json(*error.certificate).c_str());
    return static_cast<int>(error.code);
  }
  const overtet::Meshing& m = made.value();
  std::printf("%d vertices, %d tets, smallest dihedral angle %.2f degrees\n", int(m.mesh.V.rows()),
              int(m.mesh.T.rows()), m.quality.dihedral_min);
  // The surface's triangles and the regions, beside the tets.
  const auto attributes = overtet::mesh_attributes(surface.value(), {}, m.mesh, {}, context);
  if (!attributes) return 1;
  const auto written = overtet::write_tets(argv[2], m.mesh, attributes.value(), {}, context);
  if (!written) std::puts(written.error().message.c_str());
  return written ? 0 : 1;
}
