#include "src/immersion/gluing_formula.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <numeric>
#include <random>
#include <set>
#include <utility>

#include "kernels/core/tuning.h"
#include "kernels/core/union_find.h"
#include "kernels/sat/sat_solver.h"
#include "src/immersion/sheet_search.h"
#include "src/immersion/tuning.h"

namespace overtet {

namespace {

using Row = std::vector<Literal>;
using Table = std::vector<Row>;

Row variables(SatSolver& solver, std::size_t count) {
  Row out(count);
  for (Literal& x : out) x = solver.new_variable();
  return out;
}

// Of lists of copies: where each begins among all, and at the end how many there are.
std::vector<std::size_t> offsets(const std::vector<int>& copies) {
  std::vector<std::size_t> out{0};
  for (const int n : copies) out.push_back(out.back() + static_cast<std::size_t>(n));
  return out;
}

// The first of the shortest lists.
std::size_t shortest(const std::vector<int>& copies) {
  return static_cast<std::size_t>(std::min_element(copies.begin(), copies.end()) - copies.begin());
}

// Of one region: which copy in front goes on into which behind, and where its sheets end.
struct RegionVariables {
  Table through;         // front x back
  Table ends;            // sheet x copy on its inner side
  bool settled = false;  // all are known
};

// The sectors around the edge of a fan, in circles or up to where nothing is covered.
struct Sectors {
  std::vector<std::array<int, 2>> beside;  // per leaf and side; -1: not covered
  std::vector<int> copies;
  bool closed = true;  // all are covered
};

Sectors sectors_of(const Fan& fan, const std::vector<Region>& regions) {
  Sectors out;
  const int n = static_cast<int>(fan.leaves.size());
  out.beside.assign(fan.leaves.size(), {-1, -1});
  for (int i = 0; i < 2 * n; ++i) {
    const int other = fan.arc[i / 2][i % 2];
    if (other < 0) {
      out.closed = false;
      continue;
    }
    if (other < i) {
      out.beside[i / 2][i % 2] = out.beside[other / 2][other % 2];
      continue;
    }
    const Fan::Leaf& l = fan.leaves[i / 2];
    const Region& r = regions[l.region];
    out.beside[i / 2][i % 2] = static_cast<int>(out.copies.size());
    out.copies.push_back((i % 2 == 0) != l.flipped ? r.front_winding : r.back_winding);
  }
  return out;
}

int fewest(const Sectors& s) { return s.closed && !s.copies.empty() ? s.copies[shortest(s.copies)] : 0; }

// Passes are listed in both directions or in one; here each once.
std::vector<std::size_t> single_passes(const Fan& fan) {
  std::vector<std::size_t> out;
  for (std::size_t i = 0; i < fan.passes.size(); ++i) {
    const Fan::Pass& p = fan.passes[i];
    const bool known = std::any_of(out.begin(), out.end(), [&](std::size_t o) {
      const Fan::Pass& q = fan.passes[o];
      return q.from == p.to && q.from_sheet == p.to_sheet;
    });
    if (!known) out.push_back(i);
  }
  return out;
}

// More than 12 members: the arguments (five), and a table for each kind of its variables (four).
class Formula {
 public:
  Formula(const std::vector<Region>& regions, const std::vector<Index>& winding, const SheetPuzzle& puzzle,
          int variant, const RunContext& context)
      : regions_(regions), winding_(winding), puzzle_(puzzle), variant_(variant), context_(context) {}

  FormulaAnswer run() {
    if (build()) solve();
    return std::move(answer_);
  }

 private:
  // False: too large, stopped, or it is known already that there is nothing.
  bool build() {
    true_ = solver_.new_variable();
    solver_.add({true_});
    SheetSearch settled(regions_, winding_, puzzle_, context_);
    if (!settled.settle()) {
      answer_.verdict = FormulaAnswer::Verdict::none;
      return false;
    }
    add_regions(settled);
    add_turns();
    for (const Fan& fan : puzzle_.fans) {
      const bool holds = std::all_of(fan.leaves.begin(), fan.leaves.end(),
                                     [&](const Fan::Leaf& l) { return region_[l.region].settled; });
      if (!holds && !add_fan(fan, nullptr)) return false;
    }
    for (const FreeFan& fan : puzzle_.free_fans)
      if (!add_fan(fan.fan, &fan.edges)) return false;
    for (const VertexLink& link : puzzle_.links)
      if (!add_link(link)) return false;
    return true;
  }
  bool fits() {
    answer_.too_large = solver_.literals() > kMostLiterals;
    return !answer_.too_large && !stopped();
  }

  // By the context. The solver's memory grows as clauses are added and learnt.
  bool stopped() {
    if (!answer_.stop) answer_.stop = context_.stop();
    if (!answer_.stop && ++looks_ % 256 == 0) answer_.stop = context_.no_room_for(0);
    return answer_.stop.has_value();
  }

  // A clause, without what is known.
  void add(std::initializer_list<Literal> given) {
    clause_.clear();
    for (const Literal x : given) {
      if (x == true_) return;
      if (x != -true_) clause_.push_back(x);
    }
    solver_.add(clause_);
  }

  // Of what is not known to be false; the same is said once.
  void exactly_one(Row row) {
    std::erase(row, -true_);
    std::sort(row.begin(), row.end());
    if (exact_.insert(row).second) solver_.exactly_one(row);
  }

  void add_regions(const SheetSearch& settled) {
    std::vector<Index> all(regions_.size());
    std::iota(all.begin(), all.end(), 0);
    const std::vector<Named> named = name_layers(all, puzzle_.cells, winding_);
    for (std::size_t i = 0; i < regions_.size(); ++i)
      region_.push_back(settled.is_settled(static_cast<Index>(i))
                            ? known_region(regions_[i], settled.gluing(static_cast<Index>(i)))
                            : open_region(regions_[i], named[i]));
  }

  RegionVariables known_region(const Region& r, const Gluing& g) const {
    RegionVariables v;
    v.settled = true;
    v.through.assign(g.back_of.size(), Row(g.front_of.size(), -true_));
    for (const int sign : r.signs) v.ends.emplace_back((sign > 0 ? g.front_of : g.back_of).size(), -true_);
    for (std::size_t f = 0; f < g.back_of.size(); ++f)
      (g.back_of[f] >= 0 ? v.through[f][g.back_of[f]] : v.ends[-1 - g.back_of[f]][f]) = true_;
    for (std::size_t b = 0; b < g.front_of.size(); ++b)
      if (g.front_of[b] < 0) v.ends[-1 - g.front_of[b]][b] = true_;
    return v;
  }

  RegionVariables open_region(const Region& r, Named named) {
    RegionVariables v;
    for (int f = 0; f < r.front_winding; ++f)
      v.through.push_back(variables(solver_, static_cast<std::size_t>(r.back_winding)));
    Table at_front(static_cast<std::size_t>(r.front_winding)),
        at_back(static_cast<std::size_t>(r.back_winding));
    for (int f = 0; f < r.front_winding; ++f)
      for (int b = 0; b < r.back_winding; ++b) {
        at_front[f].push_back(v.through[f][b]);
        at_back[b].push_back(v.through[f][b]);
      }
    // The side whose copies get their names here goes in order, its sheets last.
    bool in_order = named != Named::neither;
    for (const int sign : r.signs) {
      Table& side = sign > 0 ? at_back : at_front;
      in_order = in_order && (sign > 0) == (named == Named::back);
      v.ends.push_back(variables(solver_, side.size()));
      for (std::size_t c = 0; c < side.size(); ++c) side[c].push_back(v.ends.back()[c]);
      solver_.exactly_one(v.ends.back());
    }
    for (const Table& side : {at_front, at_back})
      for (const Row& copy : side) exactly_one(copy);
    const auto through = static_cast<std::size_t>(std::min(r.front_winding, r.back_winding));
    if (in_order) {
      for (std::size_t c = 0; c < through; ++c) solver_.add({v.through[c][c]});
      for (std::size_t s = 0; s < v.ends.size() && through + s < v.ends[s].size(); ++s)
        solver_.add({v.ends[s][through + s]});
    }
    return v;
  }

  // As many as the sector with the fewest copies has, anywhere along the edge.
  void add_turns() {
    std::vector<int> most(static_cast<std::size_t>(puzzle_.free_edges), std::numeric_limits<int>::max());
    for (const FreeFan& f : puzzle_.free_fans) {
      const int here = fewest(sectors_of(f.fan, regions_));
      for (const Index e : f.edges)
        if (e >= 0) most[e] = std::min(most[e], here);
    }
    for (Index e = 0; e < puzzle_.free_edges; ++e) {
      turns_.push_back(variables(solver_, static_cast<std::size_t>(most[e]) + 1));
      solver_.exactly_one(turns_[e]);
      solver_.prefer(turns_[e][0]);
    }
    if (variant_ == 0) return;
    // Another solution: copies go on where they have not been asked to before.
    std::mt19937_64 random(static_cast<std::uint64_t>(variant_));
    for (const RegionVariables& r : region_)
      for (const Row& row : r.through)
        for (const Literal x : row)
          if (!r.settled) solver_.prefer(random() % 2 != 0 ? x : -x);
  }

  // What holds where a pass has so many turns. edge: -1: as many as it says.
  Row turns_of(const Fan::Pass& pass, Index edge) const {
    if (edge >= 0) return turns_[edge];
    Row out(static_cast<std::size_t>(pass.turns) + 1, -true_);
    out[pass.turns] = true_;
    return out;
  }

  // Names of one kind: by [sector][copy][name].
  using Names = std::vector<Table>;
  // Where one copy goes on into another.
  struct Way {
    int front, a, back, b;
    Literal when;
  };

  // Copies that are known to go on into each other have the same names. known: of some copies, all their
  // names (empty: to be found).
  Names names(const std::vector<int>& copies, const std::vector<Way>& ways, int columns, const Names& known) {
    const std::vector<std::size_t> begin = offsets(copies);
    UnionFind same(begin.back());
    for (const Way& w : ways)
      if (w.when == true_) same.join(begin[w.front] + w.a, begin[w.back] + w.b);
    Table of(begin.back());
    for (std::size_t s = 0; s < known.size(); ++s)
      for (std::size_t c = 0; c < known[s].size(); ++c) of[same.root(begin[s] + c)] = known[s][c];
    Names out(copies.size());
    for (std::size_t s = 0; s < copies.size(); ++s)
      for (int c = 0; c < copies[s]; ++c) {
        Row& row = of[same.root(begin[s] + c)];
        if (row.empty()) row = variables(solver_, static_cast<std::size_t>(columns));
        out[s].push_back(row);
      }
    return out;
  }

  bool add_fan(const Fan& fan, const std::vector<Index>* edges) {
    const Sectors sectors = sectors_of(fan, regions_);
    const std::vector<std::size_t> passes = single_passes(fan);
    std::vector<Row> turns;
    Index most_turns = 0;
    std::vector<char> passed(sectors.copies.size(), 0);  // by sheets, even without turns
    for (const std::size_t p : passes) {
      turns.push_back(turns_of(fan.passes[p], edges ? (*edges)[p] : -1));
      most_turns = std::max(most_turns, static_cast<Index>(turns.back().size()) - 1);
      for (const int s : sectors_passed(fan, sectors, fan.passes[p])) passed[s] = 1;
    }
    std::vector<Names> all;
    if (const int closing = fewest(sectors); closing > 0) {
      const std::size_t base = shortest(sectors.copies);
      const bool named = most_turns == 0 && !passed[base];
      Names known(sectors.copies.size());
      for (int c = 0; c < closing; ++c) {
        Row row(static_cast<std::size_t>(closing), -true_);
        row[c] = named ? true_ : solver_.new_variable();
        known[base].push_back(std::move(row));
      }
      if (named) name_neighbours(fan, sectors, static_cast<int>(base), known);
      all.push_back(add_names(sectors, ways_around(fan, sectors, -1), closing, known));
    }
    for (std::size_t i = 0; i < passes.size(); ++i) {
      const Fan::Pass& pass = fan.passes[passes[i]];
      Names known(sectors.copies.size());
      if (turns[i].size() == 1) known_on_pass(fan, sectors, pass, known);
      all.push_back(
          add_names(sectors, ways_around(fan, sectors, pass.from), static_cast<int>(turns[i].size()), known));
      add_pass(fan, sectors, pass, turns[i], all.back());
    }
    for (std::size_t s = 0; s < sectors.copies.size(); ++s)
      for (int c = 0; c < sectors.copies[s]; ++c) {
        Row any;
        for (const Names& kind : all) any.insert(any.end(), kind[s][c].begin(), kind[s][c].end());
        exactly_one(std::move(any));
      }
    return fits();
  }

  // A copy next to the sector that gives the names has that of the copy that it comes from: no variables are
  // needed, and these are most fans.
  void name_neighbours(const Fan& fan, const Sectors& sectors, int base, Names& known) const {
    for (std::size_t leaf = 0; leaf < fan.leaves.size(); ++leaf)
      for (int side = 0; side < 2; ++side) {
        const int other = sectors.beside[leaf][1 - side];
        if (sectors.beside[leaf][side] != base || other < 0 || !known[other].empty()) continue;
        const Fan::Leaf& l = fan.leaves[leaf];
        for (int a = 0; a < sectors.copies[other]; ++a) {
          Row& row = known[other].emplace_back();
          for (int c = 0; c < sectors.copies[base]; ++c)
            row.push_back(side == 0 ? through(l.region, l.flipped, c, a)
                                    : through(l.region, l.flipped, a, c));
        }
      }
  }

  // Whether a copy has the name of `from` because it comes from there, by definition.
  bool gives_name(Literal when, const Row& from, const Row& to) const {
    for (std::size_t name = 0; name < from.size(); ++name)
      if (from[name] == true_) return to[name] == when;
    return false;
  }

  // Names of a pass without extra turns: none where it does not pass, and where it begins and ends those
  // copies that end there.
  void known_on_pass(const Fan& fan, const Sectors& sectors, const Fan::Pass& pass, Names& known) const {
    std::vector<char> passed(sectors.copies.size(), 0);
    for (const int s : sectors_passed(fan, sectors, pass)) passed[s] = 1;
    for (std::size_t s = 0; s < known.size(); ++s)
      if (!passed[s]) known[s].assign(static_cast<std::size_t>(sectors.copies[s]), {-true_});
    for (const auto& [leaf, sheet] :
         {std::pair(pass.from, pass.from_sheet), std::pair(pass.to, pass.to_sheet)})
      if (Table& rows = known[sectors.beside[leaf][inner_side(fan, leaf, sheet)]]; rows.empty())
        for (const Literal ends : ends_at(fan, leaf, sheet)) rows.push_back({ends});
  }

  const Row& ends_at(const Fan& fan, int leaf, int sheet) const {
    const Fan::Leaf& l = fan.leaves[leaf];
    return region_[l.region].ends[l.slots[sheet]];
  }

  // Every copy has one name, so it is enough that names are kept in one direction.
  Names add_names(const Sectors& sectors, const std::vector<Way>& ways, int columns, const Names& known) {
    Names of = names(sectors.copies, ways, columns, known);
    for (const Way& w : ways) {
      const Row &front = of[w.front][w.a], &back = of[w.back][w.b];
      if (w.when == true_ || gives_name(w.when, front, back) || gives_name(w.when, back, front)) continue;
      for (std::size_t name = 0; name < front.size(); ++name)
        if (front[name] != back[name]) add({-w.when, -front[name], back[name]});
    }
    return of;
  }

  // What may go through one leaf.
  void add_ways(const Fan& fan, const Sectors& sectors, int leaf, std::vector<Way>& out) const {
    const auto [front, back] = sectors.beside[leaf];
    if (front < 0 || back < 0) return;
    const Fan::Leaf& l = fan.leaves[leaf];
    for (int a = 0; a < sectors.copies[front]; ++a)
      for (int b = 0; b < sectors.copies[back]; ++b)
        if (const Literal x = through(l.region, l.flipped, a, b); x != -true_)
          out.push_back({front, a, back, b, x});
  }
  // Through all leaves but one.
  std::vector<Way> ways_around(const Fan& fan, const Sectors& sectors, int but) const {
    std::vector<Way> out;
    for (int leaf = 0; leaf < static_cast<int>(fan.leaves.size()); ++leaf)
      if (leaf != but) add_ways(fan, sectors, leaf, out);
    return out;
  }

  // Copies in front of a facet and behind it.
  Literal through(Index region, bool flipped, int front, int back) const {
    return flipped ? region_[region].through[back][front] : region_[region].through[front][back];
  }

  void add_pass(const Fan& fan, const Sectors& sectors, const Fan::Pass& pass, const Row& turns,
                const Names& of) {
    const int away =
        inner_side(fan, pass.from, pass.from_sheet);  // the side of `from` on which the pass begins
    const std::size_t last = turns.size() - 1;
    std::vector<Way> ways;
    add_ways(fan, sectors, pass.from, ways);
    for (const Way& w : ways) {
      const Row &front = of[w.front][w.a], &back = of[w.back][w.b];
      const Row &before = away == 1 ? front : back, &after = away == 1 ? back : front;
      for (std::size_t t = 0; t < last; ++t) add({-w.when, -before[t], after[t + 1]});
      add({-w.when, -before[last]});
    }
    const auto each_end = [&](int leaf, int sheet, auto&& f) {
      const int sector = sectors.beside[leaf][inner_side(fan, leaf, sheet)];
      const Row& ends = ends_at(fan, leaf, sheet);
      for (std::size_t c = 0; c < ends.size(); ++c)
        if (of[sector][c][0] != ends[c]) f(ends[c], of[sector][c]);
    };
    each_end(pass.from, pass.from_sheet, [&](Literal here, const Row& name) { add({-here, name[0]}); });
    each_end(pass.to, pass.to_sheet, [&](Literal here, const Row& name) {
      for (std::size_t t = 0; t <= last; ++t) add({-here, -turns[t], name[t]});
    });
  }

  bool add_link(const VertexLink& link) {
    const std::size_t base = shortest(link.winding);
    int layers = link.winding[base];
    for (const VertexLink::Arc& arc : link.arcs)
      if (arc.front < 0 || arc.back < 0) layers = 0;
    Row& closed = closed_.emplace_back();
    if (layers > 0) {
      const std::vector<Way> ways = ways_across(link);
      const Names of = names(link.winding, ways, layers, {});
      // One direction is enough: what is named does not end, and every sector has each name once.
      for (const Way& w : ways)
        for (int layer = 0; layer < layers; ++layer)
          if (const Literal from = of[w.front][w.a][layer], to = of[w.back][w.b][layer]; from != to)
            add({-w.when, -from, to});
      for (int c = 0; c < layers; ++c) closed.push_back(of[base][c][c]);
      for (std::size_t s = 0; s < of.size(); ++s) {
        for (const Row& copy : of[s]) solver_.at_most_one(copy);
        for (int layer = 0; layer < layers; ++layer) {
          Row copies;
          for (std::size_t c = 0; c < of[s].size(); ++c) {
            copies.push_back(of[s][c][layer]);
            if (s == base && static_cast<int>(c) != layer) add({-copies.back()});
            add({-copies.back(), closed[layer]});
          }
          solver_.at_most_one(copies);
          copies.push_back(-closed[layer]);
          solver_.add(copies);
        }
      }
      for (const VertexLink::Arc& arc : link.arcs) end_layers(arc, of);
    }
    count_turns(link, closed);
    return fits();
  }

  std::vector<Way> ways_across(const VertexLink& link) const {
    std::vector<Way> out;
    for (const VertexLink::Arc& arc : link.arcs)
      for (int a = 0; a < link.winding[arc.front]; ++a)
        for (int b = 0; b < link.winding[arc.back]; ++b)
          if (const Literal x = through(arc.region, arc.flipped, a, b); x != -true_)
            out.push_back({arc.front, a, arc.back, b, x});
    return out;
  }

  // What ends at the vertex is no closed layer.
  void end_layers(const VertexLink::Arc& arc, const Names& of) {
    const RegionVariables& region = region_[arc.region];
    const Region& r = regions_[arc.region];
    for (std::size_t s = 0; s < region.ends.size(); ++s) {
      const int side = (r.signs[s] > 0) != arc.flipped ? arc.back : arc.front;
      for (std::size_t c = 0; c < region.ends[s].size(); ++c)
        for (const Literal layer : of[side][c]) add({-region.ends[s][c], -layer});
    }
  }

  // Euler's formula: what there would be without turns is discs, closed layers (two each) and turns.
  void count_turns(const VertexLink& link, const Row& closed) {
    int total = link.rest - link.borders;
    std::vector<Row> terms;  // each: what holds where it counts 0, 1, ...
    for (std::size_t i = 0; i < link.corners.size(); ++i) {
      const Fan& fan = link.corners[i];
      total += points_without_turns(fan);
      for (const std::size_t p : single_passes(fan)) {
        const Index edge = link.edges[i][p];
        if (edge < 0)
          total -= fan.passes[p].turns;
        else
          terms.push_back(turns_[edge]);
      }
    }
    for (const Literal layer : closed) terms.push_back({-layer, -true_, layer});
    exact_sum(terms, total);
  }

  // Copies that close and sheets that pass, if no sheet had extra turns.
  int points_without_turns(const Fan& fan) const {
    const Sectors sectors = sectors_of(fan, regions_);
    const std::vector<std::size_t> passes = single_passes(fan);
    const int sheets = static_cast<int>(passes.size());
    if (!sectors.closed) return sheets;
    int passing = 0;  // through the first sector
    for (const std::size_t p : passes) {
      const std::vector<int> passed = sectors_passed(fan, sectors, fan.passes[p]);
      passing += static_cast<int>(std::count(passed.begin(), passed.end(), 0));
    }
    return sectors.copies[0] - passing + sheets;
  }
  // By a pass without extra turns, in its order, as far as something is covered.
  std::vector<int> sectors_passed(const Fan& fan, const Sectors& sectors, const Fan::Pass& pass) const {
    std::vector<int> out;
    int leaf = pass.from, side = inner_side(fan, pass.from, pass.from_sheet);
    for (;;) {
      if (sectors.beside[leaf][side] < 0) return out;  // it cannot pass
      out.push_back(sectors.beside[leaf][side]);
      const int arrival = fan.arc[leaf][side];
      leaf = arrival / 2, side = 1 - arrival % 2;
      if (leaf == pass.to && arrival % 2 == inner_side(fan, pass.to, pass.to_sheet)) return out;
    }
  }
  int inner_side(const Fan& fan, int leaf, int sheet) const {
    const Fan::Leaf& l = fan.leaves[leaf];
    return (regions_[l.region].signs[l.slots[sheet]] > 0) != l.flipped ? 1 : 0;
  }

  // The terms sum up to `total`: partial sums follow from left to right.
  void exact_sum(const std::vector<Row>& terms, int total) {
    if (total < 0) return add({-true_});
    Row sum(static_cast<std::size_t>(total) + 1, 0);
    sum[0] = true_;
    for (const Row& term : terms) {
      Row next(sum.size(), 0);
      for (std::size_t s = 0; s < sum.size(); ++s) {
        if (sum[s] == 0) continue;
        for (std::size_t k = 0; k < term.size(); ++k) {
          if (term[k] == -true_) continue;
          if (s + k > static_cast<std::size_t>(total)) {
            add({-sum[s], -term[k]});
            continue;
          }
          if (next[s + k] == 0) next[s + k] = solver_.new_variable();
          add({-sum[s], -term[k], next[s + k]});
        }
      }
      sum = std::move(next);
    }
    for (int s = 0; s < total; ++s)
      if (sum[s] != 0) add({-sum[s]});
    if (sum[total] == 0) add({-true_});
  }

  SatAnswer ask(std::int64_t conflicts) {
    ++answer_.solves;
    return solver_.solve(conflicts, [&] { return stopped(); });
  }

  void solve() {
    using Verdict = FormulaAnswer::Verdict;
    for (std::int64_t round = 0; round < kMostNodes; ++round) {
      const SatAnswer found = ask(kMostNodes);
      if (found == SatAnswer::unsatisfiable) answer_.verdict = Verdict::none;
      if (found != SatAnswer::satisfiable) return;
      read();
      if (!refuse_wrong_vertices()) {
        answer_.verdict = Verdict::found;
        wind_less();
        return;
      }
    }
  }

  void read() {
    answer_.gluings.clear();
    for (std::size_t i = 0; i < regions_.size(); ++i) {
      const Region& r = regions_[i];
      Gluing g{std::vector<int>(static_cast<std::size_t>(r.front_winding), 0),
               std::vector<int>(static_cast<std::size_t>(r.back_winding), 0)};
      for (int f = 0; f < r.front_winding; ++f)
        for (int b = 0; b < r.back_winding; ++b)
          if (solver_.holds(region_[i].through[f][b])) g.back_of[f] = b, g.front_of[b] = f;
      for (std::size_t s = 0; s < r.signs.size(); ++s)
        for (std::size_t c = 0; c < region_[i].ends[s].size(); ++c)
          if (solver_.holds(region_[i].ends[s][c]))
            (r.signs[s] > 0 ? g.front_of : g.back_of)[c] = -1 - static_cast<int>(s);
      answer_.gluings.push_back(std::move(g));
    }
    turns_found_.clear();
    for (const Row& turns : turns_) {
      const auto k = std::find_if(turns.begin(), turns.end(), [&](Literal x) { return solver_.holds(x); });
      turns_found_.push_back(static_cast<int>(k - turns.begin()));
    }
  }

  // Whether there were any: spheres around a vertex that are not named as closed layers. Copies that go on
  // into each other like this must be.
  bool refuse_wrong_vertices() {
    std::vector<const Gluing*> chosen;
    for (const Gluing& g : answer_.gluings) chosen.push_back(&g);
    std::vector<Row> lacking;
    for (std::size_t i = 0; i < puzzle_.links.size(); ++i)
      if (!makes_discs(puzzle_.links[i], chosen, regions_))
        find_unnamed_spheres(puzzle_.links[i], closed_[i], lacking);
    for (const Row& clause : lacking) solver_.add(clause);
    return !lacking.empty();
  }

  void find_unnamed_spheres(const VertexLink& link, const Row& closed, std::vector<Row>& lacking) const {
    const std::vector<std::size_t> begin = offsets(link.winding);
    UnionFind pieces(begin.back());
    std::vector<std::size_t> bounded;
    std::map<std::size_t, Row> ways;  // by a copy
    for (const VertexLink::Arc& arc : link.arcs) {
      const Gluing& g = answer_.gluings[arc.region];
      const std::vector<int>&forth = arc.flipped ? g.front_of : g.back_of,
            &back = arc.flipped ? g.back_of : g.front_of;
      for (std::size_t c = 0; c < forth.size(); ++c) {
        if (forth[c] < 0) {
          bounded.push_back(begin[arc.front] + c);
          continue;
        }
        pieces.join(begin[arc.front] + c, begin[arc.back] + static_cast<std::size_t>(forth[c]));
        const Literal way = through(arc.region, arc.flipped, static_cast<int>(c), forth[c]);
        if (way != true_) ways[begin[arc.front] + c].push_back(-way);
      }
      for (std::size_t c = 0; c < back.size(); ++c)
        if (back[c] < 0) bounded.push_back(begin[arc.back] + c);
    }
    std::set<std::size_t> with_border;
    for (const std::size_t copy : bounded) with_border.insert(pieces.root(copy));
    const std::size_t base = shortest(link.winding);
    for (std::size_t c = 0; c < closed.size(); ++c) {
      const std::size_t piece = pieces.root(begin[base] + c);
      if (with_border.count(piece) || solver_.holds(closed[c])) continue;
      Row clause{closed[c]};
      for (const auto& [copy, not_ways] : ways)
        if (static_cast<std::size_t>(pieces.root(copy)) == piece)
          clause.insert(clause.end(), not_ways.begin(), not_ways.end());
      std::sort(clause.begin(), clause.end());
      clause.erase(std::unique(clause.begin(), clause.end()), clause.end());
      lacking.push_back(std::move(clause));
    }
  }

  // Edges that are wound stop being so, one by one, and no others begin; but others that nothing pierces may
  // take the place of a pierced one. As a rule, few of them need not be wound, and each try takes as long as
  // the whole formula does to be read.
  void wind_less() {
    int in_vain = 0;
    for (const char pierced : {1, 0})
      for (Index e = 0; e < puzzle_.free_edges && in_vain < kInVain; ++e) {
        if (puzzle_.pierced[e] != pierced || turns_found_[e] == 0) continue;
        ++in_vain;
        for (Index other = 0; other < puzzle_.free_edges; ++other)
          if (other == e || (turns_found_[other] == 0 && puzzle_.pierced[other] >= pierced))
            solver_.assume(turns_[other][0]);
        if (ask(kFirstNodes) != SatAnswer::satisfiable) continue;
        FormulaAnswer before = answer_;
        std::vector<int> turns = turns_found_;
        read();
        if (!refuse_wrong_vertices()) {
          in_vain = 0;
          continue;
        }
        answer_ = std::move(before);
        turns_found_ = std::move(turns);
      }
  }

  const std::vector<Region>& regions_;
  const std::vector<Index>& winding_;
  const SheetPuzzle& puzzle_;
  const int variant_;
  const RunContext& context_;
  SatSolver solver_;
  std::vector<RegionVariables> region_;
  std::vector<Row> turns_;   // per free edge: what holds where it has 0, 1, ... extra turns
  std::vector<Row> closed_;  // per link: its layers
  std::set<Row> exact_;      // sorted: exactly one of them holds
  Literal true_ = 0;
  Row clause_;              // of add()
  std::int64_t looks_ = 0;  // of stopped()
  std::vector<int> turns_found_;
  FormulaAnswer answer_;
};

}  // namespace

FormulaAnswer solve_as_formula(const std::vector<Region>& regions, const std::vector<Index>& winding,
                               const SheetPuzzle& puzzle, int variant, const RunContext& context) {
  return Formula(regions, winding, puzzle, variant, context).run();
}

}  // namespace overtet
