#include <bit>
#include <cstring>

#include "overtet/io.h"
#include "src/io/filled_file.h"
#include "src/io/names.h"
#include "src/io/surface_parts.h"
#include "src/io/tet_view.h"
#include "src/io/text.h"

namespace overtet {

namespace {

// One line a row: the lead, then three numbers. (No shift for coordinates: adding 0 loses the sign of -0.)
template <class Number>
void row(TextWriter& out, std::string_view lead, Number a, Number b, Number c) {
  out.text(lead).number(a).character(' ').number(b).character(' ').number(c).end_line();
}

void vertices(TextWriter& out, std::string_view lead, const VertexMatrix& V) {
  for (Eigen::Index v = 0; v < V.rows(); ++v) row(out, lead, V(v, 0), V(v, 1), V(v, 2));
}

void write_off(TextWriter& out, const Surface& s, const Labels& labels) {
  out.text("OFF\n")
      .number(std::int64_t{s.V.rows()})
      .character(' ')
      .number(std::int64_t{s.F.rows()})
      .text(" 0\n");
  vertices(out, "", s.V);
  for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
    out.character('3');
    for (int k = 0; k < 3; ++k) out.character(' ').number(s.F(f, k));
    if (!labels.of.empty()) out.character(' ').number(labels.of[static_cast<std::size_t>(f)]);
    out.end_line();
  }
}

void write_obj(TextWriter& out, const Surface& s, const Labels& labels) {
  vertices(out, "v ", s.V);
  for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
    const auto i = static_cast<std::size_t>(f);
    if (!labels.of.empty() && (i == 0 || labels.of[i] != labels.of[i - 1])) {
      const auto name = labels.names.find(labels.of[i]);
      out.text("g ");
      if (name == labels.names.end())
        out.number(labels.of[i]).end_line();
      else
        out.text(one_line(name->second)).end_line();
    }
    row(out, "f ", s.F(f, 0) + 1, s.F(f, 1) + 1, s.F(f, 2) + 1);
  }
}

template <class T>
void append_little(std::string& bytes, T x) {
  char b[sizeof(T)];
  std::memcpy(b, &x, sizeof(T));
  if constexpr (std::endian::native == std::endian::big)
    for (std::size_t k = 0; k < sizeof(T) / 2; ++k) std::swap(b[k], b[sizeof(T) - 1 - k]);
  bytes.append(b, sizeof(T));
}

void write_ply(TextWriter& out, const Surface& s, const Labels& labels) {
  out.text("ply\nformat binary_little_endian 1.0\nelement vertex ").number(std::int64_t{s.V.rows()});
  out.text("\nproperty double x\nproperty double y\nproperty double z\nelement face ");
  out.number(std::int64_t{s.F.rows()}).text("\nproperty list uchar int vertex_indices\n");
  out.text(labels.of.empty() ? "end_header\n" : "property int label\nend_header\n");
  std::string row;
  for (Eigen::Index v = 0; v < s.V.rows(); ++v) {
    row.clear();
    for (int k = 0; k < 3; ++k) append_little(row, s.V(v, k));
    out.text(row);
  }
  for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
    row.assign(1, '\3');
    for (int k = 0; k < 3; ++k) append_little(row, s.F(f, k));
    if (!labels.of.empty()) append_little(row, labels.of[static_cast<std::size_t>(f)]);
    out.text(row);
  }
}

void write_vtp(TextWriter& out, const Surface& s, const Labels& labels) {
  TetMesh points;
  points.V = s.V;
  MeshAttributes triangles;
  triangles.triangles = s.F;
  triangles.labels = labels;
  io_detail::write_surface_vtp(out, io_detail::TetView(points, triangles, 1));
}

}  // namespace

void io_detail::print_surface(TextWriter& out, const Surface& surface, SurfaceFormat format,
                              const Labels& labels) {
  switch (format) {
    case SurfaceFormat::off:
      return write_off(out, surface, labels);
    case SurfaceFormat::obj:
      return write_obj(out, surface, labels);
    case SurfaceFormat::ply:
      return write_ply(out, surface, labels);
    case SurfaceFormat::vtp:
      return write_vtp(out, surface, labels);
  }
}

Result<SurfaceFormat> surface_format_of(const std::string& path) {
  const std::string extension = io_detail::parts_of_name(path).extension;
  if (extension == "off") return SurfaceFormat::off;
  if (extension == "obj") return SurfaceFormat::obj;
  if (extension == "ply") return SurfaceFormat::ply;
  if (extension == "vtp") return SurfaceFormat::vtp;
  return Error{ErrorCode::usage, "Surfaces are written as .off, .obj, .ply or .vtp, not as " + path + "."};
}

Status write_surface(const std::string& path, const Surface& surface, SurfaceFormat format,
                     const RunContext& context, const Labels* labels) {
  const Labels none;
  const Labels& l = labels ? *labels : none;
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  return io_detail::write_file(path, context,
                               [&](TextWriter& out) { io_detail::print_surface(out, surface, format, l); });
}

}  // namespace overtet
