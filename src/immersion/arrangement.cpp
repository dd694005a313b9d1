#define CGAL_NO_CDT_2_WARNING  // crossing constraints are meant; few cascade
#include "src/immersion/arrangement.h"

#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>
#include <CGAL/intersections.h>

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

namespace overtet {

namespace {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Point3 = Kernel::Point_3;
using Point2 = Kernel::Point_2;
using Scalar = Kernel::FT;

struct VertexInfo {
  Index id = -1;
};
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<VertexInfo, Kernel>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation = CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::Exact_intersections_tag>;

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
    bool operator()(const Point3& a, const Point3& b) const { return CGAL::compare_xyz(a, b) == CGAL::SMALLER; }
  };
  std::map<Point3, Index, Less> number_;
  std::vector<Point3> points_;
};

// What cuts one face: points and segments in it, by point number.
struct Cuts {
  std::vector<Index> points;
  std::vector<std::pair<Index, Index>> segments;
};

class Arranger {
 public:
  explicit Arranger(const Surface& surface) : surface_(surface) {}

  Result<Arrangement> run(const std::vector<std::pair<Index, Index>>& pairs, const RunContext& context) {
    const Index faces = static_cast<Index>(surface_.F.rows());
    number_input_positions();
    for (const auto& [f, g] : pairs) enter_corners(f), enter_corners(g);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
      if (i % 64 == 0)
        if (auto stop = context.stop()) return *stop;
      intersect(pairs[i].first, pairs[i].second);
    }
    std::vector<std::array<Index, 3>> triangles;
    std::vector<ArrangementSheet> owner;
    triangles.reserve(faces + 16 * cuts_.size());
    for (Index f = 0; f < faces; ++f) {
      const auto cut = cuts_.find(f);
      if (cut == cuts_.end()) {
        const auto face = surface_.F.row(f);
        triangles.push_back({input_number_[face[0]], input_number_[face[1]], input_number_[face[2]]});
        owner.push_back({f, 1});
      } else {
        if (auto stop = context.stop()) return *stop;
        triangulate(f, cut->second, triangles, owner);
      }
    }
    return collect(triangles, owner);
  }

 private:
  Point3 corner(Index f, int k) const {
    const auto p = surface_.V.row(surface_.F(f, k));
    return Point3(p[0], p[1], p[2]);
  }

  // Input positions come first, in order of appearance; only those that cuts touch enter the exact table.
  void number_input_positions() {
    const Index n = static_cast<Index>(surface_.V.rows());
    std::vector<Index> order(n);
    std::iota(order.begin(), order.end(), 0);
    const auto key = [&](Index v) {
      return std::array<double, 3>{surface_.V(v, 0), surface_.V(v, 1), surface_.V(v, 2)};
    };
    std::sort(order.begin(), order.end(), [&](Index a, Index b) {
      const auto ka = key(a), kb = key(b);
      return ka != kb ? ka < kb : a < b;
    });
    std::vector<Index> first(n);
    for (Index i = 0; i < n; ++i)
      first[order[i]] = i > 0 && key(order[i]) == key(order[i - 1]) ? first[order[i - 1]] : order[i];
    input_number_.assign(n, -1);
    for (Index v = 0; v < n; ++v) {
      if (first[v] == v) {
        input_number_[v] = input_positions_++;
        position_of_.push_back(v);
      } else {
        input_number_[v] = input_number_[first[v]];
      }
    }
  }

  // The number of an exact point: that of the input position, or one after all input positions.
  Index number(const Point3& p) {
    const Index i = table_.number(p);
    if (i == static_cast<Index>(final_.size())) final_.push_back(-1);
    if (final_[i] < 0) {
      final_[i] = input_positions_ + static_cast<Index>(added_.size());
      added_.push_back(i);
    }
    return final_[i];
  }

  // All corners before all cuts, so that a cut through an input position gets that position's number.
  void enter_corners(Index f) {
    for (int k = 0; k < 3; ++k) {
      const Index v = surface_.F(f, k);
      const Index i = table_.number(corner(f, k));
      if (i == static_cast<Index>(final_.size())) final_.push_back(input_number_[v]);
    }
  }

  const Point3& exact(Index number) {
    if (number >= input_positions_) return table_.point(added_[number - input_positions_]);
    const auto p = surface_.V.row(position_of_[number]);
    return table_.point(table_.number(Point3(p[0], p[1], p[2])));
  }

  Cuts& cuts(Index f) { return cuts_[f]; }

  void intersect(Index f, Index g) {
    const Kernel::Triangle_3 a(corner(f, 0), corner(f, 1), corner(f, 2));
    const Kernel::Triangle_3 b(corner(g, 0), corner(g, 1), corner(g, 2));
    const auto meet = CGAL::intersection(a, b);
    if (!meet) return;
    const auto add_segment = [&](Index p, Index q) {
      if (p == q) return;
      cuts(f).segments.emplace_back(p, q);
      cuts(g).segments.emplace_back(p, q);
    };
    if (const Point3* p = boost::get<Point3>(&*meet)) {
      const Index i = number(*p);
      cuts(f).points.push_back(i);
      cuts(g).points.push_back(i);
    } else if (const Kernel::Segment_3* s = boost::get<Kernel::Segment_3>(&*meet)) {
      add_segment(number(s->source()), number(s->target()));
    } else {
      std::vector<Point3> polygon;
      if (const Kernel::Triangle_3* t = boost::get<Kernel::Triangle_3>(&*meet))
        polygon = {t->vertex(0), t->vertex(1), t->vertex(2)};
      else
        polygon = boost::get<std::vector<Point3>>(*meet);
      std::vector<Index> ids;
      for (const Point3& p : polygon) ids.push_back(number(p));
      for (std::size_t i = 0; i < ids.size(); ++i) add_segment(ids[i], ids[(i + 1) % ids.size()]);
      // Both faces must be triangulated alike inside the common polygon.
      const std::size_t apex = std::min_element(ids.begin(), ids.end()) - ids.begin();
      for (std::size_t i = 2; i + 1 < ids.size(); ++i) add_segment(ids[apex], ids[(apex + i) % ids.size()]);
    }
  }

  void triangulate(Index f, const Cuts& cut, std::vector<std::array<Index, 3>>& triangles,
                   std::vector<ArrangementSheet>& owner) {
    const Point3 a = corner(f, 0), b = corner(f, 1), c = corner(f, 2);
    const Kernel::Vector_3 normal = CGAL::cross_product(b - a, c - a);
    int drop = 0;
    for (int k = 1; k < 3; ++k)
      if (std::abs(CGAL::to_double(normal[k])) > std::abs(CGAL::to_double(normal[drop]))) drop = k;
    if (CGAL::is_zero(normal[drop]))  // underflow of the approximation
      for (int k = 0; k < 3; ++k)
        if (!CGAL::is_zero(normal[k])) drop = k;
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
    for (int k = 0; k < 3; ++k) insert(input_number_[surface_.F(f, k)]);
    for (const Index p : cut.points) insert(p);
    for (const auto& [p, q] : cut.segments) insert(p), insert(q);
    for (const auto& [p, q] : cut.segments) triangulation.insert_constraint(handle[p], handle[q]);

    for (auto v = triangulation.finite_vertices_begin(); v != triangulation.finite_vertices_end(); ++v) {
      if (v->info().id >= 0) continue;
      // Two cuts cross here: lift the point back into the plane of the face.
      std::array<Scalar, 3> p;
      p[i] = v->point().x();
      p[j] = v->point().y();
      p[drop] = a[drop] - (normal[i] * (p[i] - a[i]) + normal[j] * (p[j] - a[j])) / normal[drop];
      v->info().id = number(Point3(p[0], p[1], p[2]));
    }
    const bool flipped = CGAL::is_negative(normal[drop]);
    for (auto t = triangulation.finite_faces_begin(); t != triangulation.finite_faces_end(); ++t) {
      std::array<Index, 3> ids{t->vertex(0)->info().id, t->vertex(1)->info().id, t->vertex(2)->info().id};
      if (flipped) std::swap(ids[1], ids[2]);
      triangles.push_back(ids);
      owner.push_back({f, 1});
    }
  }

  Arrangement collect(const std::vector<std::array<Index, 3>>& triangles, std::vector<ArrangementSheet>& owner) {
    Arrangement out;
    out.input_positions = input_positions_;
    out.vertex_of_input = input_number_;
    out.cut_faces = static_cast<Index>(cuts_.size());
    out.V.resize(input_positions_ + static_cast<Index>(added_.size()), 3);
    for (Index v = 0; v < input_positions_; ++v) out.V.row(v) = surface_.V.row(position_of_[v]);
    for (std::size_t k = 0; k < added_.size(); ++k) {
      const Point3& p = table_.point(added_[k]);
      p.exact();
      for (int c = 0; c < 3; ++c) out.V(input_positions_ + k, c) = CGAL::to_double(p[c].exact());
    }
    // Coincident triangles become one with several sheets. Even permutation = same orientation.
    struct Entry {
      std::array<Index, 3> key;
      Index triangle;
    };
    std::vector<Entry> entries(triangles.size());
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      auto key = triangles[t];
      std::sort(key.begin(), key.end());
      entries[t] = {key, static_cast<Index>(t)};
    }
    std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
      return a.key != b.key ? a.key < b.key : a.triangle < b.triangle;
    });
    std::vector<std::vector<Index>> groups_of(triangles.size());
    std::vector<char> leads(triangles.size(), 0);
    for (std::size_t b = 0; b < entries.size();) {
      std::size_t e = b + 1;
      while (e < entries.size() && entries[e].key == entries[b].key) ++e;
      leads[entries[b].triangle] = 1;
      for (std::size_t k = b + 1; k < e; ++k) groups_of[entries[b].triangle].push_back(entries[k].triangle);
      b = e;
    }
    const Index distinct = static_cast<Index>(std::count(leads.begin(), leads.end(), 1));
    out.F.resize(distinct, 3);
    out.sheet_begin.push_back(0);
    Index g = 0;
    for (std::size_t t = 0; t < triangles.size(); ++t) {
      if (!leads[t]) continue;
      const auto& lead = triangles[t];
      out.F.row(g++) << lead[0], lead[1], lead[2];
      out.sheets.push_back(owner[t]);
      for (const Index other : groups_of[t]) {
        const auto& o = triangles[other];
        const int at = o[0] == lead[0] ? 0 : o[1] == lead[0] ? 1 : 2;
        out.sheets.push_back({owner[other].face, o[(at + 1) % 3] == lead[1] ? 1 : -1});
      }
      out.sheet_begin.push_back(static_cast<Index>(out.sheets.size()));
    }
    return out;
  }

  const Surface& surface_;
  PointTable table_;
  std::vector<Index> final_;  // the arrangement's number of each point of the table
  std::vector<Index> added_;  // table numbers of the points that are no input positions
  std::vector<Index> input_number_;
  std::vector<Index> position_of_;
  Index input_positions_ = 0;
  std::map<Index, Cuts> cuts_;
};

}  // namespace

Result<Arrangement> arrange(const Surface& surface, const std::vector<std::pair<Index, Index>>& pairs,
                            const RunContext& context) {
  return Arranger(surface).run(pairs, context);
}

}  // namespace overtet
