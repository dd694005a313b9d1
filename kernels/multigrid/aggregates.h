// Small groups of unknowns that are strongly coupled: the unknowns of a coarser level.
#pragma once

#include <vector>

#include "kernels/multigrid/rows.h"

namespace overtet {

struct Aggregates {
  std::vector<Index> of;  // by unknown; -1: coupled to none, it needs no coarser level
  Index count = 0;
};

// [Vanek, Mandel, Brezina 1996, algorithm 5.1]: an unknown with all that it is strongly coupled to; what is
// left over joins the neighbour that it is coupled to most. Couplings are negative entries.
Aggregates aggregates_of(const RowMatrix& A, double strong);

// The piecewise constant prolongation, smoothed by one step of Jacobi's method with the l1 norms of A's rows,
// in which weak couplings are added to the diagonal.
RowMatrix smoothed_prolongation(const RowMatrix& A, const Aggregates& aggregates, double strong);

}  // namespace overtet
