#include "kernels/delaunay/delaunay.h"

#include <CGAL/Delaunay_triangulation_3.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Spatial_sort_traits_adapter_3.h>
#include <CGAL/Triangulation_cell_base_with_info_3.h>
#include <CGAL/Triangulation_vertex_base_with_info_3.h>
#include <CGAL/property_map.h>
#include <CGAL/spatial_sort.h>

#include <numeric>
#include <vector>

#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"

namespace overtet {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;
using VertexBase = CGAL::Triangulation_vertex_base_with_info_3<Index, Kernel>;
using CellBase = CGAL::Triangulation_cell_base_with_info_3<Index, Kernel,
                                                           CGAL::Delaunay_triangulation_cell_base_3<Kernel>>;
using Structure = CGAL::Triangulation_data_structure_3<VertexBase, CellBase>;
using Triangulation = CGAL::Delaunay_triangulation_3<Kernel, Structure>;

}  // namespace

struct DelaunayBuilder::State {
  Triangulation triangulation;
  Triangulation::Cell_handle near;
};

DelaunayBuilder::DelaunayBuilder() = default;
DelaunayBuilder::~DelaunayBuilder() = default;
DelaunayBuilder::DelaunayBuilder(DelaunayBuilder&&) noexcept = default;
DelaunayBuilder& DelaunayBuilder::operator=(DelaunayBuilder&&) noexcept = default;

Index DelaunayBuilder::points() const {
  return state_ ? static_cast<Index>(state_->triangulation.number_of_vertices()) : 0;
}

bool DelaunayBuilder::insert(const double* points, Index n, const std::function<bool()>& stop) {
  std::vector<Point> position;
  position.reserve(n);
  for (Index v = 0; v < n; ++v) position.emplace_back(points[3 * v], points[3 * v + 1], points[3 * v + 2]);
  std::vector<std::size_t> order(n);
  std::iota(order.begin(), order.end(), 0);
  using Map = CGAL::Pointer_property_map<Point>::type;
  CGAL::spatial_sort(order.begin(), order.end(),
                     CGAL::Spatial_sort_traits_adapter_3<Kernel, Map>(CGAL::make_property_map(position)));

  if (!state_) state_ = std::make_unique<State>();
  Triangulation& triangulation = state_->triangulation;
  const Index before = this->points();
  for (Index i = 0; i < n; ++i) {
    const bool go_on = !stop();
    if (go_on) {
      const auto v = triangulation.insert(position[order[i]], state_->near);
      v->info() = before + static_cast<Index>(order[i]);
      state_->near = v->cell();
    }
    if (!go_on || this->points() != before + i + 1) {
      state_.reset();
      return false;
    }
  }
  return true;
}

TetArrays DelaunayBuilder::tets() const {
  if (!state_ || state_->triangulation.dimension() < 3) return {};
  const Triangulation& triangulation = state_->triangulation;
  std::vector<Triangulation::Cell_handle> cells;
  cells.reserve(triangulation.number_of_cells());
  for (const Triangulation::Cell_handle c : triangulation.all_cell_handles()) {
    c->info() = triangulation.is_infinite(c) ? -1 : static_cast<Index>(cells.size());
    if (c->info() >= 0) cells.push_back(c);
  }
  TetArrays out;
  out.tet.resize(cells.size());
  out.next.resize(cells.size());
  parallel_for(static_cast<std::int64_t>(cells.size()), kLightGrain,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t t = begin; t < end; ++t)
                   for (int k = 0; k < 4; ++k) {
                     out.tet[t][k] = cells[t]->vertex(k)->info();
                     out.next[t][k] = cells[t]->neighbor(k)->info();
                   }
               });
  return out;
}

TetArrays delaunay(const double* points, Index n, const std::function<bool()>& stop) {
  DelaunayBuilder builder;
  return builder.insert(points, n, stop) ? builder.tets() : TetArrays{};
}

}  // namespace overtet
