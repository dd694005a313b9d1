// What the repairs of one surface share: the surface and how far its vertices may move, meshes of moved
// surfaces, and the way back from them. Internal to src/pipeline.
#pragma once

#include <Eigen/Core>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

#include "overtet/report.h"
#include "overtet/run_context.h"
#include "overtet/types.h"
#include "src/certificates/diagnose.h"
#include "src/opening/opening.h"
#include "src/pipeline/pipeline.h"

namespace overtet {

struct RepairJob {
  const Surface& surface;         // as it was read
  const Diagnosis& diagnosis;     // of it, with the whole winding range
  const MeshingOptions& options;  // of the run
  const RunContext& context;
  std::vector<StageRecord>& records;
  double diagonal;  // of the surface's bounding box

  double allowed() const { return options.max_repair_move; }  // of the diagonal
};

// Vertices that are not where they were read.
struct Moves {
  std::vector<Index> vertices;                 // increasing
  double max_relative = 0, mean_relative = 0;  // of those that moved, to the diagonal
};

struct RepairedMesh {
  enum class State {
    finished,       // improved and checked
    as_made,        // checked, not improved
    pulled,         // its vertices moved since then: to be improved and checked again
    brought_nearer  // the same, but what was too far away was brought nearer at most, and not pulled home
  };
  Surface surface;
  TetMesh mesh;  // of `surface`
  State state = State::finished;
  Moves moves;
  double work = 0;  // of the last pull; VolumeMapResult::work
  // What it was pulled from, where that is near enough as well.
  std::shared_ptr<RepairedMesh> before_pull;
};

RepairedMesh measured(const RepairJob& job, TetMesh mesh);
// Without a mesh.
RepairedMesh moved_to(const RepairJob& job, const VertexMatrix& V);

// Few vertices, and small moves, count alike; nothing counts as much as a move that is too large.
double cost(const RepairJob& job, const Moves& moves);
// Fewer vertices, less far altogether, and none much further.
bool better(const Moves& a, const Moves& b);

// Errors of a run that repairing may help with.
bool repairable(const Error& error);

enum class Need {
  first,  // there is no mesh yet
  luxury  // there is one of another repaired surface: none is worth waiting for
};
struct MeshAttempt {
  Result<TetMesh> mesh;                    // in the input's space, improved and checked
  std::optional<Eigen::Vector3d> unglued;  // where the sheets could not be glued
};
// Whether the quality pass is made of it: what is pulled wants good tets, what is opened can do without.
enum class Tets { improved, as_made };
MeshAttempt mesh_moved(const RepairJob& job, const Surface& moved, Need need, Tets tets = Tets::improved);
// A mesh of the moved surface that there is already, improved and checked.
Result<TetMesh> finish_moved(const RepairJob& job, const Surface& moved, TetMesh mesh);

// Moved vertices moved further, no further than is allowed, where the tets at them are bad, and nearer to
// their places where that leaves them good (src/opening). Returns the least angle at them, in degrees.
// Errors: limit, interrupted.
Result<double> opened(const RepairJob& job, RepairedMesh& repaired,
                      OpeningOptions::Moves moves = OpeningOptions::Moves::surface);

// The boundary of a mesh pulled to the input, every tet positive all the way (src/volume_map).
struct Pull {
  // Measured: fewer rings and a force that grows faster cost a third and end as near, but not after moves
  // that went far.
  enum class Pace { quick, slow };
  enum class Aim {
    home,
    nearer  // what is further away than largest_move first, at the cost of others; only that where it does
  };
  Pace pace = Pace::quick;
  double largest_move = std::numeric_limits<double>::infinity();  // of the diagonal; VolumeMapOptions
  Aim aim = Aim::home;
};
// None: it cannot be pulled. Errors: limit, interrupted.
Result<std::optional<RepairedMesh>> pulled(const RepairJob& job, const RepairedMesh& from, const Pull& pull);

}  // namespace overtet
