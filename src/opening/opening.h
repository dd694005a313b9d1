// Gives room to the vertices of a surface that a repair has moved, and brings those home that need not be
// away.
//
// A repair moves vertices as little as it can. So the tets at them are next to flat: where it ends, one step
// less has no mesh. Here moved vertices go on, each inside a ball around the place that it had in the input.
// The balls grow until the tets at moved vertices are good enough. Where these alone find no room, the
// surface's vertices at the worst tets move as well. Then all go back as far as the tets stay as good. The
// mesh is positive at every moment: vertices move one at a time with all of their tets positive, or together
// with all tets positive on the whole way. So an interior edge keeps its one turn, and nothing has to be
// diagnosed or meshed again.
//
// In each ball, in turn: all moves of a place scaled; sweeps that minimise a sum over the star of each
// vertex, shape_energy^1.5 (kernels/tet_energy), which is (sum of squared edges)^1.5 / volume but for a
// factor, by Newton steps; the same for powers of one over the sines; then sweeps that raise the worst tet of
// each star, and changes of tets. (The worst tet alone is no goal to begin with: it locks where sums do not.)
// Only vertices with bad tets at them take part.
//
// Places (moved vertices with a few layers of tets around them; those that touch are one place) are worked on
// independently of each other. Same mesh and options, same bytes on any number of threads.
#pragma once

#include <vector>

#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// More than 12 members: flat options, which callers set by name.
struct OpeningOptions {
  enum class Moves {
    surface,  // moved vertices of the surface, as said above
    inside    // none of the surface: other tets at moved vertices, and other places inside
  };
  Moves moves = Moves::surface;
  double target_degrees = 7;  // least dihedral angle (and 180 minus the largest) wanted at moved vertices
  // No vertex goes further from its place in the input, in the input's units.
  double largest_move = 0;
  // Nor further than the mean edge of the surface at its place, times `edges`, beyond which it is another
  // shape; or than the repair's largest move there, times `further`, where that is more.
  double edges = 1, further = 1.5;
  double growth = 1.25;  // of the balls, from one round to the next
  int layers = 3;        // of tets around moved vertices that take part
  // Enough, where the least quality has not grown by the factor `gain` in so many rounds.
  double gain = 1.03;
  int idle_rounds = 4;
  int energy_sweeps = 12, worst_sweeps = 6;  // in each round, at most
  // A place where the least quality has not grown by this factor in the end stays as it was.
  double worthwhile = 1.3;
  // So often the surface's vertices at the worst tets are taken along, where moved ones find no room alone.
  int most_helps = 4;
  double usable_degrees = 5;  // that is where the least angle stays below this
  double most_tets = 1.5;     // times those that there were: no more are made by new vertices
  // Dear changes of tets that are tried in growing balls: half as many as there are tets, and so many at
  // least. Tets that nothing can improve must not cost more. A count and not a time: the same result
  // everywhere.
  int least_tries = 2000;
  double power = 6;        // of one over the sines; larger ones see the worst only, but lock earlier
  double first_cut = 0.6;  // of the largest move: what is left when moves are first cut back
  // In the end vertices go home, or nearer to it, where no tet becomes worse than the target: so many times
  // each at most, and ever shorter ways. 0: none does.
  int home_sweeps = 30;
  int home_halvings = 4;  // of the way, until a step is short enough

  Status validate() const;
};

struct OpenedPlace {
  Index vertices = 0, away = 0;                  // moved ones, before and at the end
  double degrees_before = 0, degrees_after = 0;  // of the least angle at them, as above
  double farthest = 0;                           // the largest move afterwards, in the input's units
  int rounds = 0;
  bool opened = false;
};

struct OpeningResult {
  std::vector<OpenedPlace> places;
  double degrees_before = 90, degrees_after = 90;  // the least ones; 90 where nothing has moved
};

// Works in place. home: #V x 3, where the surface's vertices were in the input; those that are there stay,
// but for most_helps. The surface's vertices keep their numbers; others that no tet needs any more are
// dropped. Errors: usage (options), interrupted, limit. pre: every tet positive; mesh.surface_vertices ==
// home.rows().
Result<OpeningResult> open_up(TetMesh& mesh, const VertexMatrix& home, const OpeningOptions& options,
                              const RunContext& context);

// The smallest angle, in degrees, among the dihedral angles and their differences from 180 of all tets that
// have a surface vertex which is not at home; 90 where there is none.
double least_angle_at_moved(const TetMesh& mesh, const VertexMatrix& home);

}  // namespace overtet
