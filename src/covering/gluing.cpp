#include "src/covering/gluing.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "kernels/core/assertions.h"
#include "kernels/core/union_find.h"
#include "src/arrangement/face_cuts.h"
#include "src/covering/gluing_search.h"
#include "src/covering/tuning.h"
#include "src/exact/ordinary_size.h"
#include "src/exact/wedges.h"
#include "src/mesh/topology.h"

namespace overtet {

namespace {

using exact::Rational;
using exact::Vec;
using Condition = GluingCondition;

// Steps in all to find conflicts near hinges, and to make a conflict small (some seconds each): whole
// searches, one for every way of looking near hinges.
std::int64_t most_steps_to_name() { return std::ssize(kStepsNear) * std::ssize(kSheets) * kMostGluingSteps; }

class Checker {
 public:
  Checker(const Surface& surface, const TriangleBvh& bvh, IntersectionGraph& graph, const RunContext& context)
      : surface_(surface),
        rays_(surface.V, surface.F, bvh),
        context_(context),
        pairs_(graph.pairs()),
        cuts_(surface, graph) {}

  Result<GluingAnswer> run(const SurfaceTopology& topology) {
    GluingAnswer out;
    try {
      cuts_.run(rays_, context_);
      if (auto stop = context_.stop()) return *stop;
      find_shells(topology);
    } catch (const Degenerate& where) {
      out.message = "Not in general position: " + where.what + ".";
      return out;
    }
    if (auto stop = context_.stop()) return *stop;
    find_conditions();
    out.parts = static_cast<Index>(cuts_.face_of_part.size());
    out.conditions = static_cast<Index>(conditions_.size());
    out.verdict = GluingVerdict::open;
    std::size_t tried = 0;
    for (const int most : kSheets) {
      std::vector<Condition> some;
      for (const Condition& c : conditions_)
        if (std::all_of(c.regions.begin(), c.regions.end(),
                        [&](Index r) { return r < 0 || shells_.layers[cells_[r][1]] <= most; }))
          some.push_back(c);
      if (some.size() == tried) continue;
      tried = some.size();
      GluingSearch search = searching(std::move(some));
      const SolverAnswer answer = search.run(kMostGluingSteps);
      out.steps += search.steps();
      if (auto stop = context_.stop()) return *stop;
      if (answer == SolverAnswer::found) continue;
      if (answer == SolverAnswer::too_long) {
        if (const auto conflict = near_hinges(most, out.steps)) {
          out.verdict = GluingVerdict::conflict;
          name(fewer(*conflict, out.steps), out.conflict);
          if (auto stop = context_.stop()) return *stop;
          return out;
        }
        if (auto stop = context_.stop()) return *stop;
        out.verdict = GluingVerdict::undecided;
        out.message = "The search for a gluing was given up.";
        return out;
      }
      out.verdict = GluingVerdict::conflict;
      name(fewer(search.needed(), out.steps), out.conflict);
      if (auto stop = context_.stop()) return *stop;
      return out;
    }
    return out;
  }

 private:
  GluingSearch searching(std::vector<Condition> conditions) const {
    return GluingSearch(std::move(conditions), cells_, shells_.layers, context_);
  }

  // Two sides of parts with a sector between them.
  struct Sector {
    Index u, v;  // halves; v runs the other way, or the same way
    int ku, kv;  // in front (0) or behind (1)
    bool same;
  };

  // Shells: what the solid covers on one side of the surface, connected around edges and curves.
  void find_shells(const SurfaceTopology& topology) {
    const Index parts = static_cast<Index>(cuts_.face_of_part.size());
    const Index n = static_cast<Index>(cuts_.halves.size());
    std::vector<Sector> sectors;
    for (Index h = 0; h < static_cast<Index>(topology.twin.size()); ++h) {
      const Index other = topology.twin[h];
      if (other < h) continue;
      const std::vector<Index> nodes = cuts_.edge_chain(h);
      for (std::size_t i = 1; i < nodes.size(); ++i) {
        const Index u = cuts_.half(h / 3, nodes[i - 1], nodes[i]),
                    v = cuts_.half(other / 3, nodes[i], nodes[i - 1]);
        edge_pieces_.push_back({h, cuts_.halves[u].part, cuts_.halves[v].part});
        for (const int k : {0, 1}) sectors.push_back({u, v, k, k, false});
      }
    }
    for (const FaceCuts::Piece& p : cuts_.pieces) {
      // Along n_f x n_g: on its left in f is what lies behind g, on its left in g what lies in front of f.
      const Index fm = cuts_.half(p.f, p.from, p.to), fp = cuts_.half(p.f, p.to, p.from);
      const Index gp = cuts_.half(p.g, p.from, p.to), gm = cuts_.half(p.g, p.to, p.from);
      sectors.push_back({fp, gp, 0, 0, false});
      sectors.push_back({fp, gm, 1, 0, true});
      sectors.push_back({fm, gp, 0, 1, true});
      sectors.push_back({fm, gm, 1, 1, false});
      const auto& halves = cuts_.halves;
      leaves_.push_back({halves[fp].part, halves[gp].part, halves[fm].part, halves[gm].part});
    }
    std::vector<Index> before(n);
    for (Index h = 0; h < n; ++h) before[cuts_.halves[h].next] = h;
    UnionFind side(2 * static_cast<std::size_t>(parts)), corner(2 * static_cast<std::size_t>(n));
    for (const Sector& s : sectors) {
      side.join(2 * cuts_.halves[s.u].part + s.ku, 2 * cuts_.halves[s.v].part + s.kv);
      // A half's corner is the one at its end.
      const Index ue = 2 * s.u + s.ku, ub = 2 * before[s.u] + s.ku;
      const Index ve = 2 * s.v + s.kv, vb = 2 * before[s.v] + s.kv;
      corner.join(ue, s.same ? ve : vb);
      corner.join(ub, s.same ? vb : ve);
    }
    std::vector<Index> number(2 * static_cast<std::size_t>(parts), -1);
    Index shells = 0;
    shells_.of_side.resize(number.size());
    for (Index x = 0; x < 2 * parts; ++x) {
      Index& s = number[side.root(x)];
      if (s < 0) s = shells++;
      shells_.of_side[x] = s;
    }
    // A sphere has two more corners and parts than pieces between them.
    std::vector<Index> euler(shells, 0);
    for (Index x = 0; x < 2 * parts; ++x) euler[shells_.of_side[x]] += 1 - cuts_.holes[x / 2];
    for (const Sector& s : sectors) --euler[shells_.of_side[side_of(s)]];
    for (Index x = 0; x < 2 * n; ++x)
      if (corner.root(x) == x) ++euler[shells_.of_side[2 * cuts_.halves[x / 2].part + x % 2]];
    find_layers(shells);
    find_coverage();
    std::vector<char> cut(shells, 0);
    for (Index s = 0; s < shells; ++s) cut[s] = shells_.layers[s] > 1 && euler[s] != 2;
    cut_handles(cut, sectors, before, corner);
  }

  Index side_of(const Sector& s) const { return 2 * cuts_.halves[s.u].part + s.ku; }
  Index other_side_of(const Sector& s) const { return 2 * cuts_.halves[s.v].part + s.kv; }

  // How often each input edge is covered all along.
  void find_coverage() {
    for (const EdgePiece& e : edge_pieces_) {
      const int here = shells_.layers[shells_.of_side[2 * e.left]];
      const auto [at, added] = covered_.try_emplace(e.half_edge, here);
      if (!added) at->second = std::min(at->second, here);
    }
  }

  // Layers over a shell with handles may change places on the way round. Such shells are cut open: what is
  // left is a tree of parts (those with holes left out), grown around every corner that but one cut leads to.
  // Across a cut names change, in the same way until the cut branches.
  void cut_handles(const std::vector<char>& cut, const std::vector<Sector>& sectors,
                   const std::vector<Index>& before, UnionFind& corner) {
    opening_.cut.assign(sectors.size(), 0);
    opening_.left_out.assign(cuts_.face_of_part.size(), 0);
    std::vector<std::pair<int, Index>> order;  // what had better not be cut comes first
    for (std::size_t i = 0; i < sectors.size(); ++i) {
      const Sector& s = sectors[i];
      if (!cut[shells_.of_side[side_of(s)]]) continue;
      opening_.cut[i] = 1;
      const bool at_edge = i < 2 * edge_pieces_.size();
      order.emplace_back(at_edge && covered_.at(edge_pieces_[i / 2].half_edge) > 0, static_cast<Index>(i));
      for (const Index p : {side_of(s) / 2, other_side_of(s) / 2})
        if (cuts_.holes[p] > 0) opening_.left_out[p] = 1;
    }
    std::sort(order.begin(), order.end());
    const auto whole = [&](const Sector& s) {
      return !opening_.left_out[side_of(s) / 2] && !opening_.left_out[other_side_of(s) / 2];
    };
    UnionFind grown(2 * cuts_.face_of_part.size());
    std::map<Index, std::vector<Index>> at_corner;
    const auto corners = [&](const Sector& s) {
      return std::array<Index, 2>{corner.root(2 * s.u + s.ku), corner.root(2 * before[s.u] + s.ku)};
    };
    for (const auto& [late, i] : order) {
      const Sector& s = sectors[i];
      const Index a = grown.root(side_of(s)), b = grown.root(other_side_of(s));
      if (a != b && whole(s)) {
        grown.join(a, b);
        opening_.cut[i] = 0;
      } else {
        for (const Index x : corners(s)) at_corner[x].push_back(i);
      }
    }
    std::vector<Index> stack;
    for (const auto& [x, list] : at_corner) stack.push_back(x);
    while (!stack.empty()) {
      const Index x = stack.back();
      stack.pop_back();
      Index only = -1;
      int count = 0;
      for (const Index i : at_corner[x])
        if (opening_.cut[i]) only = i, ++count;
      if (count != 1 || !whole(sectors[only])) continue;
      opening_.cut[only] = 0;
      for (const Index y : corners(sectors[only])) stack.push_back(y);
    }
    // Around a corner with two cuts: what one does the other undoes.
    opening_.names.assign(sectors.size(), -1);
    opening_.backwards.assign(sectors.size(), 0);
    // From a half's left to its right is counter-clockwise at its end, clockwise at its beginning; behind the
    // face the other way round.
    const auto turns_left = [&](Index i, Index x) {
      return (corners(sectors[i])[0] == x) != (sectors[i].ku == 1);
    };
    for (Index first = 0; first < static_cast<Index>(sectors.size()); ++first) {
      if (!opening_.cut[first] || opening_.names[first] >= 0) continue;
      const Index name = static_cast<Index>(opening_.name_shells.size());
      opening_.name_shells.push_back(shells_.of_side[side_of(sectors[first])]);
      opening_.names[first] = name;
      std::vector<Index> arc{first};
      for (std::size_t k = 0; k < arc.size(); ++k) {
        const Index here = arc[k];
        for (const Index x : corners(sectors[here])) {
          std::vector<Index> met;  // twice where both ends are at x
          for (const Index i : at_corner[x])
            if (opening_.cut[i]) met.push_back(i);
          if (met.size() != 2 || met[0] == met[1]) continue;
          const Index other = met[0] == here ? met[1] : met[0];
          if (opening_.names[other] >= 0) continue;
          opening_.names[other] = name;
          opening_.backwards[other] =
              (opening_.backwards[here] != 0) != (turns_left(here, x) == turns_left(other, x));
          arc.push_back(other);
        }
      }
    }
  }

  // The winding number over each shell: by one ray, at the first face that is whole or piece of curve, for
  // all that hang together.
  void find_layers(Index shells) {
    const Index parts = static_cast<Index>(cuts_.face_of_part.size());
    std::vector<std::vector<std::pair<Index, int>>> links(shells);
    for (Index p = 0; p < parts; ++p) {
      links[shells_.of_side[2 * p]].emplace_back(shells_.of_side[2 * p + 1], 1);
      links[shells_.of_side[2 * p + 1]].emplace_back(shells_.of_side[2 * p], -1);
    }
    for (auto& list : links) {
      std::sort(list.begin(), list.end());
      list.erase(std::unique(list.begin(), list.end()), list.end());
    }
    std::vector<char> known(shells, 0);
    shells_.layers.assign(shells, 0);
    const auto spread = [&](Index first, int winding) {
      std::vector<Index> stack{first};
      shells_.layers[first] = winding;
      known[first] = 1;
      while (!stack.empty()) {
        const Index s = stack.back();
        stack.pop_back();
        for (const auto& [other, jump] : links[s]) {
          if (known[other] && shells_.layers[other] != shells_.layers[s] + jump)
            throw Degenerate{"winding numbers disagree"};
          if (known[other]) continue;
          known[other] = 1;
          shells_.layers[other] = shells_.layers[s] + jump;
          stack.push_back(other);
        }
      }
    };
    for (Index p = 0; p < parts; ++p) {
      const Index f = cuts_.face_of_part[p];
      if (known[shells_.of_side[2 * p]] || cuts_.half_begin[f + 1] - cuts_.half_begin[f] != 3) continue;
      if (const auto winding = just_in_front(f)) spread(shells_.of_side[2 * p], *winding);
    }
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      const Index s = shells_.of_side[2 * leaves_[i][0]];
      if (known[s]) continue;
      if (const auto winding = in_front_of_both(cuts_.pieces[i])) spread(s, *winding);
    }
    for (Index s = 0; s < shells; ++s)
      if (!known[s] || shells_.layers[s] < 0) throw Degenerate{"a winding number is unknown or negative"};
  }

  std::optional<int> just_in_front(Index f) const {
    for (int k = 0; k < 4; ++k) {
      const Rational a(3 + k, 9 + 2 * k), b(3, 9 + 2 * k), c = 1 - a - b;
      const exact::Point start(a * exact::vec(rays_.corner(f, 0)) + b * exact::vec(rays_.corner(f, 1)) +
                               c * exact::vec(rays_.corner(f, 2)));
      const exact::RayCount ray = rays_.count(start, exact::Point(rays_.normal(f)), nullptr, {f});
      if (ray.status == exact::RayStatus::counted) return ray.winding;
    }
    return std::nullopt;
  }

  std::optional<int> in_front_of_both(const FaceCuts::Piece& piece) const {
    const Vec from = cuts_.place(piece.from), along = cuts_.place(piece.to) - from;
    const Vec u = exact::cross(rays_.normal(piece.f), rays_.normal(piece.g));
    const auto wedge = Wedges(rays_).in_front(piece.f, piece.g, u, from, along, 0, 1);
    return wedge ? std::optional<int>(wedge->winding) : std::nullopt;
  }

  void find_conditions() {
    const Index parts = static_cast<Index>(cuts_.face_of_part.size());
    UnionFind region(parts);
    // Edges that are not covered all along turn as they show: one gluing on both sides.
    const auto uncut = [&](std::size_t first, int count) {
      return std::none_of(opening_.cut.begin() + first, opening_.cut.begin() + first + count,
                          [](char c) { return c; });
    };
    for (std::size_t i = 0; i < edge_pieces_.size(); ++i) {
      const EdgePiece& e = edge_pieces_[i];
      if (covered_.at(e.half_edge) < 1 && uncut(2 * i, 2)) region.join(e.left, e.right);
    }
    cells_.assign(parts, {-1, -1});
    for (Index p = 0; p < parts; ++p)
      cells_[region.root(p)] = {shells_.of_side[2 * p], shells_.of_side[2 * p + 1]};
    // Names across cuts are unknown like gluings.
    for (const Index shell : opening_.name_shells) cells_.push_back({shell, shell});
    using Key = std::tuple<std::array<Index, 4>, std::array<Index, 4>, std::array<char, 4>, int>;
    std::set<Key> known;
    const auto add = [&](Condition& c, std::size_t sector, int sectors) {
      for (const Index r : c.regions)
        if (r >= 0 && (opening_.left_out[r] || shells_.layers[cells_[r][1]] > *std::rbegin(kSheets))) return;
      for (int k = 0; k < sectors; ++k)
        if (opening_.names[sector + k] >= 0) {
          c.names[k] = parts + opening_.names[sector + k];
          c.backwards[k] = opening_.backwards[sector + k];
        }
      if (known.insert({c.regions, c.names, c.backwards, c.most}).second) conditions_.push_back(c);
    };
    for (std::size_t i = 0; i < leaves_.size(); ++i) {
      Condition c;
      for (int k = 0; k < 4; ++k) c.regions[k] = region.root(leaves_[i][k]);
      c.piece = static_cast<Index>(i);
      add(c, 2 * edge_pieces_.size() + 4 * i, 4);
    }
    for (std::size_t i = 0; i < edge_pieces_.size(); ++i) {
      const EdgePiece& e = edge_pieces_[i];
      Condition c;
      c.regions = {region.root(e.left), region.root(e.right), -1, -1};
      c.most = covered_.at(e.half_edge);
      const Index a = half_edge_source(surface_.F, e.half_edge),
                  b = half_edge_target(surface_.F, e.half_edge);
      c.edge = {std::min(a, b), std::max(a, b)};
      // One layer outside fits whatever happens, where it may turn.
      const bool idle = c.most > 0 && shells_.layers[cells_[c.regions[0]][0]] < 2;
      if (!idle && (c.regions[0] != c.regions[1] || !uncut(2 * i, 2))) add(c, 2 * i, 2);
    }
  }

  std::array<double, 3> place_of(const Condition& c) const {
    if (c.most < 0) {
      const FaceCuts::Piece& p = cuts_.pieces[c.piece];
      return exact::approximate(Rational(1, 2) * (cuts_.place(p.from) + cuts_.place(p.to)));
    }
    const Eigen::RowVector3d m = (surface_.V.row(c.edge[0]) + surface_.V.row(c.edge[1])) / 2;
    return {m[0], m[1], m[2]};
  }

  // A conflict among the conditions closest to one of the hinges, if that is found. least: of kSheets, what
  // is known to contradict nothing has fewer layers.
  std::optional<std::vector<Condition>> near_hinges(int least, std::int64_t& steps) const {
    std::set<Index> hinges;
    for (const auto& [f, g] : pairs_)
      for (const Index v : surface_.F.row(f))
        if ((surface_.F.row(g).array() == v).any() && hinges.size() < kMostHinges) hinges.insert(v);
    std::vector<std::array<double, 3>> places;
    for (const Condition& c : conditions_) places.push_back(place_of(c));
    const std::int64_t end = steps + most_steps_to_name();
    for (const std::int64_t budget : kStepsNear)
      for (const int most : kSheets) {
        if (most < least) continue;
        for (const Index v : hinges) {
          std::vector<std::pair<double, std::size_t>> order;
          for (std::size_t i = 0; i < conditions_.size(); ++i) {
            const auto& regions = conditions_[i].regions;
            if (std::all_of(regions.begin(), regions.end(),
                            [&](Index r) { return r < 0 || shells_.layers[cells_[r][1]] <= most; }))
              order.emplace_back((surface_.V.row(v) - Eigen::RowVector3d::Map(places[i].data())).norm(), i);
          }
          std::sort(order.begin(), order.end());
          for (const std::size_t size : kNear) {
            std::vector<Condition> some;
            for (std::size_t i = 0; i < std::min(size, order.size()); ++i)
              some.push_back(conditions_[order[i].second]);
            GluingSearch search = searching(std::move(some));
            const SolverAnswer answer = search.run(budget);
            steps += search.steps();
            if (steps > end || context_.stop()) return std::nullopt;
            if (answer == SolverAnswer::none) return search.needed();
            if (answer == SolverAnswer::too_long || size >= order.size()) break;
          }
        }
      }
    return std::nullopt;
  }

  // A conflict in which nothing is left out that it can do without.
  std::vector<Condition> fewer(std::vector<Condition> conflict, std::int64_t& steps) const {
    const std::int64_t end = steps + most_steps_to_name();
    std::int64_t most = kMostGluingSteps;
    const auto still = [&](const std::vector<Condition>& some) -> std::optional<std::vector<Condition>> {
      GluingSearch search = searching(some);
      const SolverAnswer answer = search.run(std::min(most, end - steps));
      steps += search.steps();
      if (answer != SolverAnswer::none) return std::nullopt;
      most = std::max(kFewSteps, search.steps());
      return search.needed();
    };
    while (auto less = still(conflict)) {
      if (less->size() >= conflict.size()) break;
      conflict = std::move(*less);
    }
    for (std::size_t i = 0; i < conflict.size() && steps < end && !context_.stop();) {
      std::vector<Condition> without = conflict;
      without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
      if (auto less = still(without))
        conflict = std::move(*less), i = 0;
      else
        ++i;
    }
    return conflict;
  }

  void name(const std::vector<Condition>& conflict, GluingCertificate& out) const {
    for (const Condition& c : conflict) {
      if (c.most >= 0) {
        out.edges.push_back(c.edge);
        continue;
      }
      const FaceCuts::Piece& p = cuts_.pieces[c.piece];
      out.crossings.push_back({{p.f, p.g}, shells_.layers[cells_[c.regions[0]][0]], place_of(c)});
    }
    std::sort(out.edges.begin(), out.edges.end());
    out.edges.erase(std::unique(out.edges.begin(), out.edges.end()), out.edges.end());
    std::sort(out.crossings.begin(), out.crossings.end(), [](const auto& a, const auto& b) {
      return std::tie(a.faces, a.layers, a.position) < std::tie(b.faces, b.layers, b.position);
    });
    const auto same = [](const auto& a, const auto& b) { return a.faces == b.faces && a.layers == b.layers; };
    out.crossings.erase(std::unique(out.crossings.begin(), out.crossings.end(), same), out.crossings.end());
  }

  struct EdgePiece {
    Index half_edge;    // of the input
    Index left, right;  // parts
  };

  struct Shells {
    std::vector<Index> of_side;  // per part: in front, behind
    std::vector<int> layers;     // per shell
  };
  // How shells with handles are cut open.
  struct Opening {
    std::vector<char> cut;           // per sector: two a piece of an edge, then four a piece of a curve
    std::vector<Index> names;        // per sector: what changes there, or -1
    std::vector<char> backwards;     // per sector
    std::vector<char> left_out;      // per part
    std::vector<Index> name_shells;  // per change of names
  };

  const Surface& surface_;
  const exact::Rays rays_;
  const RunContext& context_;
  const std::vector<FacePair>& pairs_;
  FaceCuts cuts_;
  std::vector<EdgePiece> edge_pieces_;
  std::vector<std::array<Index, 4>> leaves_;  // per piece of a curve
  std::map<Index, int> covered_;              // per edge of the input: how often, all along
  Shells shells_;
  Opening opening_;
  std::vector<std::array<Index, 2>> cells_;  // per region, named by one of its parts: shells
  std::vector<Condition> conditions_;
};

}  // namespace

Result<GluingAnswer> check_gluing(const Surface& surface, const SurfaceTopology& topology,
                                  const TriangleBvh& bvh, IntersectionGraph& graph,
                                  const RunContext& context) {
  OVERTET_EXPECTS(degenerate_faces(surface).empty());
  const OrdinarySize sized(surface, bvh);
  Result<GluingAnswer> answer = Checker(sized.surface(), sized.bvh(), graph, context).run(topology);
  if (answer.ok() && sized.scaled())
    for (GluingCertificate::Crossing& c : answer.value().conflict.crossings)
      c.position = sized.back(c.position);
  return answer;
}

}  // namespace overtet