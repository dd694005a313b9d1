#include "src/prepare/polygon_meshes.h"

#define CGAL_EIGEN3_ENABLED
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Polygon_mesh_processing/repair_degeneracies.h>
#include <CGAL/Polygon_mesh_processing/triangulate_hole.h>
#include <CGAL/Surface_mesh.h>

#include <cmath>
#include <exception>
#include <iterator>
#include <map>
#include <numbers>

#include "src/prepare/tuning.h"

namespace overtet {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;
using Vertex = Mesh::Vertex_index;
namespace Processing = CGAL::Polygon_mesh_processing;

// Vertices and faces have their numbers; false where a face does not fit.
bool build(const Surface& s, Mesh& mesh) {
  for (Index v = 0; v < s.V.rows(); ++v) mesh.add_vertex({s.V(v, 0), s.V(v, 1), s.V(v, 2)});
  const auto vertex = [](Index v) { return Vertex(static_cast<Mesh::size_type>(v)); };
  for (Index f = 0; f < s.F.rows(); ++f)
    if (mesh.add_face(vertex(s.F(f, 0)), vertex(s.F(f, 1)), vertex(s.F(f, 2))) == Mesh::null_face())
      return false;
  return true;
}

std::array<Index, 3> corners_of(const Mesh& mesh, Mesh::Face_index f) {
  std::array<Index, 3> corners{};
  int k = 0;
  for (const Vertex v : CGAL::vertices_around_face(mesh.halfedge(f), mesh))
    corners[k++] = static_cast<Index>(v.idx());
  return corners;
}

// The half-edges of a border that runs through a vertex twice can be linked in several ways: so that they go
// around the hole. Returns one of them; none where an edge is not there or has two faces.
Mesh::Halfedge_index linked_around(Mesh& mesh, const std::vector<Index>& hole) {
  std::map<std::pair<Index, Index>, Mesh::Halfedge_index> border;
  std::map<Index, std::vector<Mesh::Halfedge_index>> entering, leaving;
  for (const Mesh::Halfedge_index h : mesh.halfedges()) {
    if (!mesh.is_border(h)) continue;
    const auto from = static_cast<Index>(mesh.source(h).idx()), to = static_cast<Index>(mesh.target(h).idx());
    border[{from, to}] = h;
    entering[to].push_back(h);
    leaving[from].push_back(h);
  }
  const std::size_t n = hole.size();
  std::vector<Mesh::Halfedge_index> around;  // against the faces' direction
  for (std::size_t i = 0; i < n; ++i) {
    const auto found = border.find({hole[(i + 1) % n], hole[i]});
    if (found == border.end()) return Mesh::null_halfedge();
    around.push_back(found->second);
  }
  for (std::size_t i = 0; i < n; ++i) {  // around[i] ends at hole[i], where around[i - 1] begins
    std::vector<Mesh::Halfedge_index>&in = entering[hole[i]], &out = leaving[hole[i]];
    std::erase(in, around[i]);
    std::erase(out, around[(i + n - 1) % n]);
    mesh.set_next(around[i], around[(i + n - 1) % n]);
    // What is left, of one other hole, is linked with each other.
    for (std::size_t k = 0; k < in.size() && k < out.size(); ++k) mesh.set_next(in[k], out[k]);
  }
  return around.front();
}

bool fill(Mesh& mesh, Mesh::Halfedge_index border, Filling filling, std::vector<Mesh::Face_index>& faces) {
  std::size_t edges = 0;
  for (const auto h : CGAL::halfedges_around_face(border, mesh)) (void)h, ++edges;
  const auto options = CGAL::parameters::do_not_use_cubic_algorithm(edges > kCubicEdges);
  const auto out = std::back_inserter(faces);
  std::vector<Vertex> vertices;
  const auto also = std::back_inserter(vertices);
  switch (filling) {
    case Filling::plain:
      Processing::triangulate_hole(mesh, border, out, options);
      break;
    case Filling::refined:
      Processing::triangulate_and_refine_hole(mesh, border, out, also, options);
      break;
    case Filling::faired:
      Processing::triangulate_refine_and_fair_hole(mesh, border, out, also, options);
      break;
  }
  return !faces.empty();
}

}  // namespace

std::optional<FilledHole> filled(const Surface& around, const std::vector<Index>& hole, Filling filling) {
  try {
    Mesh mesh;
    if (!build(around, mesh)) return std::nullopt;
    const Mesh::Halfedge_index edge = linked_around(mesh, hole);
    if (edge == Mesh::null_halfedge()) return std::nullopt;
    std::vector<Mesh::Face_index> faces;
    if (!fill(mesh, edge, filling, faces)) return std::nullopt;
    FilledHole out;
    const Index given = static_cast<Index>(around.V.rows());
    for (Index v = given; v < static_cast<Index>(mesh.num_vertices()); ++v) {
      const auto& p = mesh.point(Vertex(static_cast<Mesh::size_type>(v)));
      out.points.emplace_back(p.x(), p.y(), p.z());
      if (!out.points.back().allFinite()) return std::nullopt;
    }
    for (const Mesh::Face_index f : faces) {
      out.faces.push_back(corners_of(mesh, f));
      for (Index& corner : out.faces.back())
        if (corner >= given) corner = given - 1 - corner;
    }
    return out;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {  // a precondition of CGAL's, or a number it cannot compute with
    return std::nullopt;
  }
}

std::vector<std::array<Index, 3>> without_needles(const Surface& around, const std::vector<char>& fixed,
                                                  const NeedleLimits& limits) {
  try {
    Mesh mesh;
    if (!build(around, mesh)) return {};
    auto stays = mesh.add_property_map<Vertex, bool>("v:stays", false).first;
    for (Index v = 0; v < around.V.rows(); ++v)
      stays[Vertex(static_cast<Mesh::size_type>(v))] = fixed[static_cast<std::size_t>(v)] != 0;
    const double angle = limits.degrees * std::numbers::pi / 180;
    // A needle's longest side is 1 / sin(angle) of its shortest; of a cap both small angles are small.
    Processing::experimental::remove_almost_degenerate_faces(
        faces(mesh), mesh, std::cos(std::numbers::pi - 2 * angle), 1 / std::sin(angle), limits.move,
        CGAL::parameters::vertex_is_constrained_map(stays).flip_triangle_height_threshold(limits.move));
    std::vector<std::array<Index, 3>> out;
    for (Index f = 0; f < around.F.rows(); ++f) {
      const Mesh::Face_index face(static_cast<Mesh::size_type>(f));
      out.push_back(mesh.is_removed(face) ? std::array<Index, 3>{-1, -1, -1} : corners_of(mesh, face));
    }
    return out;
  } catch (const std::bad_alloc&) {
    throw;
  } catch (const std::exception&) {
    return {};
  }
}

}  // namespace overtet
