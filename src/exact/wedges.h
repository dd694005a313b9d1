// For .cpp files only: winding numbers next to a line in which faces meet.
#pragma once

#include <optional>
#include <vector>

#include "src/exact/rays.h"

namespace overtet {

// A ray into one of the wedges around a point of a line, with what it counted.
struct Wedge {
  exact::Vec start, direction;
  std::vector<Index> skip;  // the faces that contain the start
  int winding = 0;
};

class Wedges {
 public:
  explicit Wedges(const exact::Rays& rays) : rays_(rays) {}

  // The wedge in front of both faces, at a point between from + t0 along and from + t1 along of the line
  // along u (n_f x n_g) in which they cross. None where another face contains that point, or no ray could be
  // counted.
  std::optional<Wedge> in_front(Index f, Index g, const exact::Vec& u, const exact::Vec& from,
                                const exact::Vec& along, const exact::Rational& t0,
                                const exact::Rational& t1) const;

  // All wedges around a point of a line along u where faces meet in whatever way; some may come twice.
  std::vector<Wedge> around(const exact::Whole& u, const exact::Point& m) const;

 private:
  const exact::Rays& rays_;
};

}  // namespace overtet
