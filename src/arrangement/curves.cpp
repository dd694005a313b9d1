#include "src/arrangement/curves.h"

#include <algorithm>
#include <cmath>

#include "kernels/parallel/parallel.h"
#include "kernels/predicates/predicates.h"
#include "src/exact/ordinary_size.h"
#include "src/exact/wedges.h"

namespace overtet {

namespace {

// Places on a segment (0 to 1) that doubles do not tell better than this are computed in fractions.
constexpr double kNear = 1e-9;

using exact::Point;
using exact::Rational;
using exact::Rays;
using exact::Vec;

// A vertex, an edge (by its smaller half-edge) or a face.
struct Simplex {
  int dimension = 0;
  Index id = -1;
  auto operator<=>(const Simplex&) const = default;
};

// An end of a segment: the smallest simplex that contains it on each of the two faces. If they met in more
// than one point there, the segment would go on: so they name the point, whichever pair it is found from.
using Meeting = std::array<Simplex, 2>;

struct RawSegment {
  FacePair faces;                  // first < second
  std::array<Meeting, 2> ends;     // on the first face, on the second
  std::array<Simplex, 2> along{};  // the smallest simplices that contain the segment
  std::array<Index, 2> node{-1, -1};
  bool plain() const { return along[0].dimension == 2 && along[1].dimension == 2; }
};

// Where third faces cross a segment. Where each of them does so with its inside, and the segment lies inside
// its own two faces, the faces at that point name it, whichever segment it is found from.
struct Cut {
  double near = 0, error = 0;  // the place, from 0 to 1
  std::optional<Rational> exact;
  int step = 0;  // of the winding number
  bool plain = true;
  Index by = -1;             // the face that the place is computed from
  std::vector<Index> faces;  // sorted: all that contain the point
};

struct PairMeets {
  enum class Kind { nothing, point, segment, coplanar } kind = Kind::nothing;
  RawSegment segment;
};

class Tracer {
 public:
  Tracer(const Surface& surface, const SurfaceTopology& topology, const TriangleBvh& bvh,
         const std::vector<FacePair>& pairs, const RunContext& context)
      : surface_(surface),
        topology_(topology),
        pairs_(pairs),
        context_(context),
        rays_(surface.V, surface.F, bvh),
        partners_(pairs),
        wedges_(rays_) {}

  Result<Curves> run() {
    find_segments();
    if (auto stop = context_.stop()) return *stop;
    number_nodes();
    cut_segments();
    if (auto stop = context_.stop()) return *stop;
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
  const double* point(Index v) const { return surface_.V.data() + 3 * std::int64_t{v}; }
  Vec exact_point(Index v) const { return exact::vec(point(v)); }
  Index edge_of(Index h) const { return std::min(h, topology_.twin[h]); }

  // Segments

  void find_segments() {
    std::vector<PairMeets> found(pairs_.size());
    parallel_for(static_cast<std::int64_t>(pairs_.size()), 64, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) found[i] = meets(pairs_[i].first, pairs_[i].second);
    });
    for (PairMeets& m : found) {
      out_.touching_pairs += m.kind == PairMeets::Kind::point;
      out_.coplanar_pairs += m.kind == PairMeets::Kind::coplanar;
      if (m.kind == PairMeets::Kind::segment) segments_.push_back(std::move(m.segment));
    }
  }

  PairMeets meets(Index f, Index g) const {
    PairMeets out;
    std::vector<Meeting> ends;
    if (!edges_through(f, g, false, ends)) {
      out.kind = PairMeets::Kind::coplanar;
      return out;
    }
    edges_through(g, f, true, ends);
    std::sort(ends.begin(), ends.end());
    ends.erase(std::unique(ends.begin(), ends.end()), ends.end());
    if (ends.empty()) return out;
    if (ends.size() == 1) {
      out.kind = PairMeets::Kind::point;
      return out;
    }
    out.kind = PairMeets::Kind::segment;
    out.segment.faces = {f, g};
    out.segment.ends = {ends[0], ends[1]};
    out.segment.along = {along(f, ends[0][0], ends[1][0]), along(g, ends[0][1], ends[1][1])};
    return out;
  }

  // Where edges of f meet g. False when the faces lie in one plane. swapped: g is the first face of the pair.
  bool edges_through(Index f, Index g, bool swapped, std::vector<Meeting>& ends) const {
    const double *p = point(surface_.F(g, 0)), *q = point(surface_.F(g, 1)), *r = point(surface_.F(g, 2));
    int side[3];
    for (int k = 0; k < 3; ++k) side[k] = orient3d(p, q, r, point(surface_.F(f, k)));
    if (side[0] == 0 && side[1] == 0 && side[2] == 0) return false;
    const auto add = [&](Simplex in_f, Simplex in_g) {
      ends.push_back(swapped ? Meeting{in_g, in_f} : Meeting{in_f, in_g});
    };
    for (int k = 0; k < 3; ++k) {
      if (side[k] == 0) {
        const Index v = surface_.F(f, k);
        if (const auto where = locate(v, g)) add({0, v}, *where);
      }
      if (side[k] * side[(k + 1) % 3] >= 0) continue;
      const double *a = point(surface_.F(f, k)), *b = point(surface_.F(f, (k + 1) % 3));
      const int turn[3] = {orient3d(a, b, p, q), orient3d(a, b, q, r), orient3d(a, b, r, p)};
      if (const auto where = inside(g, turn)) add({1, edge_of(3 * f + k)}, *where);
    }
    return true;
  }

  // The simplex of g in which a point lies, from the sides of g's half-edges that it is on.
  std::optional<Simplex> inside(Index g, const int* side) const {
    int zeros = 0, sum = 0;
    for (int k = 0; k < 3; ++k) zeros += side[k] == 0, sum += side[k];
    if (std::abs(sum) + zeros != 3) return std::nullopt;
    if (zeros == 0) return Simplex{2, g};
    for (int k = 0; k < 3; ++k) {
      if (side[k] != 0) continue;
      if (zeros == 1) return Simplex{1, edge_of(3 * g + k)};
      if (side[(k + 1) % 3] == 0) return Simplex{0, surface_.F(g, (k + 1) % 3)};
    }
    return std::nullopt;
  }

  // A vertex in the plane of g.
  std::optional<Simplex> locate(Index v, Index g) const {
    for (int k = 0; k < 3; ++k)
      if (surface_.F(g, k) == v) return Simplex{0, v};
    const Vec m = exact_point(v), n = rays_.normal(g);
    int side[3];
    for (int k = 0; k < 3; ++k) {
      const Vec a = exact_point(surface_.F(g, k));
      side[k] = exact::sign(dot(n, exact::cross(exact_point(surface_.F(g, (k + 1) % 3)) - a, m - a)));
      if (side[k] < 0) return std::nullopt;
    }
    return inside(g, side);
  }

  Simplex along(Index f, const Simplex& a, const Simplex& b) const {
    for (Index h = 3 * f; h < 3 * f + 3; ++h) {
      const auto on = [&](const Simplex& x) {
        return x == Simplex{1, edge_of(h)} || x == Simplex{0, half_edge_source(surface_.F, h)} ||
               x == Simplex{0, half_edge_target(surface_.F, h)};
      };
      if (on(a) && on(b)) return {1, edge_of(h)};
    }
    return {2, f};
  }

  // Nodes

  static Meeting unordered(const Meeting& m) { return m[0] <= m[1] ? m : Meeting{m[1], m[0]}; }

  void number_nodes() {
    for (const RawSegment& s : segments_)
      for (const Meeting& m : s.ends) nodes_.push_back(unordered(m));
    std::sort(nodes_.begin(), nodes_.end());
    nodes_.erase(std::unique(nodes_.begin(), nodes_.end()), nodes_.end());
    for (RawSegment& s : segments_) {
      for (int e = 0; e < 2; ++e)
        s.node[e] = static_cast<Index>(std::lower_bound(nodes_.begin(), nodes_.end(), unordered(s.ends[e])) -
                                       nodes_.begin());
      if (s.node[0] > s.node[1]) {
        std::swap(s.node[0], s.node[1]);
        std::swap(s.ends[0], s.ends[1]);
      }
    }
    // A segment along an edge is found from both faces of the edge.
    const auto key = [](const RawSegment& s) {
      return std::pair(s.node, unordered({s.along[0], s.along[1]}));
    };
    std::vector<Index> order(segments_.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<Index>(i);
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return key(segments_[a]) < key(segments_[b]); });
    std::vector<char> drop(segments_.size(), 0);
    for (std::size_t i = 1; i < order.size(); ++i)
      drop[order[i]] = key(segments_[order[i]]) == key(segments_[order[i - 1]]);
    std::size_t kept = 0;
    for (std::size_t i = 0; i < segments_.size(); ++i)
      if (!drop[i]) segments_[kept++] = segments_[i];
    segments_.resize(kept);

    position_.resize(nodes_.size());
    parallel_for(static_cast<std::int64_t>(nodes_.size()), 64, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) position_[i] = Point(place(nodes_[i]));
    });
    touching_.resize(nodes_.size());
    for (std::size_t s = 0; s < segments_.size(); ++s)
      for (int e = 0; e < 2; ++e) touching_[segments_[s].node[e]].emplace_back(static_cast<Index>(s), e);
  }

  Vec place(const Meeting& m) const {  // dimensions do not decrease
    if (m[0].dimension == 0) return exact_point(m[0].id);
    const Vec a = exact_point(half_edge_source(surface_.F, m[0].id));
    const Vec e = exact_point(half_edge_target(surface_.F, m[0].id)) - a;
    if (m[1].dimension == 2) {
      const Vec n = rays_.normal(m[1].id);
      return a + (dot(n, exact_point(surface_.F(m[1].id, 0)) - a) / dot(n, e)) * e;
    }
    const Vec c = exact_point(half_edge_source(surface_.F, m[1].id));
    const Vec d = exact_point(half_edge_target(surface_.F, m[1].id)) - c;
    const Vec n = exact::cross(e, d);
    return a + (exact::det(c - a, d, n) / dot(n, n)) * e;
  }

  // Third faces

  void cut_segments() {
    cuts_.resize(segments_.size());
    overlaid_.assign(segments_.size(), 0);
    parallel_for(static_cast<std::int64_t>(segments_.size()), 16, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t s = begin; s < end && !context_.stop(); ++s) cut(s);
    });
  }

  bool apart(const Point& a, const Point& b, Index h) const {
    for (int k = 0; k < 3; ++k) {
      // The points are rounded by an ulp.
      const double slack = 1e-15 * (std::fabs(a.near[k]) + std::fabs(b.near[k]));
      const double x = surface_.V(surface_.F(h, 0), k), y = surface_.V(surface_.F(h, 1), k),
                   z = surface_.V(surface_.F(h, 2), k);
      if (std::max({x, y, z}) < std::min(a.near[k], b.near[k]) - slack ||
          std::min({x, y, z}) > std::max(a.near[k], b.near[k]) + slack)
        return true;
    }
    return false;
  }

  void cut(std::size_t number) {
    const RawSegment& s = segments_[number];
    const Point &a = position_[s.node[0]], &b = position_[s.node[1]];
    std::optional<Point> direction;
    std::vector<Cut> cuts;
    const auto add = [&](Index h, int step, bool plain) -> Cut& {
      cuts.emplace_back();
      cuts.back().step = step;
      cuts.back().plain = plain;
      cuts.back().by = h;
      cuts.back().faces = {h};
      return cuts.back();
    };
    for (const Index h : partners_.common(s.faces.first, s.faces.second)) {
      if (apart(a, b, h)) continue;
      const int sa = rays_.side(a, h), sb = rays_.side(b, h);
      if (sa * sb > 0 || (sa == 0) != (sb == 0)) continue;
      if (sa != 0) {
        if (!direction) direction.emplace(b.x - a.x);
        const int passes = rays_.passes(a, *direction, h);
        if (passes == 0) continue;
        const bool plain = passes != Rays::kGrazes;
        Cut& cut = add(h, plain ? -passes : 0, plain && s.plain());
        double error_a, error_b;
        const double x = rays_.height(a, h, error_a), y = rays_.height(b, h, error_b);
        const double span = std::fabs(x - y) - error_a - error_b;
        cut.near = x / (x - y);
        cut.error = span > 0 ? 3 * (error_a + error_b) / span + 1e-15 : HUGE_VAL;
        if (!(cut.error < kNear)) refine(cut, a, b);
      } else {
        // The segment runs in the plane of h: cut it at h's edges.
        const Vec n = rays_.normal(h);
        Rational lo = 0, hi = 1;
        for (int k = 0; k < 3; ++k) {
          const Vec o = exact_point(surface_.F(h, k));
          const Vec wall = exact::cross(n, exact_point(surface_.F(h, (k + 1) % 3)) - o);
          const Rational x = dot(wall, a.x - o), y = dot(wall, b.x - o);
          if (exact::sign(x) < 0 && exact::sign(y) < 0) hi = -1;
          if (exact::sign(x) * exact::sign(y) >= 0) continue;
          const Rational t = x / (x - y);
          if (exact::sign(x) < 0) lo = std::max(lo, t);
          if (exact::sign(x) > 0) hi = std::min(hi, t);
        }
        if (lo > hi) continue;
        overlaid_[number] = 1;
        for (const Rational& t : {lo, hi}) {
          if (exact::sign(t) <= 0 || t >= 1) continue;
          Cut& cut = add(h, 0, false);
          cut.near = t.get_d();
          cut.error = 1e-15;
          cut.exact = t;
        }
      }
    }
    // The order of exact arithmetic; the doubles decide wherever they are far enough apart.
    const auto compare = [&](Cut& x, Cut& y) {
      const double gap = x.near - y.near;
      if (std::fabs(gap) > x.error + y.error) return gap < 0 ? -1 : 1;
      refine(x, a, b);
      refine(y, a, b);
      return cmp(*x.exact, *y.exact);
    };
    std::vector<Cut*> order;
    for (Cut& c : cuts) order.push_back(&c);
    std::sort(order.begin(), order.end(), [&](Cut* x, Cut* y) { return compare(*x, *y) < 0; });
    auto& kept = cuts_[number];
    for (Cut* c : order) {
      if (kept.empty() || compare(kept.back(), *c) != 0) {
        kept.push_back(std::move(*c));
        continue;
      }
      kept.back().step += c->step;
      kept.back().plain = kept.back().plain && c->plain;
      kept.back().faces.push_back(c->faces[0]);
    }
    for (Cut& c : kept) {
      c.faces.push_back(s.faces.first);
      c.faces.push_back(s.faces.second);
      std::sort(c.faces.begin(), c.faces.end());
      if (!c.plain || overlaid_[number]) {
        c.plain = false;
        refine(c, a, b);
      }
    }
  }

  Rational exact_place(const Cut& cut, const Point& a, const Point& b) const {
    return cut.exact ? *cut.exact : rays_.cut(a, b, cut.by);
  }
  void refine(Cut& cut, const Point& a, const Point& b) const {
    if (cut.exact) return;
    cut.exact = exact_place(cut, a, b);
    cut.near = cut.exact->get_d();
    cut.error = 1e-15;
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
    const Cut* cut;
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
    std::vector<Index> order(steps_.size()), least(steps_.size());
    for (std::size_t c = 0; c < steps_.size(); ++c) {
      order[c] = static_cast<Index>(c);
      least[c] = steps_[c][0].segment;
      for (const Step& step : steps_[c]) least[c] = std::min(least[c], step.segment);
    }
    std::sort(order.begin(), order.end(), [&](Index a, Index b) { return least[a] < least[b]; });
    std::vector<std::vector<Step>> steps;
    std::vector<Curve> curves;
    for (const Index c : order) {
      steps.push_back(std::move(steps_[c]));
      curves.push_back(std::move(out_.curves[c]));
    }
    steps_ = std::move(steps);
    out_.curves = std::move(curves);
    pieces_.resize(steps_.size());
    places_.resize(steps_.size());
    for (std::size_t c = 0; c < steps_.size(); ++c) lay_out(c);
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
    steps_.push_back(std::move(steps));
    out_.curves.push_back(std::move(curve));
  }

  // Nodes and segments of a curve, without what is computed later.
  void lay_out(std::size_t c) {
    Curve& curve = out_.curves[c];
    const auto begin = [&](Index node) {
      CurveNode out;
      const Meeting& m = nodes_[node];
      if (m[0].dimension == 0) {
        out.kind = is_hinge(node) ? CurveNode::Kind::hinge : CurveNode::Kind::vertex;
        out.vertex = m[0].id;
      }
      out.position = position_[node].near;
      curve.nodes.push_back(out);
      places_[c].push_back({node, nullptr});
    };
    for (const Step& step : steps_[c]) {
      const RawSegment& s = segments_[step.segment];
      begin(s.node[step.enters]);
      const auto& cuts = cuts_[step.segment];
      const int n = static_cast<int>(cuts.size());
      const Point &a = position_[s.node[0]], &b = position_[s.node[1]];
      for (int i = 0; i <= n; ++i) {
        const int k = step.enters == 0 ? i : n - i;  // piece k lies between cuts k - 1 and k
        Piece piece{step.segment, k};
        if (i > 0) {
          const Cut& before = cuts[step.enters == 0 ? k - 1 : k];
          piece.follows = before.plain;
          piece.step = step.enters == 0 ? before.step : -before.step;
          CurveNode out;
          out.kind = CurveNode::Kind::triple;
          for (int j = 0; j < 3; ++j) out.position[j] = a.near[j] + before.near * (b.near[j] - a.near[j]);
          curve.nodes.push_back(out);
          places_[c].push_back({-1, &before});
        } else {
          const Meeting& m = nodes_[s.node[step.enters]];
          piece.follows = m[0].dimension == 1 && m[1].dimension == 2;
        }
        CurveSegment segment;
        segment.faces = {s.faces.first, s.faces.second};
        if (step.sheet == 1) std::swap(segment.faces[0], segment.faces[1]);
        segment.crossing = s.plain();
        curve.segments.push_back(segment);
        pieces_[c].push_back(std::move(piece));
      }
    }
    if (!curve.closed) {
      const Step& last = steps_[c].back();
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
    for (Index c = 0; c < static_cast<Index>(places_.size()); ++c)
      for (Index i = 0; i < static_cast<Index>(places_[c].size()); ++i) {
        const Place& place = places_[c][i];
        if (place.node >= 0) {
          all.push_back({position_[place.node], nullptr, c, i});
        } else if (place.cut->plain) {
          all.push_back({{}, &place.cut->faces, c, i});
        } else {
          const Piece& piece = pieces_[c][i];
          const RawSegment& s = segments_[piece.segment];
          const Vec& a = position_[s.node[0]].x;
          all.push_back({Point(a + *place.cut->exact * (position_[s.node[1]].x - a)), nullptr, c, i});
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
    const std::size_t m = curve.nodes.size();
    std::array<SurfacePoint, 2> from, to;
    for (std::size_t i = 0; i < m; ++i) {
      CurveNode& node = curve.nodes[i];
      const Place& place = places_[c][i];
      const auto& faces = curve.segments[std::min(i, curve.segments.size() - 1)].faces;
      if (place.node >= 0) {
        for (int k = 0; k < 2; ++k) node.on[k] = on_face(position_[place.node].x, faces[k]);
        continue;
      }
      if (places_[c][i - 1].node >= 0) {
        const auto& ends = segments_[pieces_[c][i].segment].node;
        for (int k = 0; k < 2; ++k) {
          from[k] = on_face(position_[ends[0]].x, faces[k]);
          to[k] = on_face(position_[ends[1]].x, faces[k]);
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
      const Piece& piece = pieces_[c][i];
      CurveSegment& segment = curve.segments[i];
      const auto &a = curve.nodes[i].position, &b = curve.nodes[(i + 1) % m].position;
      curve.length += std::hypot(b[0] - a[0], b[1] - a[1], b[2] - a[2]);
      const bool plain = segment.crossing && !overlaid_[piece.segment];
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
    const Vec &from = position_[s.node[0]].x, along = position_[s.node[1]].x - from;
    const Vec u = exact::cross(rays_.normal(s.faces.first), rays_.normal(s.faces.second));
    const auto wedge = wedges_.in_front(s.faces.first, s.faces.second, u, from, along, begin, end);
    return wedge ? std::optional<int>(wedge->winding) : std::nullopt;
  }

  std::pair<Rational, Rational> range(const Piece& piece) const {
    const RawSegment& s = segments_[piece.segment];
    const auto& cuts = cuts_[piece.segment];
    const Point &a = position_[s.node[0]], &b = position_[s.node[1]];
    const std::size_t k = static_cast<std::size_t>(piece.number);
    return {k == 0 ? Rational(0) : exact_place(cuts[k - 1], a, b),
            k == cuts.size() ? Rational(1) : exact_place(cuts[k], a, b)};
  }

  void look_around(const Piece& piece, CurveSegment& segment) const {
    const RawSegment& s = segments_[piece.segment];
    const auto [begin, end] = range(piece);
    const Vec &from = position_[s.node[0]].x, along = position_[s.node[1]].x - from;
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

  const Surface& surface_;
  const SurfaceTopology& topology_;
  const std::vector<FacePair>& pairs_;
  const RunContext& context_;
  const Rays rays_;
  const Partners partners_;
  const Wedges wedges_;
  std::vector<RawSegment> segments_;
  std::vector<Meeting> nodes_;
  std::vector<Point> position_;                               // of the nodes
  std::vector<std::vector<std::pair<Index, int>>> touching_;  // per node: (segment, end)
  std::vector<std::vector<Cut>> cuts_;                        // per segment
  std::vector<char> overlaid_;                                // per segment: third faces run along it
  std::vector<std::vector<Step>> steps_;                      // per curve, and so on
  std::vector<std::vector<Piece>> pieces_;
  std::vector<std::vector<Place>> places_;
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

Result<Curves> trace_curves(const Surface& surface, const SurfaceTopology& topology, const TriangleBvh& bvh,
                            const std::vector<FacePair>& pairs, const RunContext& context) {
  const OrdinarySize sized(surface, bvh);
  Result<Curves> curves = Tracer(sized.surface(), topology, sized.bvh(), pairs, context).run();
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
