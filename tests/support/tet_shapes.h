// Small closed surfaces and tet meshes for the tests of the tet rooms.
#pragma once

#include "overtet/types.h"

namespace overtet::test {

Surface box_surface(double x, double y, double z);                 // 8 vertices, 12 faces
Surface sphere_surface(int subdivisions);                          // icosphere of radius 1
Surface torus_surface(int around, int across, double R, double r);  // genus 1

// n^3 cubes of 5 or 6 tets each (Kuhn: 6), every tet positive; vertices jittered inside by `jitter` of
// a cell with the seed given.
TetMesh grid_tets(int n, double jitter, unsigned seed);

}  // namespace overtet::test
