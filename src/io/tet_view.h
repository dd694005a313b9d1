// A tet mesh as the writers see it: with what goes into the file besides, of first or second order. Internal
// to src/io.
#pragma once

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "overtet/io.h"
#include "src/io/file.h"

namespace overtet::io_detail {

using SixMatrix = Eigen::Matrix<Index, Eigen::Dynamic, 6, Eigen::RowMajor>;

class TetView {
 public:
  // Both must outlive the view.
  TetView(const TetMesh& mesh, const MeshAttributes& attributes, int order);

  const TetMesh& mesh;
  const MeshAttributes& attributes;

  bool second_order() const { return second_; }
  std::int64_t vertices() const { return mesh.V.rows() + middle_.rows(); }
  std::int64_t tets() const { return mesh.T.rows(); }
  std::int64_t triangles() const { return attributes.triangles.rows(); }
  Index label(std::int64_t f) const { return value(attributes.labels.of, f); }
  Index region(std::int64_t t) const { return value(attributes.regions.of, t); }

  // The vertices, those in the middle of edges last.
  double coordinate(std::int64_t v, int k) const {
    return v < mesh.V.rows() ? mesh.V(v, k) : middle_(v - mesh.V.rows(), k);
  }
  TextBuffer& coordinates(TextBuffer& out, std::int64_t v) const {
    return out.number(coordinate(v, 0))
        .character(' ')
        .number(coordinate(v, 1))
        .character(' ')
        .number(coordinate(v, 2));
  }
  // A corner, or from 4 on a vertex in the middle of an edge: as kMiddleOf has them (mesh_parts.h).
  Index tet(std::int64_t t, int k) const { return k < 4 ? mesh.T(t, k) : middle_of_tet_(t, k - 4); }
  // A corner, or from 3 on a vertex in the middle of an edge.
  Index triangle(std::int64_t f, int k) const;

  // Counted from `first`, with blanks between them; edges in the order that is given.
  TextBuffer& tet(TextBuffer& out, std::int64_t t, Index first,
                  const std::array<int, 6>& edges = {0, 1, 2, 3, 4, 5}) const;
  TextBuffer& triangle(TextBuffer& out, std::int64_t f, Index first) const;

 private:
  static Index value(const std::vector<Index>& values, std::int64_t i) {
    return values.empty() ? 1 : values[static_cast<std::size_t>(i)];
  }
  void add_middles();
  Index middle(Index a, Index b) const;

  bool second_;
  std::vector<std::int64_t> first_edge_;  // of each vertex: its edges to larger ones
  std::vector<Index> other_end_;          // sorted
  VertexMatrix middle_;
  SixMatrix middle_of_tet_;
};

// The values that occur, in order, and how often: labels, regions.
std::map<Index, std::int64_t> occurring(std::int64_t n, const std::vector<Index>& values);

// Writers. What a format has no place for is left out.
void write_medit(TextWriter& out, const TetView& m);
void write_gmsh22(TextWriter& out, const TetView& m);
void write_gmsh41(TextWriter& out, const TetView& m);
void write_vtu(TextWriter& out, const TetView& m);
void write_vtk(TextWriter& out, const TetView& m);
void write_boundary_vtp(TextWriter& out, const TetView& m);
void write_surface_vtp(TextWriter& out, const TetView& m);  // all vertices, and labels only if there are any
void write_abaqus(TextWriter& out, const TetView& m);
void write_node(TextWriter& out, const TetView& m);
void write_ele(TextWriter& out, const TetView& m);
void write_face(TextWriter& out, const TetView& m);

}  // namespace overtet::io_detail
