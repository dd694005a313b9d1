#include "src/cleanup/messages.h"

#include <algorithm>
#include <cstdio>

namespace overtet {

namespace {

std::string number_text(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

std::string position_text(const Surface& s, Index v) {
  return "(" + number_text(s.V(v, 0)) + ", " + number_text(s.V(v, 1)) + ", " + number_text(s.V(v, 2)) + ")";
}

// Names of one place's vertices and faces.
class Names {
 public:
  Names(const DefectPlace& place, const Surface& surface, const SurfaceSource& source)
      : place_(place), surface_(surface), source_(source) {}

  std::string vertex(std::size_t i) const { return source_.vertex_name(place_.vertices[i]); }
  std::string face(std::size_t i) const { return source_.face_name(place_.faces[i]); }
  std::string faces() const {
    std::string text;
    for (std::size_t i = 0; i < place_.faces.size() && i < 3; ++i) text += (i > 0 ? ", " : "") + face(i);
    return text + (place_.faces.size() > 3 ? ", ..." : "");
  }
  std::string edge() const {
    return "edge from " + vertex(0) + " to " + vertex(1) + ", " +
           position_text(surface_, place_.vertices[0]) + " to " + position_text(surface_, place_.vertices[1]);
  }
  // The first vertices: "vertices 1, 5, 7, ... (lines 3, 7, 9)".
  std::string around() const {
    std::string text = "vertices ", lines;
    const std::size_t n = std::min<std::size_t>(place_.vertices.size(), 3);
    for (std::size_t i = 0; i < n; ++i) {
      const Index v = source_.vertex_in_file(place_.vertices[i]);
      text += (i > 0 ? ", " : "") + std::to_string(std::int64_t{v} + source_.first);
      if (static_cast<std::size_t>(v) < source_.vertex_line.size())
        lines += (i > 0 ? ", " : "") + std::to_string(source_.vertex_line[static_cast<std::size_t>(v)]);
    }
    if (place_.edges > 3) text += ", ...";
    return lines.empty() ? text : text + " (lines " + lines + ")";
  }
  std::string at(std::size_t i) const { return position_text(surface_, place_.vertices[i]); }

 private:
  const DefectPlace& place_;
  const Surface& surface_;
  const SurfaceSource& source_;
};

std::string more(std::int64_t count, const char* one, const char* many) {
  if (count < 2) return {};
  return "; there " + std::string(count == 2 ? "is " : "are ") + std::to_string(count - 1) + " more such " +
         (count == 2 ? one : many);
}

}  // namespace

std::string explain(const Defect& d, const Surface& s, const SurfaceSource& source) {
  if (d.places.empty()) return {};
  const DefectPlace& p = d.places[0];
  const Names n(p, s, source);
  switch (d.kind) {
    case DefectKind::repeated_corner:
      return "Two corners of " + n.face(0) + " are the same" + more(d.count, "face", "faces") + ".";
    case DefectKind::repeated_face:
      return "The same three corners are there twice: " + n.faces() + more(d.count, "face", "faces") + ".";
    case DefectKind::unmerged_vertex:
      return "The surface is open where " + n.vertex(0) + " lies in the same place as " + n.vertex(1) + ", " +
             n.at(0) + ", but is another one" + more(d.count, "vertex", "vertices") + ".";
    case DefectKind::crowded_edge:
      return "The " + n.edge() + ", is shared by " + std::to_string(p.faces.size()) + " faces (" + n.faces() +
             "); it must be shared by two" + more(d.count, "edge", "edges") + ".";
    case DefectKind::pinched_vertex:
      return "At " + n.vertex(0) + ", " + n.at(0) + ", parts of the surface meet only in this vertex" +
             more(d.count, "vertex", "vertices") + ".";
    case DefectKind::unused_vertex:
      return "No face uses " + n.vertex(0) + more(d.count, "vertex", "vertices") + ".";
    case DefectKind::turned_face:
      return "The faces are not oriented alike: " + n.face(0) + " runs against its neighbours" +
             more(d.count, "face", "faces") + ".";
    case DefectKind::inward_component:
      return "The component of " + n.face(0) + " faces inwards and is no cavity" +
             more(d.count, "component", "components") + ".";
    case DefectKind::hole:
      return "The surface has a hole of " + std::to_string(p.edges) + (p.edges == 1 ? " edge" : " edges") +
             ", " + number_text(p.length) + " long, along " + n.around() + ", from " + n.at(0) +
             " on, beside " + n.face(0) + "; it must be closed" +
             more(d.count, "hole, no larger", "holes, none of them larger") + ".";
    case DefectKind::odd_edge:
      return "The " + n.edge() + ", is shared by " + std::to_string(p.edges) + " faces (" + n.faces() +
             "); it must be shared by two" + more(d.count, "edge", "edges") + ".";
    case DefectKind::unpaired_edge:
      return "The " + n.edge() + ", is shared by " + std::to_string(p.edges) + " faces (" + n.faces() +
             ") that cannot be told apart in pairs: they are not oriented alike, have no area, or hang "
             "together "
             "around both ends; it must be shared by two" +
             more(d.count, "edge", "edges") + ".";
    case DefectKind::one_sided:
      return "The surface is one-sided: its faces cannot be oriented so that " + n.faces() +
             ", and all others, run along their edges in opposite directions" +
             more(d.count, "component", "components") + ".";
    case DefectKind::malformed:
      break;
  }
  return "The surface has no faces, a coordinate that is not finite, or a face of a vertex that does not "
         "exist.";
}

}  // namespace overtet
