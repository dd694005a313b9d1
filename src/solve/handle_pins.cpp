#include "src/solve/handle_pins.h"

#include <algorithm>
#include <cstdio>
#include <map>
#include <set>

#include "src/solve/layers.h"
#include "src/solve/tuning.h"

namespace overtet::solve_detail {

namespace {

using Point = Eigen::Vector3d;

std::string printed(const Point& p) {
  char text[120];
  std::snprintf(text, sizeof text, "(%.6g, %.6g, %.6g)", p[0], p[1], p[2]);
  return text;
}

Error usage_at(const Point& p, const std::string& message) {
  return {ErrorCode::usage, message, std::array<double, 3>{p[0], p[1], p[2]}};
}

class Placing {
 public:
  Placing(const TetMesh& mesh, const Handles& handles, const WeightOptions& options, const Layers& layers)
      : mesh_(mesh), handles_(handles), options_(options), layers_(layers) {}

  Result<HandlePins> pins() {
    if (Status s = place_all(); !s) return s.error();
    HandlePins out;
    out.cut_at.assign(handles_.handles.size(), 1);
    for (std::size_t h = 0; h < handles_.handles.size(); ++h)
      if (Status s = hold_handle(static_cast<int>(h), out.cut_at[h]); !s) return s.error();
    // What points and bones hold is theirs: by equal parts.
    std::map<Index, Pin> pins;
    for (const auto& [vertex, holders] : held_) {
      Pin& pin = pins[vertex];
      pin.vertex = vertex;
      pin.shared = holders.size() > 1;
      for (const int h : holders) pin.weights.emplace_back(h, 1 / static_cast<double>(holders.size()));
    }
    for (const auto& edge : handles_.cage_edges)
      if (Status s = hold_edge(edge); !s) return s.error();
    for (const auto& face : handles_.cage_faces)
      if (Status s = hold_face(face); !s) return s.error();
    for (const auto& [vertex, sum] : caged_) {
      if (pins.contains(vertex)) continue;
      Pin& pin = pins[vertex];
      pin.vertex = vertex;
      double total = 0;
      for (const auto& [h, w] : sum) total += w;
      for (const auto& [h, w] : sum)
        if (w > 0) pin.weights.emplace_back(h, w / total);
    }
    for (auto& [vertex, pin] : pins) out.pins.push_back(std::move(pin));
    return out;
  }

 private:
  Point position(int place) const {
    const HandlePlace& p = handles_.places[static_cast<std::size_t>(place)];
    return p.vertex ? Point(mesh_.V.row(*p.vertex)) : p.position;
  }
  // For messages: the first handle there.
  std::string name_of(int place) const {
    for (const Handle& h : handles_.handles)
      if (h.place == place || h.tail == place)
        return (h.bone() ? (h.place == place ? "The head of bone '" : "The tail of bone '") : "Handle '") +
               h.name + "'";
    return "Place " + std::to_string(place);
  }

  Index nearest_vertex(const Point& p, const std::vector<Index>& tets) const {
    Index nearest = -1;
    const auto look = [&](Index v) {
      const auto distance = [&](Index w) { return (mesh_.V.row(w).transpose() - p).squaredNorm(); };
      if (nearest < 0 || distance(v) < distance(nearest)) nearest = v;
    };
    for (const Index t : tets)
      for (int k = 0; k < 4; ++k) look(mesh_.T(t, k));
    if (tets.empty())
      for (Index v = 0; v < mesh_.V.rows(); ++v) look(v);
    return nearest;
  }

  // The layer of every place that is in one, or says which; then what bones and cages tell of the others.
  Status place_all() {
    tets_.resize(handles_.places.size());
    choices_.resize(handles_.places.size());
    for (std::size_t i = 0; i < tets_.size(); ++i) {
      const HandlePlace& place = handles_.places[i];
      const int n = static_cast<int>(i);
      if (place.vertex) {
        if (*place.vertex < 0 || *place.vertex >= mesh_.V.rows() ||
            (tets_[i] = layers_.around(*place.vertex)).empty())
          return Error{ErrorCode::usage, name_of(n) + " is at vertex " + std::to_string(*place.vertex) +
                                             " (counted from 0), which no tet has."};
        continue;
      }
      std::vector<std::vector<Index>> found = layers_.at(place.position);
      if (place.layer && (*place.layer < 0 || *place.layer >= std::ssize(found)))
        return usage_at(place.position, name_of(n) + " is to be in layer " + std::to_string(*place.layer) +
                                            " (counted from 0), but at " + printed(place.position) +
                                            " the solid has " + std::to_string(found.size()) + ".");
      if (place.layer)
        tets_[i] = std::move(found[static_cast<std::size_t>(*place.layer)]);
      else if (found.size() == 1)
        tets_[i] = std::move(found[0]);
      else
        choices_[i] = std::move(found);
    }
    while (follow_once()) {
    }
    return success();
  }

  // Whether a place has become known.
  bool follow_once() {
    bool any = false;
    const auto follow = [&](int a, int b) {
      const auto from = static_cast<std::size_t>(a), to = static_cast<std::size_t>(b);
      if (tets_[from].empty() || !tets_[to].empty() || choices_[to].empty()) return;
      for (const Crossed& c : layers_.segment(position(a), position(b), tets_[from]))
        if (c.end >= 1 - kInTet) tets_[to].push_back(c.tet);
      std::sort(tets_[to].begin(), tets_[to].end());
      any = any || !tets_[to].empty();
    };
    const auto both = [&](int a, int b) {
      follow(a, b);
      follow(b, a);
    };
    for (const Handle& h : handles_.handles)
      if (h.bone()) both(h.place, h.tail);
    for (const auto& [a, b] : handles_.cage_edges) both(a, b);
    for (const auto& [a, b, c] : handles_.cage_faces) {
      both(a, b);
      both(b, c);
      both(c, a);
    }
    return any;
  }

  // Errors: the place is in no layer, or nobody knows in which.
  Status require(int place) const {
    const auto i = static_cast<std::size_t>(place);
    if (!tets_[i].empty()) return success();
    const Point p = position(place);
    if (choices_[i].empty()) {
      const Index near = nearest_vertex(p, {});
      if (near < 0) return Error{ErrorCode::usage, "The mesh has no vertices."};
      char distance[40];
      std::snprintf(distance, sizeof distance, "%.3g", (mesh_.V.row(near).transpose() - p).norm());
      return usage_at(p, name_of(place) + " at " + printed(p) +
                             " is outside the solid; the nearest vertex is " + std::to_string(near) +
                             " (counted from 0), at a distance of " + distance + ".");
    }
    std::string list;
    for (std::size_t n = 0; n < choices_[i].size(); ++n) {
      const std::vector<Index>& tets = choices_[i][n];
      list += (n ? "; layer " : " layer ") + std::to_string(n) + ": tet " + std::to_string(tets[0]) +
              ", nearest vertex " + std::to_string(nearest_vertex(p, tets));
    }
    return usage_at(p, name_of(place) + " at " + printed(p) + " is in " + std::to_string(choices_[i].size()) +
                           " layers of the solid. Say which, by its number or a vertex:" + list +
                           " (all counted from 0).");
  }

  void hold(Index tet, unsigned corners, int handle) {
    for (int k = 0; k < 4; ++k)
      if (corners >> k & 1) held_[mesh_.T(tet, k)].insert(handle);
  }

  Status hold_handle(int h, double& cut_at) {
    const Handle& handle = handles_.handles[static_cast<std::size_t>(h)];
    if (Status s = require(handle.place); !s) return s;
    const Point head = position(handle.place);
    const std::vector<Index>& begin = tets_[static_cast<std::size_t>(handle.place)];
    const Point tail = handle.bone() ? position(handle.tail) : head;
    const std::vector<Crossed> way = layers_.segment(head, tail, begin);
    for (const Crossed& c : way) hold(c.tet, c.corners, h);
    return handle.bone() ? check_end(way, head, tail, "Bone '" + handle.name + "'", handle.tail, &cut_at)
                         : success();
  }

  // That a way reaches its end, in the layer that the end is in.
  Status check_end(const std::vector<Crossed>& way, const Point& head, const Point& tail,
                   const std::string& what, int end, double* cut_at) const {
    double reached = 0;
    for (const Crossed& c : way) reached = std::max(reached, c.end);
    if (reached < 1 - kInTet) {
      if (cut_at && options_.cut_bones) {
        *cut_at = reached;
        return success();
      }
      const Point p = head + reached * (tail - head);
      return usage_at(p, what + " leaves the solid at " + printed(p) +
                             "; move it, or let it go through the layer that has both of its ends.");
    }
    const std::vector<Index>& wanted = tets_[static_cast<std::size_t>(end)];
    for (const Crossed& c : way)
      if (c.end >= 1 - kInTet && std::binary_search(wanted.begin(), wanted.end(), c.tet)) return success();
    if (wanted.empty()) return success();
    return usage_at(tail, what + " ends at " + printed(tail) + " in another layer (tet " +
                              std::to_string(way.back().tet) + ") than the one that is given there (tet " +
                              std::to_string(wanted[0]) + "; counted from 0).");
  }

  void hold_linear(const std::set<Index>& vertices, const std::vector<std::pair<int, int>>& places,
                   const std::function<std::vector<double>(const Point&)>& values) {
    for (const Index v : vertices) {
      const std::vector<double> w = values(mesh_.V.row(v));
      for (std::size_t k = 0; k < places.size(); ++k) caged_[v][places[k].second] += w[k];
    }
  }

  // The point handle at a place of a cage.
  int handle_at(int place) const {
    for (std::size_t h = 0; h < handles_.handles.size(); ++h)
      if (!handles_.handles[h].bone() && handles_.handles[h].place == place) return static_cast<int>(h);
    return -1;
  }

  std::set<Index> corners_in(const std::vector<Crossed>& way) const {
    std::set<Index> out;
    for (const Crossed& c : way)
      for (int k = 0; k < 4; ++k)
        if (c.corners >> k & 1) out.insert(mesh_.T(c.tet, k));
    return out;
  }

  Status hold_edge(const std::array<int, 2>& edge) {
    const auto [a, b] = edge;
    const Point p = position(a), q = position(b), d = q - p;
    const std::vector<Crossed> way = layers_.segment(p, q, tets_[static_cast<std::size_t>(a)]);
    const int first = handle_at(a), second = handle_at(b);
    const std::string what = "The cage's edge from '" + name(first) + "' to '" + name(second) + "'";
    if (Status s = check_end(way, p, q, what, b, nullptr); !s) return s;
    hold_linear(corners_in(way), {{a, first}, {b, second}}, [&](const Point& x) {
      const double length = d.squaredNorm(),
                   s = length > 0 ? std::clamp((x - p).dot(d) / length, 0.0, 1.0) : 0;
      return std::vector<double>{1 - s, s};
    });
    return success();
  }

  Status hold_face(const std::array<int, 3>& face) {
    const std::array<Point, 3> p{position(face[0]), position(face[1]), position(face[2])};
    const std::array<int, 3> h{handle_at(face[0]), handle_at(face[1]), handle_at(face[2])};
    const std::string what =
        "The cage's face of '" + name(h[0]) + "', '" + name(h[1]) + "' and '" + name(h[2]) + "'";
    std::optional<Point> leaves;
    const std::vector<Crossed> way = layers_.triangle(p, tets_[static_cast<std::size_t>(face[0])], leaves);
    if (leaves) return usage_at(*leaves, what + " leaves the solid at " + printed(*leaves) + ".");
    for (int k = 1; k < 3; ++k) {
      const std::vector<Index>& wanted = tets_[static_cast<std::size_t>(face[k])];
      if (std::none_of(way.begin(), way.end(), [&](const Crossed& c) {
            return std::binary_search(wanted.begin(), wanted.end(), c.tet);
          }))
        return usage_at(p[k], what + " does not reach '" + name(h[k]) + "' at " + printed(p[k]) +
                                  ": it is in another layer.");
    }
    hold_linear(corners_in(way), {{face[0], h[0]}, {face[1], h[1]}, {face[2], h[2]}}, [&](const Point& x) {
      const Eigen::Vector3d w = nearest_on_triangle(p, x);
      return std::vector<double>{w[0], w[1], w[2]};
    });
    return success();
  }

  // Barycentric coordinates of the triangle's point that is nearest to x: that of its plane, or of an edge.
  static Eigen::Vector3d nearest_on_triangle(const std::array<Point, 3>& p, const Point& x) {
    const Point u = p[1] - p[0], v = p[2] - p[0], d = x - p[0];
    const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), det = uu * vv - uv * uv;
    if (det > 0) {
      const double b = (vv * d.dot(u) - uv * d.dot(v)) / det, c = (uu * d.dot(v) - uv * d.dot(u)) / det;
      if (b >= 0 && c >= 0 && b + c <= 1) return {1 - b - c, b, c};
    }
    Eigen::Vector3d best = Eigen::Vector3d::Zero();
    double least = std::numeric_limits<double>::infinity();
    for (int k = 0; k < 3; ++k) {
      const int n = (k + 1) % 3;
      const Point e = p[static_cast<std::size_t>(n)] - p[static_cast<std::size_t>(k)];
      const Point from = x - p[static_cast<std::size_t>(k)];
      const double s = e.squaredNorm() > 0 ? std::clamp(from.dot(e) / e.squaredNorm(), 0.0, 1.0) : 0;
      if (const double distance = (from - s * e).squaredNorm(); distance < least) {
        least = distance;
        best.setZero();
        best[k] = 1 - s;
        best[n] += s;
      }
    }
    return best;
  }

  const std::string& name(int h) const { return handles_.handles[static_cast<std::size_t>(h)].name; }

  const TetMesh& mesh_;
  const Handles& handles_;
  const WeightOptions& options_;
  const Layers& layers_;
  std::vector<std::vector<Index>> tets_;                  // of each place; none: not known
  std::vector<std::vector<std::vector<Index>>> choices_;  // the layers that it may be in
  std::map<Index, std::set<int>> held_;                   // by vertex: points and bones
  std::map<Index, std::map<int, double>> caged_;          // by vertex, handle: what cages say, summed
};

}  // namespace

Result<HandlePins> handle_pins(const TetMesh& mesh, const Handles& handles, const WeightOptions& options) {
  const Result<Layers> layers = Layers::of(mesh);
  if (!layers) return layers.error();
  return Placing(mesh, handles, options, layers.value()).pins();
}

}  // namespace overtet::solve_detail
