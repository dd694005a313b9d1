// What can be chosen in this room, with units and reasons.
#pragma once

namespace overtet {

// Two unknowns are strongly coupled from this share of the mean of their diagonal entries on.
constexpr double kStrongCoupling = 0.02;

// Products with the matrix that a smoother makes before, and after, it goes to the coarser level.
constexpr int kSmootherDegree = 2;

// Unknowns from which on a level is solved with a dense factor: less time than smoothing it.
constexpr int kDenseUnknowns = 300;

}  // namespace overtet
