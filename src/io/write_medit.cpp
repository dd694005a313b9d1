#include "src/io/tet_view.h"

namespace overtet::io_detail {

void write_medit(TextWriter& out, const TetView& m) {
  const bool second = m.second_order();
  out.text("MeshVersionFormatted 2\nDimension 3\nVertices\n").number(m.vertices()).end_line();
  out.lines(m.vertices(), [&](TextBuffer& line, std::int64_t v) { m.coordinates(line, v).text(" 0\n"); });
  if (m.triangles() > 0) {
    out.text(second ? "TrianglesP2\n" : "Triangles\n").number(m.triangles()).end_line();
    out.lines(m.triangles(), [&](TextBuffer& line, std::int64_t f) {
      m.triangle(line, f, 1).character(' ').number(m.label(f)).end_line();
    });
  }
  out.text(second ? "TetrahedraP2\n" : "Tetrahedra\n").number(m.tets()).end_line();
  out.lines(m.tets(), [&](TextBuffer& line, std::int64_t t) {
    m.tet(line, t, 1).character(' ').number(m.region(t)).end_line();
  });
  out.text("End\n");
}

}  // namespace overtet::io_detail
