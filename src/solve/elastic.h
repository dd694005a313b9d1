// Elastic bodies, frame by frame; see Elastic.
#pragma once

#include <map>
#include <memory>
#include <span>
#include <vector>

#include "overtet/elastic.h"
#include "src/solve/elastic_loads.h"
#include "src/solve/elastic_minimum.h"

namespace overtet::solve_detail {

// The mesh and the options must outlive it.
class ElasticMotion {
 public:
  // pre: the options are valid.
  static Result<std::unique_ptr<ElasticMotion>> prepare(const LabelledTetMesh& mesh,
                                                        const ElasticOptions& options,
                                                        const RunContext& context);

  Result<ElasticStep> step(const RunContext& context);
  Status move_held(std::span<const Index> vertices, const VertexMatrix& places);

  const VertexMatrix& places() const { return now_.x; }
  const VertexMatrix& velocities() const { return now_.v; }
  double time() const { return now_.time; }
  Eigen::VectorXd von_mises() const { return body_->von_mises(now_.x); }
  Eigen::VectorXd von_mises_at_vertices() const;

 private:
  struct State {
    VertexMatrix x, v;                // #V x 3
    VertexMatrix x_before, v_before;  // a step earlier; empty: there is none, or it was another step
    int frames = 0;                   // that there were
    double time = 0;
  };
  // What acts at the end of a frame.
  struct Outside {
    VertexMatrix targets, force;
  };

  ElasticMotion(const ElasticOptions& options, ElasticLoads loads)
      : options_(options), loads_(std::move(loads)) {}
  Status begin(const LabelledTetMesh& mesh, const RunContext& context);
  double time_of(int frame) const;
  Result<Outside> outside_at(double time) const;
  ElasticPotential potential(double h, bool second_order, VertexMatrix force) const;
  // The frame in so many parts. False, and nothing has changed: tets are in the way, or an equilibrium was
  // not reached.
  Result<bool> advance(int parts, const Outside& end, ElasticStep& step, ElasticMinimum& last,
                       const RunContext& context);
  Error stuck(const ElasticMinimum& last) const;

  const ElasticOptions& options_;
  ElasticLoads loads_;
  std::map<Index, Eigen::RowVector3d> moved_;  // by hand
  std::vector<char> held_;
  Eigen::VectorXd mass_;  // #V
  double rounding_ = 0;   // of forces
  std::unique_ptr<ElasticBody> body_;
  std::unique_ptr<ElasticDirections> directions_;
  VertexMatrix force_;  // at the end of the last frame
  State now_;
};

}  // namespace overtet::solve_detail
