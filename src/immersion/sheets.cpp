#include "src/immersion/sheets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <deque>
#include <functional>
#include <map>
#include <numeric>
#include <optional>
#include <set>
#include <string>
#include <tuple>

#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"

namespace overtet {

namespace {

using Triple = std::array<Index, 3>;

// The face opposite to corner k of a positive tet, oriented outward.
constexpr int kFace[4][3] = {{1, 2, 3}, {0, 3, 2}, {0, 1, 3}, {0, 2, 1}};

// Regions with more gluings than this (windings beyond 4) have none listed beforehand: those that can be
// right are made from the gluings around them.
constexpr double kMostListed = 150;

// Where that must do, and nothing around is known, beyond this number the search gives up.
constexpr double kMostOptions = 50'000;

// At an edge that may be wound all numbers of turns are tried where a region has no more gluings than the
// first of these numbers (windings of 5 and 6), else as many turns as the second one.
constexpr double kMostTurned = 6000;
constexpr int kMostTurnsMade = 2;

// Search steps before the constraint problem counts as unsolved; natural inputs need about one a region.
constexpr std::int64_t kMostSearchNodes = 2'000'000;

// Of these, the first attempt at some regions takes so many, and so many a region.
constexpr std::int64_t kFirstNodes = 1000;
constexpr std::int64_t kFirstNodesEach = 10;

// Where options have to be made each step takes much longer: so many a region, and as many attempts at most.
constexpr std::int64_t kMostNodesMade = 3;
constexpr std::int64_t kAttemptsMade = 2;

// Rounds of the search with free edges; each but the last has found edges whose parts did not agree.
constexpr int kFreeRounds = 4;

// A wound edge that other faces pierce counts like this many others: its points are hard to take off the
// boundary.
constexpr double kPiercedCost = 50;

Triple sorted(Triple t) {
  std::sort(t.begin(), t.end());
  return t;
}

constexpr std::int64_t kTetGrain = 1 << 14;

// Finds triangles by their three vertices; open addressing, insertion order does not matter.
class TriangleTable {
 public:
  explicit TriangleTable(std::size_t n) {
    std::size_t size = 16;
    while (size < 2 * n + 2) size *= 2;
    slot_.assign(size, -1);
  }
  void insert(const Triple& key, Index value) {
    std::size_t at = hash(key);
    while (slot_[at] >= 0) at = (at + 1) & (slot_.size() - 1);
    slot_[at] = static_cast<Index>(keys_.size());
    keys_.push_back(key);
    values_.push_back(value);
  }
  Index find(const Triple& key) const {
    for (std::size_t at = hash(key); slot_[at] >= 0; at = (at + 1) & (slot_.size() - 1))
      if (same(keys_[slot_[at]], key)) return values_[slot_[at]];
    return -1;
  }

 private:
  // The array's own operator calls memcmp.
  static bool same(const Triple& a, const Triple& b) { return a[0] == b[0] && a[1] == b[1] && a[2] == b[2]; }
  std::size_t hash(const Triple& k) const {
    std::uint64_t h = static_cast<std::uint64_t>(k[0]) * 0x9e3779b97f4a7c15ull;
    h = (h ^ (h >> 29) ^ static_cast<std::uint64_t>(k[1])) * 0xbf58476d1ce4e5b9ull;
    h = (h ^ (h >> 32) ^ static_cast<std::uint64_t>(k[2])) * 0x94d049bb133111ebull;
    return (h ^ (h >> 31)) & (slot_.size() - 1);
  }
  std::vector<Index> slot_;
  std::vector<Triple> keys_;
  std::vector<Index> values_;
};

struct Option {
  std::vector<int> back_of, front_of;
};

// Copies carry no names. Where one side's copies get theirs from a gluing, of all gluings that differ by a
// relabelling of that side one remains: matched copies in the order of the other side, then those that end by
// slot.
enum class Named { neither, front, back };

// The number of gluings of a region, in doubles since it grows like a factorial; 0 when there is none.
double count_options(const Region& region, Named named) {
  double plus = 0, minus = 0;
  for (const int sign : region.signs) ++(sign > 0 ? plus : minus);
  const double front = region.front_winding, back = region.back_winding, matched = back - plus;
  if (matched < 0 || matched != front - minus) return 0;
  const auto factorial = [](double n) { return std::tgamma(n + 1); };
  if (named == Named::back) return factorial(front) / factorial(matched);
  if (named == Named::front) return factorial(back) / factorial(matched);
  return factorial(front) * factorial(back) / factorial(matched);
}

// All gluings of `front` copies to `back` copies with the given sheets ending in between.
template <class Options>
void enumerate_options(const Region& region, Named named, Options& out) {
  const int front = region.front_winding, back = region.back_winding;
  std::vector<int> plus, minus;
  for (int s = 0; s < static_cast<int>(region.signs.size()); ++s)
    (region.signs[s] > 0 ? plus : minus).push_back(s);
  Option option{std::vector<int>(front, -100), std::vector<int>(back, -100)};
  const std::function<void(int)> place_matched = [&](int f) {
    while (f < front && option.back_of[f] != -100) ++f;
    if (f >= front) return out.push_back(option);
    for (int b = 0; b < back; ++b) {
      if (option.front_of[b] != -100) continue;
      option.back_of[f] = b, option.front_of[b] = f;
      place_matched(f + 1);
      option.back_of[f] = -100, option.front_of[b] = -100;
      if (named != Named::neither) break;  // in order
    }
  };
  // The slots of a named side take its last copies.
  const auto place = [&](auto&& self, const std::vector<int>& slots, std::size_t i, std::vector<int>& side,
                         bool last, const std::function<void()>& next) -> void {
    if (i == slots.size()) return next();
    const int n = static_cast<int>(side.size()), first = last ? n - static_cast<int>(slots.size() - i) : 0;
    for (int c = first; c < n; ++c) {
      if (side[c] != -100) continue;
      side[c] = -1 - slots[i];
      self(self, slots, i + 1, side, last, next);
      side[c] = -100;
      if (last) break;
    }
  };
  place(place, plus, 0, option.front_of, named == Named::back,
        [&] { place(place, minus, 0, option.back_of, named == Named::front, [&] { place_matched(0); }); });
}

// One edge of the arrangement with all facets around it.
struct Fan {
  struct Leaf {
    Index region;
    bool flipped;
    std::vector<Index> slots;  // region slot of each local sheet
    auto operator<=>(const Leaf&) const = default;
  };
  // A sheet arrives at leaf `from`, slot `from_sheet`, and must leave at the other after `turns` extra turns.
  struct Pass {
    int from, from_sheet, to, to_sheet, turns;
    auto operator<=>(const Pass&) const = default;
  };
  std::vector<Leaf> leaves;
  std::vector<std::array<int, 2>>
      arc;  // per leaf and side (0 front, 1 back): 2 * leaf + side it faces, or -1
  std::vector<Pass> passes;
  auto operator<=>(const Fan&) const = default;
};

// Follows every copy around the edge. chosen: per region, its option.
// turns: what every pass must make instead of its own number, if not negative.
bool satisfied(const Fan& fan, const std::vector<const Option*>& chosen, const std::vector<Region>& regions,
               int turns_wanted = -1) {
  const int n = static_cast<int>(fan.leaves.size());
  // Copy `copy` in the cell on `side` of a leaf crosses the leaf: (other side's copy) or -1 - local sheet.
  const auto cross = [&](int leaf, int side, int copy) {
    const Fan::Leaf& l = fan.leaves[leaf];
    const Option& option = *chosen[l.region];
    const bool from_front = (side == 0) != l.flipped;
    const int to = from_front ? option.back_of[copy] : option.front_of[copy];
    if (to >= 0) return to;
    const auto local = std::find(l.slots.begin(), l.slots.end(), -1 - to);
    return -1 - static_cast<int>(local - l.slots.begin());
  };
  const auto copies = [&](int leaf, int side) {
    const Fan::Leaf& l = fan.leaves[leaf];
    const Region& r = regions[l.region];
    return static_cast<int>((side == 0) != l.flipped ? r.front_winding : r.back_winding);
  };
  // visited[leaf][copy on its front side] for sheets that cross the leaf
  std::vector<std::vector<char>> visited(n);
  for (int i = 0; i < n; ++i) visited[i].assign(copies(i, 0), 0);
  const int most_steps = 64 * n + 64;
  for (const Fan::Pass& pass : fan.passes) {
    // Both directions are listed or one: start inside the solid at `from`.
    const Fan::Leaf& l = fan.leaves[pass.from];
    const Region& r = regions[l.region];
    const Index slot = l.slots[pass.from_sheet];
    const bool inside_is_back = (r.signs[slot] > 0) != l.flipped;
    int side = inside_is_back ? 1 : 0, leaf = pass.from, copy = -1;
    const Option& option = *chosen[l.region];
    const auto& ends = r.signs[slot] > 0 ? option.front_of : option.back_of;
    for (int c = 0; c < static_cast<int>(ends.size()); ++c)
      if (ends[c] == -1 - slot) copy = c;
    int turns = 0;
    for (int step = 0;; ++step) {
      if (step > most_steps) return false;
      const int arrival = fan.arc[leaf][side];
      if (arrival < 0) return false;
      leaf = arrival / 2, side = arrival % 2;
      const int next = cross(leaf, side, copy);
      if (next < 0) {
        const int wanted = turns_wanted < 0 ? pass.turns : turns_wanted;
        if (leaf != pass.to || -1 - next != pass.to_sheet || turns != wanted) return false;
        break;
      }
      if (leaf == pass.from) ++turns;
      visited[leaf][side == 0 ? copy : next] = 1;
      copy = next, side = 1 - side;
    }
  }
  for (int i = 0; i < n; ++i) {
    for (int start = 0; start < static_cast<int>(visited[i].size()); ++start) {
      if (visited[i][start]) continue;
      int next = cross(i, 0, start);
      if (next < 0) continue;
      visited[i][start] = 1;
      int leaf = i, side = 1, copy = next;
      for (int step = 0;; ++step) {
        if (step > most_steps) return false;
        const int arrival = fan.arc[leaf][side];
        if (arrival < 0) return false;
        leaf = arrival / 2, side = arrival % 2;
        if (leaf == i) {
          if (side != 0 || copy != start) return false;
          break;
        }
        next = cross(leaf, side, copy);
        if (next < 0) return false;  // belongs to no pass
        visited[leaf][side == 0 ? copy : next] = 1;
        copy = next, side = 1 - side;
      }
    }
  }
  return true;
}

class Assigner {
 public:
  Assigner(const Surface& surface, const Arrangement& arrangement, const TetgenResult& tets,
           std::span<const WoundEdge> wound, const RunContext& context)
      : surface_(surface), arrangement_(arrangement), tets_(tets), context_(context) {
    for (const WoundEdge& w : wound) turns_[{std::min(w.a, w.b), std::max(w.a, w.b)}] = w.k;
  }

  Result<Sheets> run() {
    find_facets();
    find_cells();
    if (auto error = find_windings()) return *error;
    cut_handles();
    if (auto error = find_edges()) return *error;
    std::optional<Error> failure = solve();
    if (!failure) return std::move(out_);
    if (failure->code != ErrorCode::unsolved) return *failure;
    // The wound edges given leave no gluing. Let every edge that could be wound take part in the search.
    free_ = true;
    for (int round = 0; round < kFreeRounds; ++round) {
      reset();
      if (auto error = find_edges()) return *error;
      if (auto error = solve()) {
        if (error->code != ErrorCode::unsolved) return *error;
        failure->exhausted = round == 0 && !cut_short_ && !in_doubt_;
        return *failure;
      }
      if (settle_free_edges()) return std::move(out_);
    }
    return *failure;
  }

 private:
  using Edge = std::pair<Index, Index>;  // of the input, smaller vertex first

  void reset() {
    for (Facet& f : out_.facets) f.region = -1, f.flipped = false, f.slots = -1;
    out_.regions.clear();
    out_.slot_map.clear();
    region_front_.clear();
    region_back_.clear();
    fans_.clear();
    fan_place_.clear();
    options_.clear();
    open_members_.clear();
    free_fans_.clear();
    free_groups_.clear();
  }

  std::array<double, 3> place(Index vertex) const {
    return {tets_.V(vertex, 0), tets_.V(vertex, 1), tets_.V(vertex, 2)};
  }
  Index sheet_count(Index facet) const {
    const Index g = out_.facets[facet].triangle;
    if (g < 0) return 0;
    return arrangement_.sheet_begin[g + 1] - arrangement_.sheet_begin[g];
  }
  const ArrangementSheet& sheet(Index facet, Index s) const {
    return arrangement_.sheets[arrangement_.sheet_begin[out_.facets[facet].triangle] + s];
  }

  void find_facets() {
    const Index n = static_cast<Index>(tets_.T.rows());
    const Index m = static_cast<Index>(tets_.facets.rows());
    std::vector<Index> facet_of(m, -1);
    out_.facet_on.assign(n, {-1, -1, -1, -1});
    corners_.clear();
    const auto face = [&](Index t, int k) {
      return Triple{tets_.T(t, kFace[k][0]), tets_.T(t, kFace[k][1]), tets_.T(t, kFace[k][2])};
    };
    std::vector<std::array<Index, 4>> searched;
    if (tets_.facet_on.empty()) {
      TriangleTable table(m);
      std::vector<char> marked(tets_.V.rows(), 0);
      for (Index i = 0; i < m; ++i) {
        const Triple t{tets_.facets(i, 0), tets_.facets(i, 1), tets_.facets(i, 2)};
        for (const Index v : t) marked[v] = 1;
        table.insert(sorted(t), i);
      }
      searched.resize(n);
      parallel_for(n, kTetGrain, [&](std::int64_t begin, std::int64_t end) {
        for (Index t = static_cast<Index>(begin); t < end; ++t)
          for (int k = 0; k < 4; ++k) {
            const Triple f = face(t, k);
            searched[t][k] = marked[f[0]] && marked[f[1]] && marked[f[2]] ? table.find(sorted(f)) : -1;
          }
      });
    }
    const std::vector<std::array<Index, 4>>& found = searched.empty() ? tets_.facet_on : searched;
    for (Index t = 0; t < n; ++t) {
      for (int k = 0; k < 4; ++k) {
        const Index i = found[t][k];
        if (i < 0) continue;
        const Triple f = face(t, k);
        if (facet_of[i] < 0) {
          facet_of[i] = static_cast<Index>(out_.facets.size());
          Facet facet;
          facet.triangle = tets_.facet_markers[i] - 1;
          out_.facets.push_back(facet);
          corners_.push_back(oriented(f, facet.triangle));
        }
        const Index facet = facet_of[i];
        out_.facet_on[t][k] = facet;
        // f points out of t, so where the facet is oriented like f, t is behind it.
        const Triple& c = corners_[facet];
        const int at = c[0] == f[0] ? 0 : c[1] == f[0] ? 1 : 2;
        (c[(at + 1) % 3] == f[1] ? out_.facets[facet].back : out_.facets[facet].front) = t;
      }
    }
  }

  // The facet's corners in the orientation of its arrangement triangle.
  Triple oriented(const Triple& f, Index triangle) const {
    const Triple g{arrangement_.F(triangle, 0), arrangement_.F(triangle, 1), arrangement_.F(triangle, 2)};
    bool same;
    if (sorted(f) == sorted(g)) {
      const int at = g[0] == f[0] ? 0 : g[1] == f[0] ? 1 : 2;
      same = g[(at + 1) % 3] == f[1];
    } else {  // TetGen has split the triangle: compare normals
      const auto normal = [&](const Triple& t) {
        const Eigen::Vector3d a = tets_.V.row(t[0]), b = tets_.V.row(t[1]), c = tets_.V.row(t[2]);
        return Eigen::Vector3d((b - a).cross(c - a));
      };
      same = normal(f).dot(normal(g)) > 0;
    }
    return same ? f : Triple{f[0], f[2], f[1]};
  }

  void find_cells() {
    const Index n = static_cast<Index>(tets_.T.rows());
    out_.cell.assign(n, -1);
    std::vector<Index> stack;
    for (Index seed = 0; seed < n; ++seed) {
      if (out_.cell[seed] >= 0) continue;
      const Index id = cells_++;
      out_.cell[seed] = id;
      stack.push_back(seed);
      while (!stack.empty()) {
        const Index t = stack.back();
        stack.pop_back();
        for (int k = 0; k < 4; ++k) {
          const Index other = tets_.neighbours(t, k);
          if (other < 0 || out_.facet_on[t][k] >= 0 || out_.cell[other] >= 0) continue;
          out_.cell[other] = id;
          stack.push_back(other);
        }
      }
    }
  }

  // A cell that is not simply connected may be covered by copies that change places on the way round. Such
  // cells are cut: all faces between their tets that do not close up around edges become facets without a
  // sheet, whose gluing is a permutation. Starting from a spanning tree of the tets, a face is no cut when it
  // is the last open one around an edge; in a ball that leaves none.
  void cut_handles() {
    const Index n = static_cast<Index>(tets_.T.rows());
    std::vector<char> deep(n, 0);
    bool any = false;
    for (Index t = 0; t < n; ++t) any |= deep[t] = out_.winding_of(t) >= 2;
    if (!any) return;
    struct Face {
      Index tet;
      int corner;
      std::array<Index, 3> edges{-1, -1, -1};
      bool open = true;
    };
    std::vector<Face> faces;
    std::vector<std::array<Index, 4>> face_on(n, {-1, -1, -1, -1});
    for (Index t = 0; t < n; ++t) {
      if (!deep[t]) continue;
      for (int k = 0; k < 4; ++k) {
        const Index other = tets_.neighbours(t, k);
        if (other < t || out_.facet_on[t][k] >= 0) continue;
        face_on[t][k] = static_cast<Index>(faces.size());
        for (int j = 0; j < 4; ++j)
          if (tets_.neighbours(other, j) == t) face_on[other][j] = face_on[t][k];
        faces.push_back({t, k});
      }
    }
    // Edges inside the cells, with their open faces.
    struct Use {
      Index p, q, face;
      int side;
      bool operator<(const Use& other) const {
        return std::tie(p, q, face) < std::tie(other.p, other.q, other.face);
      }
    };
    std::vector<Use> uses;
    for (Index f = 0; f < static_cast<Index>(faces.size()); ++f)
      for (int i = 0; i < 3; ++i) {
        const Index a = tets_.T(faces[f].tet, kFace[faces[f].corner][i]);
        const Index b = tets_.T(faces[f].tet, kFace[faces[f].corner][(i + 1) % 3]);
        uses.push_back({std::min(a, b), std::max(a, b), f, i});
      }
    parallel_sort_groups(uses, tets_.V.rows(), [](const auto& use) { return use.p; });
    std::vector<std::pair<Index, Index>> on_surface;  // edges of facets: their rings do not close in a cell
    for (const Triple& c : corners_)
      for (int k = 0; k < 3; ++k)
        on_surface.emplace_back(std::min(c[k], c[(k + 1) % 3]), std::max(c[k], c[(k + 1) % 3]));
    parallel_sort_groups(on_surface, tets_.V.rows(), [](const auto& edge) { return edge.first; });
    std::vector<std::vector<Index>> faces_of;
    std::vector<Index> open_count;
    for (std::size_t b = 0; b < uses.size();) {
      std::size_t e = b + 1;
      while (e < uses.size() && uses[e].p == uses[b].p && uses[e].q == uses[b].q) ++e;
      if (!std::binary_search(on_surface.begin(), on_surface.end(), std::make_pair(uses[b].p, uses[b].q))) {
        faces_of.emplace_back();
        open_count.push_back(static_cast<Index>(e - b));
        for (std::size_t i = b; i < e; ++i) {
          faces_of.back().push_back(uses[i].face);
          faces[uses[i].face].edges[uses[i].side] = static_cast<Index>(faces_of.size()) - 1;
        }
      }
      b = e;
    }
    std::vector<Index> single;
    const auto close = [&](Index f) {
      faces[f].open = false;
      for (const Index e : faces[f].edges)
        if (e >= 0 && --open_count[e] == 1) single.push_back(e);
    };
    std::vector<char> reached(n, 0);
    std::vector<Index> queue;
    for (Index seed = 0; seed < n; ++seed) {
      if (!deep[seed] || reached[seed]) continue;
      reached[seed] = 1;
      queue.assign(1, seed);
      for (std::size_t head = 0; head < queue.size(); ++head)
        for (int k = 0; k < 4; ++k) {
          const Index f = face_on[queue[head]][k];
          if (f < 0) continue;
          const Index other = tets_.neighbours(queue[head], k);
          if (reached[other]) continue;
          reached[other] = 1;
          queue.push_back(other);
          close(f);
        }
    }
    while (!single.empty()) {
      const Index e = single.back();
      single.pop_back();
      for (const Index f : faces_of[e])
        if (faces[f].open) {
          close(f);
          break;
        }
    }
    for (const Face& face : faces) {
      if (!face.open) continue;
      const Index t = face.tet, other = tets_.neighbours(t, face.corner);
      const Index id = static_cast<Index>(out_.facets.size());
      Facet facet;
      facet.back = t, facet.front = other;
      out_.facets.push_back(facet);
      corners_.push_back({tets_.T(t, kFace[face.corner][0]), tets_.T(t, kFace[face.corner][1]),
                          tets_.T(t, kFace[face.corner][2])});
      out_.facet_on[t][face.corner] = id;
      for (int j = 0; j < 4; ++j)
        if (tets_.neighbours(other, j) == t) out_.facet_on[other][j] = id;
      ++out_.cuts;
    }
  }

  std::optional<Error> find_windings() {
    constexpr Index kUnknown = -1000000;
    out_.winding.assign(cells_, kUnknown);
    std::vector<std::vector<std::pair<Index, Index>>> links(cells_ + 1);  // (cell, w there - w here)
    const auto index = [&](Index tet) { return tet < 0 ? cells_ : out_.cell[tet]; };
    std::map<std::tuple<Index, Index, Index>, char> seen;
    std::tuple<Index, Index, Index> last(-1, -1, 0);
    for (Index f = 0; f < static_cast<Index>(out_.facets.size()); ++f) {
      Index jump = 0;
      for (Index s = 0; s < sheet_count(f); ++s) jump += sheet(f, s).sign;
      const Index front = index(out_.facets[f].front), back = index(out_.facets[f].back);
      const std::tuple key(front, back, jump);
      if (key == last || !seen.try_emplace(key, 1).second) continue;
      last = key;
      links[front].emplace_back(back, jump);
      links[back].emplace_back(front, -jump);
    }
    std::vector<Index> known(cells_ + 1, kUnknown), stack{cells_};
    known[cells_] = 0;
    while (!stack.empty()) {
      const Index c = stack.back();
      stack.pop_back();
      for (const auto& [other, jump] : links[c]) {
        if (known[other] == kUnknown) {
          known[other] = known[c] + jump;
          stack.push_back(other);
        } else if (known[other] != known[c] + jump) {
          return Error{ErrorCode::unsolved, "The arrangement has lost a face: winding numbers do not agree."};
        }
      }
    }
    for (Index c = 0; c < cells_; ++c) {
      out_.winding[c] = known[c];
      if (known[c] < 0 && known[c] != kUnknown)
        // Whether the surface itself has such a region is for the exact diagnosis to say; rounding can make
        // one.
        return Error{ErrorCode::unsolved, "The arrangement has a cell of negative winding number " +
                                              std::to_string(known[c]) + "."};
      if (known[c] == kUnknown)
        return Error{ErrorCode::unsolved, "The arrangement has a cell that no face bounds."};
    }
    return std::nullopt;
  }

  struct EdgeUse {
    Index p, q;  // p < q
    Index facet;
    int corner;  // the facet's corner opposite to the edge
    bool operator<(const EdgeUse& other) const {
      return std::tie(p, q, facet) < std::tie(other.p, other.q, other.facet);
    }
  };

  // Partner of each sheet at an edge, regions, and the fans that constrain them.
  std::optional<Error> find_edges() {
    const Index m = static_cast<Index>(out_.facets.size());
    std::vector<EdgeUse> uses;
    uses.reserve(3 * static_cast<std::size_t>(m));
    for (Index f = 0; f < m; ++f)
      for (int k = 0; k < 3; ++k) {
        const Index a = corners_[f][(k + 1) % 3], b = corners_[f][(k + 2) % 3];
        uses.push_back({std::min(a, b), std::max(a, b), f, k});
      }
    parallel_sort_groups(uses, tets_.V.rows(), [](const auto& use) { return use.p; });
    struct Link {
      Index facet = -1;
      std::vector<Index>
          sheet_here;  // per sheet of the facet beyond: the sheet here; empty: one to one, single
    };
    std::vector<std::array<Index, 3>> link(m, {-1, -1, -1});
    std::map<std::pair<Index, int>, std::vector<Index>> link_sheets;  // only where there are several
    std::vector<std::pair<std::size_t, std::size_t>> special;
    std::vector<Fan::Pass> passes;
    Edge over;
    std::set<Edge> covered;
    if (free_)
      if (auto error = find_covered_edges(uses, covered)) return error;
    for (std::size_t b = 0; b < uses.size();) {
      std::size_t e = b + 1;
      while (e < uses.size() && uses[e].p == uses[b].p && uses[e].q == uses[b].q) ++e;
      const std::span<const EdgeUse> group(uses.data() + b, e - b);
      if (!free_ && goes_on(group)) {  // nearly all edges
        link[group[0].facet][group[0].corner] = group[1].facet;
        link[group[1].facet][group[1].corner] = group[0].facet;
        b = e;
        continue;
      }
      if (auto error = find_passes(group, passes, over)) return error;
      if (covered.count(over)) {
        free_groups_[over].emplace_back(b, e);
        b = e;
        continue;
      }
      bool plain = group.size() == 2;
      for (const Fan::Pass& p : passes) plain &= p.turns == 0 && p.from != p.to;
      if (plain) {
        link[group[0].facet][group[0].corner] = group[1].facet;
        link[group[1].facet][group[1].corner] = group[0].facet;
        if (sheet_count(group[0].facet) > 1) {
          for (int here = 0; here < 2; ++here) {
            auto& map = link_sheets[{group[here].facet, group[here].corner}];
            map.assign(sheet_count(group[1 - here].facet), -1);
            for (const Fan::Pass& p : passes)
              if (p.from == here) map[p.to_sheet] = p.from_sheet;
          }
        }
      } else {
        special.emplace_back(b, e);
      }
      b = e;
    }
    // Regions: flood across plain edges.
    std::vector<Index> stack;
    for (Index seed = 0; seed < m; ++seed) {
      if (out_.facets[seed].region >= 0) continue;
      const Index id = static_cast<Index>(out_.regions.size());
      Region region;
      region.front_winding = out_.winding_of(out_.facets[seed].front);
      region.back_winding = out_.winding_of(out_.facets[seed].back);
      for (Index s = 0; s < sheet_count(seed); ++s) region.signs.push_back(sheet(seed, s).sign);
      region_front_.push_back(cell_of(out_.facets[seed].front));
      region_back_.push_back(cell_of(out_.facets[seed].back));
      out_.facets[seed].region = id;
      if (sheet_count(seed) > 1) {
        out_.facets[seed].slots = static_cast<Index>(out_.slot_map.size());
        for (Index s = 0; s < sheet_count(seed); ++s) out_.slot_map.push_back(s);
      }
      out_.regions.push_back(std::move(region));
      stack.push_back(seed);
      while (!stack.empty()) {
        const Index f = stack.back();
        stack.pop_back();
        for (int k = 0; k < 3; ++k) {
          const Index g = link[f][k];
          if (g < 0 || out_.facets[g].region >= 0) continue;
          // Coherent when the shared edge runs the other way in g.
          const Index a = corners_[f][(k + 1) % 3], b = corners_[f][(k + 2) % 3];
          bool coherent = false;
          for (int j = 0; j < 3; ++j) coherent |= corners_[g][j] == b && corners_[g][(j + 1) % 3] == a;
          Facet& facet = out_.facets[g];
          facet.region = id;
          facet.flipped = out_.facets[f].flipped == coherent;
          if (sheet_count(g) > 1) {
            const auto& here = link_sheets[{f, k}];
            facet.slots = static_cast<Index>(out_.slot_map.size());
            for (Index s = 0; s < sheet_count(g); ++s)
              out_.slot_map.push_back(out_.slot_map[out_.facets[f].slots + here[s]]);
          }
          stack.push_back(g);
        }
      }
    }
    std::map<Fan, Index> distinct;
    for (const auto& [b, e] : special) {
      const std::span<const EdgeUse> group(uses.data() + b, e - b);
      distinct.try_emplace(make_fan(group), group[0].p);
    }
    for (const auto& [edge, groups] : free_groups_)
      for (const auto& [b, e] : groups) {
        const auto given = turns_.find(edge);
        free_fans_.push_back({make_fan(std::span<const EdgeUse>(uses.data() + b, e - b)), edge,
                              given == turns_.end() ? 0 : given->second, groups.size() > 1});
      }
    for (const auto& [fan, vertex] : distinct) {
      fans_.push_back(fan);
      fan_place_.push_back(vertex);
    }
    out_.constraints = static_cast<Index>(fans_.size());
    return std::nullopt;
  }

  // Input edges that could be wound: nothing else meets them but in points, and the outer side is covered all
  // along.
  std::optional<Error> find_covered_edges(const std::vector<EdgeUse>& uses, std::set<Edge>& covered) {
    std::set<Edge> excluded = refused_, uncovered, doubtful;
    std::vector<Fan::Pass> passes;
    Edge over;
    for (std::size_t b = 0; b < uses.size();) {
      std::size_t e = b + 1;
      while (e < uses.size() && uses[e].p == uses[b].p && uses[e].q == uses[b].q) ++e;
      const std::span<const EdgeUse> group(uses.data() + b, e - b);
      b = e;
      if (auto error = find_passes(group, passes, over)) return error;
      if (over.first < 0) continue;
      int sheets = 0;  // cuts, which have none, may end here, too
      bool fits = true;
      for (const EdgeUse& use : group) {
        if (sheet_count(use.facet) == 0) continue;
        const Facet& f = out_.facets[use.facet];
        sheets += sheet_count(use.facet);
        fits = fits && sheet_count(use.facet) == 1 &&
               out_.winding_of(sheet(use.facet, 0).sign > 0 ? f.front : f.back) >= 1;
      }
      fits = fits && sheets == 2;
      (fits ? covered : excluded).insert(over);
      if (fits) continue;
      // The turns of a wound edge cover everything around it.
      bool surrounded = true;
      for (const EdgeUse& use : group) {
        const Facet& f = out_.facets[use.facet];
        surrounded = surrounded && std::min(out_.winding_of(f.front), out_.winding_of(f.back)) >= 1;
      }
      (surrounded ? doubtful : uncovered).insert(over);
    }
    for (const Edge& edge : excluded) covered.erase(edge);
    in_doubt_ = std::any_of(doubtful.begin(), doubtful.end(),
                            [&](const Edge& edge) { return uncovered.count(edge) == 0; });
    return std::nullopt;
  }

  // An edge that may be wound: any number of extra turns that its fan allows.
  struct FreeFan {
    Fan fan;
    Edge edge;
    int given;     // turns it was proposed to have
    bool pierced;  // the input edge has several parts
  };

  // Extra turns at a free edge under the present choice; -1: none fits.
  int turns_at(const FreeFan& f) const {
    const Region& r = out_.regions[f.fan.leaves[0].region];
    const int most = std::min(r.front_winding, r.back_winding);
    for (int turns = 0; turns <= most; ++turns)
      if (satisfied(f.fan, chosen_, out_.regions, turns)) return turns;
    return -1;
  }

  // Fewer wound edges: regions change their gluing where nothing forbids it. Then every part of an input edge
  // must have the same number of turns; edges that do not are refused for the next round.
  bool settle_free_edges() {
    const auto cost = [&](Index r) {
      double sum = 0;
      for (const Index i : free_fans_of_[r]) {
        const int turns = turns_at(free_fans_[i]);
        if (turns < 0) return std::numeric_limits<double>::infinity();
        sum += turns * (free_fans_[i].pierced ? kPiercedCost : 1.0);
      }
      return sum;
    };
    for (bool better = true; better;) {
      better = false;
      for (Index r = 0; r < static_cast<Index>(out_.regions.size()); ++r) {
        if (options_[r].size() < 2 || free_fans_of_[r].empty()) continue;
        const Option* now = chosen_[r];
        double best = cost(r);
        const Option* choice = now;
        for (const Option& option : options_[r]) {
          chosen_[r] = &option;
          const bool fits = std::all_of(fans_of_[r].begin(), fans_of_[r].end(),
                                        [&](Index c) { return satisfied(fans_[c], chosen_, out_.regions); });
          if (!fits) continue;
          if (const double there = cost(r); there < best) best = there, choice = &option;
        }
        chosen_[r] = choice;
        better |= choice != now;
      }
    }
    std::map<Edge, int> turns;
    bool agree = true;
    for (const FreeFan& f : free_fans_) {
      const int here = turns_at(f);
      if (turns.try_emplace(f.edge, here).first->second == here && here >= 0) continue;
      refused_.insert(f.edge);
      agree = false;
    }
    if (agree) take_choice();
    return agree;
  }

  Index cell_of(Index tet) const { return tet < 0 ? -1 : out_.cell[tet]; }

  int shared_corners(Index f, Index g, std::pair<Index, Index>& edge) const {
    int shared = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        if (surface_.F(f, i) == surface_.F(g, j)) {
          (shared == 0 ? edge.first : edge.second) = surface_.F(f, i);
          ++shared;
        }
    if (edge.first > edge.second) std::swap(edge.first, edge.second);
    return shared;
  }

  double distance_to_edge(Index vertex, std::pair<Index, Index> edge) const {
    const Eigen::Vector3d a = surface_.V.row(edge.first), b = surface_.V.row(edge.second),
                          p = tets_.V.row(vertex);
    const Eigen::Vector3d d = (b - a).normalized();
    return (p - a - d * d.dot(p - a)).norm();
  }

  // Two facets of one sheet each that continue into each other without extra turns.
  bool goes_on(std::span<const EdgeUse> group) const {
    if (group.size() != 2 || sheet_count(group[0].facet) != 1 || sheet_count(group[1].facet) != 1)
      return false;
    const Index f = sheet(group[0].facet, 0).face, g = sheet(group[1].facet, 0).face;
    Edge edge;
    return f == g || (shared_corners(f, g, edge) == 2 && turns_.find(edge) == turns_.end());
  }

  // Which sheet continues into which at one edge of the arrangement (from/to index the group).
  // edge: the last input edge that a sheet passes over there, or (-1, -1).
  std::optional<Error> find_passes(std::span<const EdgeUse> group, std::vector<Fan::Pass>& passes,
                                   Edge& edge_passed) const {
    passes.clear();
    edge_passed = {-1, -1};
    struct Entry {
      Index face;
      int leaf, sheet;
    };
    std::vector<Entry> entries;
    for (int i = 0; i < static_cast<int>(group.size()); ++i)
      for (Index s = 0; s < sheet_count(group[i].facet); ++s)
        entries.push_back({sheet(group[i].facet, s).face, i, static_cast<int>(s)});
    std::vector<int> partner(entries.size(), -1), turns(entries.size(), 0);
    for (std::size_t i = 0; i < entries.size(); ++i)
      for (std::size_t j = i + 1; j < entries.size(); ++j)
        if (entries[i].face == entries[j].face)
          partner[i] = static_cast<int>(j), partner[j] = static_cast<int>(i);
    for (std::size_t i = 0; i < entries.size(); ++i) {
      if (partner[i] >= 0) continue;
      double best = std::numeric_limits<double>::infinity();
      int found = -1;
      std::pair<Index, Index> found_edge;
      for (std::size_t j = i + 1; j < entries.size(); ++j) {
        if (partner[j] >= 0) continue;
        std::pair<Index, Index> edge;
        if (shared_corners(entries[i].face, entries[j].face, edge) < 2) continue;
        const double d = distance_to_edge(group[0].p, edge) + distance_to_edge(group[0].q, edge);
        if (d < best) best = d, found = static_cast<int>(j), found_edge = edge;
      }
      if (found < 0) return Error{ErrorCode::unsolved, "The arrangement is torn.", place(group[0].p)};
      partner[i] = found, partner[found] = static_cast<int>(i);
      edge_passed = found_edge;
      const auto wound = free_ ? turns_.end() : turns_.find(found_edge);
      if (wound != turns_.end()) turns[i] = turns[found] = wound->second;
    }
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const Entry &a = entries[i], &b = entries[partner[i]];
      passes.push_back({a.leaf, a.sheet, b.leaf, b.sheet, turns[i]});
    }
    return std::nullopt;
  }

  Fan make_fan(std::span<const EdgeUse> given) const {
    std::vector<EdgeUse> group(given.begin(), given.end());
    std::sort(group.begin(), group.end(), [&](const EdgeUse& a, const EdgeUse& b) {
      const Facet &fa = out_.facets[a.facet], &fb = out_.facets[b.facet];
      return std::tie(fa.region, fa.flipped, a.facet) < std::tie(fb.region, fb.flipped, b.facet);
    });
    Fan fan;
    const int n = static_cast<int>(group.size());
    fan.arc.assign(n, {-1, -1});
    for (int i = 0; i < n; ++i) {
      const Facet& f = out_.facets[group[i].facet];
      Fan::Leaf leaf{f.region, f.flipped, {}};
      if (f.slots < 0)
        leaf.slots = {0};
      else
        leaf.slots.assign(out_.slot_map.begin() + f.slots,
                          out_.slot_map.begin() + f.slots + sheet_count(group[i].facet));
      fan.leaves.push_back(std::move(leaf));
      for (int side = 0; side < 2; ++side) {
        const Index start = side == 0 ? f.front : f.back;
        if (start < 0 || out_.winding_of(start) == 0) continue;  // no copies, no way
        const auto [facet, arrival] = rotate(start, group[i].facet, group[i].p, group[i].q);
        for (int j = 0; j < n; ++j)
          if (group[j].facet == facet) fan.arc[i][side] = 2 * j + arrival;
      }
    }
    Edge over;
    (void)find_passes(group, fan.passes, over);  // cannot fail: the same group has passed before
    return fan;
  }

  // From a facet through the tets around edge p-q to the next facet; and on which side of it one arrives.
  std::pair<Index, int> rotate(Index tet, Index facet, Index p, Index q) const {
    int from = 0;
    while (out_.facet_on[tet][from] != facet) ++from;
    for (;;) {
      int to = 0;
      while (to == from || tets_.T(tet, to) == p || tets_.T(tet, to) == q) ++to;
      const Index hit = out_.facet_on[tet][to];
      if (hit >= 0) return {hit, out_.facets[hit].front == tet ? 0 : 1};
      const Index next = tets_.neighbours(tet, to);
      // In the next tet the corner opposite to the shared face is the one that this tet does not have.
      int corner = 0;
      while (tets_.T(next, corner) == p || tets_.T(next, corner) == q ||
             tets_.T(next, corner) == tets_.T(tet, from))
        ++corner;
      from = corner;
      tet = next;
    }
  }

  std::optional<Error> solve() {
    const Index n = static_cast<Index>(out_.regions.size());
    name_copies();
    options_.resize(n);
    listed_.assign(n, 1);
    known_.assign(n, {});
    for (Index r = 0; r < n; ++r) {
      const double count = count_options(out_.regions[r], named_[r]);
      if (count > kMostListed) {
        listed_[r] = 0;
        continue;
      }
      if (count > 0) {
        enumerate_options(out_.regions[r], named_[r], options_[r]);
        continue;
      }
      cut_short_ = true;
      Error error{ErrorCode::unsolved,
                  "Faces of the surface lie on each other where the solid has no thickness between them."};
      for (std::size_t f = 0; f < out_.facets.size() && !error.place; ++f)
        if (out_.facets[f].region == r) error.place = place(corners_[f][0]);
      return error;
    }
    chosen_.assign(n, nullptr);
    for (Index r = 0; r < n; ++r)
      if (listed_[r] && options_[r].size() == 1) chosen_[r] = &options_[r][0];

    fans_of_.assign(n, {});
    for (Index c = 0; c < static_cast<Index>(fans_.size()); ++c) {
      std::vector<Index> members;
      for (const auto& leaf : fans_[c].leaves) members.push_back(leaf.region);
      std::sort(members.begin(), members.end());
      members.erase(std::unique(members.begin(), members.end()), members.end());
      bool open = false;
      for (const Index r : members) open |= !chosen_[r];
      if (!open) {
        if (!satisfied(fans_[c], chosen_, out_.regions)) return no_gluing(c);
        continue;
      }
      for (const Index r : members)
        if (!chosen_[r]) fans_of_[r].push_back(c);
      open_members_.emplace(c, std::move(members));
    }
    free_fans_of_.assign(n, {});
    for (Index i = 0; i < static_cast<Index>(free_fans_.size()); ++i)
      for (const auto& leaf : free_fans_[i].fan.leaves) {
        auto& list = free_fans_of_[leaf.region];
        if (list.empty() || list.back() != i) list.push_back(i);
      }
    // Independent parts one after the other.
    std::vector<char> seen(n, 0);
    for (Index seed = 0; seed < n; ++seed) {
      if (chosen_[seed] || seen[seed]) continue;
      std::vector<Index> part{seed};
      seen[seed] = 1;
      for (std::size_t i = 0; i < part.size(); ++i) {
        const auto add = [&](Index r) {
          if (!chosen_[r] && !seen[r]) seen[r] = 1, part.push_back(r);
        };
        for (const Index c : fans_of_[part[i]])
          for (const Index r : open_members_.at(c)) add(r);
        for (const Index c : free_fans_of_[part[i]])
          for (const auto& leaf : free_fans_[c].fan.leaves) add(leaf.region);
      }
      deepest_fan_ = fans_of_[seed].empty() ? -1 : fans_of_[seed][0];
      if (!search(part)) {
        if (auto stop = context_.stop()) return stop;
        return no_gluing(deepest_fan_);
      }
    }
    take_choice();
    return std::nullopt;
  }

  void take_choice() {
    for (std::size_t r = 0; r < out_.regions.size(); ++r) {
      out_.regions[r].back_of = chosen_[r]->back_of;
      out_.regions[r].front_of = chosen_[r]->front_of;
    }
  }

  Error no_gluing(Index fan) const {
    Error error{ErrorCode::unsolved, "The sheets of the solid cannot be glued without a branch line."};
    if (fan >= 0) error.place = place(fan_place_[fan]);
    return error;
  }

  // Along a spanning forest of the cells.
  void name_copies() {
    named_.assign(out_.regions.size(), Named::neither);
    std::vector<std::vector<Index>> regions_of(cells_);
    for (Index r = 0; r < static_cast<Index>(out_.regions.size()); ++r) {
      if (region_front_[r] >= 0) regions_of[region_front_[r]].push_back(r);
      if (region_back_[r] >= 0) regions_of[region_back_[r]].push_back(r);
    }
    std::vector<Index> order(cells_);
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(),
                     [&](Index a, Index b) { return out_.winding[a] < out_.winding[b]; });
    std::vector<char> fixed(cells_, 0);
    std::vector<Index> queue;
    for (const Index c : order)
      if (out_.winding[c] <= 1) fixed[c] = 1, queue.push_back(c);
    std::size_t next_root = 0, head = 0;
    for (;;) {
      while (head < queue.size()) {
        const Index c = queue[head++];
        for (const Index r : regions_of[c]) {
          const bool here_is_front = region_front_[r] == c;
          const Index other = here_is_front ? region_back_[r] : region_front_[r];
          if (other < 0 || fixed[other] || other == c) continue;
          fixed[other] = 1;
          named_[r] = here_is_front ? Named::back : Named::front;
          queue.push_back(other);
        }
      }
      while (next_root < order.size() && fixed[order[next_root]]) ++next_root;
      if (next_root == order.size()) return;
      fixed[order[next_root]] = 1;
      queue.push_back(order[next_root]);
    }
  }

  // Options of r that no fan with all other regions chosen rejects. None, where r has no list and nothing
  // around it is known.
  std::optional<std::vector<Index>> possible(Index r) {
    std::vector<Index> candidates;
    if (listed_[r]) {
      candidates.resize(options_[r].size());
      std::iota(candidates.begin(), candidates.end(), 0);
    } else if (auto made = make_options(r)) {
      candidates = std::move(*made);
    } else {
      return std::nullopt;
    }
    std::vector<Index> out;
    std::vector<std::pair<double, Index>> costs;
    for (const Index o : candidates) {
      chosen_[r] = &options_[r][o];
      bool fits = true;
      for (const Index c : fans_of_[r]) {
        if (is_complete(fans_[c]) && !satisfied(fans_[c], chosen_, out_.regions)) {
          fits = false;
          deepest_fan_ = blamed_ = c;
          break;
        }
      }
      // Free edges: some number of turns must fit; options that need the fewest unproposed ones come first.
      double cost = 0;
      for (const Index c : free_fans_of_[r]) {
        if (!fits) break;
        const FreeFan& f = free_fans_[c];
        if (!is_complete(f.fan)) continue;
        const int turns = turns_at(f);
        fits = turns >= 0;
        if (!fits) blamed_ = static_cast<Index>(fans_.size()) + c;
        cost += (turns != f.given) + (turns > 0 && f.pierced ? kPiercedCost : 0);
      }
      if (fits) costs.emplace_back(cost, o);
    }
    chosen_[r] = nullptr;
    std::sort(costs.begin(), costs.end());
    for (const auto& [cost, o] : costs) out.push_back(o);
    return out;
  }

  // But for the region `open`.
  bool is_complete(const Fan& fan, Index open = -1) const {
    return std::all_of(fan.leaves.begin(), fan.leaves.end(),
                       [&](const Fan::Leaf& l) { return l.region == open || chosen_[l.region]; });
  }

  // For a region without a list: the gluings that a fan allows in which all others are chosen.
  std::optional<std::vector<Index>> make_options(Index r) {
    const auto once = [&](const Fan& fan) {
      return std::count_if(fan.leaves.begin(), fan.leaves.end(),
                           [&](const Fan::Leaf& l) { return l.region == r; }) == 1;
    };
    for (const Index c : fans_of_[r]) {
      const Fan& fan = fans_[c];
      int turns = 0;
      for (const Fan::Pass& pass : fan.passes) turns += pass.turns;
      if (turns > 2 * kMostTurnsMade || !once(fan) || !is_complete(fan, r)) continue;  // passes come twice
      if (auto made = options_around(fan, r, turns)) return made;
    }
    for (const Index c : free_fans_of_[r]) {
      const Fan& fan = free_fans_[c].fan;
      if (!once(fan) || !is_complete(fan, r)) continue;
      const bool all = count_options(out_.regions[r], named_[r]) <= kMostTurned;
      if (!all) cut_short_ = true;
      const int most = std::min(out_.regions[r].front_winding, out_.regions[r].back_winding);
      if (auto made = options_around(fan, r, all ? most : kMostTurnsMade)) return made;
    }
    return std::nullopt;
  }

  // Copies that come back to the region on the other side, having gone around the edge, must close there; the
  // few that begin or end on the way are joined in all ways. One more turn: a copy on such a path and one
  // that closes exchange what they lead to.
  std::optional<std::vector<Index>> options_around(const Fan& fan, Index r, int turns) {
    const Region& region = out_.regions[r];
    const int front = region.front_winding, back = region.back_winding;
    int at = 0;
    while (fan.leaves[at].region != r) ++at;
    const bool flipped = fan.leaves[at].flipped;
    // Targets: back copies, then -1 - slot. Sources: front copies, then slots that begin on the back.
    std::vector<int> target(front, -100);
    std::vector<int> loose;  // targets that no front copy has yet
    for (int b = 0; b < back; ++b) {
      int leaf = at, side = flipped ? 0 : 1, copy = b;
      for (;;) {
        const int arrival = fan.arc[leaf][side];
        if (arrival < 0) return std::nullopt;
        leaf = arrival / 2, side = arrival % 2;
        if (leaf == at) break;
        const Fan::Leaf& l = fan.leaves[leaf];
        const Option& option = *chosen_[l.region];
        copy = ((side == 0) != l.flipped ? option.back_of : option.front_of)[copy];
        if (copy < 0) break;
        side = 1 - side;
      }
      if (copy >= 0 && (side == 0) == flipped) return std::nullopt;
      if (copy >= 0)
        target[copy] = b;
      else
        loose.push_back(b);
    }
    std::vector<int> open;  // sources without a target
    for (int f = 0; f < front; ++f)
      if (target[f] == -100) open.push_back(f);
    const std::size_t copies = open.size();
    for (int s = 0; s < static_cast<int>(region.signs.size()); ++s)
      (region.signs[s] > 0 ? open : loose).push_back(region.signs[s] > 0 ? front + s : -1 - s);
    constexpr std::size_t kMostOpen = 6;
    if (open.size() != loose.size() || open.size() > kMostOpen) return std::nullopt;

    struct Made {
      std::vector<int> target;  // of the front copies, then of the slots
      std::vector<int> path;    // sources on paths that begin or end
    };
    std::vector<Made> made;
    target.resize(front + region.signs.size(), -100);
    std::sort(loose.begin(), loose.end());
    do {
      bool fits = true;  // a slot cannot begin where another one ends
      for (std::size_t i = copies; i < open.size(); ++i) fits = fits && loose[i] >= 0;
      if (!fits) continue;
      made.push_back({target, open});
      for (std::size_t i = 0; i < open.size(); ++i) made.back().target[open[i]] = loose[i];
    } while (std::next_permutation(loose.begin(), loose.end()));
    for (std::size_t begin = 0; turns > 0; --turns) {
      const std::size_t end = made.size();
      for (std::size_t i = begin; i < end; ++i)
        for (const int x : std::vector<int>(made[i].path))
          for (int f = 0; f < front; ++f) {
            const Made& now = made[i];
            if (std::find(now.path.begin(), now.path.end(), f) != now.path.end()) continue;
            Made more = now;
            std::swap(more.target[x], more.target[f]);
            more.path.push_back(f);
            if (x >= front && more.target[x] < 0) continue;
            made.push_back(std::move(more));
          }
      begin = end;
    }
    std::vector<Index> out;
    for (const Made& m : made) {
      Option option{std::vector<int>(front, -100), std::vector<int>(back, -100)};
      for (int x = 0; x < static_cast<int>(m.target.size()); ++x) {
        const int to = m.target[x];
        if (to == -100) continue;
        if (x < front) option.back_of[x] = to;
        if (to >= 0) option.front_of[to] = x < front ? x : -1 - (x - front);
      }
      std::vector<int> key = option.back_of;
      key.insert(key.end(), option.front_of.begin(), option.front_of.end());
      const auto [place, is_new] =
          known_[r].try_emplace(std::move(key), static_cast<Index>(options_[r].size()));
      if (is_new) options_[r].push_back(std::move(option));
      out.push_back(place->second);
    }
    std::sort(out.begin(), out.end());
    out.erase(std::unique(out.begin(), out.end()), out.end());
    return out;
  }

  // Lists all options of a region; false when there are too many.
  bool list_options(Index r) {
    if (count_options(out_.regions[r], named_[r]) > kMostOptions) return false;
    options_[r].clear();
    known_[r].clear();
    enumerate_options(out_.regions[r], named_[r], options_[r]);
    listed_[r] = 1;
    return true;
  }

  enum class Found { yes, no, too_long };

  // A first attempt goes on where it has been. Those that follow begin where the ones before have failed
  // most.
  bool search(const std::vector<Index>& part) {
    const bool all_listed = std::all_of(part.begin(), part.end(), [&](Index r) { return listed_[r] != 0; });
    const std::int64_t n = static_cast<std::int64_t>(part.size());
    const std::int64_t first =
        all_listed ? kFirstNodes + kFirstNodesEach * n : kFirstNodes + kMostNodesMade * n;
    const std::int64_t last = out_.search_nodes + (all_listed ? kMostSearchNodes : kAttemptsMade * first);
    weight_.assign(fans_.size() + free_fans_.size(), 1);
    for (std::int64_t most = first, round = 0;; most += most / 2, ++round) {
      const Found found = attempt(part, std::min(most, last - out_.search_nodes), round > 0);
      if (found == Found::yes) return true;
      if (found == Found::no) return false;
      if (out_.search_nodes < last && !context_.stop()) continue;
      cut_short_ = true;
      return false;
    }
  }

  Found attempt(const std::vector<Index>& part, std::int64_t most, bool by_weight) {
    struct Level {
      Index region;
      std::vector<Index> options;
      std::size_t next = 0;
    };
    std::vector<Level> levels;
    std::vector<std::optional<std::vector<Index>>> left(part.size());  // none: many
    std::vector<Index> blame(part.size(), -1);
    std::map<Index, std::size_t> at;
    const auto look = [&](std::size_t i) {
      blamed_ = -1;
      left[i] = possible(part[i]);
      blame[i] = blamed_;
    };
    for (std::size_t i = 0; i < part.size(); ++i) at[part[i]] = i, look(i);
    const std::int64_t end = out_.search_nodes + most;
    std::vector<char> stale(part.size(), 0);
    std::vector<int> touched(part.size(), 0);  // changes next to it
    const auto spoil = [&](Index r) {
      for (const Index c : fans_of_[r])
        for (const Index other : open_members_.at(c))
          if (const auto it = at.find(other); it != at.end()) stale[it->second] = 1;
      for (const Index c : free_fans_of_[r])
        for (const auto& leaf : free_fans_[c].fan.leaves)
          if (const auto it = at.find(leaf.region); it != at.end())
            stale[it->second] = 1, ++touched[it->second];
    };
    const auto give_up = [&] {
      for (const Level& level : levels) chosen_[level.region] = nullptr;
      return Found::too_long;
    };
    // Options left; a region's share of dead ends makes them fewer.
    const auto size = [&](std::size_t i) {
      if (!left[i]) return std::numeric_limits<double>::max();
      const double n = static_cast<double>(left[i]->size());
      if (!by_weight || n < 2) return n;
      double weight = 0;
      for (const Index c : fans_of_[part[i]]) weight += weight_[c];
      for (const Index c : free_fans_of_[part[i]]) weight += weight_[fans_.size() + c];
      return 1 + n / (1 + weight);
    };
    for (;;) {
      // The open region with the fewest options left; the first of them.
      std::size_t best = part.size();
      double fewest = 0;
      for (std::size_t i = 0; i < part.size(); ++i) {
        if (chosen_[part[i]]) continue;
        if (stale[i]) look(i), stale[i] = 0;
        const double here = size(i);
        if (best == part.size() || here < fewest || (here == fewest && touched[i] > touched[best]))
          best = i, fewest = here;
        if (fewest == 0) break;
      }
      if (best == part.size()) return Found::yes;
      if (!left[best]) {
        if (!list_options(part[best])) {
          cut_short_ = true;
          give_up();
          return Found::no;
        }
        look(best);
      }
      if (!left[best]->empty())
        levels.push_back({part[best], *left[best]});
      else if (blame[best] >= 0)
        ++weight_[blame[best]];
      // Take the next option of the deepest level that has one.
      for (;;) {
        if (levels.empty()) return Found::no;
        Level& level = levels.back();
        if (chosen_[level.region]) spoil(level.region);
        chosen_[level.region] = nullptr;
        if (level.next < level.options.size()) {
          chosen_[level.region] = &options_[level.region][level.options[level.next++]];
          spoil(level.region);
          if (++out_.search_nodes > end || (out_.search_nodes % 256 == 0 && context_.stop()))
            return give_up();
          break;
        }
        stale[at[level.region]] = 1;
        levels.pop_back();
      }
    }
  }

  const Surface& surface_;
  const Arrangement& arrangement_;
  const TetgenResult& tets_;
  const RunContext& context_;
  std::map<Edge, int> turns_;  // of the wound edges given
  bool free_ = false;          // all covered edges may be wound
  bool cut_short_ = false;     // the search has not seen everything
  bool in_doubt_ = false;      // an edge that might be wound does not take part in the search
  std::set<Edge> refused_;
  std::map<Edge, std::vector<std::pair<std::size_t, std::size_t>>> free_groups_;
  std::vector<FreeFan> free_fans_;
  std::vector<std::vector<Index>> free_fans_of_;  // per region
  Sheets out_;
  Index cells_ = 0;
  std::vector<Triple> corners_;  // per facet, in the orientation of its arrangement triangle
  std::vector<Index> region_front_, region_back_;  // cells, in the region's orientation
  std::vector<Fan> fans_;
  std::vector<Index> fan_place_;
  std::vector<Named> named_;                              // per region
  std::vector<std::deque<Option>> options_;               // addresses stay
  std::vector<char> listed_;                              // whether these are all
  std::vector<std::map<std::vector<int>, Index>> known_;  // where they are not: which there are
  std::vector<const Option*> chosen_;
  std::vector<std::vector<Index>> fans_of_;
  std::map<Index, std::vector<Index>> open_members_;
  Index deepest_fan_ = -1;
  Index blamed_ = -1;           // the last fan that rejected an option; free fans come after the others
  std::vector<double> weight_;  // dead ends at each fan, free or not
};

}  // namespace

int Sheets::across(Index facet, bool from_front, int copy) const {
  const Facet& f = facets[facet];
  const Region& r = regions[f.region];
  const int to = (from_front != f.flipped ? r.back_of : r.front_of)[copy];
  if (to >= 0 || f.slots < 0) return to;
  Index s = 0;
  while (slot_map[f.slots + s] != -1 - to) ++s;
  return -1 - static_cast<int>(s);
}

Result<Sheets> assign_sheets(const Surface& surface, const Arrangement& arrangement, const TetgenResult& tets,
                             std::span<const WoundEdge> wound, const RunContext& context) {
  return Assigner(surface, arrangement, tets, wound, context).run();
}

}  // namespace overtet
