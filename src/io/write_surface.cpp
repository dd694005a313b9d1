#include <bit>
#include <cstring>

#include "src/io/file.h"
#include "src/io/surface_io.h"

namespace overtet {

namespace {

void write_off(TextWriter& out, const Surface& s) {
  out.text("OFF\n")
      .number(std::int64_t{s.V.rows()})
      .character(' ')
      .number(std::int64_t{s.F.rows()})
      .text(" 0\n");
  for (Eigen::Index v = 0; v < s.V.rows(); ++v)
    out.number(s.V(v, 0)).character(' ').number(s.V(v, 1)).character(' ').number(s.V(v, 2)).end_line();
  for (Eigen::Index f = 0; f < s.F.rows(); ++f)
    out.text("3 ")
        .number(s.F(f, 0))
        .character(' ')
        .number(s.F(f, 1))
        .character(' ')
        .number(s.F(f, 2))
        .end_line();
}

void write_obj(TextWriter& out, const Surface& s) {
  for (Eigen::Index v = 0; v < s.V.rows(); ++v)
    out.text("v ")
        .number(s.V(v, 0))
        .character(' ')
        .number(s.V(v, 1))
        .character(' ')
        .number(s.V(v, 2))
        .end_line();
  for (Eigen::Index f = 0; f < s.F.rows(); ++f)
    out.text("f ")
        .number(s.F(f, 0) + 1)
        .character(' ')
        .number(s.F(f, 1) + 1)
        .character(' ')
        .number(s.F(f, 2) + 1)
        .end_line();
}

template <class T>
void append_little(std::string& bytes, T x) {
  char b[sizeof(T)];
  std::memcpy(b, &x, sizeof(T));
  if constexpr (std::endian::native == std::endian::big)
    for (std::size_t k = 0; k < sizeof(T) / 2; ++k) std::swap(b[k], b[sizeof(T) - 1 - k]);
  bytes.append(b, sizeof(T));
}

void write_ply(TextWriter& out, const Surface& s) {
  out.text("ply\nformat binary_little_endian 1.0\nelement vertex ").number(std::int64_t{s.V.rows()});
  out.text("\nproperty double x\nproperty double y\nproperty double z\nelement face ");
  out.number(std::int64_t{s.F.rows()}).text("\nproperty list uchar int vertex_indices\nend_header\n");
  std::string row;
  for (Eigen::Index v = 0; v < s.V.rows(); ++v) {
    row.clear();
    for (int k = 0; k < 3; ++k) append_little(row, s.V(v, k));
    out.text(row);
  }
  for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
    row.assign(1, '\3');
    for (int k = 0; k < 3; ++k) append_little(row, s.F(f, k));
    out.text(row);
  }
}

}  // namespace

Result<SurfaceFormat> surface_format_of(const std::string& path) {
  const auto ends = [&](std::string_view e) {
    return path.size() >= e.size() && std::string_view(path).substr(path.size() - e.size()) == e;
  };
  if (ends(".off")) return SurfaceFormat::off;
  if (ends(".obj")) return SurfaceFormat::obj;
  if (ends(".ply")) return SurfaceFormat::ply;
  return Error{ErrorCode::usage, "Surfaces are written as .off, .obj or .ply, not as " + path + "."};
}

Status write_surface(const std::string& path, const Surface& surface, SurfaceFormat format) {
  AtomicFile file;
  if (Status s = file.open(path); !s) return s;
  TextWriter out(file);
  switch (format) {
    case SurfaceFormat::off:
      write_off(out, surface);
      break;
    case SurfaceFormat::obj:
      write_obj(out, surface);
      break;
    case SurfaceFormat::ply:
      write_ply(out, surface);
      break;
  }
  if (Status s = out.finish(); !s) return s;
  return file.commit();
}

}  // namespace overtet
