#include "src/cdt/free_points.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <iterator>
#include <numeric>
#include <utility>
#include <vector>

#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/cdt/tuning.h"

namespace overtet {

namespace {

using Point = std::array<double, 3>;

struct Cell {
  Point low{};
  double size = 0;
  std::vector<Index> vertices, faces;  // of faces, those whose boxes meet it
};

class Octree {
 public:
  Octree(const VertexMatrix& V, const TriangleMatrix& F, const RunContext& context)
      : V_(V), context_(context), box_(F.rows()) {
    parallel_for(F.rows(), kLightGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t f = begin; f < end; ++f)
        for (int k = 0; k < 3; ++k) {
          const double a = V(F(f, 0), k), b = V(F(f, 1), k), c = V(F(f, 2), k);
          box_[f].low[k] = std::min({a, b, c});
          box_[f].high[k] = std::max({a, b, c});
        }
    });
  }

  std::vector<Point> points_off() const {
    std::vector<Cell> cells;
    cells.push_back(root());
    // Enough of them first for all threads to have some.
    for (std::size_t before = 0; before < cells.size() && cells.size() < kHeavyGrain;) {
      before = cells.size();
      std::vector<std::vector<Cell>> inside(before);
      parallel_for(static_cast<std::int64_t>(before), 1, [&](std::int64_t i, std::int64_t) {
        if (!divide(cells[i], inside[i])) inside[i].push_back(std::move(cells[i]));
      });
      cells.clear();
      for (auto& list : inside) std::move(list.begin(), list.end(), std::back_inserter(cells));
    }
    return parallel_collect<Point>(static_cast<std::int64_t>(cells.size()), 1,
                                   [&](std::int64_t begin, std::int64_t end, std::vector<Point>& points) {
                                     for (std::int64_t i = begin; i < end; ++i)
                                       look_through(std::move(cells[i]), points);
                                   });
  }

 private:
  struct Box {
    Point low, high;
  };

  Cell root() const {
    Cell cell;
    for (int k = 0; k < 3; ++k) {
      cell.low[k] = V_.col(k).minCoeff();
      cell.size = std::max(cell.size, V_.col(k).maxCoeff() - cell.low[k]);
    }
    cell.vertices.resize(V_.rows());
    std::iota(cell.vertices.begin(), cell.vertices.end(), 0);
    cell.faces.resize(box_.size());
    std::iota(cell.faces.begin(), cell.faces.end(), 0);
    return cell;
  }

  void look_through(Cell cell, std::vector<Point>& points) const {
    std::vector<Cell> cells;
    cells.push_back(std::move(cell));
    while (!cells.empty() && !context_.stop()) {
      const Cell c = std::move(cells.back());
      cells.pop_back();
      if (!divide(c, cells) && c.faces.empty()) points.push_back(near_middle(c));
    }
  }

  // Adds the eighths of a cell, or returns false: it has few vertices, or many faces that only pass through.
  bool divide(const Cell& cell, std::vector<Cell>& to) const {
    if (cell.vertices.size() <= kVerticesPerCell ||
        cell.faces.size() > kFacesPerVertex * cell.vertices.size())
      return false;
    std::array<Cell, 8> child;  // by bits: in the upper half along the axis
    for (unsigned i = 0; i < 8; ++i) {
      child[i].size = cell.size / 2;
      for (int k = 0; k < 3; ++k) child[i].low[k] = cell.low[k] + (i >> k & 1) * child[i].size;
    }
    const Point middle = child[7].low;
    for (const Index v : cell.vertices) {
      unsigned i = 0;
      for (int k = 0; k < 3; ++k) i |= static_cast<unsigned>(V_(v, k) >= middle[k]) << k;
      child[i].vertices.push_back(v);
    }
    for (const Index f : cell.faces) {
      unsigned not_lower = 0, upper = 0;
      for (int k = 0; k < 3; ++k) {
        not_lower |= static_cast<unsigned>(box_[f].low[k] > middle[k]) << k;
        upper |= static_cast<unsigned>(box_[f].high[k] >= middle[k]) << k;
      }
      for (unsigned i = 0; i < 8; ++i)
        if ((i & upper) == i && (i & not_lower) == not_lower) child[i].faces.push_back(f);
    }
    std::move(child.begin(), child.end(), std::back_inserter(to));
    return true;
  }

  // Not the middles themselves: eight that lie on a sphere leave it open which tets are Delaunay, and exact
  // arithmetic, which is slow, must decide. How far depends on the place only.
  static Point near_middle(const Cell& cell) {
    std::uint64_t bits = 0;
    const auto stir = [&](std::uint64_t more) {  // the mixing step of SplitMix64 (Steele, Lea, Flood 2014)
      bits = (bits ^ more) + 0x9e3779b97f4a7c15u;
      bits = (bits ^ (bits >> 30)) * 0xbf58476d1ce4e5b9u;
      bits = (bits ^ (bits >> 27)) * 0x94d049bb133111ebu;
      bits ^= bits >> 31;
    };
    for (const double x : cell.low) stir(std::bit_cast<std::uint64_t>(x));
    Point p;
    for (int k = 0; k < 3; ++k) {
      stir(0);
      const double between = static_cast<double>(bits >> 11) * 0x1p-53;  // 0 and 1
      p[k] = cell.low[k] + cell.size * (0.5 + kOffMiddle * (between - 0.5));
    }
    return p;
  }

  const VertexMatrix& V_;
  const RunContext& context_;
  std::vector<Box> box_;
};

}  // namespace

VertexMatrix free_points(const VertexMatrix& V, const TriangleMatrix& F, const RunContext& context) {
  if (V.rows() == 0) return {};
  const std::vector<Point> points = Octree(V, F, context).points_off();
  VertexMatrix out(static_cast<Eigen::Index>(points.size()), 3);
  for (Eigen::Index i = 0; i < out.rows(); ++i)
    for (int k = 0; k < 3; ++k) out(i, k) = points[static_cast<std::size_t>(i)][k];
  return out;
}

}  // namespace overtet
