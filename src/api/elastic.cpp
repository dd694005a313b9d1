#include "overtet/elastic.h"

#include "src/api/guarded.h"
#include "src/solve/elastic.h"

namespace overtet {

struct Elastic::Impl {
  LabelledTetMesh mesh;
  ElasticOptions options;
  std::unique_ptr<solve_detail::ElasticMotion> motion;
};

Elastic::Elastic(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Elastic::~Elastic() = default;
Elastic::Elastic(Elastic&&) noexcept = default;
Elastic& Elastic::operator=(Elastic&&) noexcept = default;

Result<Elastic> Elastic::prepare(const LabelledTetMesh& mesh, const ElasticOptions& options,
                                 const RunContext& outer) {
  if (Status valid = options.validate(); !valid) return valid.error();
  return guarded(outer, [&](const RunContext& context) -> Result<Elastic> {
    auto impl = std::make_unique<Impl>(Impl{mesh, options, nullptr});
    auto motion = solve_detail::ElasticMotion::prepare(impl->mesh, impl->options, context);
    if (!motion) return motion.error();
    impl->motion = std::move(motion).value();
    return Elastic(std::move(impl));
  });
}

Result<ElasticStep> Elastic::step(const RunContext& outer) {
  return guarded(outer, [&](const RunContext& context) { return impl_->motion->step(context); });
}

Status Elastic::move_held(std::span<const Index> vertices, const VertexMatrix& places) {
  return impl_->motion->move_held(vertices, places);
}

const VertexMatrix& Elastic::places() const { return impl_->motion->places(); }
const VertexMatrix& Elastic::velocities() const { return impl_->motion->velocities(); }
double Elastic::time() const { return impl_->motion->time(); }
Eigen::VectorXd Elastic::von_mises() const { return impl_->motion->von_mises(); }
Eigen::VectorXd Elastic::von_mises_at_vertices() const { return impl_->motion->von_mises_at_vertices(); }

Result<ElasticResult> solve_elastic(const LabelledTetMesh& mesh, const ElasticOptions& options,
                                    const RunContext& context, const ElasticSink& each_frame) {
  Result<Elastic> prepared = Elastic::prepare(mesh, options, context);
  if (!prepared) return prepared.error();
  Elastic& body = prepared.value();
  ElasticResult result;
  for (int frame = 0; frame < options.frames; ++frame) {
    context.report("elastic", static_cast<double>(frame) / options.frames);
    Result<ElasticStep> step = body.step(context);
    if (!step) return step.error();
    if (!step.value().converged) result.end = ElasticEnd::iterations;
    result.steps.push_back(step.value());
    if (each_frame)
      if (Status s = each_frame(body, step.value()); !s) return s.error();
  }
  result.places = body.places();
  result.velocities = body.velocities();
  result.von_mises = body.von_mises();
  return result;
}

}  // namespace overtet
