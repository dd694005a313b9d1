"""Random hard models for Overtet, and a judge of its answers.

Models are closed, oriented, manifold surfaces that pass through themselves. Kinds of models:

  bend       slabs, pipes and capsules, bent until they run into themselves
  poke       patches pushed through the opposite side
  pose       creatures with limbs that are bent strongly at two joints each
  wave       simple surfaces with waves or noise larger than they are thick
  decimate   any of these with half to a tenth of the faces
  scale      any of these huge, tiny, drawn out or far away

These may have a mesh or not. The following are surfaces of tets that overlap, so that they have one:

  grown      tets on tets
  lattice    the same in a box of few integers: much touches and coincides
  tunnels    growth that bites its own tail: handles
  fan        tets around edges, by more than a turn: wound edges
  blocks     chains of cubes that come back to where they were: coincident faces, slits
  shaken     such chains, their vertices moved at random
  cake       bars, folded
  welded     vertices moved onto others, onto middles of two, into planes
  copies     two or three of these in one place, or nearly
  needles    some of these, drawn out and sheared by large factors
  affine     images of some of these, far from the origin

A number (--seeds) makes the same model of a kind on every machine.

What is judged:

  exit code 0   `overtet verify` accepts the mesh, and so does this script, in integers: all tets are positive, the
                boundary faces are the surface's, its vertices have not moved in any bit, the tets form a manifold and
                make one turn around interior edges (the latter for up to 30000 tets)
  exit code 5   scripts/check_witness confirms the witness. It is wrong for a model that has a mesh
  exit code 4   unsolved: counted, and a failure for a model that has a mesh
  exit code 3   a failure unless a face has no area
  others        a failure: signals, other exit codes, no answer in time. A program has --time seconds of the clock and as
                many of the processor, so that a busy machine makes no failures, but at most ten times --time

With --repair, what is infeasible is repaired, and the repaired mesh is judged with the moves that the report names.

--minimise looks for fewer faces that fail in the same way. Components are left out, then tets of the solid, as long as
the rest is one; for failures other than "unsolved" and "false witness", which need the solid, edges are collapsed. The
result goes to the folder --keep, named after kind and number, with a comment that names the failure. Where there is a
solid, it is beside it, as tet mesh. `--again` judges such files, for instance those in tests/stress/kept.

Exit code: 0 nothing went wrong, 1 something did, 2 usage, 130 interrupted (the smallest model so far is kept).
Python needs no packages; check_witness needs python3-numpy and cadical."""
