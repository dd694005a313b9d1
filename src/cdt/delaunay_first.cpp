#include "src/cdt/delaunay_first.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "kernels/core/assertions.h"
#include "kernels/core/tet_tables.h"
#include "kernels/core/tuning.h"
#include "kernels/core/union_find.h"
#include "kernels/delaunay/cavity.h"
#include "kernels/delaunay/tuning.h"
#include "kernels/parallel/parallel.h"
#include "src/cdt/delaunay_match.h"
#include "src/cdt/domain_parts.h"
#include "src/cdt/tuning.h"
#include "src/cdt/unsolved.h"

namespace overtet {

namespace {

// More than 12 members: seven of them are names for fields of DelaunayMatch, whose state this goes on
// changing.
class DelaunayFirst {
 public:
  DelaunayFirst(DelaunayMatch& match, const RunContext& context, const DelaunayFirstOptions& options)
      : plc_(match.plc), context_(context), options_(options), match_(match) {}

  Result<TetgenResult> run() {
    source_.resize(facets_.size());
    std::iota(source_.begin(), source_.end(), 0);
    cavity_of_.assign(tet_.size(), -1);
    for (int round = 0; round < kRings && !missing_.empty(); ++round) {
      match_.find_crossed_tets();
      make_cavities(round);
      fill_cavities(round);
      if (auto stop = context_.stop()) return *stop;
    }
    if (auto error = fill_the_rest()) return *error;
    missing_.clear();
    if (auto stop = context_.stop()) return *stop;
    const Index needed = static_cast<Index>(plc_.V.rows()) - options_.free_points;
    Result<TetgenResult> out =
        without_outside(plc_, {tet_, next_, facet_on_, facets_, source_, added_points_, needed}, replaced_);
    if (out) {
      out.value().tetgen_facets = tetgen_facets_;
      out.value().peak_rss_bytes = peak_of_children_;
    }
    return out;
  }

 private:
  // A set of tets to be replaced, joined by faces without a facet on them, and the facets missing in it.
  struct Cavity {
    std::vector<Index> tets, facets;
    std::vector<Index> found;  // facets that are no longer missing with
    std::vector<Tet> fill;     // these tets
  };
  // A face of a cavity, turned so that the inside sees it counter-clockwise.
  struct Wall {
    Triple face;
    Index tet;  // the one inside that had it
    int corner;
  };

  // Cavities of the tets that missing facets pass through, and those beside them if wanted.
  void make_cavities(int layers) {
    std::vector<Index> tets;
    for (const auto& [t, f] : crossed_) tets.push_back(t);
    for (int layer = 0; layer < layers; ++layer) {
      for (std::size_t i = 0, n = tets.size(); i < n; ++i)
        for (int k = 0; k < 4; ++k)
          if (const Index other = next_[tets[i]][k]; other >= 0 && facet_on_[tets[i]][k] < 0)
            tets.push_back(other);
      std::sort(tets.begin(), tets.end());
      tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
    }
    std::sort(tets.begin(), tets.end());
    tets.erase(std::unique(tets.begin(), tets.end()), tets.end());
    for (std::size_t i = 0; i < tets.size(); ++i) cavity_of_[tets[i]] = static_cast<Index>(i);
    UnionFind joined(tets.size());
    for (std::size_t i = 0; i < tets.size(); ++i)
      for (int k = 0; k < 4; ++k) {
        const Index other = next_[tets[i]][k];
        if (other < tets[i] || facet_on_[tets[i]][k] >= 0 || cavity_of_[other] < 0) continue;
        joined.join_smaller(static_cast<Index>(i), cavity_of_[other]);
      }
    for (std::size_t i = 1; i < crossed_.size(); ++i)
      if (crossed_[i].second == crossed_[i - 1].second)
        joined.join_smaller(cavity_of_[crossed_[i].first], cavity_of_[crossed_[i - 1].first]);
    cavities_.clear();
    std::vector<Index> number(tets.size(), -1);
    for (std::size_t i = 0; i < tets.size(); ++i) {
      Index& c = number[joined.root(static_cast<Index>(i))];
      if (c < 0) {
        c = static_cast<Index>(cavities_.size());
        cavities_.emplace_back();
      }
      cavity_of_[tets[i]] = c;
      cavities_[c].tets.push_back(tets[i]);
    }
    for (std::size_t i = 0; i < crossed_.size(); ++i)
      if (i == 0 || crossed_[i].second != crossed_[i - 1].second)
        cavities_[cavity_of_[crossed_[i].first]].facets.push_back(crossed_[i].second);
  }

  void find_walls(const Cavity& cavity, std::vector<Wall>& walls) const {
    walls.clear();
    for (const Index t : cavity.tets)
      for (int k = 0; k < 4; ++k) {
        const Index other = next_[t][k];
        if (other >= 0 && cavity_of_[other] == cavity_of_[t] && facet_on_[t][k] < 0) continue;
        const Triple f = tet_face(tet_[t], k);
        walls.push_back({{f[0], f[2], f[1]}, t, k});
      }
  }

  // Fills the cavities so that as many facets as possible are no longer missing.
  void fill_cavities(int round) {
    parallel_for(static_cast<std::int64_t>(cavities_.size()), 32, [&](std::int64_t begin, std::int64_t end) {
      CavityFiller filler;
      for (std::int64_t c = begin; c < end; ++c)
        if (!fill_whole(cavities_[c], filler)) fill_facet_by_facet(cavities_[c], filler, round);
    });
    // What lies beyond walls changes while cavities are replaced one by one; the walls themselves do not.
    std::vector<Replacement> replacements(cavities_.size());
    parallel_for(static_cast<std::int64_t>(cavities_.size()), 32, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t c = begin; c < end; ++c) {
        if (cavities_[c].found.empty()) continue;
        find_walls(cavities_[c], replacements[c].walls);
        prepare(cavities_[c].found, cavities_[c].fill, replacements[c]);
      }
    });
    std::vector<char> found(plc_.F.rows(), 0);
    for (std::size_t c = 0; c < cavities_.size(); ++c) {
      const Cavity& cavity = cavities_[c];
      if (cavity.found.empty()) continue;
      replace(replacements[c], cavity.fill);
      for (const Index t : cavity.tets) replaced_[t] = 1;
      for (const Index f : cavity.found) found[f] = 1;
    }
    for (const Cavity& cavity : cavities_)
      for (const Index t : cavity.tets) cavity_of_[t] = -1;
    std::erase_if(missing_, [&](Index f) { return found[f] != 0; });
  }

  bool fill_whole(Cavity& cavity, CavityFiller& filler) const {
    if (cavity.tets.size() > kMostTetsFilled) return false;
    std::vector<Wall> walls;
    find_walls(cavity, walls);
    std::vector<Triple> faces;
    for (const Wall& w : walls) faces.push_back(w.face);
    for (const Index f : cavity.facets) add_both_sides(facets_[f], faces);
    if (!filler.fill(plc_.V.data(), faces, kFillSteps, cavity.fill)) return false;
    cavity.found = cavity.facets;
    return true;
  }

  static void add_both_sides(const Triple& f, std::vector<Triple>& faces) {
    faces.push_back(f);
    faces.push_back({f[0], f[2], f[1]});
  }

  // One missing facet after the other, each with the tets that it passes through, or those beside them as
  // well.
  void fill_facet_by_facet(Cavity& cavity, CavityFiller& filler, int passes) const {
    if (cavity.tets.size() * cavity.facets.size() > kMostPairs) return;
    std::vector<Tet> tets;
    for (const Index t : cavity.tets) tets.push_back(tet_[t]);
    std::vector<Index> todo = cavity.facets, still;
    std::vector<Triple> kept;  // facets that are there, sorted
    for (const Index t : cavity.tets)
      for (int k = 0; k < 4; ++k)
        if (facet_on_[t][k] >= 0) kept.push_back(sorted(facets_[facet_on_[t][k]]));
    std::sort(kept.begin(), kept.end());
    const auto keep = [&](Index f) {
      const Triple key = sorted(facets_[f]);
      kept.insert(std::lower_bound(kept.begin(), kept.end(), key), key);
      cavity.found.push_back(f);
    };
    const auto is_there = [&](Index f) {
      return std::any_of(tets.begin(), tets.end(), [&](const Tet& t) {
        return std::all_of(facets_[f].begin(), facets_[f].end(),
                           [&](Index v) { return std::find(t.begin(), t.end(), v) != t.end(); });
      });
    };
    struct Side {
      Triple key;
      std::size_t tet;
      int corner;
    };
    std::vector<Side> sides;
    std::vector<char> inside;
    std::vector<Triple> faces;
    std::vector<Tet> fill;
    for (int pass = 0; pass <= passes && !todo.empty(); ++pass) {
      still.clear();
      for (const Index f : todo) {
        const Triple& facet = facets_[f];
        inside.assign(tets.size(), 0);
        if (is_there(f)) {
          keep(f);
          continue;
        }
        for (std::size_t t = 0; t < tets.size(); ++t) inside[t] = !apart(plc_.V.data(), tets[t], facet);
        for (int layer = 0; layer < pass; ++layer) grow(tets, kept, inside);
        sides.clear();
        for (std::size_t t = 0; t < tets.size(); ++t)
          for (int k = 0; inside[t] && k < 4; ++k) sides.push_back({sorted(tet_face(tets[t], k)), t, k});
        std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.key < b.key; });
        faces.clear();
        for (std::size_t i = 0; i < sides.size(); ++i) {
          const bool inner = (i > 0 && sides[i - 1].key == sides[i].key) ||
                             (i + 1 < sides.size() && sides[i + 1].key == sides[i].key);
          if (inner && !std::binary_search(kept.begin(), kept.end(), sides[i].key)) continue;
          const Triple face = tet_face(tets[sides[i].tet], sides[i].corner);
          faces.push_back({face[0], face[2], face[1]});
        }
        add_both_sides(facet, faces);
        if (!filler.fill(plc_.V.data(), faces, kFillSteps, fill)) {
          still.push_back(f);
          continue;
        }
        std::size_t n = 0;
        for (std::size_t t = 0; t < tets.size(); ++t)
          if (!inside[t]) tets[n++] = tets[t];
        tets.resize(n);
        tets.insert(tets.end(), fill.begin(), fill.end());
        keep(f);
      }
      std::swap(todo, still);
    }
    for (const Index f : todo)
      if (is_there(f)) keep(f);
    cavity.fill = std::move(tets);
  }

  // Adds the tets beside those that are marked.
  static void grow(const std::vector<Tet>& tets, const std::vector<Triple>& kept, std::vector<char>& inside) {
    std::vector<Triple> faces;
    for (std::size_t t = 0; t < tets.size(); ++t)
      for (int k = 0; inside[t] && k < 4; ++k)
        if (const Triple key = sorted(tet_face(tets[t], k));
            !std::binary_search(kept.begin(), kept.end(), key))
          faces.push_back(key);
    std::sort(faces.begin(), faces.end());
    for (std::size_t t = 0; t < tets.size(); ++t)
      for (int k = 0; !inside[t] && k < 4; ++k)
        inside[t] = std::binary_search(faces.begin(), faces.end(), sorted(tet_face(tets[t], k)));
  }

  // What meets where tets take the place of those of cavities.
  struct Replacement {
    struct Side {
      Triple key;
      int kind;  // 0: a wall, 1: a facet, 2: a new tet's
      Index a;   // wall, facet or new tet
      int corner;
    };
    std::vector<Wall> walls;
    std::vector<Side> sides;  // sorted
  };

  // Fills in the sides. facets: those that the added tets have.
  void prepare(const std::vector<Index>& facets, const std::vector<Tet>& added, Replacement& r) const {
    for (std::size_t i = 0; i < r.walls.size(); ++i)
      r.sides.push_back({sorted(r.walls[i].face), 0, static_cast<Index>(i), 0});
    for (const Index f : facets) r.sides.push_back({sorted(facets_[f]), 1, f, 0});
    for (std::size_t i = 0; i < added.size(); ++i)
      for (int k = 0; k < 4; ++k)
        r.sides.push_back({sorted(tet_face(added[i], k)), 2, static_cast<Index>(i), k});
    std::sort(r.sides.begin(), r.sides.end(), [](const Replacement::Side& a, const Replacement::Side& b) {
      return std::tie(a.key, a.kind, a.a, a.corner) < std::tie(b.key, b.kind, b.a, b.corner);
    });
  }

  // Puts the tets in: their faces meet the walls, the facets or each other.
  void replace(const Replacement& r, const std::vector<Tet>& added) {
    const auto& sides = r.sides;
    const Index first = static_cast<Index>(tet_.size());
    for (const Tet& t : added) {
      tet_.push_back(t);
      next_.push_back({-1, -1, -1, -1});
      facet_on_.push_back({-1, -1, -1, -1});
      cavity_of_.push_back(-1);
      replaced_.push_back(0);
    }
    for (std::size_t b = 0; b < sides.size();) {
      std::size_t e = b + 1;
      while (e < sides.size() && sides[e].key == sides[b].key) ++e;
      for (std::size_t i = b; i < e; ++i) {
        if (sides[i].kind != 2) continue;
        const Index t = first + sides[i].a;
        const int k = sides[i].corner;
        for (std::size_t j = b; j < e; ++j) {
          if (j == i) continue;
          if (sides[j].kind == 2) {
            next_[t][k] = first + sides[j].a;
          } else if (sides[j].kind == 1) {
            facet_on_[t][k] = sides[j].a;
          } else {
            const Wall& wall = r.walls[sides[j].a];
            if (same_turn(wall.face, tet_face(added[t - first], k))) continue;  // the wall's other side
            const Index f = facet_on_[wall.tet][wall.corner], outside = next_[wall.tet][wall.corner];
            facet_on_[t][k] = f;
            if (outside >= 0) {
              for (int m = 0; m < 4; ++m)
                if (next_[outside][m] == wall.tet) next_[outside][m] = t;
              next_[t][k] = outside;
            }
          }
        }
      }
      b = e;
    }
  }

  // A triangle that TetGen gets: a wall of one cavity or of two, or a missing facet; -1: it is none.
  struct Row {
    Triple key;  // its vertices, sorted
    Index wall = -1, facet = -1;
    Index second_wall = -1;
  };
  // Cavities that TetGen meshes together.
  struct Piece {
    std::vector<Index> cavities;
    std::vector<Wall> walls;
    std::vector<Index> vertices;  // the numbers of TetGen's input vertices
    std::vector<Row> rows;        // of TetGen's input facets
    TetgenResult result;
    std::vector<Index> inside;   // the tets of the result that lie in the cavities
    std::vector<Index> sources;  // of its facets: the missing facet that each is part of, or -1

    // The number among `vertices`.
    Index local(Index v) const {
      return static_cast<Index>(std::lower_bound(vertices.begin(), vertices.end(), v) - vertices.begin());
    }
    Triple local(const Triple& t) const { return {local(t[0]), local(t[1]), local(t[2])}; }
  };

  std::optional<Error> fill_the_rest();
  std::optional<Error> mesh_cavities(std::span<const Index> cavities, std::vector<Piece>& pieces) const;
  std::optional<Error> mesh_piece(Piece& piece) const;
  void collect_rows(Piece& piece) const;
  static std::optional<Error> check_rows(const Piece& piece);
  static std::optional<Error> find_inside(Piece& piece);
  void put_in(const Piece& piece);

  const Plc& plc_;
  const RunContext& context_;
  const DelaunayFirstOptions& options_;
  DelaunayMatch& match_;
  RawVector<Tet>&tet_ = match_.tet, &next_ = match_.next, &facet_on_ = match_.facet_on;
  std::vector<char>& replaced_ = match_.replaced;
  std::vector<Triple>& facets_ = match_.facets;  // the input's, then parts of those that had to be split
  std::vector<Index>& missing_ = match_.missing;
  std::vector<std::pair<Index, Index>>& crossed_ = match_.crossed;
  std::vector<Index> cavity_of_;  // of tets in cavities
  std::vector<Index> source_;     // the input facet of each
  std::vector<Cavity> cavities_;
  std::vector<Eigen::Vector3d> added_points_;
  Index tetgen_facets_ = 0;
  std::size_t peak_of_children_ = 0;
};

// TetGen meshes the cavities that are left, several lots at a time.
std::optional<Error> DelaunayFirst::fill_the_rest() {
  if (missing_.empty()) return std::nullopt;
  match_.find_crossed_tets();
  make_cavities(kRings - 1);
  std::vector<Index> left;
  std::vector<std::int64_t> before{0};  // facets of all cavities before each
  std::vector<Wall> walls;
  for (Index c = 0; c < static_cast<Index>(cavities_.size()); ++c) {
    left.push_back(c);
    find_walls(cavities_[c], walls);
    before.push_back(before.back() + static_cast<std::int64_t>(walls.size() + cavities_[c].facets.size()));
  }
  if (static_cast<double>(before.back()) > options_.most_left * static_cast<double>(plc_.F.rows()))
    return unsolved("Most facets are not faces of the Delaunay tets.");
  const std::int64_t count = std::clamp<std::int64_t>(before.back() / kLarge, 1, kMostPieces);
  std::vector<std::vector<Index>> lots(count);
  for (std::size_t i = 0; i < left.size(); ++i)
    lots[std::min(count - 1, before[i] * count / before.back())].push_back(left[i]);
  std::vector<std::vector<Piece>> pieces(count);
  std::vector<std::optional<Error>> errors(count);
  parallel_for(count, 1,
               [&](std::int64_t i, std::int64_t) { errors[i] = mesh_cavities(lots[i], pieces[i]); });
  for (auto& error : errors)
    if (error) return std::move(error);
  for (const auto& list : pieces)
    for (const Piece& piece : list) put_in(piece);
  return std::nullopt;
}

// Together, or in halves where TetGen fails.
std::optional<Error> DelaunayFirst::mesh_cavities(std::span<const Index> cavities,
                                                  std::vector<Piece>& pieces) const {
  if (cavities.empty()) return std::nullopt;
  Piece piece;
  piece.cavities.assign(cavities.begin(), cavities.end());
  auto error = mesh_piece(piece);
  if (!error) pieces.push_back(std::move(piece));
  if (!error || error->code != ErrorCode::unsolved || cavities.size() == 1) return error;
  const std::size_t half = cavities.size() / 2;
  error = mesh_cavities(cavities.first(half), pieces);
  return error ? error : mesh_cavities(cavities.subspan(half), pieces);
}

// Walls and missing facets, those that are the same once, and their vertices.
void DelaunayFirst::collect_rows(Piece& piece) const {
  std::vector<Wall> walls;
  std::vector<Row> entries;
  for (const Index c : piece.cavities) {
    find_walls(cavities_[c], walls);
    for (const Wall& w : walls) {
      entries.push_back({sorted(w.face), static_cast<Index>(piece.walls.size())});
      piece.walls.push_back(w);
    }
    for (const Index f : cavities_[c].facets) entries.push_back({sorted(facets_[f]), -1, f});
  }
  std::sort(entries.begin(), entries.end(), [](const Row& a, const Row& b) {
    return std::tie(a.key, a.wall, a.facet) < std::tie(b.key, b.wall, b.facet);
  });
  for (const Row& e : entries) piece.vertices.insert(piece.vertices.end(), e.key.begin(), e.key.end());
  std::sort(piece.vertices.begin(), piece.vertices.end());
  piece.vertices.erase(std::unique(piece.vertices.begin(), piece.vertices.end()), piece.vertices.end());
  for (const Row& e : entries)
    if (!piece.rows.empty() && piece.rows.back().key == e.key)
      piece.rows.back().second_wall = e.wall;  // a facet between two cavities is a wall of both
    else
      piece.rows.push_back(e);
}

// Whether the result has every row, and walls in one.
std::optional<Error> DelaunayFirst::check_rows(const Piece& piece) {
  const TetgenResult& r = piece.result;
  std::vector<Index> parts(piece.rows.size(), 0);
  for (Eigen::Index i = 0; i < r.facets.rows(); ++i) {
    const Index source = r.facet_sources[static_cast<std::size_t>(i)];
    const Row& row = piece.rows[source];
    ++parts[source];
    if (row.wall >= 0 &&
        sorted(std::array<Index, 3>{r.facets(i, 0), r.facets(i, 1), r.facets(i, 2)}) != piece.local(row.key))
      return unsolved("TetGen split a face that must stay whole.");
  }
  if (std::find(parts.begin(), parts.end(), 0) != parts.end()) return unsolved("TetGen lost a face.");
  return std::nullopt;
}

// What lies inside the walls, starting from them.
std::optional<Error> DelaunayFirst::find_inside(Piece& piece) {
  const TetgenResult& r = piece.result;
  std::vector<Triple> triangles(r.facets.rows());
  for (std::size_t i = 0; i < triangles.size(); ++i)
    triangles[i] = {r.facets(i, 0), r.facets(i, 1), r.facets(i, 2)};
  const TriangleTable table(static_cast<Index>(r.V.rows()), triangles);
  const Index n = static_cast<Index>(r.T.rows());
  enum : char { unknown, inside, outside };
  std::vector<char> where(n, unknown);
  std::vector<std::array<char, 4>> closed(n);
  std::vector<Index> stack;
  bool contradiction = false;
  const auto enter = [&](Index t, char place) {
    if (where[t] == unknown) {
      where[t] = place;
      stack.push_back(t);
    }
    contradiction |= where[t] != place;
  };
  for (Index t = 0; t < n; ++t)
    for (int k = 0; k < 4; ++k) {
      closed[t][k] = false;
      const Triple face = tet_face(r.T.row(t), k);
      const Index facet = table.find(face);
      if (facet < 0) continue;
      const Row& row = piece.rows[r.facet_sources[facet]];
      if (row.wall < 0) continue;
      closed[t][k] = true;
      char place = outside;
      for (const Index w : {row.wall, row.second_wall})
        if (w >= 0 && !same_turn(piece.local(piece.walls[w].face), face)) place = inside;
      enter(t, place);
    }
  while (!stack.empty()) {
    const Index t = stack.back();
    stack.pop_back();
    for (int k = 0; k < 4; ++k)
      if (const Index other = r.neighbours(t, k); other >= 0 && !closed[t][k]) enter(other, where[t]);
  }
  if (contradiction) return unsolved("TetGen did not keep inside and outside apart.");
  for (Index t = 0; t < n; ++t)
    if (where[t] == inside) piece.inside.push_back(t);
  return std::nullopt;
}

std::optional<Error> DelaunayFirst::mesh_piece(Piece& piece) const {
  collect_rows(piece);
  Plc part;
  part.V.resize(piece.vertices.size(), 3);
  for (std::size_t v = 0; v < piece.vertices.size(); ++v) part.V.row(v) = plc_.V.row(piece.vertices[v]);
  part.F.resize(piece.rows.size(), 3);
  for (std::size_t f = 0; f < piece.rows.size(); ++f) {
    const Triple t = piece.local(piece.rows[f].key);
    part.F.row(f) << t[0], t[1], t[2];
  }
  TetgenOptions options;
  options.quality = false;
  options.accept_split = options_.parts.accept_split;
  options.patience = options_.parts.patience;
  Result<TetgenResult> result = piece.cavities.size() == 1 ? tetrahedralize_shuffled(part, options, context_)
                                                           : tetrahedralize(part, options, context_);
  if (!result) return result.error();
  piece.result = std::move(result).value();
  if (auto error = check_rows(piece)) return error;
  if (auto error = find_inside(piece)) return error;
  for (const Index row : piece.result.facet_sources) piece.sources.push_back(piece.rows[row].facet);
  return std::nullopt;
}

void DelaunayFirst::put_in(const Piece& piece) {
  const TetgenResult& r = piece.result;
  std::vector<Index> number_of(piece.vertices);
  number_of.resize(r.V.rows(), -1);
  const auto number = [&](Index v) {
    if (number_of[v] < 0) {
      number_of[v] = static_cast<Index>(plc_.V.rows() + static_cast<Eigen::Index>(added_points_.size()));
      added_points_.push_back(r.V.row(v));
    }
    return number_of[v];
  };
  std::vector<Index> facets;
  std::vector<char> begun(plc_.F.rows(), 0);
  for (std::size_t i = 0; i < piece.sources.size(); ++i) {
    const Index f = piece.sources[i];
    if (f < 0) continue;
    const Triple t{number(r.facets(i, 0)), number(r.facets(i, 1)), number(r.facets(i, 2))};
    if (!begun[f]) {
      begun[f] = 1;
      facets_[f] = t;
      facets.push_back(f);
      continue;
    }
    facets.push_back(static_cast<Index>(facets_.size()));
    facets_.push_back(t);
    source_.push_back(f);
  }
  std::vector<Tet> tets;
  for (const Index t : piece.inside)
    tets.push_back({number(r.T(t, 0)), number(r.T(t, 1)), number(r.T(t, 2)), number(r.T(t, 3))});
  Replacement replacement;
  replacement.walls = piece.walls;
  prepare(facets, tets, replacement);
  replace(replacement, tets);
  for (const Index c : piece.cavities)
    for (const Index t : cavities_[c].tets) replaced_[t] = 1;
  tetgen_facets_ += r.tetgen_facets;
  peak_of_children_ = std::max(peak_of_children_, r.peak_rss_bytes);
}

}  // namespace

Result<TetgenResult> tetrahedralize_delaunay_first(const Plc& plc, const RunContext& context,
                                                   const DelaunayFirstOptions& options,
                                                   DelaunayBuilder begun) {
  OVERTET_EXPECTS(options.free_points == 0 || !options.in_parts);
  const auto begin = RunContext::Clock::now();
  DelaunayMatch match(plc);
  if (auto error = match.run(context, std::move(begun), options.free_points)) return *error;
  const Index missing = static_cast<Index>(match.missing.size());
  const double most = options.in_parts ? options.most_missing : options.most_missing_without_parts;
  const bool few = static_cast<double>(missing) <= most * static_cast<double>(plc.F.rows());
  if (!options.in_parts && (!few || match.crosses_many()))
    return unsolved("Too many facets are not faces of the Delaunay tets.");
  Result<TetgenResult> out =
      few ? DelaunayFirst(match, context, options).run() : mesh_in_parts(match, options.parts, context);
  if (out) {
    out.value().missing_facets = missing;
    out.value().seconds = std::chrono::duration<double>(RunContext::Clock::now() - begin).count();
  }
  return out;
}

}  // namespace overtet
