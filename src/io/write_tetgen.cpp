#include "src/io/tet_view.h"

namespace overtet::io_detail {

void write_node(TextWriter& out, const TetView& m) {
  const std::vector<Index>& input = m.attributes.input_vertex;
  out.number(m.vertices()).text(m.triangles() > 0 ? " 3 0 1\n" : " 3 0 0\n");
  out.lines(m.vertices(), [&](TextBuffer& line, std::int64_t v) {
    m.coordinates(line.number(v).character(' '), v);
    if (m.triangles() > 0) {
      const bool outer = v < m.mesh.V.rows() && !input.empty() && input[static_cast<std::size_t>(v)] >= 0;
      line.text(outer ? " 1" : " 0");
    }
    line.end_line();
  });
}

// TetGen has its own order of the vertices in the middle of edges.
void write_ele(TextWriter& out, const TetView& m) {
  const bool regions = !m.attributes.regions.of.empty();
  out.number(m.tets()).text(m.second_order() ? " 10 " : " 4 ").text(regions ? "1\n" : "0\n");
  out.lines(m.tets(), [&](TextBuffer& line, std::int64_t t) {
    m.tet(line.number(t).character(' '), t, 0, {5, 3, 0, 1, 4, 2});
    if (regions) line.character(' ').number(m.region(t));
    line.end_line();
  });
}

void write_face(TextWriter& out, const TetView& m) {
  out.number(m.triangles()).text(" 1\n");
  out.lines(m.triangles(), [&](TextBuffer& line, std::int64_t f) {
    line.number(f);
    for (int k = 0; k < 3; ++k) line.character(' ').number(m.triangle(f, k));
    line.character(' ').number(m.label(f)).end_line();
  });
}

}  // namespace overtet::io_detail
