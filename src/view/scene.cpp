#include "src/view/scene.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <queue>

#include "kernels/core/tet_tables.h"
#include "kernels/tet_energy/tet_quality.h"
#include "src/view/tuning.h"

namespace overtet::view {

namespace {

using Point = Eigen::Vector3d;

Colour colour(double red, double green, double blue) {
  const auto part = [](double x) { return static_cast<std::uint8_t>(std::lround(255 * x)); };
  return {part(red), part(green), part(blue)};
}

// The mesh about the middle of its box, its radius the unit; and where its vertices are drawn, which is
// elsewhere if layers are pulled apart.
struct Places {
  VertexMatrix rest, drawn;
  Eigen::RowVector3d low = Eigen::RowVector3d::Zero(), high = low;
  Eigen::RowVector3d middle = low;
  double radius = 1;

  explicit Places(const VertexMatrix& V) {
    if (V.rows() > 0) {
      low = V.colwise().minCoeff(), high = V.colwise().maxCoeff();
      middle = low / 2 + high / 2;
      // Two steps: squares of very large and very small numbers are not numbers.
      const double half = (high / 2 - low / 2).maxCoeff();
      if (half > 0) radius = half * ((V.rowwise() - middle) / half).rowwise().norm().maxCoeff();
    }
    rest = (V.rowwise() - middle) / radius;
    drawn = rest;
  }
  Point of(const std::array<double, 3>& p) const {
    return Point((p[0] - middle[0]) / radius, (p[1] - middle[1]) / radius, (p[2] - middle[2]) / radius);
  }
  // Along the axis in which the mesh is thinnest, by how far they are along the solid.
  void pull_apart(double apart, const std::vector<Index>& elements, int corners) {
    if (apart == 0 || rest.rows() == 0) return;
    const std::vector<double> along = along_of(rest, elements, corners);
    Eigen::Index axis = 0;
    (high - low).minCoeff(&axis);
    for (Eigen::Index v = 0; v < drawn.rows(); ++v)
      drawn(v, axis) += 3 * apart * (along[static_cast<std::size_t>(v)] - .5);
  }
};

// What is kept of the mesh: a point is, if its coordinate is at most `limit`.
struct Plane {
  Eigen::Index axis = 0;
  double limit = std::numeric_limits<double>::infinity();
  bool keeps(const Places& places, Index v) const { return places.rest(v, axis) <= limit; }
  // Where the edge between two vertices, one kept, meets the plane; as drawn. The same point for both ways.
  Point meets(const Places& places, Index a, Index b) const {
    if (a > b) std::swap(a, b);
    const double x = places.rest(a, axis), y = places.rest(b, axis);
    const double t = std::clamp((limit - x) / (y - x), 0., 1.);
    return (1 - t) * places.drawn.row(a) + t * places.drawn.row(b);
  }
};

Plane plane_of(const std::optional<Cut>& cut, const Places& places) {
  if (!cut) return {};
  const double low = places.rest.col(cut->axis).minCoeff(), high = places.rest.col(cut->axis).maxCoeff();
  return {cut->axis, low + cut->share * (high - low)};
}

// ---- the camera

Point towards_of(const PictureOptions& options) {
  if (options.eye) return Point((*options.eye)[0], (*options.eye)[1], (*options.eye)[2]).stableNormalized();
  // As the page begins, or turned so that the cut is seen.
  const int axis = options.cut ? options.cut->axis : 2;
  const Point from[] = {{3.4, .8, .9}, {.9, 3.4, .8}, {.9, .8, 3.4}};
  return from[axis].normalized();
}

// Looks at all points from the given side: as near as possible without leaving one out.
Camera camera_for(const VertexMatrix& points, const Point& towards, int width, int height) {
  Camera camera;
  const Point side = std::abs(towards.y()) > .999 ? Point(0, 0, -towards.y()) : Point(0, 1, 0);
  const Point right = side.cross(towards).normalized();
  camera.up = towards.cross(right);
  const double aspect = static_cast<double>(width) / height,
               free = .94;  // of the picture; the rest is margin
  const double ty = free * std::tan(camera.height_degrees / 360 * std::numbers::pi), tx = ty * aspect;
  // A point at (x, y, z) along right, up and towards is seen if |x - cx| <= (distance - z) tx, and so on.
  const double none = -std::numeric_limits<double>::infinity();
  double right_of = none, left_of = none, above = none, below = none, nearest = none, farthest = -none;
  for (Eigen::Index v = 0; v < points.rows(); ++v) {
    const double x = points.row(v).dot(right), y = points.row(v).dot(camera.up),
                 z = points.row(v).dot(towards);
    right_of = std::max(right_of, x + z * tx), left_of = std::max(left_of, -x + z * tx);
    above = std::max(above, y + z * ty), below = std::max(below, -y + z * ty);
    nearest = std::max(nearest, z), farthest = std::min(farthest, z);
  }
  if (points.rows() == 0) right_of = left_of = tx, above = below = ty, nearest = farthest = 0;
  // Not so near that the front is seen alone where the mesh is deep.
  const double distance =
      std::max({(right_of + left_of) / (2 * tx), (above + below) / (2 * ty), nearest + .5});
  const Point centre = (right_of - left_of) / 2 * right + (above - below) / 2 * camera.up;
  camera.eye = centre + distance * towards;
  camera.target = centre;
  camera.near = (distance - nearest) * .9;
  camera.far = (distance - farthest) * 1.1 + .1;
  return camera;
}

// ---- triangles

class Drawing {
 public:
  Drawing(Scene& scene, const Places& places, const Plane& plane, const PictureOptions& options)
      : scene_(scene), places_(places), plane_(plane) {
    scene_.width = options.width, scene_.height = options.height;
    scene_.camera = camera_for(places.drawn, towards_of(options), options.width, options.height);
  }

  // A face of the boundary, as far as it is kept.
  void face(const std::array<Index, 3>& f, Index element, const Colour& colour) {
    std::array<Point, 4> polygon;
    polygon.fill(Point::Zero());
    std::size_t corners = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const Index a = f[k], b = f[(k + 1) % 3];
      const bool kept = plane_.keeps(places_, a);
      if (kept) polygon[corners++] = places_.drawn.row(a);
      if (kept != plane_.keeps(places_, b)) polygon[corners++] = plane_.meets(places_, a, b);
    }
    for (std::size_t k = 2; k < corners; ++k)
      triangle(polygon[0], polygon[k - 1], polygon[k], element, colour, SceneTriangles::From::boundary);
  }

  // What the plane cuts out of a tet: a triangle or a quadrilateral.
  template <class Tet>
  void cut(const Tet& tet, Index element, const Colour& colour) {
    std::array<int, 4> order;  // corners that are kept first
    int kept = 0, left_out = 0;
    for (int k = 0; k < 4; ++k)
      if (plane_.keeps(places_, tet[k]))
        order[static_cast<std::size_t>(kept++)] = k;
      else
        order[static_cast<std::size_t>(3 - left_out++)] = k;
    if (kept == 0 || kept == 4) return;
    const auto at = [&](std::size_t i, std::size_t j) {
      return plane_.meets(places_, tet[order[i]], tet[order[j]]);
    };
    const std::size_t corners = kept == 2 ? 4 : 3;
    std::array<Point, 4> p;
    if (kept == 1)
      p = {at(0, 1), at(0, 2), at(0, 3), at(0, 3)};
    else if (kept == 2)
      p = {at(0, 2), at(0, 3), at(1, 3), at(1, 2)};
    else
      p = {at(0, 3), at(1, 3), at(2, 3), at(2, 3)};
    // Counter-clockwise seen from what is left out, where there is a corner that is not on the plane.
    if ((p[1] - p[0]).cross(p[2] - p[0]).dot(Point(places_.drawn.row(tet[order[3]])) - p[0]) < 0)
      std::reverse(p.begin(), p.begin() + static_cast<std::ptrdiff_t>(corners));
    for (std::size_t k = 2; k < corners; ++k)
      triangle(p[0], p[k - 1], p[k], element, colour, SceneTriangles::From::cut);
    for (std::size_t k = 0; k < corners; ++k) wire(p[k], p[(k + 1) % corners]);
  }

  void end() {
    if (wires_ == 0 || wire_pixels_ / static_cast<double>(wires_) < kShortestWire) scene_.wires.clear();
  }

  void annotate(const PictureOptions& options) {
    if (options.apart > 0) return;  // they would lie where nothing is
    const auto kept = [&](const Point& p) { return p[plane_.axis] <= plane_.limit; };
    if (options.curves)
      for (const Curve& c : options.curves->curves)
        for (std::size_t i = 0; i < c.segments.size(); ++i) {
          const Point a = places_.of(c.nodes[i].position),
                      b = places_.of(c.nodes[(i + 1) % c.nodes.size()].position);
          if (kept(a) && kept(b)) add(a, scene_.lines), add(b, scene_.lines);
        }
    for (const auto& m : options.marks)
      if (const Point p = places_.of(m); kept(p)) add(p, scene_.marks);
  }

 private:
  static void add(const Point& p, std::vector<float>& to) {
    for (int k = 0; k < 3; ++k) to.push_back(static_cast<float>(p[k]));
  }

  void triangle(const Point& a, const Point& b, const Point& c, Index element, const Colour& colour,
                SceneTriangles::From from) {
    const Point normal = (b - a).cross(c - a), eye = scene_.camera.eye - (a + b + c) / 3;
    const Point towards_eye = eye.normalized();
    const double length = normal.norm();
    const bool from_inside = normal.dot(eye) < 0;
    const double shade = shade_of(length > 0 ? Point(normal / length) : towards_eye, towards_eye);
    for (const Point& p : {a, b, c}) add(p, scene_.triangles.corners);
    scene_.triangles.colours.push_back(shaded(from_inside ? inside_colour() : colour, shade));
    scene_.triangles.element.push_back(element);
    scene_.triangles.from.push_back(from);
  }

  void wire(const Point& a, const Point& b) {
    add(a, scene_.wires), add(b, scene_.wires);
    const Camera& c = scene_.camera;
    const double depth = (c.eye - (a + b) / 2).dot((c.eye - c.target).normalized());
    const double seen = 2 * depth * std::tan(c.height_degrees / 360 * std::numbers::pi);
    wire_pixels_ += (b - a).norm() / seen * scene_.height;
    ++wires_;
  }

  Scene& scene_;
  const Places& places_;
  const Plane& plane_;
  double wire_pixels_ = 0;
  std::int64_t wires_ = 0;
};

// ---- tets

struct KeyedFace {
  std::array<Index, 3> key;  // its vertices, sorted
  std::int64_t number;       // of a tet's face: 4 * tet + corner opposite; of a triangle: -1 - triangle
  bool operator<(const KeyedFace& o) const { return key != o.key ? key < o.key : number < o.number; }
};

struct BoundaryFace {
  std::int64_t face;  // 4 * tet + corner opposite
  Index triangle;     // of the attributes, -1: none
};

// Faces of one tet only, in the order of the tets; triangles belong to the faces with their vertices.
std::vector<BoundaryFace> boundary_of(const LabelledTetMesh& m) {
  std::vector<KeyedFace> faces;
  faces.reserve(static_cast<std::size_t>(4 * m.mesh.T.rows() + m.attributes.triangles.rows()));
  const auto add = [&](std::array<Index, 3> key, std::int64_t number) {
    std::sort(key.begin(), key.end());
    faces.push_back({key, number});
  };
  for (Eigen::Index t = 0; t < m.mesh.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) add(tet_face(m.mesh.T.row(t), k), 4 * t + k);
  for (Eigen::Index f = 0; f < m.attributes.triangles.rows(); ++f) {
    const auto& row = m.attributes.triangles.row(f);
    add({row[0], row[1], row[2]}, -1 - f);
  }
  std::sort(faces.begin(), faces.end());
  std::vector<BoundaryFace> boundary;
  for (std::size_t i = 0; i < faces.size();) {
    std::size_t end = i;
    Index triangle = -1;
    for (; end < faces.size() && faces[end].key == faces[i].key; ++end)
      if (faces[end].number < 0) triangle = static_cast<Index>(-1 - faces[end].number);
    std::size_t first = i;
    while (first < end && faces[first].number < 0) ++first;
    if (end - first == 1) boundary.push_back({faces[first].number, triangle});
    i = end;
  }
  std::sort(boundary.begin(), boundary.end(),
            [](const BoundaryFace& a, const BoundaryFace& b) { return a.face < b.face; });
  return boundary;
}

double least_angle(const TetMesh& mesh, Index t) {
  const auto corner = [&](int k) -> Point { return mesh.V.row(mesh.T(t, k)); };
  const auto angles = dihedral_angles(corner(0), corner(1), corner(2), corner(3));
  return *std::min_element(angles.begin(), angles.end()) * 180 / std::numbers::pi;
}

Colour colour_of(const LabelledTetMesh& m, Colouring by, Index tet, Index triangle, bool boundary) {
  const MeshAttributes& a = m.attributes;
  switch (by) {
    case Colouring::layers:
      return layer_colour(a.layers[static_cast<std::size_t>(tet)]);
    case Colouring::region:
      return group_colour(a.regions.of[static_cast<std::size_t>(tet)]);
    case Colouring::angle:
      return angle_colour(least_angle(m.mesh, tet));
    case Colouring::label:
      return triangle >= 0 ? group_colour(a.labels.of[static_cast<std::size_t>(triangle)]) : inside_colour();
    default:
      return boundary ? plain_colour() : inside_colour();
  }
}

template <class Matrix>
std::vector<Index> flat(const Matrix& m) {
  return {m.data(), m.data() + m.size()};
}

Colouring chosen(const LabelledTetMesh& m, Colouring by) {
  if (by != Colouring::automatic) return by;
  const MeshAttributes& a = m.attributes;
  if (std::any_of(a.layers.begin(), a.layers.end(), [](Index n) { return n > 1; })) return Colouring::layers;
  if (!a.labels.of.empty()) return Colouring::label;
  return a.regions.of.empty() ? Colouring::angle : Colouring::region;
}

}  // namespace

Colour plain_colour() { return colour(.55, .68, .82); }
Colour inside_colour() { return colour(.93, .78, .5); }
Colour mark_colour() { return {0xd0, 0x10, 0x40}; }

Colour group_colour(Index n) {
  // Well apart also for eyes that see red and green alike (Okabe and Ito 2008).
  static const std::array<Colour, 8> groups{colour(.34, .71, .91), colour(.9, .62, 0), colour(0, .62, .45),
                                            colour(.94, .89, .26), colour(0, .45, .7), colour(.84, .37, 0),
                                            colour(.8, .47, .65),  colour(.6, .6, .6)};
  return groups[static_cast<std::size_t>((n % 8 + 8) % 8)];
}

Colour layer_colour(Index layers) {
  return layers <= 1   ? colour(.75, .8, .85)
         : layers == 2 ? colour(.9, .55, .1)
         : layers == 3 ? colour(.75, .15, .2)
                       : colour(.4, 0, .4);
}

Colour angle_colour(double degrees) {
  const double x = std::clamp(degrees / 40, 0., 1.);
  if (x < .5) return colour(.8 + .2 * x, .1 + 1.6 * x, .1);
  return colour(1.8 - 1.8 * x, 1.3 - .8 * x, .1 + 1.4 * (x - .5));
}

Colour shaded(const Colour& c, double shade) {
  Colour out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = static_cast<std::uint8_t>(std::lround(shade * c[k]));
  return out;
}

double shade_of(const Eigen::Vector3d& normal, const Eigen::Vector3d& towards_eye) {
  return .4 + .6 * std::abs(normal.dot(towards_eye));
}

std::vector<double> along_of(const VertexMatrix& V, const std::vector<Index>& elements, int corners) {
  const auto vertices = static_cast<std::size_t>(V.rows());
  std::vector<std::int64_t> first(vertices + 1, 0);
  const auto each_pair = [&](const auto& visit) {
    for (std::size_t i = 0; i < elements.size(); i += static_cast<std::size_t>(corners))
      for (int p = 0; p < corners; ++p)
        for (int q = p + 1; q < corners; ++q)
          visit(static_cast<std::size_t>(elements[i + static_cast<std::size_t>(p)]),
                static_cast<std::size_t>(elements[i + static_cast<std::size_t>(q)]));
  };
  each_pair([&](std::size_t a, std::size_t b) { ++first[a + 1], ++first[b + 1]; });
  for (std::size_t v = 0; v < vertices; ++v) first[v + 1] += first[v];
  std::vector<std::size_t> to(static_cast<std::size_t>(first[vertices]));
  std::vector<std::int64_t> at(first.begin(), first.end() - 1);
  each_pair([&](std::size_t a, std::size_t b) {
    to[static_cast<std::size_t>(at[a]++)] = b;
    to[static_cast<std::size_t>(at[b]++)] = a;
  });
  // Dijkstra's algorithm; what it reaches, in the order of the distances.
  std::vector<double> distance(vertices, -1), along(vertices, 0);
  std::vector<std::size_t> reached;
  const auto spread = [&](std::size_t start) {
    for (const std::size_t v : reached) distance[v] = -1;
    reached.clear();
    std::priority_queue<std::pair<double, std::size_t>, std::vector<std::pair<double, std::size_t>>,
                        std::greater<>>
        waiting;
    waiting.emplace(0, start);
    while (!waiting.empty()) {
      const auto [d, v] = waiting.top();
      waiting.pop();
      if (distance[v] >= 0) continue;
      distance[v] = d;
      reached.push_back(v);
      for (std::int64_t i = first[v]; i < first[v + 1]; ++i) {
        const std::size_t w = to[static_cast<std::size_t>(i)];
        if (distance[w] < 0)
          waiting.emplace(
              d + (V.row(static_cast<Eigen::Index>(v)) - V.row(static_cast<Eigen::Index>(w))).norm(), w);
      }
    }
  };
  std::vector<char> done(vertices, 0);
  for (std::size_t v = 0; v < vertices; ++v) {
    if (done[v] || first[v] == first[v + 1]) continue;
    spread(v);
    spread(reached.back());
    const double most = distance[reached.back()];
    for (const std::size_t w : reached) {
      done[w] = 1;
      along[w] = most > 0 ? distance[w] / most : 0;
    }
    reached.clear();  // the next component has vertices of its own
  }
  return along;
}

Scene scene_of(const LabelledTetMesh& m, const PictureOptions& options) {
  Places places(m.mesh.V);
  const Plane plane = plane_of(m.mesh.V.rows() > 0 ? options.cut : std::nullopt, places);
  if (options.apart > 0) places.pull_apart(options.apart, flat(m.mesh.T), 4);
  Scene scene;
  Drawing drawing(scene, places, plane, options);
  const Colouring by = chosen(m, options.colouring);
  for (const BoundaryFace& b : boundary_of(m)) {
    const auto tet = static_cast<Index>(b.face / 4);
    drawing.face(tet_face(m.mesh.T.row(tet), static_cast<int>(b.face % 4)), tet,
                 colour_of(m, by, tet, b.triangle, true));
  }
  if (options.cut)
    for (Index t = 0; t < static_cast<Index>(m.mesh.T.rows()); ++t)
      drawing.cut(m.mesh.T.row(t), t, colour_of(m, by, t, -1, false));
  drawing.end();
  drawing.annotate(options);
  return scene;
}

Scene scene_of(const Surface& s, const SurfaceAttributes& attributes, const PictureOptions& options) {
  Places places(s.V);
  const Plane plane = plane_of(s.V.rows() > 0 ? options.cut : std::nullopt, places);
  if (options.apart > 0) places.pull_apart(options.apart, flat(s.F), 3);
  Scene scene;
  Drawing drawing(scene, places, plane, options);
  const std::vector<Index>& labels = attributes.faces.of;
  const bool by_label = !labels.empty() && options.colouring != Colouring::plain;
  for (Index f = 0; f < static_cast<Index>(s.F.rows()); ++f)
    drawing.face({s.F(f, 0), s.F(f, 1), s.F(f, 2)}, f,
                 by_label ? group_colour(labels[static_cast<std::size_t>(f)]) : plain_colour());
  drawing.annotate(options);
  return scene;
}

}  // namespace overtet::view
