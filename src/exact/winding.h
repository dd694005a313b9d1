// The exact winding number of a surface around a point: how often the surface encloses it, with sign.
// Positive tets only ever add winding, so a point with a negative one proves that no mesh exists.
#pragma once

#include <array>
#include <memory>
#include <optional>
#include <string>

#include "kernels/bvh/bvh.h"
#include "overtet/types.h"

namespace overtet {

// Guaranteed: the number of exact arithmetic, on the very doubles. Several threads may ask at once.
// The surface (and the tree) must outlive the object and not change.
class WindingNumber {
 public:
  // pre: closed surface, finite coordinates.
  explicit WindingNumber(const Surface& surface);
  WindingNumber(const Surface& surface, const TriangleBvh& bvh);
  ~WindingNumber();
  WindingNumber(WindingNumber&&) noexcept;

  // Three doubles; none when the point lies on the surface.
  std::optional<int> at(const double* point) const;
  // Decimal integers or fractions such as "12345/65536"; none on the surface or when not a number.
  std::optional<int> at(const std::array<std::string, 3>& point) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace overtet
