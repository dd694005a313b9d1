// Sparse matrices made row by row, by all threads: the same bytes on any number of them. Only for .cpp files
// of rooms that link `parallel`.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/sparse/row_sums.h"

namespace overtet {

// outer x inner (of column-major matrices: outer columns). sum(i, sums) adds what row i has.
template <class Matrix, class Sum>
Matrix matrix_of_rows(std::int64_t outer, std::int64_t inner, Sum&& sum) {
  constexpr std::int64_t grain = kMediumGrain;
  struct Block {
    std::vector<Index> columns;
    std::vector<double> values;
  };
  std::vector<Block> blocks(static_cast<std::size_t>((outer + grain - 1) / grain));
  Matrix A = Matrix::IsRowMajor ? Matrix(outer, inner) : Matrix(inner, outer);
  int* const start = A.outerIndexPtr();
  parallel_for(outer, grain, [&](std::int64_t begin, std::int64_t end) {
    Block& block = blocks[static_cast<std::size_t>(begin / grain)];
    RowSums sums;
    for (std::int64_t i = begin; i < end; ++i) {
      sum(static_cast<Index>(i), sums);
      start[i + 1] = sums.take(block.columns, block.values);
    }
  });
  for (std::int64_t i = 0; i < outer; ++i) start[i + 1] += start[i];
  A.resizeNonZeros(start[outer]);
  parallel_for(outer, grain, [&](std::int64_t begin, std::int64_t) {
    Block& block = blocks[static_cast<std::size_t>(begin / grain)];
    std::copy(block.columns.begin(), block.columns.end(), A.innerIndexPtr() + start[begin]);
    std::copy(block.values.begin(), block.values.end(), A.valuePtr() + start[begin]);
    block = {};
  });
  return A;
}

}  // namespace overtet
