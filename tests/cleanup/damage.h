// Damaged versions of surfaces, with what a clean-up has to make of them.
#pragma once

#include <optional>
#include <random>
#include <string>
#include <vector>

#include "overtet/cleanup.h"
#include "overtet/types.h"

namespace overtet::test {

struct Damaged {
  Surface given;
  Surface right;                     // but for the numbers of vertices, and where the corners of a face begin
  std::optional<DefectKind> beyond;  // what cannot be mended, if anything: no surface is right then
  std::int64_t count = -1;           // of it; -1: not known
};

struct Damage {
  const char* name;
  Damaged (*make)(const Surface& surface, std::mt19937_64& random);
};

// Every way to damage a surface (closed, oriented, manifold; no two vertices in one place).
const std::vector<Damage>& damages();

// Ten surfaces to damage.
struct NamedSurface {
  const char* name;
  Surface surface;
};
std::vector<NamedSurface> surfaces_to_damage();

// What is wrong: the cleaned surface's faces are not those of the right one (in the same places, with the
// same orientation), it has another number of vertices, it is not closed, oriented and manifold, or its maps
// are wrong. Empty where it is right.
std::string wrong_with(const Cleanup& cleaned, const Damaged& damaged);

// The same, where only what was given is known: the cleaned surface is closed, oriented and manifold, and its
// maps lead to faces that were given, to each once.
std::string wrong_with(const Cleanup& cleaned, const Surface& given);

}  // namespace overtet::test
