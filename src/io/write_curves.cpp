#include "kernels/parallel/parallel.h"
#include "overtet/io.h"
#include "src/io/polylines_io.h"

namespace overtet {

namespace {

// One cell a segment: the two faces and the winding numbers change along a curve.
Polylines lines_of(const Curves& curves) {
  Polylines out;
  const auto field = [](std::vector<Polylines::Field>& into, const char* name, int components = 1,
                        bool whole = true) -> std::size_t {
    into.push_back({name, {}, components, whole});
    return into.size() - 1;
  };
  auto& on_segments = out.segment_data;
  auto& on_points = out.point_data;
  const auto number = field(on_segments, "curve"), closed = field(on_segments, "closed"),
             faces = field(on_segments, "faces", 2), crossing = field(on_segments, "crossing"),
             low = field(on_segments, "winding_min"), high = field(on_segments, "winding_max"),
             hinges = field(on_segments, "end_hinges", 2);
  const auto kind = field(on_points, "kind"), vertex = field(on_points, "vertex"),
             junction = field(on_points, "junction"), on = field(on_points, "on_faces", 2),
             first = field(on_points, "barycentric_0", 3, false),
             second = field(on_points, "barycentric_1", 3, false);
  const auto add = [](Polylines::Field& f, double x) { f.values.push_back(x); };
  for (std::size_t c = 0; c < curves.curves.size(); ++c) {
    const Curve& curve = curves.curves[c];
    Polylines::Line line;
    line.name = "curve_" + std::to_string(c) + (curve.closed ? "_closed" : "");
    const Index begin = static_cast<Index>(out.points.size());
    for (const CurveNode& node : curve.nodes) {
      line.points.push_back(static_cast<Index>(out.points.size()));
      out.points.push_back(node.position);
      add(on_points[kind], static_cast<int>(node.kind));
      add(on_points[vertex], node.vertex);
      add(on_points[junction], node.junction);
      for (const SurfacePoint& p : node.on) add(on_points[on], p.face);
      for (const double x : node.on[0].barycentric) add(on_points[first], x);
      for (const double x : node.on[1].barycentric) add(on_points[second], x);
    }
    if (curve.closed) line.points.push_back(begin);
    for (const CurveSegment& s : curve.segments) {
      add(on_segments[number], static_cast<double>(c));
      add(on_segments[closed], curve.closed);
      for (const Index f : s.faces) add(on_segments[faces], f);
      add(on_segments[crossing], s.crossing);
      add(on_segments[low], s.winding_min);
      add(on_segments[high], s.winding_max);
      for (const int k : {0, 1})
        add(on_segments[hinges], curve.ends[k] == Curve::End::hinge
                                     ? (k == 0 ? curve.nodes.front() : curve.nodes.back()).vertex
                                     : -1);
    }
    out.lines.push_back(std::move(line));
  }
  return out;
}

}  // namespace

Status write_curves(const std::string& path, const Curves& curves, CurveFormat format,
                    const RunContext& context) {
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  return write_polylines(path, lines_of(curves), format);
}

}  // namespace overtet
