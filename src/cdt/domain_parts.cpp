#include "src/cdt/domain_parts.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <iterator>
#include <numeric>
#include <span>
#include <tuple>

#include "kernels/core/tet_tables.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "src/cdt/tuning.h"
#include "src/cdt/unsolved.h"

namespace overtet {

namespace {

// Boxes with about equally many points in each, by halving along the longest side.
class Halving {
 public:
  Halving(std::vector<Eigen::Vector3d> points, Index boxes) : points_(std::move(points)) {
    split(points_, 0, boxes);
  }
  Index find(const Eigen::Vector3d& p) const {
    std::size_t node = 0;
    while (nodes_[node].above != 0)
      node = p[nodes_[node].axis] < nodes_[node].cut ? node + 1 : nodes_[node].above;
    return nodes_[node].box;
  }

 private:
  struct Node {
    int axis = 0;
    double cut = 0;
    std::size_t above = 0;  // the other one is the next; 0: a box
    Index box = 0;
  };
  void split(std::span<Eigen::Vector3d> points, Index first, Index boxes) {
    const std::size_t node = nodes_.size();
    nodes_.emplace_back();
    nodes_[node].box = first;
    if (boxes == 1) return;
    Eigen::AlignedBox3d box;
    for (const auto& p : points) box.extend(p);
    int axis = 0;
    box.sizes().maxCoeff(&axis);
    const Index below = boxes / 2;
    const std::size_t at = points.size() * below / boxes;
    std::nth_element(
        points.begin(), points.begin() + at, points.end(),
        [axis](const Eigen::Vector3d& a, const Eigen::Vector3d& b) { return a[axis] < b[axis]; });
    nodes_[node].axis = axis;
    nodes_[node].cut = points[at][axis];
    split(points.first(at), first, below);
    nodes_[node].above = nodes_.size();
    split(points.subspan(at), first + below, boxes - below);
  }

  std::vector<Eigen::Vector3d> points_;
  std::vector<Node> nodes_;
};

// How it works. Tets that can be reached from outside the hull without passing through a facet are nobody's.
// The others are shared out; a part's complex has the facets on and in its tets, and the faces between them
// and those of other parts. Every way from a part's inside to what is not its own passes through one of
// these, so TetGen, which fills what is enclosed, fills at least the part. What it fills beyond the faces
// between parts belongs to others and is dropped, and what is neither inside any facets nor the outside of
// all (around a missing facet nobody knows) goes when the parts have been joined and the whole is seen from
// outside.
// More than 12 members: four of them are names for fields of DelaunayMatch.
class Parts {
 public:
  Parts(const DelaunayMatch& match, const PartsOptions& options, const RunContext& context)
      : match_(match),
        plc_(match.plc),
        tet_(match.tet),
        next_(match.next),
        facet_on_(match.facet_on),
        facets_(match.facets),
        options_(options),
        context_(context) {}

  Result<TetgenResult> run();

 private:
  // What TetGen gets: facets, and faces of Delaunay tets between parts.
  struct Row {
    Triple face;  // if shared, counter-clockwise seen from outside of the part
    Index facet;  // or -1
    bool shared;  // with another part
  };
  // A face between parts, and the tet of the result inside of it.
  struct Door {
    Triple key;
    Index tet;
    int corner;
    bool operator<(const Door& other) const { return std::tie(key, tet) < std::tie(other.key, other.tet); }
  };
  struct Part {
    std::vector<Index> tets;
    std::vector<std::pair<Index, Index>> missing;  // a tet that it passes through, facet
    bool stubborn = false;                         // TetGen shall try all orders of points
    std::vector<Row> rows;
    std::vector<Index> vertices;  // the numbers of TetGen's input vertices
    TetgenResult result;
    std::vector<Index> kept;                     // tets of the result
    std::vector<std::array<Index, 4>> facet_on;  // per tet of the result: row of result.facets, or -1
    std::vector<Door> doors;
    std::optional<Error> error;

    Index local(Index v) const {
      return static_cast<Index>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
    }
  };

  Eigen::Vector3d centre_of_tet(Index t) const {
    const Eigen::RowVector3d sum =
        plc_.V.row(tet_[t][0]) + plc_.V.row(tet_[t][1]) + plc_.V.row(tet_[t][2]) + plc_.V.row(tet_[t][3]);
    return sum.transpose() / 4;
  }

  void find_clumps();
  void find_outside();
  bool share_out(Part& whole, Index count);
  bool again(std::size_t number);
  void mesh(Part& part) const;
  void collect_rows(Part& part) const;
  std::optional<Error> sort_out(Part& part) const;
  Result<TetgenResult> join() const;

  const DelaunayMatch& match_;
  const Plc& plc_;
  const RawVector<Tet>&tet_, &next_, &facet_on_;
  const std::vector<Triple>& facets_;
  const PartsOptions& options_;
  const RunContext& context_;
  std::vector<Index> clump_of_;            // per tet: tets that missing facets join, or -1
  std::vector<Eigen::Vector3d> clump_at_;  // per clump
  std::vector<Index> part_of_;             // per tet; -1: outside
  std::vector<Part> parts_;
};

Result<TetgenResult> Parts::run() {
  const Index facets = static_cast<Index>(facets_.size());
  if (facets < options_.facets_per_part / 2)
    return unsolved("There are too few facets to cut them into parts.");
  const Index count =
      2 * std::max<Index>(1, facets / (2 * options_.facets_per_part));  // even: two threads get as much each
  std::vector<char> used(plc_.V.rows(), 0);
  for (const Triple& f : facets_)
    for (const Index v : f) used[v] = 1;
  if (std::find(used.begin(), used.end(), 0) != used.end())
    return unsolved("Some points belong to no facet.");
  find_clumps();
  find_outside();
  Part whole;
  for (Index t = 0; t < static_cast<Index>(tet_.size()); ++t)
    if (part_of_[t] == 0) whole.tets.push_back(t);
  for (std::size_t i = 0; i < match_.crossed.size(); ++i)
    if (i == 0 || match_.crossed[i].second != match_.crossed[i - 1].second)
      whole.missing.push_back(match_.crossed[i]);
  if (!share_out(whole, count)) return unsolved("There is no place to cut.");
  for (std::size_t done = 0; done < parts_.size();) {
    const std::size_t end = parts_.size();
    parallel_for(static_cast<std::int64_t>(end - done), 1,
                 [&](std::int64_t i, std::int64_t) { mesh(parts_[done + i]); });
    for (; done < end; ++done)
      if (auto error = parts_[done].error; error && (error->code != ErrorCode::unsolved || !again(done)))
        return *error;
  }
  return join();
}

// Tets that one missing facet passes through, or several that have tets in common.
void Parts::find_clumps() {
  const auto& crossed = match_.crossed;
  UnionFind clumps(tet_.size());
  for (std::size_t i = 1; i < crossed.size(); ++i) {
    if (crossed[i].second == crossed[i - 1].second)
      clumps.join_smaller(crossed[i].first, crossed[i - 1].first);
  }
  clump_of_.assign(tet_.size(), -1);
  std::vector<Index> tets;
  const auto number = [&](Index t) {
    const Index root = clumps.root(t);
    if (clump_of_[root] < 0) {
      clump_of_[root] = static_cast<Index>(clump_at_.size());
      clump_at_.push_back(Eigen::Vector3d::Zero());
      tets.push_back(0);
    }
    return clump_of_[t] = clump_of_[root];
  };
  for (const auto& [t, f] : crossed) {
    const Index clump = number(t);
    clump_at_[clump] += centre_of_tet(t);
    ++tets[clump];
  }
  for (std::size_t c = 0; c < tets.size(); ++c) clump_at_[c] /= tets[c];
}

// Tets that can be reached from outside the hull without passing through a facet.
void Parts::find_outside() {
  part_of_.assign(tet_.size(), 0);
  std::vector<Index> stack;
  const auto enter = [&](Index t) {
    if (part_of_[t] < 0 || clump_of_[t] >= 0) return;
    part_of_[t] = -1;
    stack.push_back(t);
  };
  for (Index t = 0; t < static_cast<Index>(tet_.size()); ++t)
    for (int k = 0; k < 4; ++k)
      if (next_[t][k] < 0 && facet_on_[t][k] < 0) enter(t);
  while (!stack.empty()) {
    const Index t = stack.back();
    stack.pop_back();
    for (int k = 0; k < 4; ++k)
      if (next_[t][k] >= 0 && facet_on_[t][k] < 0) enter(next_[t][k]);
  }
}

// False, and nothing changes, where all would go to one part.
bool Parts::share_out(Part& whole, Index count) {
  const auto centre = [&](Index t) { return clump_of_[t] < 0 ? centre_of_tet(t) : clump_at_[clump_of_[t]]; };
  const std::int64_t n = static_cast<std::int64_t>(whole.tets.size());
  const std::int64_t step = std::max<std::int64_t>(1, n / (kSampledFacets * count));
  std::vector<Eigen::Vector3d> samples;
  for (std::int64_t i = 0; i < n; i += step) samples.push_back(centre(whole.tets[i]));
  if (static_cast<Index>(samples.size()) < count) return false;
  const Halving halving(std::move(samples), count);
  std::vector<Index> box(n);
  parallel_for(n, kLightGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t i = begin; i < end; ++i) box[i] = halving.find(centre(whole.tets[i]));
  });
  std::vector<Part> parts(count);
  for (std::int64_t i = 0; i < n; ++i) parts[box[i]].tets.push_back(whole.tets[i]);
  if (std::count_if(parts.begin(), parts.end(), [](const Part& p) { return !p.tets.empty(); }) < 2)
    return false;
  const Index first = static_cast<Index>(parts_.size());
  for (std::int64_t i = 0; i < n; ++i) part_of_[whole.tets[i]] = first + box[i];
  for (const auto& [t, f] : whole.missing) parts[part_of_[t] - first].missing.emplace_back(t, f);
  whole = {};
  std::move(parts.begin(), parts.end(), std::back_inserter(parts_));
  return true;
}

// What to do where TetGen fails: the part in halves, so that what it cannot do stays small, then all orders
// of points.
bool Parts::again(std::size_t number) {
  Part part = std::move(parts_[number]);
  parts_[number] = {};
  if (part.rows.size() > kSmallestPart && share_out(part, 2)) return true;
  if (part.stubborn) return false;
  Part next;
  next.tets = std::move(part.tets);
  next.missing = std::move(part.missing);
  next.stubborn = true;
  for (const Index t : next.tets) part_of_[t] = static_cast<Index>(parts_.size());
  parts_.push_back(std::move(next));
  return true;
}

void Parts::mesh(Part& part) const {
  if (part.tets.empty()) return;
  collect_rows(part);
  Plc plc;
  plc.V.resize(part.vertices.size(), 3);
  for (std::size_t v = 0; v < part.vertices.size(); ++v) plc.V.row(v) = plc_.V.row(part.vertices[v]);
  plc.F.resize(part.rows.size(), 3);
  for (std::size_t r = 0; r < part.rows.size(); ++r)
    for (int k = 0; k < 3; ++k) plc.F(r, k) = part.local(part.rows[r].face[k]);
  TetgenOptions options;
  options.quality = false;
  options.accept_split = options_.accept_split;
  options.accept_unused = true;
  options.patience = options_.patience;
  Result<TetgenResult> result = part.stubborn ? tetrahedralize_shuffled(plc, options, context_)
                                              : tetrahedralize(plc, options, context_);
  if (!result) {
    part.error = result.error();
    return;
  }
  part.result = std::move(result).value();
  part.error = sort_out(part);
}

void Parts::collect_rows(Part& part) const {
  const Index here = part_of_[part.tets[0]];
  for (const Index t : part.tets)
    for (int k = 0; k < 4; ++k) {
      const Index other = next_[t][k], f = facet_on_[t][k];
      const Index there = other < 0 ? -1 : part_of_[other];
      // Between two tets of the part, the first one sees to it.
      if (there == here ? f < 0 || other < t : f < 0 && there < 0) continue;
      part.rows.push_back({tet_face(tet_[t], k), f, there >= 0 && there != here});
    }
  for (const auto& [t, f] : part.missing) part.rows.push_back({facets_[f], f, false});
  for (const Row& row : part.rows)
    part.vertices.insert(part.vertices.end(), row.face.begin(), row.face.end());
  std::sort(part.vertices.begin(), part.vertices.end());
  part.vertices.erase(std::unique(part.vertices.begin(), part.vertices.end()), part.vertices.end());
}

// Which tets of the result lie in the part, and where its facets and doors are.
std::optional<Error> Parts::sort_out(Part& part) const {
  const TetgenResult& r = part.result;
  std::vector<Triple> triangles(r.facets.rows());
  std::vector<Index> pieces(part.rows.size(), 0);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    triangles[i] = {r.facets(i, 0), r.facets(i, 1), r.facets(i, 2)};
    ++pieces[r.facet_sources[i]];
  }
  const TriangleTable table(static_cast<Index>(r.V.rows()), triangles);
  const Index n = static_cast<Index>(r.T.rows());
  const Index given = static_cast<Index>(part.vertices.size());
  part.facet_on.assign(n, {-1, -1, -1, -1});
  std::vector<char> closed(n, 0), beyond(n, 0);  // closed: a bit for each face
  std::vector<Index> stack;
  for (Index t = 0; t < n; ++t) {
    const Tet tet{r.T(t, 0), r.T(t, 1), r.T(t, 2), r.T(t, 3)};
    for (int k = 0; k < 4; ++k) {
      const Triple face = tet_face(tet, k);
      const Index i = table.find(face);
      if (i < 0) continue;
      const Row& row = part.rows[r.facet_sources[i]];
      closed[t] |= 1 << k;
      if (row.facet >= 0) part.facet_on[t][k] = i;
      if (!row.shared) continue;
      if (pieces[r.facet_sources[i]] != 1 || face[0] >= given || face[1] >= given || face[2] >= given)
        return unsolved("TetGen split a face between parts.");
      const Triple global{part.vertices[face[0]], part.vertices[face[1]], part.vertices[face[2]]};
      if (same_turn(row.face, global)) {
        part.doors.push_back({sorted(global), t, k});
      } else if (!beyond[t]) {
        beyond[t] = 1;
        stack.push_back(t);
      }
    }
  }
  while (!stack.empty()) {
    const Index t = stack.back();
    stack.pop_back();
    for (int k = 0; k < 4; ++k)
      if (const Index other = r.neighbours(t, k); other >= 0 && !(closed[t] >> k & 1) && !beyond[other]) {
        beyond[other] = 1;
        stack.push_back(other);
      }
  }
  for (const Door& door : part.doors)
    if (beyond[door.tet]) return unsolved("TetGen did not keep parts apart.");
  for (Index t = 0; t < n; ++t)
    if (!beyond[t]) part.kept.push_back(t);
  return std::nullopt;
}

Result<TetgenResult> Parts::join() const {
  Index tetgen_facets = 0, parts = 0;
  std::size_t peak = 0;
  const Index given = static_cast<Index>(plc_.V.rows()), facets = static_cast<Index>(facets_.size());
  std::vector<Triple> facet = facets_;
  std::vector<Index> source(facets);
  std::iota(source.begin(), source.end(), 0);
  std::vector<char> found(facets, 0);
  std::vector<Eigen::Vector3d> added;
  RawVector<Tet> tet, next, facet_on;
  std::vector<Door> doors;
  for (const Part& part : parts_) {
    const TetgenResult& r = part.result;
    std::vector<Index> vertex(part.vertices), row(r.facets.rows(), -1), number(r.T.rows(), -1);
    for (Index v = static_cast<Index>(vertex.size()); v < r.V.rows(); ++v) {
      vertex.push_back(given + static_cast<Index>(added.size()));
      added.push_back(r.V.row(v));
    }
    for (Index i = 0; i < r.facets.rows(); ++i) {
      const Row& from = part.rows[r.facet_sources[i]];
      if (from.facet < 0) continue;
      const Triple t{vertex[r.facets(i, 0)], vertex[r.facets(i, 1)], vertex[r.facets(i, 2)]};
      if (!found[from.facet] || from.shared) {
        row[i] = from.facet;
        facet[from.facet] = t;
        found[from.facet] = 1;
      } else {
        row[i] = static_cast<Index>(facet.size());
        facet.push_back(t);
        source.push_back(from.facet);
      }
    }
    const Index first = static_cast<Index>(tet.size());
    for (std::size_t i = 0; i < part.kept.size(); ++i) number[part.kept[i]] = first + static_cast<Index>(i);
    for (const Index t : part.kept) {
      Tet corners, beside, on;
      for (int k = 0; k < 4; ++k) {
        corners[k] = vertex[r.T(t, k)];
        beside[k] = r.neighbours(t, k) < 0 ? -1 : number[r.neighbours(t, k)];
        on[k] = part.facet_on[t][k] < 0 ? -1 : row[part.facet_on[t][k]];
      }
      tet.push_back(corners);
      next.push_back(beside);
      facet_on.push_back(on);
    }
    for (const Door& door : part.doors) doors.push_back({door.key, number[door.tet], door.corner});
    tetgen_facets += static_cast<Index>(part.rows.size());
    peak = std::max(peak, r.peak_rss_bytes);
    parts += !part.tets.empty();
  }
  if (std::find(found.begin(), found.end(), 0) != found.end()) return unsolved("TetGen lost a facet.");
  std::sort(doors.begin(), doors.end());
  for (std::size_t i = 1; i < doors.size(); ++i)
    if (doors[i - 1].key == doors[i].key) {
      next[doors[i - 1].tet][doors[i - 1].corner] = doors[i].tet;
      next[doors[i].tet][doors[i].corner] = doors[i - 1].tet;
    }
  Result<TetgenResult> out =
      without_outside(plc_, {tet, next, facet_on, facet, source, added, static_cast<Index>(plc_.V.rows())},
                      std::vector<char>(tet.size(), 0));
  if (out) {
    out.value().tetgen_facets = tetgen_facets;
    out.value().peak_rss_bytes = peak;
    out.value().parts = parts;
  }
  return out;
}

}  // namespace

Result<TetgenResult> mesh_in_parts(DelaunayMatch& match, const PartsOptions& options,
                                   const RunContext& context) {
  match.find_crossed_tets();
  if (match.crossed.size() > kMostCrossed * match.missing.size())
    return unsolved("Missing facets pass through too many tets.");
  return Parts(match, options, context).run();
}

}  // namespace overtet
