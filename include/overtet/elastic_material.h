// The laws of elastic materials that elastic.h has a choice of.
#pragma once

namespace overtet {

// Energy densities of the deformation gradient F, with Lame's parameters mu and lambda of linear elasticity,
// with which all of them agree where strains are small. J = det F.
enum class ElasticMaterial {
  // mu E:E + lambda/2 (tr E)^2, E = (F'F - I)/2. What CalculiX makes of *ELASTIC with NLGEOM. Soft under
  // strong
  // pressure: it yields where a tet is pressed to 58 % of its length.
  st_venant_kirchhoff,
  // mu |S - I|^2 + lambda/2 (tr S - 3)^2, F = R S with a rotation R: linear elasticity in a frame that turns
  // along.
  corotated,
  // mu'/2 (|F|^2 - 3) + lambda'/2 (J - a)^2 - mu'/2 log(|F|^2 + 1) [Smith, de Goes, Kim 2018, equation 14],
  // with mu' =
  // 4/3 mu, lambda' = lambda + 5/6 mu, and a such that there is no stress at rest.
  neo_hookean
};

}  // namespace overtet
