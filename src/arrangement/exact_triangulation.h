// Exact constrained triangulations of a face, as both ways of cutting use them. Only for .cpp files of this
// room.
#pragma once

#define CGAL_NO_CDT_2_WARNING  // crossing constraints are meant; few cascade
#include <CGAL/Constrained_Delaunay_triangulation_2.h>
#include <CGAL/Exact_predicates_exact_constructions_kernel.h>
#include <CGAL/Triangulation_vertex_base_with_info_2.h>

#include "overtet/types.h"

namespace overtet::exact {

using Kernel = CGAL::Exact_predicates_exact_constructions_kernel;
using Point2 = Kernel::Point_2;
using Scalar = Kernel::FT;

struct VertexInfo {
  Index id = -1;  // the complex's number; -1: where two constraints cross
};
using VertexBase = CGAL::Triangulation_vertex_base_with_info_2<VertexInfo, Kernel>;
using FaceBase = CGAL::Constrained_triangulation_face_base_2<Kernel>;
using Structure = CGAL::Triangulation_data_structure_2<VertexBase, FaceBase>;
using Triangulation =
    CGAL::Constrained_Delaunay_triangulation_2<Kernel, Structure, CGAL::Exact_intersections_tag>;

}  // namespace overtet::exact
