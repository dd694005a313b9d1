#include "tests/cleanup/damage.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <functional>
#include <map>
#include <numeric>
#include <set>

#include "tests/support/models.h"

namespace overtet::test {

namespace {

using Random = std::mt19937_64;

Index below(Random& random, Eigen::Index n) {
  return static_cast<Index>(random() % static_cast<std::uint64_t>(n));
}

std::vector<Index> some_faces(const Surface& s, Eigen::Index n, Random& random) {
  std::vector<Index> all(s.F.rows());
  std::iota(all.begin(), all.end(), 0);
  std::shuffle(all.begin(), all.end(), random);
  all.resize(static_cast<std::size_t>(std::clamp<Eigen::Index>(n, 1, s.F.rows())));
  return all;
}

void turn(Surface& s, Index f) { std::swap(s.F(f, 1), s.F(f, 2)); }

// Of each vertex: the smallest vertex of its component.
std::vector<int> components(const Surface& s) {
  std::vector<int> of(s.V.rows());
  std::iota(of.begin(), of.end(), 0);
  for (bool changed = true; changed;) {
    changed = false;
    for (Index f = 0; f < s.F.rows(); ++f) {
      const int least = std::min({of[s.F(f, 0)], of[s.F(f, 1)], of[s.F(f, 2)]});
      for (int k = 0; k < 3; ++k) changed = changed || of[s.F(f, k)] != least, of[s.F(f, k)] = least;
    }
  }
  return of;
}

std::vector<int> components_of(const Surface& s) {
  const std::vector<int> of = components(s);
  std::vector<int> faces(s.F.rows());
  for (Index f = 0; f < s.F.rows(); ++f) faces[f] = of[s.F(f, 0)];
  return faces;
}

// Every face gets vertices of its own.
Damaged unwelded(const Surface& s, Random&) {
  Damaged d{{VertexMatrix(3 * s.F.rows(), 3), s.F}, s, {}, -1};
  for (Index c = 0; c < 3 * s.F.rows(); ++c) {
    d.given.V.row(c) = s.V.row(s.F(c / 3, c % 3));
    d.given.F(c / 3, c % 3) = c;
  }
  return d;
}

// Some faces get vertices of their own, as at the seams of a texture; with the other zero.
Damaged seams(const Surface& s, Random& random) {
  Damaged d{s, s, {}, -1};
  std::vector<std::array<Index, 2>> corners;
  for (const Index f : some_faces(s, s.F.rows() / 7, random))
    for (int k = 0; k < 3; ++k) corners.push_back({f, k});
  const Eigen::Index n = s.V.rows();
  d.given.V.conservativeResize(n + static_cast<Eigen::Index>(corners.size()), 3);
  for (std::size_t i = 0; i < corners.size(); ++i) {
    const auto [f, k] = corners[i];
    Eigen::RowVector3d p = s.V.row(s.F(f, k));
    for (double& x : p)
      if (x == 0) x = -x;
    d.given.V.row(n + static_cast<Eigen::Index>(i)) = p;
    d.given.F(f, k) = static_cast<Index>(n + static_cast<Eigen::Index>(i));
  }
  return d;
}

// Fewer than half of the faces of each component are turned.
Damaged some_turned(const Surface& s, Random& random) {
  Damaged d{s, s, {}, -1};
  const std::vector<int> component = components_of(s);
  std::map<int, Index> left;
  for (const int c : component) ++left[c];
  for (auto& [c, n] : left) n = (n - 1) / 2;
  for (const Index f : some_faces(s, s.F.rows() / 3, random))
    if (left[component[f]]-- > 0) turn(d.given, f);
  return d;
}

// The whole model faces inwards.
Damaged all_turned(const Surface& s, Random&) {
  Damaged d{s, s, {}, -1};
  for (Index f = 0; f < s.F.rows(); ++f) turn(d.given, f);
  return d;
}

// The first component faces inwards, the others stay as they are.
Damaged first_component_turned(const Surface& s, Random&) {
  Damaged d{s, s, {}, -1};
  const std::vector<int> component = components_of(s);
  for (Index f = 0; f < s.F.rows(); ++f)
    if (component[f] == component[0]) turn(d.given, f);
  return d;
}

// Faces put in between the others.
Damaged with_faces(const Surface& s, const std::vector<std::array<Index, 3>>& more, Random& random) {
  std::vector<std::array<Index, 3>> all;
  for (Index f = 0; f < s.F.rows(); ++f) all.push_back({s.F(f, 0), s.F(f, 1), s.F(f, 2)});
  for (const auto& f : more)
    all.insert(all.begin() + below(random, static_cast<Eigen::Index>(all.size()) + 1), f);
  Damaged d{{s.V, TriangleMatrix(static_cast<Eigen::Index>(all.size()), 3)}, s, {}, -1};
  for (std::size_t f = 0; f < all.size(); ++f)
    for (int k = 0; k < 3; ++k) d.given.F(static_cast<Index>(f), k) = all[f][k];
  return d;
}

Damaged repeated(const Surface& s, Random& random) {
  std::vector<std::array<Index, 3>> more;
  for (const Index f : some_faces(s, s.F.rows() / 9, random)) {
    const int k = below(random, 3);
    more.push_back({s.F(f, k), s.F(f, (k + 1) % 3), s.F(f, (k + 2) % 3)});
  }
  return with_faces(s, more, random);
}

// Copies that run the other way.
Damaged repeated_and_turned(const Surface& s, Random& random) {
  std::vector<std::array<Index, 3>> more;
  for (const Index f : some_faces(s, s.F.rows() / 9, random))
    more.push_back({s.F(f, 0), s.F(f, 2), s.F(f, 1)});
  return with_faces(s, more, random);
}

Damaged repeated_corners(const Surface& s, Random& random) {
  std::vector<std::array<Index, 3>> more;
  for (int i = 0; i < 5; ++i) {
    const Index a = below(random, s.V.rows()), b = below(random, s.V.rows());
    more.push_back(i % 3 == 0 ? std::array{a, a, b} : i % 3 == 1 ? std::array{a, b, a} : std::array{a, b, b});
  }
  return with_faces(s, more, random);
}

Damaged unused(const Surface& s, Random& random) {
  Damaged d{s, s, {}, -1};
  for (int i = 0; i < 5; ++i) {
    const Index at = below(random, d.given.V.rows() + 1);
    VertexMatrix V(d.given.V.rows() + 1, 3);
    V << d.given.V.topRows(at), Eigen::RowVector3d(9, 9, i), d.given.V.bottomRows(d.given.V.rows() - at);
    d.given.V = V;
    d.given.F = d.given.F.unaryExpr([&](Index v) { return v >= at ? v + 1 : v; });
  }
  return d;
}

// Two vertices far from each other become one.
Damaged pinched(const Surface& s, Random& random) {
  // Of the last component: a dent in another one would let its cavity out.
  const std::vector<int> component = components(s);
  Index a = below(random, s.V.rows());
  while (component[a] != component.back()) a = (a + 1) % static_cast<Index>(s.V.rows());
  std::vector<char> near(s.V.rows(), 0);
  for (int ring = 0; ring < 4; ++ring) {
    std::vector<char> next = near;
    next[a] = 1;
    for (Index f = 0; f < s.F.rows(); ++f)
      for (int k = 0; k < 3; ++k)
        if (near[s.F(f, k)] || s.F(f, k) == a)
          for (int j = 0; j < 3; ++j) next[s.F(f, j)] = 1;
    near = next;
  }
  for (Index v = 0; v < s.V.rows(); ++v) near[v] = near[v] || component[v] != component[a];
  Index b = below(random, s.V.rows());
  for (Index tries = 0; near[b] && tries < s.V.rows(); ++tries) b = (b + 1) % static_cast<Index>(s.V.rows());
  Damaged d{s, s, {}, -1};
  if (near[b]) return d;
  d.right.V.row(b) = s.V.row(a);
  d.given.F = s.F.unaryExpr([&](Index v) { return v == b ? a : v; });
  return d;
}

// A second one, mirrored at an edge, which they share: a point reflection at a line keeps the orientation.
Damaged touching(const Surface& s, Random& random) {
  const Index f = below(random, s.F.rows()), a = s.F(f, 0), b = s.F(f, 1);
  const Eigen::RowVector3d o = s.V.row(a), axis = (s.V.row(b) - s.V.row(a)).normalized();
  Surface other = s;
  for (Index v = 0; v < s.V.rows(); ++v) {
    if (v == a || v == b) continue;
    const Eigen::RowVector3d p = s.V.row(v) - o;
    other.V.row(v) = o + 2 * p.dot(axis) * axis - p;
  }
  Damaged d{joined(s, other), joined(s, other), {}, -1};
  const Index n = static_cast<Index>(s.V.rows());
  d.given.F = d.given.F.unaryExpr([&](Index v) { return v == n + a ? a : v == n + b ? b : v; });
  return d;
}

Damaged one_missing(const Surface& s, Random& random) {
  Damaged d{s, s, DefectKind::hole, 1};
  const Index f = below(random, s.F.rows());
  d.given.F.row(f) = s.F.row(s.F.rows() - 1);
  d.given.F.conservativeResize(s.F.rows() - 1, 3);
  return d;
}

// A face on an edge that has two already.
Damaged third_face(const Surface& s, Random& random) {
  const Index f = below(random, s.F.rows());
  Damaged d = with_faces(s, {{s.F(f, 0), s.F(f, 1), static_cast<Index>(s.V.rows())}}, random);
  d.given.V.conservativeResize(s.V.rows() + 1, 3);
  d.given.V.row(s.V.rows()) << 7, 8, 9;
  d.beyond = DefectKind::odd_edge;
  d.count = 1;
  return d;
}

Damaged everything(const Surface& s, Random& random) {
  Damaged d = some_turned(s, random);
  for (const auto damage : {repeated, repeated_corners, seams, unused})
    d.given = damage(d.given, random).given;
  return d;
}

Damaged everything_as_soup(const Surface& s, Random& random) {
  Damaged d = everything(s, random);
  d.given = unwelded(d.given, random).given;
  return d;
}

// So that products of three coordinates leave the range of doubles.
Damaged scaled(const Surface& s, Random& random) {
  Damaged d = everything_as_soup(s, random);
  const double factor = random() % 2 == 0 ? 0x1p+400 : 0x1p-400;
  for (Index f = 0; f < d.given.F.rows(); ++f) turn(d.given, f);
  d.given.V *= factor;
  d.right.V *= factor;
  return d;
}

// As a multiset: coordinates of the corners, the smallest first.
using Triangle = std::array<double, 9>;
Triangle triangle(const Surface& s, Index f) {
  Triangle best{};
  for (int start = 0; start < 3; ++start) {
    Triangle t;
    for (int k = 0; k < 3; ++k)
      for (int i = 0; i < 3; ++i) t[3 * k + i] = s.V(s.F(f, (start + k) % 3), i) + 0.0;
    if (start == 0 || t < best) best = t;
  }
  return best;
}
std::vector<Triangle> triangles(const Surface& s) {
  std::vector<Triangle> all;
  for (Index f = 0; f < s.F.rows(); ++f) all.push_back(triangle(s, f));
  std::sort(all.begin(), all.end());
  return all;
}

// Every vertex has one fan, every edge two faces that run along it in opposite directions.
bool is_manifold(const Surface& s) {
  if (!is_closed_oriented(s)) return false;
  std::map<std::array<Index, 2>, Index> third;
  std::vector<Index> faces_at(s.V.rows(), 0), some(s.V.rows(), -1);
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      third[{s.F(f, k), s.F(f, (k + 1) % 3)}] = s.F(f, (k + 2) % 3);
      ++faces_at[s.F(f, k)];
      some[s.F(f, k)] = s.F(f, (k + 1) % 3);
    }
  for (Index v = 0; v < s.V.rows(); ++v) {
    if (faces_at[v] == 0) return false;
    Index n = 0, at = some[v];
    do {
      at = third.at({v, at});
      ++n;
    } while (at != some[v] && n <= faces_at[v]);
    if (n != faces_at[v]) return false;
  }
  return true;
}

std::string wrong_with_maps(const Cleanup& c, const Surface& given) {
  const Surface& s = c.surface;
  if (c.vertex_of.empty() ? s.V.rows() != given.V.rows()
                          : static_cast<Index>(c.vertex_of.size()) != s.V.rows())
    return "the map of vertices has another size";
  if (c.face_of.empty() ? s.F.rows() != given.F.rows() : static_cast<Index>(c.face_of.size()) != s.F.rows())
    return "the map of faces has another size";
  const auto vertex = [&](Index v) { return c.vertex_of.empty() ? v : c.vertex_of[v]; };
  for (Index v = 0; v < s.V.rows(); ++v)
    for (int k = 0; k < 3; ++k)
      if (std::bit_cast<std::uint64_t>(s.V(v, k)) != std::bit_cast<std::uint64_t>(given.V(vertex(v), k)))
        return "vertex " + std::to_string(v) + " is not where the map says";
  for (Index f = 0; f < s.F.rows(); ++f) {
    const Index g = c.face_of.empty() ? f : c.face_of[f];
    const bool turned = std::binary_search(c.turned.begin(), c.turned.end(), f);
    for (int k = 0; k < 3; ++k)
      if (s.V.row(s.F(f, k)) != given.V.row(given.F(g, turned ? (3 - k) % 3 : k)))
        return "face " + std::to_string(f) + " is not the one that the map says";
  }
  for (const auto& [from, to] : c.merged)
    if (given.V.row(from) != s.V.row(to))
      return "vertex " + std::to_string(from) + " was merged with another place";
  return {};
}

}  // namespace

const std::vector<Damage>& damages() {
  static const std::vector<Damage> all = {{"unwelded", unwelded},
                                          {"seams", seams},
                                          {"some_turned", some_turned},
                                          {"all_turned", all_turned},
                                          {"first_component_turned", first_component_turned},
                                          {"repeated", repeated},
                                          {"repeated_and_turned", repeated_and_turned},
                                          {"repeated_corners", repeated_corners},
                                          {"unused", unused},
                                          {"pinched", pinched},
                                          {"touching", touching},
                                          {"one_missing", one_missing},
                                          {"third_face", third_face},
                                          {"everything", everything},
                                          {"everything_as_soup", everything_as_soup},
                                          {"scaled", scaled}};
  return all;
}

std::vector<NamedSurface> surfaces_to_damage() {
  return {{"sphere", sphere(2)},
          {"torus", torus(12, 8)},
          {"capsule", capsule(3, 0.5, 8)},
          {"box", box(3)},
          {"slab", slab(2, 2)},
          {"curled_worm", curled_worm(420, 8)},
          {"bent_slab", bent_slab(2, 400, 3)},
          {"two_spheres", two_spheres(1)},
          {"elbow", elbow(150, 10)},
          {"sphere_with_cavity", sphere_with_cavity(1)}};
}

std::string wrong_with(const Cleanup& cleaned, const Damaged& damaged) {
  if (damaged.beyond) {
    if (!cleaned.problem) return "a surface that cannot be cleaned was";
    for (const Defect& d : cleaned.defects)
      if (d.kind == *damaged.beyond)
        return damaged.count < 0 || d.count == damaged.count ? "" : "another number of defects was found";
    return "the defect was not found";
  }
  if (cleaned.problem) return cleaned.problem->message;
  if (cleaned.surface.V.rows() != damaged.right.V.rows())
    return std::to_string(cleaned.surface.V.rows()) + " vertices instead of " +
           std::to_string(damaged.right.V.rows());
  if (triangles(cleaned.surface) != triangles(damaged.right)) return "the faces are others";
  return wrong_with(cleaned, damaged.given);
}

std::string wrong_with(const Cleanup& cleaned, const Surface& given) {
  if (!is_manifold(cleaned.surface)) return "the surface is not closed, oriented and manifold";
  if (std::adjacent_find(cleaned.face_of.begin(), cleaned.face_of.end(), std::greater_equal<>()) !=
      cleaned.face_of.end())
    return "a face is there twice, or in another order";
  return wrong_with_maps(cleaned, given);
}

}  // namespace overtet::test
