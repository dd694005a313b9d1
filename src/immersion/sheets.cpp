#include "src/immersion/sheets.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "kernels/core/assertions.h"
#include "kernels/core/union_find.h"
#include "kernels/parallel/grouping.h"
#include "src/immersion/cells.h"
#include "src/immersion/gluing_formula.h"
#include "src/immersion/sheet_search.h"
#include "src/immersion/tuning.h"

namespace overtet {

namespace {

using Triple = std::array<Index, 3>;

// More than 12 members: the arguments (six), and what find_edges leaves for the searches (nine).
class Assigner {
 public:
  Assigner(const Surface& surface, const Arrangement& arrangement, const TetgenResult& tets,
           std::span<const WoundEdge> wound, int variant, const RunContext& context)
      : surface_(surface),
        arrangement_(arrangement),
        tets_(tets),
        variant_(variant),
        context_(context),
        discs_(!arrangement.tolerant) {
    for (const WoundEdge& w : wound) turns_[{std::min(w.a, w.b), std::max(w.a, w.b)}] = w.k;
  }

  Result<Sheets> run() {
    Result<std::vector<Triple>> corners = find_cells(arrangement_, tets_, out_);
    if (!corners.ok()) return corners.error();
    corners_ = std::move(corners.value());
    if (auto error = find_edges()) return *error;
    if (variant_ == 0) {
      const std::optional<Error> failure = search();
      if (!failure || failure->code != ErrorCode::unsolved) return answer(failure);
      failure_ = *failure;
    }
    // The wound edges given leave no gluing, or none was found. Let others be wound: first those next to the
    // given ones, last every edge that could be. The fewer there are, the smaller is the formula.
    for (const auto& [edge, turns] : turns_) near_.insert({edge.first, edge.second});
    int rings = 0;
    for (const int wanted : kFreeRings) {
      if (near_.empty() || too_large_) break;
      while (rings < wanted) widen(), ++rings;
      if (std::optional<Error> other = glue_freely(); !other || other->code != ErrorCode::unsolved)
        return answer(other);
    }
    near_.clear();
    return answer(too_large_ ? failure_ : glue_freely());
  }

 private:
  using Edge = std::pair<Index, Index>;  // of the input, smaller vertex first

  Result<Sheets> answer(const std::optional<Error>& failure) {
    return failure ? Result<Sheets>(*failure) : Result<Sheets>(std::move(out_));
  }

  // With other wound edges: those near the given ones, or all.
  std::optional<Error> glue_freely() {
    free_ = true;
    // With a tolerance the surface may be pinched where it is not, and then no solution has discs there.
    for (const bool discs : {true, false}) {
      if (!discs && !arrangement_.tolerant) continue;
      discs_ = discs;
      reset();
      if (auto error = find_edges()) return error;
      const FormulaAnswer found = solve_as_formula(out_.regions, out_.winding, puzzle_, variant_, context_);
      out_.search_nodes += found.solves;
      too_large_ = found.too_large;
      if (found.stop) return found.stop;
      if (found.verdict == FormulaAnswer::Verdict::found) {
        take([&](Index r) -> const Gluing& { return found.gluings[r]; });
        return std::nullopt;
      }
      failure_.reason = near_.empty() && found.verdict == FormulaAnswer::Verdict::none && !has_stacks()
                            ? ErrorReason::exhausted
                            : ErrorReason::none;
    }
    return failure_;
  }

  // One more ring of faces.
  void widen() {
    std::set<Index> wider = near_;
    for (Index f = 0; f < surface_.F.rows(); ++f) {
      const auto face = surface_.F.row(f);
      if (near_.count(face[0]) || near_.count(face[1]) || near_.count(face[2]))
        wider.insert({face[0], face[1], face[2]});
    }
    near_ = std::move(wider);
  }

  // Whether faces lie on each other. Rounding may have put them there, and then a layer between them is left
  // out.
  bool has_stacks() const {
    return std::any_of(out_.regions.begin(), out_.regions.end(),
                       [](const Region& r) { return r.signs.size() > 1; });
  }

  void reset() {
    for (Facet& f : out_.facets) f.region = -1, f.flipped = false, f.slots = -1;
    out_.regions.clear();
    out_.slot_map.clear();
    puzzle_ = {};
    fan_place_.clear();
    free_groups_.clear();
    free_edges_.clear();
  }

  // With the wound edges given.
  std::optional<Error> search() {
    SheetSearch search(out_.regions, out_.winding, puzzle_, context_);
    const bool found = search.solve();
    out_.search_nodes += search.nodes();
    if (!found) {
      if (auto stop = context_.stop()) return stop;
      return no_gluing(search);
    }
    take([&](Index r) -> const Gluing& { return search.gluing(r); });
    return std::nullopt;
  }

  template <class F>
  void take(F&& gluing) {
    for (Index r = 0; r < static_cast<Index>(out_.regions.size()); ++r) {
      out_.regions[r].back_of = gluing(r).back_of;
      out_.regions[r].front_of = gluing(r).front_of;
    }
  }

  Error no_gluing(const SheetSearch& search) const {
    if (const Index r = search.impossible_region(); r >= 0) {
      Error error{ErrorCode::unsolved,
                  "Faces of the surface lie on each other, and the solid has no thickness between them."};
      for (std::size_t f = 0; f < out_.facets.size() && !error.place; ++f)
        if (out_.facets[f].region == r) error.place = place(corners_[f][0]);
      return error;
    }
    Error error{ErrorCode::unsolved, "The layers of the solid cannot be glued without a branch line."};
    if (search.deepest_fan() >= 0) error.place = place(fan_place_[search.deepest_fan()]);
    return error;
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

  struct EdgeUse {
    Index p, q;  // p < q
    Index facet;
    int corner;  // the facet's corner opposite to the edge
    bool operator<(const EdgeUse& other) const {
      return std::tie(p, q, facet) < std::tie(other.p, other.q, other.facet);
    }
  };

  // What lies beyond each edge of each facet where nothing branches.
  struct Links {
    explicit Links(Index facets) : facet(static_cast<std::size_t>(facets), {-1, -1, -1}) {}
    std::vector<std::array<Index, 3>> facet;
    // Of a facet and corner: per sheet of the facet beyond, the sheet here. Only where there are several.
    std::map<std::pair<Index, int>, std::vector<Index>> sheets;
  };
  using Range = std::pair<std::size_t, std::size_t>;  // of the uses of one edge

  // Partner of each sheet at an edge, regions, and the fans that constrain them.
  std::optional<Error> find_edges() {
    const std::vector<EdgeUse> uses = edge_uses();
    if (free_)
      if (auto error = find_covered_edges(uses)) return error;
    Links links(static_cast<Index>(out_.facets.size()));
    std::vector<Range> special;
    std::set<Index> turning;  // vertices at edges that are wound, or may be
    if (auto error = sort_edges(uses, links, special, turning)) return error;
    flood_regions(links);
    list_fans(uses, special);
    if (discs_) add_links(uses, turning);
    return std::nullopt;
  }

  // By edge.
  std::vector<EdgeUse> edge_uses() const {
    const Index m = static_cast<Index>(out_.facets.size());
    std::vector<EdgeUse> uses;
    uses.reserve(3 * static_cast<std::size_t>(m));
    for (Index f = 0; f < m; ++f)
      for (int k = 0; k < 3; ++k) {
        const Index a = corners_[f][(k + 1) % 3], b = corners_[f][(k + 2) % 3];
        uses.push_back({std::min(a, b), std::max(a, b), f, k});
      }
    parallel_sort_groups(uses, tets_.V.rows(), [](const auto& use) { return use.p; });
    return uses;
  }

  // Links across edges where nothing branches; special: the others, but for those that may be wound.
  std::optional<Error> sort_edges(const std::vector<EdgeUse>& uses, Links& links, std::vector<Range>& special,
                                  std::set<Index>& turning) {
    std::vector<Fan::Pass> passes;
    std::vector<Edge> over;
    for (std::size_t b = 0, e = 0; b < uses.size(); b = e) {
      for (e = b + 1; e < uses.size() && uses[e].p == uses[b].p && uses[e].q == uses[b].q;) ++e;
      const std::span<const EdgeUse> group(uses.data() + b, e - b);
      if (!free_ && goes_on(group)) {  // nearly all edges
        link(group, links);
        continue;
      }
      if (auto error = find_passes(group, passes, over)) return error;
      if (std::any_of(over.begin(), over.end(),
                      [&](const Edge& edge) { return free_edges_.count(edge) > 0; })) {
        free_groups_.emplace_back(b, e);
        turning.insert({group[0].p, group[0].q});
        continue;
      }
      if (std::any_of(passes.begin(), passes.end(), [](const Fan::Pass& p) { return p.turns > 0; }))
        turning.insert({group[0].p, group[0].q});
      const bool plain = group.size() == 2 && std::all_of(passes.begin(), passes.end(), [](const auto& p) {
                           return p.turns == 0 && p.from != p.to;
                         });
      if (!plain) {
        special.emplace_back(b, e);
        continue;
      }
      link(group, links);
      if (sheet_count(group[0].facet) <= 1) continue;
      for (int here = 0; here < 2; ++here) {
        auto& map = links.sheets[{group[here].facet, group[here].corner}];
        map.assign(sheet_count(group[1 - here].facet), -1);
        for (const Fan::Pass& p : passes)
          if (p.from == here) map[p.to_sheet] = p.from_sheet;
      }
    }
    return std::nullopt;
  }

  static void link(std::span<const EdgeUse> group, Links& links) {
    links.facet[group[0].facet][group[0].corner] = group[1].facet;
    links.facet[group[1].facet][group[1].corner] = group[0].facet;
  }

  // Regions: what can be reached across linked edges.
  void flood_regions(Links& links) {
    std::vector<Index> stack;
    for (Index seed = 0; seed < static_cast<Index>(out_.facets.size()); ++seed) {
      if (out_.facets[seed].region >= 0) continue;
      begin_region(seed);
      stack.push_back(seed);
      while (!stack.empty()) {
        const Index f = stack.back();
        stack.pop_back();
        for (int k = 0; k < 3; ++k) {
          const Index g = links.facet[f][k];
          if (g < 0 || out_.facets[g].region >= 0) continue;
          continue_region(f, k, g, links);
          stack.push_back(g);
        }
      }
    }
  }

  void begin_region(Index seed) {
    const Index id = static_cast<Index>(out_.regions.size());
    Region region;
    region.front_winding = out_.winding_of(out_.facets[seed].front);
    region.back_winding = out_.winding_of(out_.facets[seed].back);
    for (Index s = 0; s < sheet_count(seed); ++s) region.signs.push_back(sheet(seed, s).sign);
    puzzle_.cells.push_back({cell_of(out_.facets[seed].front), cell_of(out_.facets[seed].back)});
    out_.facets[seed].region = id;
    if (sheet_count(seed) > 1) {
      out_.facets[seed].slots = static_cast<Index>(out_.slot_map.size());
      for (Index s = 0; s < sheet_count(seed); ++s) out_.slot_map.push_back(s);
    }
    out_.regions.push_back(std::move(region));
  }

  // From f across the edge opposite to its corner k to g.
  void continue_region(Index f, int k, Index g, Links& links) {
    // Coherent when the shared edge runs the other way in g.
    const Index a = corners_[f][(k + 1) % 3], b = corners_[f][(k + 2) % 3];
    bool coherent = false;
    for (int j = 0; j < 3; ++j) coherent |= corners_[g][j] == b && corners_[g][(j + 1) % 3] == a;
    Facet& facet = out_.facets[g];
    facet.region = out_.facets[f].region;
    facet.flipped = out_.facets[f].flipped == coherent;
    if (sheet_count(g) <= 1) return;
    const std::vector<Index>& here = links.sheets[{f, k}];
    facet.slots = static_cast<Index>(out_.slot_map.size());
    for (Index s = 0; s < sheet_count(g); ++s)
      out_.slot_map.push_back(out_.slot_map[out_.facets[f].slots + here[s]]);
  }

  // What constrains the regions at edges where something branches or may be wound.
  void list_fans(const std::vector<EdgeUse>& uses, const std::vector<Range>& special) {
    const auto group = [&](const Range& r) {
      return std::span<const EdgeUse>(uses.data() + r.first, r.second - r.first);
    };
    std::map<Fan, Index> distinct;
    for (const Range& r : special) distinct.try_emplace(make_fan(group(r)), uses[r.first].p);
    for (const Range& r : free_groups_) {
      FreeFan f;
      f.fan = make_fan(group(r), &f.edges);
      puzzle_.free_fans.push_back(std::move(f));
    }
    puzzle_.free_edges = static_cast<Index>(free_edges_.size());
    puzzle_.pierced = pierced_edges();
    for (const auto& [fan, vertex] : distinct) {
      puzzle_.fans.push_back(fan);
      fan_place_.push_back(vertex);
    }
    out_.constraints = static_cast<Index>(puzzle_.fans.size());
  }

  // Of the free edges, those with several parts.
  std::vector<char> pierced_edges() const {
    std::vector<int> parts(free_edges_.size(), 0);
    for (const FreeFan& f : puzzle_.free_fans)
      for (const Index e : f.edges)
        if (e >= 0) ++parts[e];
    std::vector<char> out;
    for (const int n : parts) out.push_back(n > 2);  // passes come twice
    return out;
  }

  // Fans leave open what becomes of a vertex: its turns may make a handle.
  void add_links(const std::vector<EdgeUse>& uses, const std::set<Index>& vertices) {
    struct Star {
      std::vector<std::span<const EdgeUse>> edges;
      std::vector<Index> tets;  // that are covered
    };
    std::map<Index, Star> stars;
    for (const Index v : vertices) stars[v];
    for (std::size_t b = 0; b < uses.size();) {
      std::size_t e = b + 1;
      while (e < uses.size() && uses[e].p == uses[b].p && uses[e].q == uses[b].q) ++e;
      for (const Index v : {uses[b].p, uses[b].q})
        if (const auto star = stars.find(v); star != stars.end())
          star->second.edges.emplace_back(uses.data() + b, e - b);
      b = e;
    }
    for (Index t = 0; t < tets_.T.rows() && !stars.empty(); ++t) {
      if (out_.winding_of(t) == 0) continue;
      for (const Index v : tets_.T.row(t))
        if (const auto star = stars.find(v); star != stars.end()) star->second.tets.push_back(t);
    }
    for (const auto& [v, star] : stars) puzzle_.links.push_back(make_link(v, star.edges, star.tets));
  }

  VertexLink make_link(Index v, const std::vector<std::span<const EdgeUse>>& edges,
                       const std::vector<Index>& tets) const {
    VertexLink link;
    std::map<Index, int> sector_of;  // per tet
    std::map<Index, Index> ends;     // of edges at v, with how often they are covered; -1: facets meet there
    for (const Index seed : tets) {
      if (!sector_of.try_emplace(seed, static_cast<int>(link.winding.size())).second) continue;
      const Index w = out_.winding_of(seed);
      link.winding.push_back(w);
      for (std::vector<Index> stack{seed}; !stack.empty();) {
        const Index t = stack.back();
        stack.pop_back();
        link.rest += w;
        for (int k = 0; k < 4; ++k) {
          if (tets_.T(t, k) == v) continue;
          ends.emplace(tets_.T(t, k), w);
          if (out_.facet_on[t][k] >= 0) continue;
          const Index next = tets_.neighbours(t, k);
          if (t < next) link.rest -= w;
          if (sector_of.emplace(next, sector_of.at(seed)).second) stack.push_back(next);
        }
      }
    }
    std::set<Index> facets;
    for (const std::span<const EdgeUse> group : edges) {
      if (free_) link.edges.emplace_back();
      link.corners.push_back(make_fan(group, free_ ? &link.edges.back() : nullptr));
      ends[group[0].p == v ? group[0].q : group[0].p] = -1;
      for (const EdgeUse& use : group) facets.insert(use.facet);
    }
    for (const auto& [end, w] : ends)
      if (w > 0) link.rest += w;
    const auto sector = [&](Index tet) { return out_.winding_of(tet) > 0 ? sector_of.at(tet) : -1; };
    for (const Index f : facets) {
      const Facet& facet = out_.facets[f];
      const Region& region = out_.regions[facet.region];
      link.arcs.push_back({facet.region, facet.flipped, sector(facet.front), sector(facet.back)});
      link.rest -=
          region.front_winding + static_cast<int>(std::count(region.signs.begin(), region.signs.end(), 1));
    }
    if (free_) link.borders = borders_around(edges);
    return link;
  }

  // Closed polygons of sheets around the vertex that these edges meet at.
  int borders_around(const std::vector<std::span<const EdgeUse>>& edges) const {
    std::map<std::pair<Index, int>, std::size_t> number;  // of a sheet of a facet
    std::vector<std::pair<std::size_t, std::size_t>> joined;
    std::vector<Fan::Pass> passes;
    std::vector<Edge> over;
    for (const std::span<const EdgeUse> group : edges) {
      (void)find_passes(group, passes, over);  // the same group has passed before
      for (const Fan::Pass& p : passes)
        joined.emplace_back(
            number.try_emplace({group[p.from].facet, p.from_sheet}, number.size()).first->second,
            number.try_emplace({group[p.to].facet, p.to_sheet}, number.size()).first->second);
    }
    UnionFind polygons(number.size());
    auto left = static_cast<int>(number.size());
    for (const auto& [a, b] : joined) left -= polygons.join(a, b);
    return left;
  }

  // Input edges that could be wound: covered on all sides all along. (An edge may lie in a face or on another
  // edge, too; so its fans may have other sheets that pass.)
  std::optional<Error> find_covered_edges(const std::vector<EdgeUse>& uses) {
    std::set<Edge> covered, uncovered;
    std::vector<Fan::Pass> passes;
    std::vector<Edge> over;
    for (std::size_t b = 0, e = 0; b < uses.size(); b = e) {
      for (e = b + 1; e < uses.size() && uses[e].p == uses[b].p && uses[e].q == uses[b].q;) ++e;
      const std::span<const EdgeUse> group(uses.data() + b, e - b);
      if (auto error = find_passes(group, passes, over)) return error;
      const bool surrounded = std::all_of(group.begin(), group.end(), [&](const EdgeUse& use) {
        const Facet& f = out_.facets[use.facet];
        return std::min(out_.winding_of(f.front), out_.winding_of(f.back)) >= 1;
      });
      for (const Edge& edge : over)
        if (edge.first >= 0) (surrounded ? covered : uncovered).insert(edge);
    }
    for (const Edge& edge : uncovered) covered.erase(edge);
    if (!near_.empty())
      std::erase_if(covered, [&](const Edge& e) { return !near_.count(e.first) && !near_.count(e.second); });
    for (const Edge& edge : covered) free_edges_.emplace(edge, static_cast<Index>(free_edges_.size()));
    return std::nullopt;
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
  // over: per pass, the input edge that the sheet passes over there, or (-1, -1) inside a face.
  std::optional<Error> find_passes(std::span<const EdgeUse> group, std::vector<Fan::Pass>& passes,
                                   std::vector<Edge>& over) const {
    passes.clear();
    struct Entry {
      Index face;
      int leaf, sheet;
    };
    std::vector<Entry> entries;
    for (int i = 0; i < static_cast<int>(group.size()); ++i)
      for (Index s = 0; s < sheet_count(group[i].facet); ++s)
        entries.push_back({sheet(group[i].facet, s).face, i, static_cast<int>(s)});
    std::vector<int> partner(entries.size(), -1), turns(entries.size(), 0);
    over.assign(entries.size(), {-1, -1});
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
      if (found < 0)
        return Error{ErrorCode::unsolved, "The rounded arrangement has a gap.", place(group[0].p)};
      partner[i] = found, partner[found] = static_cast<int>(i);
      over[i] = over[found] = found_edge;
      const auto wound = free_ ? turns_.end() : turns_.find(found_edge);
      if (wound != turns_.end()) turns[i] = turns[found] = wound->second;
    }
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const Entry &a = entries[i], &b = entries[partner[i]];
      passes.push_back({a.leaf, a.sheet, b.leaf, b.sheet, turns[i]});
    }
    return std::nullopt;
  }

  // edges: per pass, the number of the free edge that it is over, or -1.
  Fan make_fan(std::span<const EdgeUse> given, std::vector<Index>* edges = nullptr) const {
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
    std::vector<Edge> over;
    (void)find_passes(group, fan.passes, over);  // cannot fail: the same group has passed before
    if (edges) {
      edges->clear();
      for (const Edge& edge : over) {
        const auto number = free_edges_.find(edge);
        edges->push_back(number == free_edges_.end() ? -1 : number->second);
      }
    }
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

  const Surface& surface_;
  const Arrangement& arrangement_;
  const TetgenResult& tets_;
  const int variant_;
  const RunContext& context_;
  std::map<Edge, int> turns_;  // of the wound edges given
  bool free_ = false;          // covered edges may be wound
  Error failure_{ErrorCode::unsolved, "The layers of the solid cannot be glued in another way."};
  bool too_large_ = false;  // the last formula
  bool discs_;              // vertices at edges that turn must have them
  std::set<Index> near_;    // vertices at which they may; none: all
  std::map<Edge, Index> free_edges_;
  std::vector<Range> free_groups_;  // uses of fans over such edges
  Sheets out_;
  std::vector<Triple> corners_;  // per facet, in the orientation of its arrangement triangle
  SheetPuzzle puzzle_;
  std::vector<Index> fan_place_;  // a vertex of each of its fans
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
                             std::span<const WoundEdge> wound, int variant, const RunContext& context) {
  OVERTET_EXPECTS(tets.facet_markers.size() == static_cast<std::size_t>(tets.facets.rows()));
  OVERTET_EXPECTS(std::all_of(tets.facet_markers.begin(), tets.facet_markers.end(),
                              [&](Index m) { return 1 <= m && m <= arrangement.F.rows(); }));
  return Assigner(surface, arrangement, tets, wound, variant, context).run();
}

}  // namespace overtet
