#include "src/repair/least_move.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <vector>

#include "kernels/bvh/bvh.h"
#include "kernels/core/box.h"
#include "kernels/core/tuning.h"
#include "src/exact/winding.h"
#include "src/mesh/topology.h"
#include "src/repair/ray_hit.h"
#include "src/repair/tuning.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

double distance_to_segment(const Vector3d& p, const Vector3d& a, const Vector3d& b) {
  const Vector3d e = b - a;
  const double length = e.squaredNorm();
  const double t = length > 0 ? std::clamp((p - a).dot(e) / length, 0.0, 1.0) : 0;
  return (p - a - t * e).norm();
}

double distance_to_triangle(const Vector3d& p, const Vector3d& a, const Vector3d& b, const Vector3d& c) {
  const Vector3d n = (b - a).cross(c - a), d = p - a;
  const double nn = n.squaredNorm();
  if (nn > 0) {
    const double v = d.cross(c - a).dot(n), w = (b - a).cross(d).dot(n);
    if (v >= 0 && w >= 0 && v + w <= nn) return std::fabs(d.dot(n)) / std::sqrt(nn);
  }
  return std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
}

class Balls {
 public:
  Balls(const Surface& surface, const Diagnosis& diagnosis)
      : surface_(surface),
        diagnosis_(diagnosis),
        winding_(surface, *diagnosis.bvh),
        diagonal_(diagonal_of(surface.V)) {}

  std::optional<LeastMove> run(const RunContext& context) {
    std::optional<LeastMove> best;
    std::vector<Start> starts = half_way_to_the_other_wall(context);
    std::stable_sort(starts.begin(), starts.end(),
                     [](const Start& a, const Start& b) { return a.width > b.width; });
    if (starts.size() > kMostTried) starts.resize(kMostTried);
    for (const Start& start : starts) {
      if (context.stop()) break;
      const LeastMove ball = grown(start);
      if (best && ball.distance <= best->distance) continue;
      const auto w = winding_.at(ball.at.data());
      if (w && *w < 0) best = ball;
    }
    if (best) best->distance *= 1 - kRounding;
    return best;
  }

 private:
  struct Start {
    Vector3d at;
    double width;  // between the walls
  };

  Vector3d corner(Index f, int k) const { return surface_.V.row(surface_.F(f, k)); }

  // From the middles of all faces that have negative winding in front.
  std::vector<Start> half_way_to_the_other_wall(const RunContext& context) const {
    std::vector<Index> list;
    std::vector<char> seen(static_cast<std::size_t>(surface_.F.rows()), 0);
    const auto look_at = [&](Index f) {
      if (f >= 0 && !seen[f]) seen[f] = 1, list.push_back(f);
    };
    for (const auto& [f, g] : diagnosis_.winding.negative_at) look_at(f), look_at(g);
    std::vector<Start> starts;
    for (std::size_t i = 0; i < std::min(list.size(), kMostFlooded); ++i) {
      if (i % 256 == 0 && context.stop()) break;
      const Vector3d a = corner(list[i], 0), b = corner(list[i], 1), c = corner(list[i], 2);
      const Vector3d n = (b - a).cross(c - a).normalized(), p = (a + b + c) / 3 + kAhead * diagonal_ * n;
      const auto w = winding_.at(p.data());
      if (!w || *w >= 0) continue;
      for (Index h = 3 * list[i]; h < 3 * list[i] + 3; ++h)
        look_at(half_edge_face(diagnosis_.topology.topology.twin[h]));
      const double far = along(p, n);
      if (far < 1e300) starts.push_back({p + far / 2 * n, far});
    }
    return starts;
  }

  // How far away the first face is.
  double along(const Vector3d& from, const Vector3d& d) const {
    double far = 1e300;
    diagnosis_.bvh->query_ray(from.data(), d.data(), 0, [&](Index f) {
      if (const auto hit = ray_hit(from, d, corner(f, 0), corner(f, 1), corner(f, 2)))
        far = std::min(far, hit->far);
    });
    return far;
  }

  // To the surface, at most `most`.
  double distance(const Vector3d& p, double most) {
    const Vector3d low = p.array() - most, high = p.array() + most;
    diagnosis_.bvh->query_box(low.data(), high.data(), [&](Index f) {
      ++work_;
      most = std::min(most, distance_to_triangle(p, corner(f, 0), corner(f, 1), corner(f, 2)));
    });
    return most;
  }

  // The centre goes where there is more room, without leaving the ball, so the winding number stays.
  LeastMove grown(const Start& start) {
    LeastMove ball{distance(start.at, start.width), start.at};
    for (double step = ball.distance / 2; step > kPrecise * ball.distance && work_ < kMostBallWork;) {
      LeastMove next = ball;
      for (int x = -1; x <= 1; ++x)
        for (int y = -1; y <= 1; ++y)
          for (int z = -1; z <= 1; ++z) {
            if (x == 0 && y == 0 && z == 0) continue;
            const Vector3d to = ball.at + step * Vector3d(x, y, z).normalized();
            if (const double d = distance(to, ball.distance + step); d > next.distance) next = {d, to};
          }
      if (next.distance > (1 + kPrecise) * ball.distance)
        ball = next;
      else
        step /= 2;
    }
    return ball;
  }

  const Surface& surface_;
  const Diagnosis& diagnosis_;
  const WindingNumber winding_;
  const double diagonal_;
  std::int64_t work_ = 0;
};

}  // namespace

std::optional<LeastMove> least_move(const Surface& surface, const Diagnosis& diagnosis,
                                    const RunContext& context) {
  if (!diagnosis.complete() || diagnosis.winding.negative_at.empty()) return std::nullopt;
  return Balls(surface, diagnosis).run(context);
}

}  // namespace overtet
