// Skinning weights on tet meshes that overlap themselves: how much each handle moves each vertex. Where two
// layers of the solid lie in one place, a handle in one of them does not move the other.
//
// Handles are points and bones, as in a skeleton. All results are the same bytes on any number of threads.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "overtet/io.h"
#include "overtet/result.h"
#include "overtet/run_context.h"
#include "overtet/types.h"

namespace overtet {

// A point of the solid. A position that several layers have in common does not say which of them is meant:
// `layer` does, or the bones and cages that lead there from a place that is in one layer only.
struct HandlePlace {
  Eigen::Vector3d position = Eigen::Vector3d::Zero();
  std::optional<Index> vertex;  // of the mesh: its position counts
  std::optional<int> layer;  // of those at the position, counted from 0 in the order of their smallest tets
};

struct Handle {
  std::string name;  // one of a kind, not empty
  int place = 0;     // of a point; of a bone its head
  int tail = -1;     // of a bone: the place where it ends; -1: a point
  int parent = -1;   // the handle whose motion it takes part in; -1: none

  bool bone() const { return tail >= 0; }
};

// Numbers of places and handles are counted from 0. Bones that share a place hang together there.
struct Handles {
  std::vector<HandlePlace> places;
  std::vector<Handle> handles;
  // Between places of point handles, which are the cage's vertices: weights are linear along them.
  std::vector<std::array<int, 2>> cage_edges;
  std::vector<std::array<int, 3>> cage_faces;

  // Numbers in range, names, no cycle of parents; cages between points. Errors: usage.
  Status validate() const;
};

struct WeightOptions {
  // A bone that leaves the solid is cut off there; otherwise it is an error.
  bool cut_bones = false;

  Status validate() const;  // Errors: usage.
};

enum class WeightsEnd {
  exact,   // the conditions of Karush, Kuhn and Tucker hold to 1e-10
  gap,     // the energy is the least one but for a part of at most 1e-14
  stalled  // neither is reached: doubles have too few digits for this mesh; the residual says how far it came
};

struct HandleWeights {
  double energy = 0;  // w' K M^-1 K w / 2, of the weights before they were divided by their sum
  double residual =
      0;  // of the conditions of Karush, Kuhn and Tucker: how far a weight is from where they want it
  int interior_steps = 0, active_set_steps = 0;  // a factorisation each
  WeightsEnd end = WeightsEnd::exact;
  Index held = 0;     // vertices at which the weight is given and not 0
  double cut_at = 1;  // of a bone: the part of its length that is in the solid
};

struct SkinningWeights {
  // #V x #H: at least 0, at most 1, and their sum is 1 (but for vertices of no tet, whose weights are 0).
  Eigen::MatrixXd weights;
  std::vector<HandleWeights> handles;
  double least_sum = 1, most_sum = 1;  // of the weights of a vertex, before they were divided by it
  Index shared = 0;                    // vertices that several handles hold, in equal parts
  double factor_entries = 0;           // of the Cholesky factor of all free vertices
  double seconds_prepare = 0, seconds_solve = 0;
};

// Bounded biharmonic weights [Jacobson, Baran, Popovic, Sorkine 2011]: for each handle the w that minimises
// w' K M^-1 K w / 2 (K: stiffness of linear elements, M: lumped mass; what their mixed method has as natural
// boundary conditions), where 0 <= w <= 1, w is 1 at the handle and 0 at the others. Each is solved to the
// conditions of optimality; then the weights of a vertex are divided by their sum, as the authors do it. (The
// joint problem, with the sum as a constraint, is not solved.)
//
// Where a handle is: a linear function of values up to 1 is 1 inside a tet only if it is at all corners. So
// what is held are the corners of the tets that a bone goes through, and of the tet of a point (of an edge or
// a face where it lies in one). Bones are followed from tet to tet, so that they stay in their layer; where
// they begin or end decides the layer, or what is known of the bones that they hang together with. A vertex
// that k handles hold has 1/k of each. Along the edges and faces of a cage, which are followed likewise, the
// corners get what the linear function is at the nearest point, where no point or bone holds them already. In
// a component of the tets that holds one handle only, that has weight 1.
//
// Errors: usage (handles; a place outside the solid, in several layers, or in a tet whose component no handle
// holds; a bone that leaves the solid: with the place), bad_input (a tet that is not positive, a face of more
// than two tets), unsolved (the system is not positive definite in doubles, or all weights of a vertex are
// 0), limit, interrupted.
Result<SkinningWeights> skinning_weights(const TetMesh& mesh, const Handles& handles,
                                         const WeightOptions& options = {}, const RunContext& context = {});

// What a pose does to one handle: x -> rotation (x - head) + head + translation, or `matrix` (applied to
// (x, y, z, 1)) in its place. Handles that have parents move with them first.
using AffineMatrix = Eigen::Matrix<double, 3, 4, Eigen::RowMajor>;
struct HandlePose {
  Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();
  std::optional<AffineMatrix> matrix;
};

// Of each handle the map of space, parents' motion included. V: of the mesh, for places that are vertices.
// pre: the handles are valid, poses are as many as handles. Errors: usage (a vertex that does not exist, a
// rotation of length 0, numbers that are not finite).
Result<std::vector<AffineMatrix>> pose_transforms(const Handles& handles, const VertexMatrix& V,
                                                  const std::vector<HandlePose>& poses);

struct SkinnedMesh {
  TetMesh mesh;
  Index flipped = 0;         // tets that are not positive any more, decided exactly
  Index first_flipped = -1;  // the first of them
};

// Linear blend skinning: vertex v goes to v + the sum of w_h (T_h v - v). Identities leave it as it is, to
// the last bit. weights: #V x #H. Errors: usage (sizes; what is not finite).
Result<SkinnedMesh> skinned(const TetMesh& mesh, const Eigen::MatrixXd& weights,
                            const std::vector<AffineMatrix>& transforms);

// Files.

// JSON, schema in docs/handles.md, or TGF (.tgf): points as lines "number x y z", a line "#", then edges
// "number number bone pseudo cage", counted from 1, where of the last three (0 or 1, each may be left out)
// pseudo edges are passed over. Points of no bone are point handles, named point_N; bones come after them,
// named bone_N in their order (from 1), children of the bone that ends where they begin. Errors: bad_input
// (the message names the line or the entry), io.
Result<Handles> read_handles(const std::string& path);

// JSON: of each handle that moves, by name, its motion (docs/handles.md). Errors: bad_input, io.
Result<std::vector<HandlePose>> read_pose(const std::string& path, const Handles& handles);

// The same of what is in memory; messages call it `name`, whose ending says what it is.
Result<Handles> parse_handles(std::string_view name, std::string_view text);
Result<std::vector<HandlePose>> parse_pose(std::string_view name, std::string_view json,
                                           const Handles& handles);

// Weights as text: a line a vertex, a column a handle, with a first line of names. Numbers read back as the
// same doubles. Errors: usage (sizes), io.
Status write_weights_csv(const std::string& path, const Handles& handles, const Eigen::MatrixXd& weights,
                         const RunContext& context = {});
// By the names of the handles, columns in any order. Errors: bad_input (the message names the line), io.
Result<Eigen::MatrixXd> read_weights_csv(const std::string& path, const Handles& handles);
Result<Eigen::MatrixXd> parse_weights_csv(std::string_view name, std::string_view text,
                                          const Handles& handles);

// The boundary as a skinned mesh of glTF 2 (.glb): a node a handle at its head, JOINTS_n and WEIGHTS_n of
// four each (two of them at most), inverse bind matrices. Positions and weights are floats; a weight that is
// nearly 0 (below half of what glTF's 16-bit weights can say) is left out, so are all but the eight largest,
// and the rest is divided by its sum. Errors: usage, io.
struct SkinFigures {
  int sets = 1;        // of JOINTS_n and WEIGHTS_n
  double dropped = 0;  // the largest sum of weights that was left out at a vertex
};
Result<SkinFigures> write_skin(const std::string& path, const TetMesh& mesh, const Handles& handles,
                               const Eigen::MatrixXd& weights, const RunContext& context = {});

}  // namespace overtet
