// Small closed surfaces and tet meshes for the tests of the tet rooms.
#pragma once

#include "overtet/types.h"

namespace overtet::test {

Surface box_surface(double x, double y, double z);                  // 8 vertices, 12 faces
Surface sphere_surface(int subdivisions);                           // icosphere of radius 1
Surface torus_surface(int around, int across, double R, double r);  // genus 1

// n^3 cubes of 5 or 6 tets each (Kuhn: 6), every tet positive; vertices jittered inside by `jitter` of
// a cell with the seed given.
TetMesh grid_tets(int n, double jitter, unsigned seed);
TetMesh grid_tets(int nx, int ny, int nz, double jitter, unsigned seed);

// A grid of nx x n x n cells, nx as needed, bent around an axis by `degrees`: above 360 it passes through
// itself. Every tet positive for jitter up to 0.2.
TetMesh bent_grid(int n, double degrees, double jitter, unsigned seed);

// The same with the vertices of the boundary first.
TetMesh surface_first(const TetMesh& mesh);

}  // namespace overtet::test
