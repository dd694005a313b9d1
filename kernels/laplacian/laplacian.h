// Laplace matrices of triangle meshes, as the lower triangle of a symmetric matrix, and lumped masses.
//
// Convention: positive semi-definite, L_ij = -w_ij, L_ii = sum_j w_ij, so that u' L u / 2 is the Dirichlet
// energy. Every vertex has its diagonal entry. Entries are the sum over faces in face order: the same bytes
// on any number of threads.
//
// Degenerate triangles: cotangents are computed from edge lengths or cross products with the double area
// floored at `kAreaFloor` times the longest squared edge, so that every weight is finite when every
// coordinate is. A triangle of three equal points has no weight.
#pragma once

#include <array>
#include <limits>
#include <vector>

#include "kernels/laplacian/tuning.h"
#include "kernels/sparse/cholesky.h"
#include "overtet/types.h"

namespace overtet {

// Half cotangents of the three corners of every face: #F x 3, entry k belongs to the edge opposite to
// corner k (the weight cot/2 that the face gives to that edge).
VertexMatrix half_cotangents(const VertexMatrix& V, const TriangleMatrix& F);

// Cotangent Laplacian [Pinkall and Polthier 1993]. The *summed* weight of every edge is raised to at least
// `smallest_weight`: obtuse pairs of triangles then cannot pull the wrong way (the flow stays an
// averaging), at the price of not being the Laplacian of that surface any more.
SymmetricMatrix cotangent_laplacian(const VertexMatrix& V, const TriangleMatrix& F,
                                    double smallest_weight = -std::numeric_limits<double>::infinity());

// Every edge has weight 1/sqrt(3), that of an equilateral mesh: knows nothing but the connectivity.
SymmetricMatrix uniform_laplacian(Index vertices, const TriangleMatrix& F);

// Cotangent Laplacian of the intrinsic Delaunay triangulation of the same surface [Bobenko and Springborn
// 2007; Fisher et al. 2007]: edge weights never negative (up to rounding), geometry unchanged.
// pre: every edge has at most two faces. Flips at most 30 edges per edge, then takes what it has.
SymmetricMatrix intrinsic_delaunay_laplacian(const VertexMatrix& V, const TriangleMatrix& F);

// A third of the area of the incident faces: one entry per vertex.
Eigen::VectorXd lumped_mass(const VertexMatrix& V, const TriangleMatrix& F);

double surface_area(const VertexMatrix& V, const TriangleMatrix& F);

}  // namespace overtet
