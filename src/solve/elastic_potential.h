// What a step of an elastic body makes least: its energy, the work of outer forces, and in motion the
// incremental potential of one step in time [Kane, Marsden, Ortiz, West 2000; Gast, Schroeder, Stomakhin,
// Jiang, Teran 2015]. Internal to src/solve.
#pragma once

#include "kernels/elastic/body.h"

namespace overtet::solve_detail {

//   elastic(x) - force.(x - base) + inertia/2 |x - predicted|^2 + drag/2 |x - base|^2 + viscosity/2 (x -
//   base)' K (x - base)
//
// with squares weighed by mass, and K the stiffness at `base`. Rates are 1/h^2 (inertia) and damping over h,
// h the step.
struct ElasticPotential {
  const ElasticBody* body = nullptr;
  const Eigen::VectorXd* mass = nullptr;  // #V
  VertexMatrix force, base, predicted;    // #V x 3; predicted only where there is inertia
  double inertia = 0, drag = 0, viscosity = 0;
  ElasticBody::Tangents at_base;  // where there is viscosity
  double rounding = 0;            // a length of the gradient that is nothing but rounding

  struct Value {
    double sum = 0;
    double size = 0;  // of its terms, none of which is cancelled
  };
  // The derivative, by vertex; size: the length of its terms, in which nothing has cancelled.
  struct Slope {
    Value value;
    VertexMatrix gradient;
    double size = 0;
  };
  Slope slope(const VertexMatrix& x) const;
  // The second derivative times d; tangents: of the body, at x.
  VertexMatrix change(const ElasticBody::Tangents& tangents, const VertexMatrix& d) const;
  // The second derivative.
  void assemble(const ElasticBody::Tangents& tangents, SymmetricMatrix& A) const;
};

}  // namespace overtet::solve_detail
