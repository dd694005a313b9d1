#include "src/solve/elastic.h"

#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <string>
#include <utility>

#include "src/solve/parts.h"
#include "src/solve/tuning.h"

namespace overtet {

using namespace solve_detail;

Status ElasticOptions::validate() const {
  const auto wrong = [](const char* what) { return Error{ErrorCode::usage, what}; };
  const auto positive = [](double x) { return x > 0 && std::isfinite(x); };
  const auto not_negative = [](double x) { return x >= 0 && std::isfinite(x); };
  if (!positive(young)) return wrong("Young's modulus must be greater than 0.");
  if (!(poisson >= 0 && poisson <= 0.499)) return wrong("Poisson's ratio must lie between 0 and 0.499.");
  if (!positive(density)) return wrong("The density must be greater than 0.");
  if (!gravity.allFinite()) return wrong("Gravity is not finite.");
  if (!not_negative(mass_damping) || !not_negative(stiffness_damping))
    return wrong("Damping must not be negative.");
  if (!positive(time_step)) return wrong("The time step must be greater than 0.");
  if (frames < 1) return wrong("There must be at least one frame.");
  if (!(tolerance > 0 && tolerance < 1)) return wrong("The tolerance must lie between 0 and 1.");
  if (most_iterations < 1) return wrong("There must be at least one iteration.");
  if (!dynamic && velocities.rows() > 0) return wrong("An equilibrium has no velocities at its start.");
  if (!rest.allFinite() || !velocities.allFinite())
    return wrong("A number of the rest shape or of the velocities is not finite.");
  for (const ElasticCondition& t : tractions)
    if (!t.vertices.empty() || !t.function)
      return wrong("A traction is a function on triangles; at vertices there are forces.");
  for (const ElasticCondition& f : forces)
    if (f.vertices.empty() || f.label || !f.function)
      return wrong("A force is a function at vertices; on triangles there are tractions.");
  return success();
}

namespace solve_detail {

namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

// A quarter of the mass of the tets around each vertex.
Eigen::VectorXd masses(const ElasticBody& body, double density) {
  Eigen::VectorXd out = Eigen::VectorXd::Zero(body.rest().rows());
  for (Index t = 0; t < body.tets(); ++t)
    for (int k = 0; k < 4; ++k) out[body.tet(t)[k]] += density * body.shape(t).volume / 4;
  return out;
}

}  // namespace

Result<std::unique_ptr<ElasticMotion>> ElasticMotion::prepare(const LabelledTetMesh& mesh,
                                                              const ElasticOptions& options,
                                                              const RunContext& context) {
  const Eigen::Index n = mesh.mesh.V.rows();
  for (const VertexMatrix* m : {&options.rest, &options.velocities})
    if (m->rows() > 0 && m->rows() != n)
      return Error{ErrorCode::usage, "The rest shape and the velocities need a row for each of the " +
                                         std::to_string(n) + " vertices of the mesh."};
  if (Status s = check(mesh.mesh); !s) return s.error();
  if (options.rest.rows() > 0)
    if (Status s = check({options.rest, mesh.mesh.T, 0}); !s)
      return Error{s.error().code, "At rest: " + s.error().message};
  Result<ElasticLoads> loads = ElasticLoads::prepare(mesh, options);
  if (!loads) return loads.error();
  std::unique_ptr<ElasticMotion> motion(new ElasticMotion(options, std::move(loads).value()));
  if (Status s = motion->begin(mesh, context); !s) return s.error();
  return motion;
}

Status ElasticMotion::begin(const LabelledTetMesh& mesh, const RunContext& context) {
  const TetMatrix& T = mesh.mesh.T;
  const auto vertices = static_cast<Index>(mesh.mesh.V.rows());
  // Free are the vertices of tets that are not held.
  std::vector<Index> number(static_cast<std::size_t>(vertices), -1);
  held_.assign(static_cast<std::size_t>(vertices), 1);
  for (const Index v : T.reshaped())
    if (!loads_.is_held(v)) held_[static_cast<std::size_t>(v)] = 0;
  Index free = 0;
  for (std::size_t v = 0; v < number.size(); ++v)
    if (!held_[v]) number[v] = free++;
  if (auto stop = context.stop()) return *stop;
  const ElasticLaw law{options_.material, lame_of(options_.young, options_.poisson)};
  const VertexMatrix& rest = options_.rest.rows() > 0 ? options_.rest : mesh.mesh.V;
  body_ = std::make_unique<ElasticBody>(rest, T, law, number);
  rounding_ = body_->rounding();
  mass_ = masses(*body_, options_.density);
  if (auto stop = context.stop()) return *stop;
  directions_ = options_.method.value_or(ElasticMethod::newton) == ElasticMethod::newton
                    ? newton_directions(number)
                    : quasi_newton_directions(
                          number, (2 * law.lame.mu + law.lame.lambda) * TetElements(rest, T, 1).stiffness());
  now_.x = mesh.mesh.V;
  now_.v =
      options_.velocities.rows() > 0 ? options_.velocities : VertexMatrix(VertexMatrix::Zero(vertices, 3));
  force_ = VertexMatrix::Zero(vertices, 3);
  return success();
}

double ElasticMotion::time_of(int frame) const {
  return options_.dynamic ? frame * options_.time_step : static_cast<double>(frame) / options_.frames;
}

Result<ElasticMotion::Outside> ElasticMotion::outside_at(double time) const {
  Result<VertexMatrix> targets = loads_.targets(time), force = loads_.forces(time);
  if (!targets) return targets.error();
  if (!force) return force.error();
  for (const auto& [v, place] : moved_) targets.value().row(v) = place;
  return Outside{std::move(targets).value(), std::move(force).value() + mass_ * options_.gravity.transpose()};
}

// Of a step of length h from what is now; h = 0: of an equilibrium.
ElasticPotential ElasticMotion::potential(double h, bool second_order, VertexMatrix force) const {
  ElasticPotential E;
  E.body = body_.get();
  E.mass = &mass_;
  E.force = std::move(force);
  E.base = now_.x;
  E.rounding = rounding_;
  if (h <= 0) return E;
  VertexMatrix v = now_.v;
  if (second_order) {  // x' = (3 x - 4 x_0 + x_before) / (2 h), and so is v'
    h *= 2.0 / 3;
    E.base = (4 * now_.x - now_.x_before) / 3;
    v = (4 * now_.v - now_.v_before) / 3;
  }
  E.predicted = E.base + h * v;
  E.inertia = 1 / (h * h);
  E.drag = options_.mass_damping / h;
  E.viscosity = options_.stiffness_damping / h;
  if (E.viscosity > 0) body_->tangents(now_.x, Tangent::definite, E.at_base);
  return E;
}

Result<bool> ElasticMotion::advance(int parts, const Outside& end, ElasticStep& step, ElasticMinimum& last,
                                    const RunContext& context) {
  const State start = now_;
  const VertexMatrix force = force_;
  const bool second_order =
      parts == 1 && options_.integrator == ElasticIntegrator::bdf2 && now_.x_before.rows() > 0;
  const double h = options_.dynamic ? options_.time_step / parts : 0;
  step.converged = true;
  for (int part = 1; part <= parts; ++part) {
    const double share = static_cast<double>(part) / parts;
    const VertexMatrix targets =
        part == parts ? end.targets : VertexMatrix(start.x + share * (end.targets - start.x));
    // Forces on bodies that move do not wait for the end of the frame.
    const VertexMatrix acting =
        options_.dynamic || part == parts ? end.force : VertexMatrix(force + share * (end.force - force));
    const ElasticPotential E = potential(h, second_order, acting);
    VertexMatrix x = now_.x;
    const Result<ElasticMinimum> found = minimise(
        E, {&held_, &targets, options_.tolerance, options_.most_iterations}, *directions_, x, context);
    if (!found) {
      now_ = start;
      return found.error();
    }
    last = found.value();
    step.iterations += last.iterations;
    step.line_search_steps += last.line_search_steps;
    if (!last.brought || (!options_.dynamic && !last.converged)) {
      now_ = start;
      return false;
    }
    step.converged = step.converged && last.converged;
    step.residual = last.residual;
    if (options_.dynamic) {
      const double rate = second_order ? 1.5 / h : 1 / h;
      VertexMatrix v = rate * (x - E.base);
      now_.x_before = std::move(now_.x), now_.v_before = std::move(now_.v);
      now_.v = std::move(v);
    }
    now_.x = std::move(x);
  }
  if (parts > 1) now_.x_before.resize(0, 3);
  return true;
}

Error ElasticMotion::stuck(const ElasticMinimum& last) const {
  char text[280];
  if (last.brought) {
    std::snprintf(
        text, sizeof text,
        "No equilibrium was found: after %d iterations %.2g of the forces is left. Allow more iterations, or "
        "load the body in more frames.",
        options_.most_iterations, last.residual);
    return {ErrorCode::unsolved, text};
  }
  const auto corner = body_->tet(std::max(last.flat, Index{0}))[0];
  const Eigen::RowVector3d p = now_.x.row(corner);
  std::snprintf(
      text, sizeof text,
      "What is held cannot be moved so far in one frame, even in %d parts: tet %d (counted from 0), near "
      "(%.6g, %.6g, %.6g), would become flat. Move it less, in more frames, or another way.",
      kMostFrameParts, last.flat, p[0], p[1], p[2]);
  return {ErrorCode::unsolved, text, std::array<double, 3>{p[0], p[1], p[2]}};
}

Result<ElasticStep> ElasticMotion::step(const RunContext& context) {
  const auto begin = std::chrono::steady_clock::now();
  const double time = time_of(now_.frames + 1);
  Result<Outside> end = outside_at(time);
  if (!end) return end.error();
  ElasticStep step;
  const int factorisations = directions_->factorisations;
  ElasticMinimum last;
  for (step.parts = 1;; step.parts *= 2) {
    const Result<bool> done = advance(step.parts, end.value(), step, last, context);
    if (!done) return done.error();
    if (done.value()) break;
    if (step.parts == kMostFrameParts) return stuck(last);
  }
  ++now_.frames;
  now_.time = step.time = time;
  force_ = std::move(end.value().force);
  step.factorisations = directions_->factorisations - factorisations;
  step.elastic_energy = body_->energy(now_.x);
  step.kinetic_energy = (mass_.array() * now_.v.rowwise().squaredNorm().array()).sum() / 2;
  step.least_ratio = body_->least_ratio(now_.x);
  step.seconds = seconds_since(begin);
  return step;
}

Status ElasticMotion::move_held(std::span<const Index> vertices, const VertexMatrix& places) {
  if (std::ssize(vertices) != places.rows())
    return Error{ErrorCode::usage, "There must be a place for each vertex that is moved."};
  if (!places.allFinite())
    return Error{ErrorCode::usage, "A place that a vertex is to move to is not finite."};
  for (const Index v : vertices)
    if (v < 0 || v >= now_.x.rows() || !loads_.is_held(v))
      return Error{ErrorCode::usage, "Vertex " + std::to_string(v) + " (counted from 0) is not held."};
  for (std::size_t i = 0; i < vertices.size(); ++i)
    moved_[vertices[i]] = places.row(static_cast<Eigen::Index>(i));
  return success();
}

Eigen::VectorXd ElasticMotion::von_mises_at_vertices() const {
  const Eigen::VectorXd of_tets = von_mises();
  Eigen::VectorXd out = Eigen::VectorXd::Zero(now_.x.rows()), volume = out;
  for (Index t = 0; t < body_->tets(); ++t)
    for (int k = 0; k < 4; ++k) {
      out[body_->tet(t)[k]] += body_->shape(t).volume * of_tets[t];
      volume[body_->tet(t)[k]] += body_->shape(t).volume;
    }
  for (Eigen::Index v = 0; v < out.size(); ++v)
    if (volume[v] > 0) out[v] /= volume[v];
  return out;
}

}  // namespace solve_detail

}  // namespace overtet
