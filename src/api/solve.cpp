#include "overtet/solve.h"

#include "src/api/guarded.h"
#include "src/solve/distances.h"
#include "src/solve/field.h"

namespace overtet {

Result<Field> solve_field(const LabelledTetMesh& mesh, const FieldOptions& options, const RunContext& outer) {
  if (Status valid = options.validate(); !valid) return valid.error();
  return guarded(outer,
                 [&](const RunContext& context) { return solve_detail::field(mesh, options, context); });
}

struct Distances::Impl {
  solve_detail::HeatMethod method;
};

Distances::Distances(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}
Distances::~Distances() = default;
Distances::Distances(Distances&&) noexcept = default;
Distances& Distances::operator=(Distances&&) noexcept = default;

Result<Distances> Distances::prepare(const TetMesh& mesh, const DistanceOptions& options,
                                     const RunContext& outer) {
  if (Status valid = options.validate(); !valid) return valid.error();
  return guarded(outer, [&](const RunContext& context) -> Result<Distances> {
    Result<solve_detail::HeatMethod> method = solve_detail::HeatMethod::prepare(mesh, options, context);
    if (!method) return method.error();
    return Distances(std::make_unique<Impl>(Impl{std::move(method).value()}));
  });
}

Result<Eigen::VectorXd> Distances::from(std::span<const Index> sources, const RunContext& outer) const {
  return guarded(outer, [&](const RunContext& context) { return impl_->method.from(sources, context); });
}

}  // namespace overtet
