#include "overtet/cleanup.h"
#include "src/io/polylines_io.h"

namespace overtet {

namespace {

// The vertices along which a place is drawn.
std::vector<Index> outline(const Surface& s, const Defect& d, const DefectPlace& p) {
  std::vector<Index> line = p.vertices;
  const bool closed = d.kind == DefectKind::hole && static_cast<std::int64_t>(line.size()) == p.edges;
  if (closed) line.push_back(line[0]);
  if (line.size() > 1 && d.kind != DefectKind::unmerged_vertex) return line;
  if (!p.faces.empty()) {
    line.clear();
    for (const int k : {0, 1, 2, 0}) line.push_back(s.F(p.faces[0], k));
  }
  if (line.size() == 1) line.push_back(line[0]);
  return line;
}

}  // namespace

Status write_defects(const std::string& path, const Surface& surface, const std::vector<Defect>& defects,
                     CurveFormat format) {
  Polylines out;
  out.segment_data = {{"kind", {}, 1, true}, {"place", {}, 1, true}};
  for (const Defect& d : defects)
    for (std::size_t i = 0; i < d.places.size(); ++i) {
      Polylines::Line line;
      line.name = std::string(name_of(d.kind)) + "_" + std::to_string(i);
      for (const Index v : outline(surface, d, d.places[i])) {
        if (!line.points.empty()) {
          out.segment_data[0].values.push_back(static_cast<double>(d.kind));
          out.segment_data[1].values.push_back(static_cast<double>(i));
        }
        line.points.push_back(static_cast<Index>(out.points.size()));
        out.points.push_back({surface.V(v, 0), surface.V(v, 1), surface.V(v, 2)});
      }
      if (line.points.size() > 1) out.lines.push_back(std::move(line));
    }
  return write_polylines(path, out, format);
}

}  // namespace overtet
