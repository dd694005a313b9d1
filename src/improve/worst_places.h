// The last means, for the very worst tets: what lies around one is copied, changed in a way that may make it
// worse (a vertex more or less, an edge less), mended by all operations that there are, and put back where
// that has made the worst tets better. So a mesh gets out of states that no single operation improves. Where
// one change does not help, walks of several chosen at random do (always the same ones). All this is done
// with few tets around the worst one, or else with more. The places of many bad tets are taken out of the
// mesh at once, and put back at once: a place costs what lies around it, not a look at the whole mesh.
#pragma once

#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// The worst tet again and again, until it is good enough, or it and the next few resist, or a number of
// attempts has been made that depends on the number of tets. Returns how many times a place got better.
// target: the smallest dihedral sine that is good enough. The surface's vertices keep their numbers; others
// that no tet needs any more are dropped.
int lift_worst(TetMesh& mesh, double target, const RunContext& context);

}  // namespace overtet
