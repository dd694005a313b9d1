#include "src/pipeline/nearby_surface.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>
#include <vector>

#include "kernels/core/box.h"
#include "kernels/core/tuning.h"
#include "src/certificates/diagnose.h"
#include "src/immersion/immersion.h"
#include "src/improve/improve.h"
#include "src/pipeline/stage_clock.h"
#include "src/pipeline/tuning.h"
#include "src/volume_map/volume_map.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

// How the vertices of a nearby surface are moved.
struct Nudge {
  enum class Direction { outward, random };
  Direction direction;
  double length;  // of the diagonal
};

// In (-1, 1), the same on every machine.
double noise(std::uint64_t seed) {
  seed += 0x9E3779B97F4A7C15u;
  seed = (seed ^ (seed >> 30)) * 0xBF58476D1CE4E5B9u;
  seed = (seed ^ (seed >> 27)) * 0x94D049BB133111EBu;
  return static_cast<double>(static_cast<std::int64_t>(seed ^ (seed >> 31))) * 0x1p-63;
}

std::vector<Vector3d> outward_normals(const Surface& s) {
  std::vector<Vector3d> normal(static_cast<std::size_t>(s.V.rows()), Vector3d::Zero());
  for (Index f = 0; f < s.F.rows(); ++f) {
    const Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
    for (const Index v : s.F.row(f)) normal[v] += (b - a).cross(c - a);
  }
  for (Vector3d& n : normal) n.normalize();
  return normal;
}

// No vertex goes further than a share of its shortest edge.
Surface nudged(const Surface& s, const Nudge& nudge) {
  const double diagonal = diagonal_of(s.V);
  std::vector<double> reach(static_cast<std::size_t>(s.V.rows()), nudge.length * diagonal);
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k) {
      const Index a = s.F(f, k), b = s.F(f, (k + 1) % 3);
      const double length = kNudgeOfEdge * (s.V.row(a) - s.V.row(b)).norm();
      reach[a] = std::min(reach[a], length);
      reach[b] = std::min(reach[b], length);
    }
  std::vector<Vector3d> direction;
  if (nudge.direction == Nudge::Direction::outward) {
    direction = outward_normals(s);
  } else {
    for (Index v = 0; v < s.V.rows(); ++v) {
      const std::uint64_t seed = 3 * static_cast<std::uint64_t>(v);
      direction.emplace_back(noise(seed), noise(seed + 1), noise(seed + 2));
    }
  }
  Surface out = s;
  for (Index v = 0; v < s.V.rows(); ++v)
    out.V.row(v) += (reach[static_cast<std::size_t>(v)] * direction[static_cast<std::size_t>(v)]).transpose();
  return out;
}

class NearbySurface {
 public:
  explicit NearbySurface(const MeshingJob& job) : job_(job) {}

  Result<TetMesh> run() {
    std::vector<TetMesh> meshes;
    std::vector<Nudge> nudges{{Nudge::Direction::outward, kNudges[0]}};
    for (const double length : kNudges) nudges.push_back({Nudge::Direction::random, length});
    for (const Nudge& nudge : nudges) {
      Result<TetMesh> nearby = mesh_of(nudged(job_.surface, nudge));
      if (nearby) {
        meshes.push_back(nearby.value());
        nearby = brought_home(std::move(nearby).value(), 1, kHastyWork);
      }
      if (nearby || ends_run(nearby.error())) return nearby;
      failure_ = nearby.error();
    }
    // None came home at once: now more patiently.
    for (TetMesh& mesh : meshes) {
      Result<TetMesh> home = brought_home(std::move(mesh), kInVain, kRoundsWork);
      if (home || ends_run(home.error())) return home;
      failure_ = home.error();
    }
    return failure_;
  }

 private:
  Result<TetMesh> mesh_of(const Surface& nearby) {
    return timed_stage(
        "nearby_surface", job_.records, job_.context, [&](StageRecord& record) -> Result<TetMesh> {
          Result<Diagnosis> d = diagnose(nearby, {}, job_.context);
          if (!d) return d.error();
          if (const std::optional<Error> refused = refuse(d.value()))
            return Error{ErrorCode::unsolved, "A surface close to this one has no mesh: " + refused->message};
          Result<ImmersionResult> r =
              immerse(nearby, d.value().pairs, d.value().wound.edges, {}, job_.context);
          if (!r) return r.error();
          record.figures = {{"tets", std::int64_t{r.value().mesh.T.rows()}}};
          return std::move(r.value().mesh);
        });
  }

  // Back to the input, in rounds: among other tets what was locked may be free again.
  Result<TetMesh> brought_home(TetMesh mesh, int most_rounds, double work) {
    return timed_stage("volume_map", job_.records, job_.context, [&](StageRecord& record) -> Result<TetMesh> {
      for (int round = 0;; ++round) {
        std::optional<TetMesh> locked;
        VolumeMapOptions options;
        options.work = work;
        options.on_locked = [&](const TetMesh& at, const std::vector<Index>&) { locked = at; };
        Result<VolumeMapResult> r = volume_map(mesh, job_.surface.V, {}, options, job_.context);
        record.iterations = round + 1;
        if (r) return std::move(r.value().mesh);
        if (!locked || round + 1 == most_rounds) return r.error();
        mesh = std::move(*locked);
        Result<ImproveResult> better = improve(mesh, {}, job_.context);
        if (!better) return better.error();
      }
    });
  }

  const MeshingJob& job_;
  Error failure_;
};

}  // namespace

bool may_coincide(const MeshingJob& job) { return !job.diagnosis.pairs.empty() && !job.part_without_mesh; }

Result<TetMesh> mesh_by_nearby_surface(const MeshingJob& job) { return NearbySurface(job).run(); }

}  // namespace overtet
