#include "tests/fuzz/checks.h"

#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <limits>

#include "src/io/mesh_parts.h"
#include "src/io/surface_parts.h"
#include "src/io/tet_view.h"

#if defined(__SANITIZE_ADDRESS__)
#define OVERTET_COUNTS_MEMORY 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer)
#define OVERTET_COUNTS_MEMORY 1
#endif
#endif
#ifdef OVERTET_COUNTS_MEMORY
extern "C" {
int __sanitizer_install_malloc_and_free_hooks(void (*)(const volatile void*, std::size_t),
                                              void (*)(const volatile void*));
std::size_t __sanitizer_get_allocated_size(const volatile void*);
}
#endif

namespace overtet::fuzz {

namespace {

std::atomic<std::int64_t> in_use{0}, most_in_use{0};

void count_allocation(const volatile void*, std::size_t size) {
  const std::int64_t now = in_use += static_cast<std::int64_t>(size);
  if (now > most_in_use) most_in_use = now;
}

#ifdef OVERTET_COUNTS_MEMORY
void count_release(const volatile void* p) {
  if (p) in_use -= static_cast<std::int64_t>(__sanitizer_get_allocated_size(p));
}
#endif

template <class Matrix>
bool same_bits(const Matrix& a, const Matrix& b) {
  return a.rows() == b.rows() && a.cols() == b.cols() &&
         (a.size() == 0 ||
          std::memcmp(a.data(), b.data(), sizeof(*a.data()) * static_cast<std::size_t>(a.size())) == 0);
}

template <class Matrix>
bool in_range(const Matrix& indices, Eigen::Index vertices) {
  return indices.size() == 0 || (indices.minCoeff() >= 0 && indices.maxCoeff() < vertices);
}

void check_list(std::size_t size, Eigen::Index items, bool may_be_empty, const char* what) {
  if (size != static_cast<std::size_t>(items) && !(may_be_empty && size == 0))
    fail(std::string(what) + ": " + std::to_string(size) + " for " + std::to_string(items));
}

void check_data(const std::vector<Attribute>& list, Eigen::Index items, const char* what) {
  for (const Attribute& a : list) {
    require(a.width >= 1, "data without a width", a.name);
    check_list(a.values.size(), items * a.width, false, what);
    check_line(a.name, what);
  }
}

void check_names(const Labels& labels, const char* what) {
  for (const auto& [label, name] : labels.names) check_line(name, what);
}

// The mesh in a format, as the bytes of its files.
struct Written {
  std::vector<std::string> files;
};
Written written(const LabelledTetMesh& mesh, TetFormat format) {
  using namespace io_detail;
  const TetView view(mesh.mesh, mesh.attributes, 1);
  std::vector<void (*)(TextWriter&, const TetView&)> parts;
  switch (format) {
    case TetFormat::medit:
      parts = {write_medit};
      break;
    case TetFormat::gmsh22:
      parts = {write_gmsh22};
      break;
    case TetFormat::gmsh41:
      parts = {write_gmsh41};
      break;
    case TetFormat::vtu:
      parts = {write_vtu};
      break;
    case TetFormat::vtk:
      parts = {write_vtk};
      break;
    case TetFormat::abaqus:
      parts = {write_abaqus};
      break;
    case TetFormat::tetgen:
      parts = {write_node, write_ele, write_face};
      break;
  }
  Written out;
  for (const auto& write : parts) {
    TextWriter writer(out.files.emplace_back());
    write(writer, view);
    require(writer.finish().ok(), "writing to memory failed");
  }
  return out;
}

Result<LabelledTetMesh> read_back(const Written& w, TetFormat format) {
  using namespace io_detail;
  if (format != TetFormat::tetgen) return parse_tets("again", format, w.files[0]);
  MeshParts parts;
  std::int64_t first = 0;
  Status s = parse_tetgen_nodes("again.node", w.files[0], parts, first);
  if (s) s = parse_tetgen_tets("again.ele", w.files[1], parts, first);
  if (s) s = parse_tetgen_faces("again.face", w.files[2], parts, first);
  return s ? tet_mesh_of("again", std::move(parts)) : Result<LabelledTetMesh>(s.error());
}

}  // namespace

void fail(const std::string& what) {
  std::fprintf(stderr, "What must hold does not: %s\n", what.c_str());
  std::abort();
}

void check_line(std::string_view text, const char* what) {
  for (const char c : text)
    if (static_cast<unsigned char>(c) < ' ' || c == 127)
      fail(std::string(what) + " has a control character: " + std::string(text));
}

void check_error(const Error& e) {
  check_line(e.message, "an error");
  require(e.message.size() > 2 && e.message.back() == '.' && e.message[e.message.size() - 2] != '.',
          "an error is no sentence", e.message);
  require(e.message.size() < 600, "an error is too long", e.message);
  require(e.code == ErrorCode::bad_input || e.code == ErrorCode::usage || e.code == ErrorCode::io,
          "an error has an odd code", e.message);
}

void check_surface(const Surface& s, const SurfaceReadInfo& info) {
  require(s.V.rows() > 0 && s.F.rows() > 0, "a surface without vertices or faces");
  require(s.V.array().isFinite().all(), "a coordinate is not finite");
  require(in_range(s.F, s.V.rows()), "a face has a vertex that is not there");
  const SurfaceAttributes& a = info.attributes;
  check_list(a.faces.of.size(), s.F.rows(), true, "labels of faces");
  check_list(a.solids.of.size(), s.F.rows(), true, "solids of faces");
  check_list(a.input_vertex.size(), s.V.rows(), true, "input_vertex");
  check_list(info.source.vertex.size(), s.V.rows(), true, "source of vertices");
  check_list(info.source.face.size(), s.F.rows(), true, "source of faces");
  check_data(a.vertex_data, s.V.rows(), "data of vertices");
  check_data(a.face_data, s.F.rows(), "data of faces");
  check_names(a.faces, "the name of a label");
  check_names(a.solids, "the name of a solid");
  check_line(info.format, "the format");
  for (const std::string& note : info.notes) check_line(note, "a note");
  check_line(info.source.vertex_name(static_cast<Index>(s.V.rows() - 1)), "a name of a vertex");
  check_line(info.source.face_name(static_cast<Index>(s.F.rows() - 1)), "a name of a face");
}

void check_mesh(const LabelledTetMesh& m) {
  const TetMesh& mesh = m.mesh;
  const MeshAttributes& a = m.attributes;
  require(mesh.V.rows() > 0 && mesh.T.rows() > 0, "a mesh without vertices or tets");
  require(mesh.V.array().isFinite().all(), "a coordinate is not finite");
  require(in_range(mesh.T, mesh.V.rows()), "a tet has a vertex that is not there");
  require(in_range(a.triangles, mesh.V.rows()), "a triangle has a vertex that is not there");
  check_list(a.labels.of.size(), a.triangles.rows(), false, "labels");
  check_list(a.input_face.size(), a.triangles.rows(), true, "input_face");
  check_list(a.regions.of.size(), mesh.T.rows(), true, "regions");
  check_list(a.layers.size(), mesh.T.rows(), true, "layers");
  check_list(a.input_vertex.size(), mesh.V.rows(), true, "input_vertex");
  check_data(a.vertex_data, mesh.V.rows(), "data of vertices");
  check_data(a.triangle_data, a.triangles.rows(), "data of triangles");
  check_names(a.labels, "the name of a label");
  check_names(a.regions, "the name of a region");
}

void check_round_trip(const Surface& s, const Labels& labels, std::uint64_t choice) {
  static constexpr struct {
    SurfaceFormat format;
    const char* path;
  } formats[] = {{SurfaceFormat::off, "again.off"},
                 {SurfaceFormat::obj, "again.obj"},
                 {SurfaceFormat::ply, "again.ply"},
                 {SurfaceFormat::vtp, "again.vtp"}};
  const auto& [format, path] = formats[choice % std::size(formats)];
  std::string bytes;
  TextWriter out(bytes);
  io_detail::print_surface(out, s, format, labels);
  require(out.finish().ok(), "writing to memory failed");
  SurfaceReadInfo info;
  const Result<Surface> again = io_detail::parse_surface(path, std::move(bytes), info);
  if (!again) fail(std::string(path) + " is not read back: " + again.error().message);
  require(same_bits(again.value().V, s.V), "other vertices were read back", path);
  require(same_bits(again.value().F, s.F), "other faces were read back", path);
  check_surface(again.value(), info);
  const std::vector<Index>& of = info.attributes.faces.of;
  if (labels.of.empty()) return;
  if (format != SurfaceFormat::obj) return require(of == labels.of, "other labels were read back", path);
  require(of.size() == labels.of.size(), "again.obj has other labels");
}

void check_round_trip(const LabelledTetMesh& mesh, std::uint64_t choice) {
  static constexpr TetFormat formats[] = {TetFormat::medit, TetFormat::gmsh22, TetFormat::gmsh41,
                                          TetFormat::vtu,   TetFormat::tetgen, TetFormat::abaqus,
                                          TetFormat::vtk};
  const TetFormat format = formats[choice % std::size(formats)];
  const std::string_view name = name_of(format);
  const Result<LabelledTetMesh> read = read_back(written(mesh, format), format);
  if (!read) fail(std::string(name) + " is not read back: " + read.error().message);
  const LabelledTetMesh& again = read.value();
  check_mesh(again);
  require(same_bits(again.mesh.V, mesh.mesh.V), "other vertices were read back", name);
  require(same_bits(again.mesh.T, mesh.mesh.T), "other tets were read back", name);
  if (!mesh.attributes.regions.of.empty())
    require(again.attributes.regions.of == mesh.attributes.regions.of, "other regions were read back", name);
  if (format == TetFormat::abaqus) return;  // which has only triangles that are faces of tets, each once
  require(same_bits(again.attributes.triangles, mesh.attributes.triangles), "other triangles were read back",
          name);
  require(again.attributes.labels.of == mesh.attributes.labels.of, "other labels were read back", name);
}

void check_as_surface(const std::string& path, std::string_view bytes) {
  const MemoryUse memory;
  SurfaceReadInfo info;
  const Result<Surface> surface = io_detail::parse_surface(path, std::string(bytes), info);
  memory.check(bytes.size());
  if (!surface) return check_error(surface.error());
  check_surface(surface.value(), info);
  check_round_trip(surface.value(), info.attributes.faces, mixed(bytes));
}

void check_as_mesh(const std::string& path, std::string_view bytes) {
  const MemoryUse memory;
  const Result<TetFormat> format = tet_format_of(path);
  const Result<LabelledTetMesh> mesh =
      io_detail::parse_tets(path, format ? std::optional(format.value()) : std::nullopt, bytes);
  memory.check(bytes.size());
  if (!mesh) return check_error(mesh.error());
  check_mesh(mesh.value());
  check_round_trip(mesh.value(), mixed(bytes));
}

std::uint64_t mixed(std::string_view bytes) {
  std::uint64_t h = 0xCBF29CE484222325ull;
  for (const char c : bytes) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001B3ull;
  return h ^ h >> 29;
}

std::vector<std::string_view> parts_of(std::string_view bytes, std::size_t count) {
  constexpr std::string_view mark = "%\n";
  std::vector<std::string_view> parts;
  while (parts.size() + 1 < count) {
    const std::size_t at = bytes.find(mark);
    parts.push_back(bytes.substr(0, at));
    bytes = at == std::string_view::npos ? std::string_view() : bytes.substr(at + mark.size());
  }
  parts.push_back(bytes);
  return parts;
}

MemoryUse::MemoryUse() {
#ifdef OVERTET_COUNTS_MEMORY
  [[maybe_unused]] static const int installed =
      __sanitizer_install_malloc_and_free_hooks(count_allocation, count_release);
#endif
  in_use = most_in_use = 0;
}

void MemoryUse::check(std::size_t file_size, std::size_t each) const {
  const auto most = static_cast<std::int64_t>((std::size_t{4} << 20) + each * file_size);
  if (most_in_use > most)
    fail("a file of " + std::to_string(file_size) + " bytes takes " + std::to_string(most_in_use.load()) +
         " bytes of memory");
}

}  // namespace overtet::fuzz
