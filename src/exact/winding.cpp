#include "src/exact/winding.h"

#include "kernels/core/assertions.h"
#include "src/exact/rays.h"

namespace overtet {

struct WindingNumber::Impl {
  std::unique_ptr<TriangleBvh> own;
  exact::Rays rays;
  Impl(const Surface& s, std::unique_ptr<TriangleBvh> tree) : own(std::move(tree)), rays(s.V, s.F, *own) {}
  Impl(const Surface& s, const TriangleBvh& bvh) : rays(s.V, s.F, bvh) {
    OVERTET_EXPECTS(s.V.allFinite() && bvh.faces() == s.F.rows());
  }
};

WindingNumber::WindingNumber(const Surface& surface)
    : impl_(std::make_unique<Impl>(surface, std::make_unique<TriangleBvh>(surface.V, surface.F))) {}
WindingNumber::WindingNumber(const Surface& surface, const TriangleBvh& bvh)
    : impl_(std::make_unique<Impl>(surface, bvh)) {}
WindingNumber::~WindingNumber() = default;
WindingNumber::WindingNumber(WindingNumber&&) noexcept = default;

std::optional<int> WindingNumber::at(const double* point) const {
  return impl_->rays.winding(exact::Point(point));
}

std::optional<int> WindingNumber::at(const std::array<std::string, 3>& point) const {
  exact::Vec p;
  for (int k = 0; k < 3; ++k) {
    const std::string& s = point[k];
    const auto slash = s.find('/');
    const auto digits = [](const std::string& t, bool sign) {
      const std::size_t from = sign && !t.empty() && t[0] == '-' ? 1 : 0;
      return t.size() > from && t.find_first_not_of("0123456789", from) == std::string::npos;
    };
    const std::string top = s.substr(0, slash),
                      bottom = slash == std::string::npos ? "1" : s.substr(slash + 1);
    if (!digits(top, true) || !digits(bottom, false)) return std::nullopt;
    if (bottom.find_first_not_of('0') == std::string::npos) return std::nullopt;
    p[k] = exact::Rational(s, 10);
    p[k].canonicalize();
  }
  return impl_->rays.winding(exact::Point(p));
}

}  // namespace overtet
