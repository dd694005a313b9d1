#include "src/arrangement/arrangement.h"

#include <CGAL/intersections.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <iterator>
#include <map>
#include <numeric>
#include <optional>
#include <string>

#include "kernels/bvh/self_intersections.h"
#include "kernels/core/assertions.h"
#include "kernels/core/tuning.h"
#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"
#include "src/arrangement/exact_triangulation.h"
#include "src/arrangement/pieces.h"
#include "src/arrangement/tolerant_cutter.h"
#include "src/arrangement/tuning.h"
#include "src/exact/piercing.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

using exact::Kernel;
using exact::Point2;
using exact::Scalar;
using exact::Triangulation;
using Point3 = Kernel::Point_3;

// Numbers exact points: equal points get equal numbers, whichever faces they were computed from.
class PointTable {
 public:
  Index number(const Point3& p) {
    const auto [at, added] = number_.try_emplace(p, static_cast<Index>(points_.size()));
    if (added) points_.push_back(p);
    return at->second;
  }
  const Point3& point(Index i) const { return points_[i]; }
  Index size() const { return static_cast<Index>(points_.size()); }

 private:
  struct Less {
    bool operator()(const Point3& a, const Point3& b) const {
      return CGAL::compare_xyz(a, b) == CGAL::SMALLER;
    }
  };
  std::map<Point3, Index, Less> number_;
  std::vector<Point3> points_;
};

// What cuts one face: points and segments in it, by point number.
struct Cuts {
  std::vector<Index> points;
  std::vector<std::pair<Index, Index>> segments;
};

// What two faces have in common: a point, a segment or a polygon.
using Meeting = std::vector<Point3>;

// A face cut up. Vertices below 0: -1 - i is point i of `crossings`, where two cuts cross.
struct Cut {
  std::vector<std::array<Index, 3>> triangles;
  std::vector<Point3> crossings;
};

// One round: cuts the pieces along all given pairs, exactly, and rounds the new points to doubles. Points are
// computed by all threads and numbered by one, in the order of the pairs and faces.
class Cutter {
 public:
  Cutter(std::vector<Eigen::Vector3d>& points, std::vector<Piece>& pieces)
      : points_(points), pieces_(pieces) {}

  std::optional<Error> run(const std::vector<FacePair>& pairs, const RunContext& context) {
    std::vector<Meeting> meetings(pairs.size());
    parallel_for(static_cast<std::int64_t>(pairs.size()), kHeavyGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                   if (context.stop()) return;
                   for (std::int64_t i = begin; i < end; ++i)
                     meetings[i] = meeting(pairs[i].first, pairs[i].second);
                 });
    if (auto stop = context.stop()) return stop;
    // All corners before all cuts, so that a cut through a corner gets that corner's number.
    for (const auto& [f, g] : pairs) enter_corners(f), enter_corners(g);
    for (std::size_t i = 0; i < pairs.size(); ++i) enter(pairs[i].first, pairs[i].second, meetings[i]);
    meetings.clear();

    std::vector<std::pair<Index, const Cuts*>> faces;
    for (const auto& [f, cuts] : cuts_) faces.emplace_back(f, &cuts);
    std::vector<Cut> cut(faces.size());
    parallel_for(static_cast<std::int64_t>(faces.size()), kHeavyGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                   if (context.stop()) return;
                   for (std::int64_t i = begin; i < end; ++i)
                     cut[i] = triangulate(faces[i].first, *faces[i].second);
                 });
    if (auto stop = context.stop()) return stop;
    std::vector<Piece> out;
    out.reserve(pieces_.size() + 16 * faces.size());
    std::size_t next = 0;
    std::vector<Index> ids;
    for (Index f = 0; f < static_cast<Index>(pieces_.size()); ++f) {
      if (next == faces.size() || faces[next].first != f) {
        out.push_back(std::move(pieces_[f]));
        continue;
      }
      ids.clear();
      for (const Point3& p : cut[next].crossings) ids.push_back(number(p));
      for (auto corners : cut[next].triangles) {
        for (Index& v : corners)
          if (v < 0) v = ids[-1 - v];
        out.push_back({corners, pieces_[f].sheet, pieces_[f].more, true});
      }
      ++next;
    }
    const std::size_t before = points_.size();
    points_.resize(before + added_.size());
    parallel_for(static_cast<std::int64_t>(added_.size()), kHeavyGrain,
                 [&](std::int64_t begin, std::int64_t end) {
                   for (std::int64_t i = begin; i < end; ++i) {
                     const Point3& p = table_.point(added_[i]);
                     p.exact();
                     points_[before + i] = {CGAL::to_double(p.x().exact()), CGAL::to_double(p.y().exact()),
                                            CGAL::to_double(p.z().exact())};
                   }
                 });
    pieces_ = std::move(out);
    return std::nullopt;
  }

 private:
  Point3 exact_input(Index v) const { return Point3(points_[v][0], points_[v][1], points_[v][2]); }
  Point3 corner(Index f, int k) const { return exact_input(pieces_[f].corners[k]); }

  void enter_corners(Index f) {
    for (const Index v : pieces_[f].corners) {
      const Index i = table_.number(exact_input(v));
      if (i == static_cast<Index>(final_.size())) final_.push_back(v);
    }
  }

  // The complex's number of an exact point; new points come after all present ones.
  Index number(const Point3& p) {
    const Index i = table_.number(p);
    if (i == static_cast<Index>(final_.size())) {
      final_.push_back(static_cast<Index>(points_.size() + added_.size()));
      added_.push_back(i);
    }
    return final_[i];
  }

  Point3 exact(Index number) const {
    const Index n = static_cast<Index>(points_.size());
    return number < n ? exact_input(number) : table_.point(added_[number - n]);
  }

  Meeting meeting(Index f, Index g) const {
    const Kernel::Triangle_3 a(corner(f, 0), corner(f, 1), corner(f, 2));
    const Kernel::Triangle_3 b(corner(g, 0), corner(g, 1), corner(g, 2));
    const auto meet = CGAL::intersection(a, b);
    Meeting out;
    if (!meet) return out;
    if (const Kernel::Segment_3* s = boost::get<Kernel::Segment_3>(&*meet))
      if (auto ends = ends_in_general_position(f, g, *s)) return *std::move(ends);
    if (const Point3* p = boost::get<Point3>(&*meet))
      out = {*p};
    else if (const Kernel::Segment_3* s = boost::get<Kernel::Segment_3>(&*meet))
      out = {s->source(), s->target()};
    else if (const Kernel::Triangle_3* t = boost::get<Kernel::Triangle_3>(&*meet))
      out = {t->vertex(0), t->vertex(1), t->vertex(2)};
    else
      out = boost::get<std::vector<Point3>>(*meet);
    for (const Point3& p : out) p.exact();
    return out;
  }

  // The two points in which an edge of one face goes through the inside of the other, and of these the one
  // first in which the segment in question begins; none where corners or edges touch. CGAL computes the same
  // points, in fractions, in ten times the time; so it is only asked about their order, which it knows
  // from intervals.
  std::optional<Meeting> ends_in_general_position(Index f, Index g, const Kernel::Segment_3& segment) const {
    const auto point = [&](Index face, int k) { return points_[pieces_[face].corners[k % 3]].data(); };
    std::array<exact::Vec, 2> ends;
    int count = 0;
    for (const auto& [of, through] : {std::pair(f, g), std::pair(g, f)}) {
      const double *a = point(through, 0), *b = point(through, 1), *c = point(through, 2);
      int side[3];
      for (int k = 0; k < 3; ++k) side[k] = orient3d(a, b, c, point(of, k));
      for (int k = 0; k < 3; ++k) {
        if (side[k] == 0) return std::nullopt;
        if (side[k] * side[(k + 1) % 3] > 0) continue;
        const double *p = point(of, k), *q = point(of, k + 1);
        const int u = orient3d(p, q, a, b), v = orient3d(p, q, b, c), w = orient3d(p, q, c, a);
        if (u == 0 || v == 0 || w == 0) return std::nullopt;
        if (u != v || v != w) continue;
        if (count == 2) return std::nullopt;
        ends[count++] = exact::piercing(p, q, a, b, c);
      }
    }
    if (count != 2) return std::nullopt;
    const Point3 source = segment.source();  // made anew: what approx() refers to lives as long as it does
    const auto may_begin = [&](const exact::Vec& x) {
      const auto& approximate = source.approx();
      bool may = true;
      for (int k = 0; k < 3; ++k) may = may && x[k] >= approximate[k].inf() && x[k] <= approximate[k].sup();
      return may;
    };
    const bool may[2] = {may_begin(ends[0]), may_begin(ends[1])};
    if (may[0] == may[1]) return std::nullopt;
    const auto lazy = [](const exact::Vec& x) { return Point3(Scalar(x[0]), Scalar(x[1]), Scalar(x[2])); };
    return Meeting{lazy(ends[may[0] ? 0 : 1]), lazy(ends[may[0] ? 1 : 0])};
  }

  void enter(Index f, Index g, const Meeting& meeting) {
    if (meeting.empty()) return;
    const auto add_segment = [&](Index p, Index q) {
      if (p == q) return;
      cuts_[f].segments.emplace_back(p, q);
      cuts_[g].segments.emplace_back(p, q);
    };
    std::vector<Index> ids;
    for (const Point3& p : meeting) ids.push_back(number(p));
    if (ids.size() == 1) {
      cuts_[f].points.push_back(ids[0]);
      cuts_[g].points.push_back(ids[0]);
      return;
    }
    if (ids.size() == 2) return add_segment(ids[0], ids[1]);
    for (std::size_t i = 0; i < ids.size(); ++i) add_segment(ids[i], ids[(i + 1) % ids.size()]);
    // Both faces must be triangulated alike inside the common polygon.
    const std::size_t apex = std::min_element(ids.begin(), ids.end()) - ids.begin();
    for (std::size_t i = 2; i + 1 < ids.size(); ++i) add_segment(ids[apex], ids[(apex + i) % ids.size()]);
  }

  Cut triangulate(Index f, const Cuts& cut) const {
    const Point3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
    const Kernel::Vector_3 normal = CGAL::cross_product(b - a, c - a);
    int drop = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(CGAL::to_double(normal[k])) > std::abs(CGAL::to_double(normal[drop]))) drop = k;
    // As doubles all may be 0.
    for (int k = 1; k < 3 && CGAL::is_zero(normal[drop]); ++k) drop = k;
    const int i = (drop + 1) % 3, j = (drop + 2) % 3;
    const auto flat = [&](const Point3& p) { return Point2(p[i], p[j]); };

    Triangulation triangulation;
    std::map<Index, Triangulation::Vertex_handle> handle;
    const auto insert = [&](Index id) {
      const auto [at, added] = handle.try_emplace(id);
      if (added) {
        at->second = triangulation.insert(flat(exact(id)));
        at->second->info().id = id;
      }
      return at->second;
    };
    for (const Index v : pieces_[f].corners) insert(v);
    for (const Index p : cut.points) insert(p);
    for (const auto& [p, q] : cut.segments) insert(p), insert(q);
    for (const auto& [p, q] : cut.segments) triangulation.insert_constraint(handle[p], handle[q]);

    Cut out;
    for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end(); ++v) {
      if (v->info().id >= 0) continue;
      // Two cuts cross here: lift the point back into the plane of the face.
      std::array<Scalar, 3> p;
      p[i] = v->point().x();
      p[j] = v->point().y();
      p[drop] = a[drop] - (normal[i] * (p[i] - a[i]) + normal[j] * (p[j] - a[j])) / normal[drop];
      out.crossings.emplace_back(p[0], p[1], p[2]);
      out.crossings.back().exact();
      v->info().id = -1 - static_cast<Index>(out.crossings.size() - 1);
    }
    const bool flipped = CGAL::is_negative(normal[drop]);
    for (auto t = triangulation.finite_faces_begin(); t != triangulation.finite_faces_end(); ++t) {
      std::array<Index, 3> corners{t->vertex(0)->info().id, t->vertex(1)->info().id, t->vertex(2)->info().id};
      if (flipped) std::swap(corners[1], corners[2]);
      out.triangles.push_back(corners);
    }
    return out;
  }

  std::vector<Eigen::Vector3d>& points_;
  std::vector<Piece>& pieces_;
  PointTable table_;
  std::vector<Index> final_;  // the complex's number of each point of the table
  std::vector<Index> added_;  // table numbers of the new points
  std::map<Index, Cuts> cuts_;
};

class Arranger {
 public:
  explicit Arranger(const Surface& surface) : surface_(surface) {}

  Result<Arrangement> run_with_tolerance(double tolerance, const RunContext& context) {
    number_input_positions();
    const double near = std::ldexp(tolerance, std::ilogb(largest_));
    const bool merged = merge_input_positions(near);
    merge();
    Index last = 0;
    for (int round = 0; round < kMostRounds; ++round) {
      const CutIf when = round == 0 && !merged ? CutIf::touching : CutIf::anything;
      Result<ToleranceRound> done = cut_with_tolerance(points_, pieces_, near, when, context);
      if (!done) return done.error();
      const Index cut = done.value().cut;
      if (when == CutIf::touching && done.value().touching == 0)
        return Error{ErrorCode::unsolved, "No parts of the surface touch each other within the tolerance."};
      if (cut == 0) {
        const std::vector<FacePair> crossing = intersections();
        if (crossing.empty()) return collect_tolerant(round + 1);
        if (auto error = Cutter(points_, pieces_).run(crossing, context)) return *error;
      }
      // Two or three rounds are the rule. Then each must cut fewer pieces than the one before, or features of
      // the tolerance's own size breed ever more of them.
      if (round > kInVain && cut > last) break;
      last = cut;
      snap(near, SnapAt::all_pieces);
      merge();
    }
    return Error{ErrorCode::unsolved, "Parts of the surface are too close together to be told apart."};
  }

  Result<Arrangement> run(const std::vector<FacePair>& pairs, const RunContext& context) {
    number_input_positions();
    std::vector<FacePair> crossing = pairs;
    for (int round = 0;; ++round) {
      if (auto error = Cutter(points_, pieces_).run(crossing, context)) return *error;
      if (round == 0)
        for (const Piece& p : pieces_) cut_faces_.push_back(p.cut ? p.sheet.face : -1);
      snap(std::ldexp(1.0, std::ilogb(largest_) + kDistances[round / kRoundsPerDistance]),
           SnapAt::cut_pieces);
      merge();
      crossing = intersections();
      if (crossing.empty()) return collect(round + 1);
      if (round + 1 == kRoundsPerDistance * std::ssize(kDistances) ||
          (round > 1 && crossing.size() > kMostCrossings * (pairs.size() + 100)))
        return Error{ErrorCode::unsolved,
                     "Where the surface crosses itself, " + std::to_string(crossing.size()) +
                         " pairs of pieces are too close together for double precision."};
    }
  }

 private:
  // Equal positions get one number, in order of appearance.
  void number_input_positions() {
    const Index n = static_cast<Index>(surface_.V.rows());
    const std::size_t mask = std::bit_ceil(2 * static_cast<std::size_t>(n) + 1) - 1;
    std::vector<Index> table(mask + 1, -1);  // by position: the first vertex there
    const auto hash = [&](Index v) {
      std::uint64_t h = 0;
      for (int k = 0; k < 3; ++k)  // -0 is 0
        h = (h ^ (h >> 29) ^ std::bit_cast<std::uint64_t>(surface_.V(v, k) + 0.0)) * 0x9e3779b97f4a7c15ull;
      return static_cast<std::size_t>(h ^ (h >> 32));
    };
    input_number_.assign(n, -1);
    for (Index v = 0; v < n; ++v) {
      std::size_t at = hash(v) & mask;
      while (table[at] >= 0 && surface_.V.row(table[at]) != surface_.V.row(v)) at = (at + 1) & mask;
      if (table[at] < 0) {
        table[at] = v;
        input_number_[v] = static_cast<Index>(points_.size());
        points_.push_back(surface_.V.row(v));
      } else {
        input_number_[v] = input_number_[table[at]];
      }
    }
    input_positions_ = static_cast<Index>(points_.size());
    largest_ = surface_.V.cwiseAbs().maxCoeff();
    for (Index f = 0; f < static_cast<Index>(surface_.F.rows()); ++f) {
      const auto face = surface_.F.row(f);
      pieces_.push_back(
          {{input_number_[face[0]], input_number_[face[1]], input_number_[face[2]]}, {f, 1}, {}, false});
    }
  }

  // Input positions closer than `near` become one, the first of them, unless they belong to one face. True if
  // any.
  bool merge_input_positions(double near) {
    std::vector<std::vector<Index>> beside(points_.size());
    for (const Piece& p : pieces_)
      for (int k = 0; k < 3; ++k) {
        beside[p.corners[k]].push_back(p.corners[(k + 1) % 3]);
        beside[p.corners[k]].push_back(p.corners[(k + 2) % 3]);
      }
    using Cell = std::array<double, 3>;
    std::map<Cell, std::vector<Index>> cells;
    std::vector<Index> to(points_.size());
    std::iota(to.begin(), to.end(), 0);
    for (Index v = 0; v < input_positions_; ++v) {
      const Eigen::Vector3d p = points_[v];
      const Cell cell{std::floor(p[0] / near), std::floor(p[1] / near), std::floor(p[2] / near)};
      double best = near;
      for (int i = 0; i < 27; ++i) {
        const auto at = cells.find({cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1});
        if (at == cells.end()) continue;
        for (const Index u : at->second)
          if (const double d = (points_[u] - p).norm(); d < best)
            if (std::none_of(beside[v].begin(), beside[v].end(), [&](Index w) { return to[w] == u; }))
              best = d, to[v] = u;
      }
      if (to[v] == v) cells[cell].push_back(v);
    }
    std::vector<Index> number(points_.size(), -1);
    std::vector<Eigen::Vector3d> kept;
    for (Index v = 0; v < input_positions_; ++v)
      if (to[v] == v) number[v] = static_cast<Index>(kept.size()), kept.push_back(points_[v]);
    for (Piece& piece : pieces_)
      for (Index& v : piece.corners) v = number[to[v]];
    for (Index& v : input_number_) v = number[to[v]];
    const bool any = kept.size() < points_.size();
    points_ = std::move(kept);
    input_positions_ = static_cast<Index>(points_.size());
    return any;
  }

  Result<Arrangement> collect_tolerant(int rounds) {
    std::vector<char> there(surface_.F.rows(), 0);
    for (const Piece& p : pieces_) {
      there[p.sheet.face] = 1;
      for (const ArrangementSheet& s : p.more) there[s.face] = 1;
      if (p.cut) cut_faces_.push_back(p.sheet.face);
    }
    cut_faces_.push_back(-1);
    if (const auto lost = std::find(there.begin(), there.end(), 0); lost != there.end())
      return Error{ErrorCode::unsolved,
                   "Face " + std::to_string(lost - there.begin()) +
                       " is thinner than the distance at which parts of the surface count as "
                       "touching."};
    Arrangement out = collect(rounds);
    out.tolerant = true;
    return out;
  }

  enum class SnapAt { cut_pieces, all_pieces };

  // Added points move onto an earlier point closer than the distance, input positions first. All others stay:
  // moving them would only make new crossings.
  void snap(double near, SnapAt where) {
    std::vector<char> used(points_.size(), 0);
    for (const Piece& piece : pieces_)
      if (piece.cut || where == SnapAt::all_pieces)
        for (const Index v : piece.corners) used[v] = 1;
    // Cells of that size: whoever is near lies in a cell next to it.
    using Cell = std::array<double, 3>;
    std::map<Cell, std::vector<Index>> cells;
    std::vector<Index> to(points_.size());
    std::iota(to.begin(), to.end(), 0);
    for (Index v = 0; v < static_cast<Index>(points_.size()); ++v) {
      if (!used[v]) continue;
      const Eigen::Vector3d p = points_[v];
      const Cell cell{std::floor(p[0] / near), std::floor(p[1] / near), std::floor(p[2] / near)};
      if (v >= input_positions_) {
        double best = near;
        for (int i = 0; i < 27; ++i) {
          const auto at = cells.find({cell[0] + i % 3 - 1, cell[1] + i / 3 % 3 - 1, cell[2] + i / 9 - 1});
          if (at == cells.end()) continue;
          for (const Index u : at->second)
            if (const double d = (points_[u] - p).norm(); d < best) best = d, to[v] = u;
        }
      }
      if (to[v] == v) cells[cell].push_back(v);
    }
    for (Piece& piece : pieces_)
      for (Index& v : piece.corners)
        if (to[v] != v) v = to[v], piece.fresh = true;
  }

  // Drops pieces that have collapsed and makes one of those that coincide; a face folded onto itself cancels.
  void merge() {
    if (points_.size() > static_cast<std::size_t>(input_positions_)) unify_equal_points();
    const Index n = static_cast<Index>(pieces_.size());
    std::vector<std::array<Index, 3>> keys(n);
    std::vector<char> gone(n, 0);
    parallel_for(n, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t i = begin; i < end; ++i) {
        auto& key = keys[i] = pieces_[i].corners;
        std::sort(key.begin(), key.end());
        gone[i] = key[0] == key[1] || key[1] == key[2] ||
                  (pieces_[i].cut &&
                   collinear(points_[key[0]].data(), points_[key[1]].data(), points_[key[2]].data()));
      }
    });
    RawVector<Index> start, order;  // pieces by their smallest corner, then by key
    group_items(static_cast<std::int64_t>(points_.size()), start, order, [&](auto visit) {
      for (Index i = 0; i < n; ++i)
        if (!gone[i]) visit(keys[i][0], i);
    });
    using Range = std::pair<Index, Index>;  // of `order`: pieces with the same key
    const std::vector<Range> same = parallel_collect<Range>(
        static_cast<std::int64_t>(points_.size()), kLightGrain,
        [&](std::int64_t begin, std::int64_t end, std::vector<Range>& ranges) {
          for (std::int64_t v = begin; v < end; ++v) {
            std::sort(order.begin() + start[v], order.begin() + start[v + 1],
                      [&](Index i, Index j) { return keys[i] != keys[j] ? keys[i] < keys[j] : i < j; });
            for (Index b = start[v], e; b < start[v + 1]; b = e) {
              for (e = b + 1; e < start[v + 1] && keys[order[e]] == keys[order[b]];) ++e;
              if (e - b > 1) ranges.emplace_back(b, e);
            }
          }
        });
    for (const auto& [b, e] : same) {
      Piece& lead = pieces_[order[b]];
      std::vector<ArrangementSheet> sheets{lead.sheet};
      sheets.insert(sheets.end(), lead.more.begin(), lead.more.end());
      for (Index k = b + 1; k < e; ++k) {
        const Piece& other = pieces_[order[k]];
        gone[order[k]] = 1;
        const auto& o = other.corners;
        const int at = o[0] == lead.corners[0] ? 0 : o[1] == lead.corners[0] ? 1 : 2;
        const int sign = o[(at + 1) % 3] == lead.corners[1] ? 1 : -1;
        const auto add = [&](ArrangementSheet s) {
          s.sign *= sign;
          const auto opposite = std::find_if(sheets.begin(), sheets.end(), [&](const ArrangementSheet& t) {
            return t.face == s.face && t.sign == -s.sign;
          });
          if (opposite != sheets.end())
            sheets.erase(opposite);
          else
            sheets.push_back(s);
        };
        add(other.sheet);
        for (const ArrangementSheet& s : other.more) add(s);
        lead.cut |= other.cut;
        lead.fresh = true;
      }
      drop_folds_at_edges(lead.corners, sheets);
      if (sheets.empty()) {
        gone[order[b]] = 1;
        continue;
      }
      lead.sheet = sheets[0];
      lead.more.assign(sheets.begin() + 1, sheets.end());
    }
    Index kept = 0;
    for (Index i = 0; i < n; ++i) {
      if (gone[i]) continue;
      if (kept != i) pieces_[kept] = std::move(pieces_[i]);
      ++kept;
    }
    pieces_.resize(kept);
  }

  // Two faces with a common edge, folded onto each other in a sliver along it: rounding has moved a point of
  // the edge across it. The faces meet along the sliver's other side instead.
  void drop_folds_at_edges(const std::array<Index, 3>& corners, std::vector<ArrangementSheet>& sheets) const {
    const auto along_common_edge = [&](Index f, Index g) {
      std::vector<Eigen::Vector3d> ends;
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
          if (surface_.F(f, i) == surface_.F(g, j)) ends.push_back(surface_.V.row(surface_.F(f, i)));
      if (ends.size() != 2) return false;
      const Eigen::Vector3d d = (ends[1] - ends[0]).normalized();
      return std::all_of(corners.begin(), corners.end(), [&](Index v) {
        const Eigen::Vector3d r = points_[v] - ends[0];
        return (r - d * d.dot(r)).norm() < std::ldexp(largest_, kDistances[1]);
      });
    };
    for (std::size_t i = 0; i < sheets.size(); ++i)
      for (std::size_t j = i + 1; j < sheets.size(); ++j) {
        if (sheets[i].sign == sheets[j].sign || !along_common_edge(sheets[i].face, sheets[j].face)) continue;
        sheets.erase(sheets.begin() + static_cast<std::ptrdiff_t>(j));
        sheets.erase(sheets.begin() + static_cast<std::ptrdiff_t>(i));
        return drop_folds_at_edges(corners, sheets);
      }
  }

  // Rounding can make points equal.
  void unify_equal_points() {
    std::map<std::array<double, 3>, Index> at;
    std::vector<char> used(points_.size(), 0);
    for (const Piece& piece : pieces_)
      if (piece.cut)
        for (const Index v : piece.corners) used[v] = 1;
    std::vector<Index> to(points_.size());
    std::iota(to.begin(), to.end(), 0);
    for (Index v = 0; v < static_cast<Index>(points_.size()); ++v)
      if (used[v]) to[v] = at.try_emplace({points_[v][0], points_[v][1], points_[v][2]}, v).first->second;
    for (Piece& piece : pieces_)
      if (piece.cut)
        for (Index& v : piece.corners) v = to[v];
  }

  // Pairs of pieces that still intersect after rounding; only what was cut can.
  std::vector<FacePair> intersections() const {
    VertexMatrix V(points_.size(), 3);
    for (std::size_t v = 0; v < points_.size(); ++v) V.row(v) = points_[v];
    TriangleMatrix F(pieces_.size(), 3);
    SelfIntersectionOptions options;
    options.active.resize(pieces_.size());
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      F.row(i) << pieces_[i].corners[0], pieces_[i].corners[1], pieces_[i].corners[2];
      options.active[i] = pieces_[i].cut;
    }
    return find_self_intersections(V, F, options);
  }

  Arrangement collect(int rounds) {
    Arrangement out;
    out.rounds = rounds;
    out.vertex_of_input = input_number_;
    out.input_positions = input_positions_;
    std::sort(cut_faces_.begin(), cut_faces_.end());
    out.cut_faces =
        static_cast<Index>(std::unique(cut_faces_.begin(), cut_faces_.end()) - cut_faces_.begin()) - 1;
    // Points that snapping left unused are dropped.
    std::vector<Index> number(points_.size(), -1);
    for (Index v = 0; v < input_positions_; ++v) number[v] = v;
    Index next = input_positions_;
    for (const Piece& p : pieces_)
      for (const Index v : p.corners)
        if (number[v] < 0) number[v] = next++;
    out.V.resize(next, 3);
    for (std::size_t v = 0; v < points_.size(); ++v)
      if (number[v] >= 0) out.V.row(number[v]) = points_[v];
    out.F.resize(pieces_.size(), 3);
    out.sheet_begin.push_back(0);
    for (std::size_t i = 0; i < pieces_.size(); ++i) {
      const Piece& p = pieces_[i];
      out.F.row(i) << number[p.corners[0]], number[p.corners[1]], number[p.corners[2]];
      out.sheets.push_back(p.sheet);
      out.sheets.insert(out.sheets.end(), p.more.begin(), p.more.end());
      out.sheet_begin.push_back(static_cast<Index>(out.sheets.size()));
    }
    return out;
  }

  const Surface& surface_;
  std::vector<Eigen::Vector3d> points_;  // the input's distinct positions, then added points
  std::vector<Piece> pieces_;
  std::vector<Index> input_number_;
  std::vector<Index> cut_faces_;
  Index input_positions_ = 0;
  double largest_ = 0;  // coordinate, in absolute value
};

}  // namespace

Result<Arrangement> arrange(const Surface& surface, const std::vector<std::pair<Index, Index>>& pairs,
                            const ArrangeOptions& options, const RunContext& context) {
  OVERTET_EXPECTS(degenerate_faces(surface).empty());
  if (options.tolerance > 0) return Arranger(surface).run_with_tolerance(options.tolerance, context);
  return Arranger(surface).run(pairs, context);
}

}  // namespace overtet
