#include "src/arrangement/curves.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "kernels/core/assertions.h"
#include "kernels/parallel/parallel.h"
#include "src/arrangement/intersection_graph.h"
#include "src/arrangement/tuning.h"
#include "src/exact/ordinary_size.h"
#include "src/exact/wedges.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

using exact::Point;
using exact::Rational;
using exact::Rays;
using exact::Vec;

using Meeting = IntersectionGraph::Meeting;
using RawSegment = IntersectionGraph::Segment;

// Where third faces cross a segment. Where each of them does so with its inside, and the segment lies inside
// its own two faces, the faces at that point name it, whichever segment it is found from.
struct SegmentCut {
  double near = 0;  // the place, from 0 to 1
  std::optional<Rational> exact;
  int step = 0;  // of the winding number
  bool plain = true;
  std::vector<Index> faces;  // sorted: all that contain the point
  const IntersectionGraph::Cut* origin = nullptr;
};

class Tracer {
 public:
  Tracer(const Surface& surface, const TriangleBvh& bvh, IntersectionGraph& graph, const RunContext& context)
      : surface_(surface),
        graph_(graph),
        nodes_(graph.nodes()),
        context_(context),
        rays_(surface.V, surface.F, bvh),
        wedges_(rays_) {}

  Result<Curves> run() {
    if (const Status ready = graph_.prepare_all(rays_, context_); !ready) return ready.error();
    find_segments();
    trace();
    find_junctions();
    parallel_for(static_cast<std::int64_t>(out_.curves.size()), 1, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t c = begin; c < end && !context_.stop(); ++c) finish(c);
    });
    if (auto stop = context_.stop()) return *stop;
    for (const Curve& c : out_.curves) out_.length += c.length;
    return std::move(out_);
  }

 private:
  Vec exact_point(Index v) const { return exact::vec(surface_.V.data() + 3 * std::int64_t{v}); }
  const Point& position(Index node) const { return graph_.position(node); }

  // Those of the graph, but one of those that lie along the same edge: it is found from both faces there.
  void find_segments() {
    for (std::size_t i = 0; i < graph_.pairs().size(); ++i) {
      out_.touching_pairs += graph_.kind(i) == IntersectionGraph::Kind::point;
      out_.coplanar_pairs += graph_.kind(i) == IntersectionGraph::Kind::coplanar;
    }
    const std::vector<RawSegment>& all = graph_.segments();
    const auto key = [&](Index i) {
      auto along = all[i].along;
      if (along[1] < along[0]) std::swap(along[0], along[1]);
      return std::pair(all[i].node, along);
    };
    std::vector<Index> order(all.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](Index a, Index b) { return key(a) < key(b); });
    std::vector<char> drop(all.size(), 0);
    for (std::size_t i = 1; i < order.size(); ++i) drop[order[i]] = key(order[i]) == key(order[i - 1]);
    touching_.resize(nodes_.size());
    for (Index i = 0; i < static_cast<Index>(all.size()); ++i) {
      if (drop[i]) continue;
      for (int e = 0; e < 2; ++e)
        touching_[all[i].node[e]].emplace_back(static_cast<Index>(segments_.size()), e);
      segments_.push_back(all[i]);
      found_on_.push_back({i, cuts_of(i), graph_.cuts(i).overlaid});
    }
  }

  std::vector<SegmentCut> cuts_of(Index number) const {
    const RawSegment& s = graph_.segments()[number];
    const IntersectionGraph::Cuts& cuts = graph_.cuts(number);
    std::vector<SegmentCut> out;
    for (const IntersectionGraph::Cut& c : cuts.places) {
      if (c.faces.empty()) continue;
      SegmentCut cut{c.near, c.exact, c.step, c.plain && !cuts.overlaid, c.faces, &c};
      if (!cut.exact && !cut.plain) {
        cut.exact = graph_.place(rays_, number, c);
        cut.near = cut.exact->get_d();
      }
      cut.faces.push_back(s.faces.first);
      cut.faces.push_back(s.faces.second);
      std::sort(cut.faces.begin(), cut.faces.end());
      out.push_back(std::move(cut));
    }
    return out;
  }

  // Curves

  // A segment as a curve runs along it.
  struct Step {
    Index segment;
    int enters;  // the end at which it is entered
    int sheet;   // which of its faces is the first sheet
  };
  // Where the winding number comes from: a piece of a segment.
  struct Piece {
    Index segment;
    Index number;  // among the segment's pieces, from its first node to its second
    int step = 0;  // from the piece before, where that says it
    bool follows = false;
  };

  // Of a node of a curve: a node of segments, or where third faces cut one.
  struct Place {
    Index node;
    const SegmentCut* cut;
  };
  // One curve.
  struct Course {
    std::vector<Step> steps;
    std::vector<Piece> pieces;
    std::vector<Place> places;
  };

  bool is_hinge(Index node) const {
    return nodes_[node][0].dimension == 0 && nodes_[node][0] == nodes_[node][1];
  }
  bool goes_on(Index node) const { return touching_[node].size() == 2 && !is_hinge(node); }

  void trace() {
    std::vector<char> used(segments_.size(), 0);
    for (const bool closed : {false, true})
      for (Index s = 0; s < static_cast<Index>(segments_.size()); ++s)
        for (int e = 0; e < 2 && !used[s]; ++e)
          if (closed || !goes_on(segments_[s].node[e])) follow(s, e, used);
    // By the smallest pair of faces, which is the first segment of the walk or not.
    std::vector<Index> order(courses_.size()), least(courses_.size());
    for (std::size_t c = 0; c < courses_.size(); ++c) {
      order[c] = static_cast<Index>(c);
      least[c] = courses_[c].steps[0].segment;
      for (const Step& step : courses_[c].steps) least[c] = std::min(least[c], step.segment);
    }
    std::sort(order.begin(), order.end(), [&](Index a, Index b) { return least[a] < least[b]; });
    std::vector<Course> courses;
    std::vector<Curve> curves;
    for (const Index c : order) {
      courses.push_back(std::move(courses_[c]));
      curves.push_back(std::move(out_.curves[c]));
    }
    courses_ = std::move(courses);
    out_.curves = std::move(curves);
    for (std::size_t c = 0; c < courses_.size(); ++c) lay_out(c);
  }

  void follow(Index first, int enters, std::vector<char>& used) {
    std::vector<Step> steps;
    Curve curve;
    Step at{first, enters, 0};
    for (;;) {
      const RawSegment& s = segments_[at.segment];
      used[at.segment] = 1;
      steps.push_back(at);
      const int leaves = 1 - at.enters;
      const Index node = s.node[leaves];
      if (!goes_on(node)) break;
      const auto& both = touching_[node];
      const auto [next, end] = both[both[0] == std::pair(at.segment, leaves) ? 1 : 0];
      // The simplex that a sheet shows at the node is the same on both sides.
      const int sheet = segments_[next].ends[end][0] == s.ends[leaves][at.sheet] ? 0 : 1;
      if (next == first) {
        curve.closed = true;
        curve.sheets_swap = sheet != 0;
        break;
      }
      at = {next, end, sheet};
    }
    if (!curve.closed) {
      const auto kind = [&](const Step& step, bool start) {
        return is_hinge(segments_[step.segment].node[start ? step.enters : 1 - step.enters])
                   ? Curve::End::hinge
                   : Curve::End::contact;
      };
      curve.ends = {kind(steps.front(), true), kind(steps.back(), false)};
    }
    courses_.push_back({std::move(steps), {}, {}});
    out_.curves.push_back(std::move(curve));
  }

  // Nodes and segments of a curve, without what is computed later.
  void lay_out(std::size_t c) {
    Curve& curve = out_.curves[c];
    Course& course = courses_[c];
    const auto begin = [&](Index node) {
      CurveNode out;
      const Meeting& m = nodes_[node];
      if (m[0].dimension == 0) {
        out.kind = is_hinge(node) ? CurveNode::Kind::hinge : CurveNode::Kind::vertex;
        out.vertex = m[0].id;
      }
      out.position = position(node).near;
      curve.nodes.push_back(out);
      course.places.push_back({node, nullptr});
    };
    for (const Step& step : course.steps) {
      const RawSegment& s = segments_[step.segment];
      begin(s.node[step.enters]);
      const auto& cuts = found_on_[step.segment].cuts;
      const int n = static_cast<int>(cuts.size());
      const Point &a = position(s.node[0]), &b = position(s.node[1]);
      for (int i = 0; i <= n; ++i) {
        const int k = step.enters == 0 ? i : n - i;  // piece k lies between cuts k - 1 and k
        Piece piece{step.segment, k};
        if (i > 0) {
          const SegmentCut& before = cuts[step.enters == 0 ? k - 1 : k];
          piece.follows = before.plain;
          piece.step = step.enters == 0 ? before.step : -before.step;
          CurveNode out;
          out.kind = CurveNode::Kind::triple;
          for (int j = 0; j < 3; ++j) out.position[j] = a.near[j] + before.near * (b.near[j] - a.near[j]);
          curve.nodes.push_back(out);
          course.places.push_back({-1, &before});
        } else {
          const Meeting& m = nodes_[s.node[step.enters]];
          piece.follows = m[0].dimension == 1 && m[1].dimension == 2;
        }
        CurveSegment segment;
        segment.faces = {s.faces.first, s.faces.second};
        if (step.sheet == 1) std::swap(segment.faces[0], segment.faces[1]);
        segment.crossing = s.plain();
        curve.segments.push_back(segment);
        course.pieces.push_back(std::move(piece));
      }
    }
    if (!curve.closed) {
      const Step& last = course.steps.back();
      begin(segments_[last.segment].node[1 - last.enters]);
    }
  }

  // Points that are the same: by their faces where those name them, else by their coordinates.
  void find_junctions() {
    struct Entry {
      Point at;                         // where the faces do not name it
      const std::vector<Index>* faces;  // where they do
      Index curve, node;
    };
    std::vector<Entry> all;
    for (Index c = 0; c < static_cast<Index>(courses_.size()); ++c)
      for (Index i = 0; i < static_cast<Index>(courses_[c].places.size()); ++i) {
        const Place& place = courses_[c].places[i];
        if (place.node >= 0) {
          all.push_back({position(place.node), nullptr, c, i});
        } else if (place.cut->plain) {
          all.push_back({{}, &place.cut->faces, c, i});
        } else {
          const Piece& piece = courses_[c].pieces[i];
          const RawSegment& s = segments_[piece.segment];
          const Vec& a = position(s.node[0]).x;
          all.push_back({Point(a + *place.cut->exact * (position(s.node[1]).x - a)), nullptr, c, i});
        }
      }
    const auto order = [](const Entry& a, const Entry& b) {
      if ((a.faces == nullptr) != (b.faces == nullptr)) return a.faces ? -1 : 1;
      if (a.faces) return *a.faces == *b.faces ? 0 : *a.faces < *b.faces ? -1 : 1;
      // Equal numbers have equal roundings.
      if (a.at.near != b.at.near) return a.at.near < b.at.near ? -1 : 1;
      for (int k = 0; k < 3; ++k)
        if (const int sign = cmp(a.at.x[k], b.at.x[k])) return sign;
      return 0;
    };
    std::vector<Index> sorted(all.size());
    for (std::size_t i = 0; i < all.size(); ++i) sorted[i] = static_cast<Index>(i);
    std::stable_sort(sorted.begin(), sorted.end(),
                     [&](Index a, Index b) { return order(all[a], all[b]) < 0; });
    for (std::size_t b = 0, e; b < all.size(); b = e) {
      for (e = b + 1; e < all.size() && order(all[sorted[b]], all[sorted[e]]) == 0;) ++e;
      if (e - b < 2) continue;
      Junction junction;
      const Entry& first = all[sorted[b]];
      junction.position = out_.curves[first.curve].nodes[first.node].position;
      for (std::size_t i = b; i < e; ++i) {
        const Entry& entry = all[sorted[i]];
        CurveNode& node = out_.curves[entry.curve].nodes[entry.node];
        node.junction = static_cast<Index>(out_.junctions.size());
        node.position = junction.position;  // one rounding for all
        junction.strands.emplace_back(entry.curve, entry.node);
      }
      out_.junctions.push_back(std::move(junction));
    }
  }

  // Numbers

  // The preimages of the nodes. Those where third faces cut a segment lie between those of its ends.
  void put_on_faces(std::size_t c) {
    Curve& curve = out_.curves[c];
    const Course& course = courses_[c];
    const std::size_t m = curve.nodes.size();
    std::array<SurfacePoint, 2> from, to;
    for (std::size_t i = 0; i < m; ++i) {
      CurveNode& node = curve.nodes[i];
      const Place& place = course.places[i];
      const auto& faces = curve.segments[std::min(i, curve.segments.size() - 1)].faces;
      if (place.node >= 0) {
        for (int k = 0; k < 2; ++k) node.on[k] = on_face(position(place.node).x, faces[k]);
        continue;
      }
      if (course.places[i - 1].node >= 0) {
        const auto& ends = segments_[course.pieces[i].segment].node;
        for (int k = 0; k < 2; ++k) {
          from[k] = on_face(position(ends[0]).x, faces[k]);
          to[k] = on_face(position(ends[1]).x, faces[k]);
        }
      }
      for (int k = 0; k < 2; ++k) {
        node.on[k].face = faces[k];
        for (int j = 0; j < 3; ++j)
          node.on[k].barycentric[j] =
              from[k].barycentric[j] + place.cut->near * (to[k].barycentric[j] - from[k].barycentric[j]);
      }
    }
  }

  void finish(std::size_t c) {
    Curve& curve = out_.curves[c];
    const std::size_t n = curve.segments.size(), m = curve.nodes.size();
    put_on_faces(c);
    std::optional<int> outer;  // of the segment before
    bool any = false;
    for (std::size_t i = 0; i < n; ++i) {
      const Piece& piece = courses_[c].pieces[i];
      CurveSegment& segment = curve.segments[i];
      const auto &a = curve.nodes[i].position, &b = curve.nodes[(i + 1) % m].position;
      curve.length += std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
      const bool plain = segment.crossing && !found_on_[piece.segment].overlaid;
      const bool inside = curve.nodes[i].kind == CurveNode::Kind::triple;
      const bool follows = plain && outer && piece.follows && (inside || curve.nodes[i].junction < 0);
      if (follows) {
        *outer += inside ? piece.step : 0;
      } else {
        outer = plain ? look(piece) : std::nullopt;
      }
      if (outer) {
        segment.winding_min = *outer;
        segment.winding_max = *outer + 2;
        segment.winding_known = true;
      } else {
        look_around(piece, segment);
      }
      if (!segment.winding_known) continue;
      curve.winding_min = any ? std::min(curve.winding_min, segment.winding_min) : segment.winding_min;
      curve.winding_max = any ? std::max(curve.winding_max, segment.winding_max) : segment.winding_max;
      any = true;
    }
  }

  // The winding number in front of both faces.
  std::optional<int> look(const Piece& piece) const {
    const RawSegment& s = segments_[piece.segment];
    const auto [begin, end] = range(piece);
    const Vec &from = position(s.node[0]).x, along = position(s.node[1]).x - from;
    const Vec u = exact::cross(rays_.normal(s.faces.first), rays_.normal(s.faces.second));
    const auto wedge = wedges_.in_front(s.faces.first, s.faces.second, u, from, along, begin, end);
    return wedge ? std::optional<int>(wedge->winding) : std::nullopt;
  }

  std::pair<Rational, Rational> range(const Piece& piece) const {
    const FoundOn& found = found_on_[piece.segment];
    const auto place = [&](const SegmentCut& cut) {
      return cut.exact ? *cut.exact : graph_.place(rays_, found.number, *cut.origin);
    };
    const std::vector<SegmentCut>& cuts = found.cuts;
    const std::size_t k = static_cast<std::size_t>(piece.number);
    return {k == 0 ? Rational(0) : place(cuts[k - 1]), k == cuts.size() ? Rational(1) : place(cuts[k])};
  }

  void look_around(const Piece& piece, CurveSegment& segment) const {
    const RawSegment& s = segments_[piece.segment];
    const auto [begin, end] = range(piece);
    const Vec &from = position(s.node[0]).x, along = position(s.node[1]).x - from;
    for (const Wedge& wedge :
         wedges_.around(exact::whole(along), Point(from + ((begin + end) / 2) * along))) {
      segment.winding_min =
          segment.winding_known ? std::min(segment.winding_min, wedge.winding) : wedge.winding;
      segment.winding_max =
          segment.winding_known ? std::max(segment.winding_max, wedge.winding) : wedge.winding;
      segment.winding_known = true;
    }
  }

  SurfacePoint on_face(const Vec& p, Index f) const {
    const Vec n = rays_.normal(f);
    const auto size = exact::approximate(n);
    int axis = 0;
    for (int k = 1; k < 3; ++k)
      if (std::fabs(size[k]) > std::fabs(size[axis]) || exact::sign(n[axis]) == 0) axis = k;
    const int i = (axis + 1) % 3, j = (axis + 2) % 3;
    SurfacePoint out;
    out.face = f;
    for (int k = 0; k < 3; ++k) {
      const Vec a = exact_point(surface_.F(f, (k + 1) % 3)) - p,
                b = exact_point(surface_.F(f, (k + 2) % 3)) - p;
      const Rational part = (a[i] * b[j] - a[j] * b[i]) / n[axis];
      out.barycentric[k] = part.get_d();
    }
    return out;
  }

  struct FoundOn {  // a segment
    Index number;   // in the graph
    std::vector<SegmentCut> cuts;
    bool overlaid;  // third faces run along it
  };

  const Surface& surface_;
  IntersectionGraph& graph_;
  const std::vector<Meeting>& nodes_;
  const RunContext& context_;
  const Rays rays_;
  const Wedges wedges_;
  std::vector<RawSegment> segments_;
  std::vector<FoundOn> found_on_;                             // per segment
  std::vector<std::vector<std::pair<Index, int>>> touching_;  // per node: (segment, end)
  std::vector<Course> courses_;                               // per curve
  Curves out_;
};

}  // namespace

Index Curves::closed() const {
  return static_cast<Index>(
      std::count_if(curves.begin(), curves.end(), [](const Curve& c) { return c.closed; }));
}

Index Curves::hinge_to_hinge() const {
  return static_cast<Index>(std::count_if(curves.begin(), curves.end(), [](const Curve& c) {
    return c.ends[0] == Curve::End::hinge && c.ends[1] == Curve::End::hinge;
  }));
}

Index Curves::triple_points() const {
  return static_cast<Index>(std::count_if(junctions.begin(), junctions.end(),
                                          [](const Junction& j) { return j.strands.size() > 2; }));
}

Result<Curves> trace_curves(const Surface& surface, const TriangleBvh& bvh, IntersectionGraph& graph,
                            const RunContext& context) {
  OVERTET_EXPECTS(degenerate_faces(surface).empty());
  const OrdinarySize sized(surface, bvh);
  Result<Curves> curves = Tracer(sized.surface(), sized.bvh(), graph, context).run();
  if (curves.ok() && sized.scaled()) {
    for (Curve& curve : curves.value().curves) {
      curve.length = sized.back(curve.length);
      for (CurveNode& node : curve.nodes) node.position = sized.back(node.position);
    }
    for (Junction& junction : curves.value().junctions) junction.position = sized.back(junction.position);
    curves.value().length = sized.back(curves.value().length);
  }
  return curves;
}

}  // namespace overtet
