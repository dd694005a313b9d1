// Elastic bodies on tet meshes that overlap themselves (Sacht et al. 2013, section 5): where two layers of
// the solid overlap they have vertices of their own, and move by themselves. Layers do not collide: neither
// overlap that is there nor overlap that comes about is seen.
//
// Linear tets, large deformations. No tet is ever flat or flipped: steps end before that, and every state
// that is given back has positive tets only, exactly. Units are the caller's: if lengths are metres and
// forces newtons, then Young's modulus is in pascals, density in kilograms a cubic metre, and time in
// seconds. All results are the same bytes on any number of threads.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "overtet/attributes.h"
#include "overtet/elastic_material.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// Of a place at the start (a row of the mesh's V) and the time.
using VectorFunction = std::function<Eigen::Vector3d(const Eigen::Vector3d& place, double time)>;

// What holds at part of the boundary: all of it, the triangles with a label, or some vertices, which may lie
// inside, too.
struct ElasticCondition {
  std::optional<Index> label;
  std::vector<Index> vertices;
  VectorFunction function;
};

enum class ElasticIntegrator {
  implicit_euler,  // damps what is fast [Baraff, Witkin 1998]
  bdf2             // of second order, damps less; the first step, and one that is cut, is of implicit Euler
};

enum class ElasticMethod {
  newton,  // Newton's, the matrix factored in every iteration: few iterations, to any tolerance
  // L-BFGS on top of one matrix that is factored once [Liu, Bouaziz, Kavan 2017]: quick iterations. Ahead of
  // Newton's while waves pass some edges in a frame, not ten (perf/README.md), and where little is asked of
  // the residual; of no use for equilibria of thin bodies.
  quasi_newton
};

// More than 12 members: each is a choice of its own.
struct ElasticOptions {
  ElasticMaterial material = ElasticMaterial::neo_hookean;
  double young = 1, poisson = 0.3;  // poisson: 0 to 0.499; linear tets are too stiff near 0.5
  double density = 1;               // of the body at rest
  Eigen::Vector3d gravity = Eigen::Vector3d::Zero();  // an acceleration
  // Rayleigh's: forces -(mass_damping M + stiffness_damping K) v, K the stiffness at the start of each step.
  double mass_damping = 0, stiffness_damping = 0;

  // Displacements from the start that are given; no function: none, the place is fixed. Where two of them
  // meet, the later one counts.
  std::vector<ElasticCondition> held;
  // Forces per area of the boundary at rest, on triangles, and forces at vertices. They keep their direction
  // when the body turns, and add up where several are given.
  std::vector<ElasticCondition> tractions, forces;
  VertexMatrix
      rest;  // #V x 3: another shape of the same tets, in which there is no stress; empty: the mesh's

  // false: an equilibrium (a local minimum of the energy), for time 1; mass and damping do not matter. true:
  // motion from rest, or from `velocities` (#V x 3).
  bool dynamic = false;
  ElasticIntegrator integrator = ElasticIntegrator::implicit_euler;
  VertexMatrix velocities;
  double time_step = 0.01;  // of motion, from frame to frame
  int frames =
      1;  // of motion: steps in time. Otherwise equilibria one after the other, at the times 1/frames to 1.

  std::optional<ElasticMethod> method;  // none: Newton's
  // Of the forces that are left over where nothing is held, relative to the forces in the tets.
  double tolerance = 1e-8;
  // Of a frame. Where motion has not converged after that, it goes on from what there is; an equilibrium is
  // an error.
  int most_iterations = 200;

  Status validate() const;  // Errors: usage.
};

struct ElasticStep {
  double time = 0;            // at its end
  int parts = 1;              // that the step was cut into, as tets would have become flat
  int iterations = 0;         // directions in which the energy was made less
  int line_search_steps = 0;  // shorter ways that were tried
  int factorisations = 0;
  double elastic_energy = 0, kinetic_energy = 0;
  double residual = 0;     // as ElasticOptions::tolerance
  bool converged = true;   // the residual is small enough, or as small as doubles allow
  double least_ratio = 0;  // of a tet's volume to that at rest
  double seconds = 0;
};

enum class ElasticEnd {
  converged,   // every frame
  iterations,  // some frames of motion have used all their iterations
};

// A body that is prepared once and moved frame by frame.
class Elastic {
 public:
  // The mesh is copied. Errors: usage (options; a label that no triangle has; a vertex that does not exist;
  // of equilibria, a component of the tets that can still turn or move), bad_input (a tet that is not
  // positive, at the start or at rest; a function's value that is not finite: the message has the place),
  // limit, interrupted.
  static Result<Elastic> prepare(const LabelledTetMesh& mesh, const ElasticOptions& options,
                                 const RunContext& context = {});
  ~Elastic();
  Elastic(Elastic&&) noexcept;
  Elastic& operator=(Elastic&&) noexcept;

  // The next frame, also beyond ElasticOptions::frames. After an error everything is as before. Errors:
  // unsolved (tets would become flat, however small the steps; an equilibrium that was not reached: the
  // message says where or how much force is left), bad_input (a function's value that is not finite), limit,
  // interrupted.
  Result<ElasticStep> step(const RunContext& context = {});

  // From now on vertices that are held go to these places (a row each) by the next frame and stay there,
  // whatever their function says. Errors: usage (a vertex that is not held; numbers of rows that differ).
  Status move_held(std::span<const Index> vertices, const VertexMatrix& places);

  const VertexMatrix& places() const;      // #V x 3
  const VertexMatrix& velocities() const;  // #V x 3; 0 of equilibria
  double time() const;
  // Of Cauchy's stress: #T, and at vertices the mean of the tets around, by volume: #V, 0 where there are
  // none.
  Eigen::VectorXd von_mises() const;
  Eigen::VectorXd von_mises_at_vertices() const;

 private:
  struct Impl;
  explicit Elastic(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

struct ElasticResult {
  VertexMatrix places, velocities;  // of the last frame
  Eigen::VectorXd von_mises;        // #T
  std::vector<ElasticStep> steps;
  ElasticEnd end = ElasticEnd::converged;
};

// What is done with each frame; an error ends the run.
using ElasticSink = std::function<Status(const Elastic& body, const ElasticStep& step)>;

// All frames. Errors: as Elastic has them, and those of `each_frame`.
Result<ElasticResult> solve_elastic(const LabelledTetMesh& mesh, const ElasticOptions& options,
                                    const RunContext& context = {}, const ElasticSink& each_frame = {});

}  // namespace overtet
