// Fields on tet meshes that overlap themselves: what the meshes are for (Sacht et al. 2013, section 5). A
// field has a value at every node of the mesh, so it has two in a place where two layers of the solid
// overlap, and neither knows of the other.
//
// Nodes are the vertices of the mesh; of quadratic elements (order 2) also the middles of its edges, which
// follow them as in files of second order (io.h). All results are the same bytes on any number of threads.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "overtet/attributes.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// Of a place. It may be called from several threads at a time.
using ScalarFunction = std::function<double(const Eigen::Vector3d&)>;

// A function on part of the boundary: all of it, the triangles with a label, or (of values only) some
// vertices, which may lie inside, too.
struct BoundaryValue {
  std::optional<Index> label;
  std::vector<Index> vertices;
  ScalarFunction function;
};

enum class FieldEquation {
  laplace,    // Laplace(u) = 0
  poisson,    // -Laplace(u) = f
  biharmonic  // Laplace(Laplace(u)) = f; values and fluxes hold both where values are given
};

enum class LinearSolver {
  automatic,  // direct where there are few unknowns, or the equation is biharmonic
  direct,     // a Cholesky factor
  iterative   // conjugate gradients with algebraic multigrid: time and memory grow with the mesh, not faster
};

struct FieldOptions {
  FieldEquation equation = FieldEquation::laplace;
  int order = 1;  // of the elements: 1 or, but for the biharmonic equation, 2
  // Given u; where two of them meet, the later one counts. At least one a connected component of the tets.
  std::vector<BoundaryValue> values;
  // Given du/dn, along the normal that points outwards; the sum where several are given for a triangle. 0
  // elsewhere.
  std::vector<BoundaryValue> fluxes;
  ScalarFunction source;  // f; none: 0
  // Not iterative for the biharmonic equation. The iterative solver ends with a residual of 1e-12 (or, up
  // to 1e-10, as far as doubles reach); where it does not get there (tets that are very flat), the direct one
  // takes over.
  LinearSolver solver = LinearSolver::automatic;

  Status validate() const;  // Errors: usage.
};

struct Field {
  VertexMatrix nodes;                          // #N x 3
  Eigen::VectorXd values;                      // #N
  double energy = 0;                           // the integral of |grad u|^2 / 2
  LinearSolver solver = LinearSolver::direct;  // that the values are from: direct or iterative
  int iterations = 0;         // of the iterative solver, also where the direct one had to take over
  double residual = 0;        // of the linear system, relative to its right-hand side
  double factor_entries = 0;  // of the Cholesky factor; 0: there is none
  // From the mesh to the system; of the factor, or of the iterative solver's levels; to the solution.
  double seconds_assembly = 0, seconds_factor = 0, seconds_solve = 0;
};

// Galerkin's method; the biharmonic equation as two of second order (-Laplace(u) = v, -Laplace(v) = f) with a
// lumped mass matrix, the fluxes holding weakly. pre: indices are in range. Errors: usage (options; a label
// that no triangle has; a vertex that does not exist; a component of the tets without a given value),
// bad_input (a tet that is not positive; a function's value that is not finite: the message has the place),
// unsolved (the system is not positive definite in doubles), limit, interrupted.
Result<Field> solve_field(const LabelledTetMesh& mesh, const FieldOptions& options,
                          const RunContext& context = {});

struct DistanceOptions {
  // Of the heat's time, in squares of the edges' mean length (by volume), from 0.5 on: more is smoother and
  // less exact.
  double smoothing = 1;

  Status validate() const;  // Errors: usage.
};

// Geodesic distances inside the solid, which the overlap does not shorten, by the heat method [Crane,
// Weischedel, Wardetzky 2013] with linear elements: two systems that are factored once, for any number of
// sources. Heat leaves through the boundary half as fast as it would along ways that end head-on; the
// potential is found twice, and shifted so that the sources' neighbours are as far as their edges are long.
class Distances {
 public:
  // Errors: usage, bad_input (a tet that is not positive), unsolved, limit, interrupted. The mesh is not
  // kept.
  static Result<Distances> prepare(const TetMesh& mesh, const DistanceOptions& options = {},
                                   const RunContext& context = {});
  ~Distances();
  Distances(Distances&&) noexcept;
  Distances& operator=(Distances&&) noexcept;

  // By vertex: the distance from the nearest source; infinity where no way leads. Errors: usage (no source,
  // or a vertex that does not exist), limit, interrupted.
  Result<Eigen::VectorXd> from(std::span<const Index> sources, const RunContext& context = {}) const;

 private:
  struct Impl;
  explicit Distances(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace overtet
