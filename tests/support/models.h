// Surfaces made for the tests: closed, manifold, oriented outward. Nothing here comes from a file.
#pragma once

#include <Eigen/Core>
#include <cstdint>

#include "overtet/types.h"

namespace overtet::test {

// Clean ones.
Surface sphere(int subdivisions = 2, double radius = 1,
               const Eigen::Vector3d& centre = Eigen::Vector3d::Zero());  // 20 * 4^subdivisions faces
Surface torus(int around = 32, int across = 16, double major = 1, double minor = 0.4);
Surface capsule(double length = 4, double radius = 0.5, int around = 16);
Surface box(int cells = 4);                           // the unit cube, cells x cells squares on each side
Surface slab(int holes = 2, int cells_per_hole = 3);  // a flat plate with a row of holes: genus `holes`

// Crossing ones that have a solution. No hinges (vertices whose one-ring crosses itself) unless said.
// A capsule rolled up by more than one turn, its end running into its beginning: winding 2 there.
Surface curled_worm(double degrees = 420, int around = 16, double radius = 0.3);
// The slab rolled up in the same way: genus `holes`.
Surface bent_slab(int holes = 3, double degrees = 400, int cells_per_hole = 4);
// Two spheres that cross each other (two components).
Surface two_spheres(int subdivisions = 2, double distance = 1.1);
// A capped cylinder bent so sharply that its inner side folds through itself: has hinges.
Surface elbow(double degrees = 150, int around = 24, double blend = 0.5);

// One without a solution: a squashed sphere whose top is pushed out through its bottom, where the
// winding number becomes -1.
Surface saucer(int subdivisions = 3, double depth = 0.9);

// Another one: a ball whose top has a fold around it, pressed flat onto the plane z = 0.3 (three layers where
// the fold was); and its mirror image above, so that the flat parts lie on each other.
Surface pressed_fold(int subdivisions = 2);
Surface mirrored_folds(int subdivisions = 2);

// A sphere with a spherical hole inside (second component, oriented inward).
Surface sphere_with_cavity(int subdivisions = 2, double inner_radius = 0.4);

// Combinations and changes.
Surface joined(const Surface& a, const Surface& b);  // b's vertices after a's
Surface flipped(const Surface& s);
Surface transformed(const Surface& s, const Eigen::Matrix3d& A, const Eigen::Vector3d& t);  // det A > 0
Surface shifted(Surface s, double x, double y, double z);
Eigen::Matrix3d some_rotation(std::uint64_t seed);
// Vertices and faces in another order, faces rotated; `new_of_old` gets the vertex permutation.
Surface permuted(const Surface& s, std::uint64_t seed, Eigen::VectorXi* new_of_old = nullptr);

double signed_volume(const Surface& s);
// True when every edge is used once in each direction.
bool is_closed_oriented(const Surface& s);

}  // namespace overtet::test
