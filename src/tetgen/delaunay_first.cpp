#include "src/tetgen/delaunay_first.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <optional>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "kernels/delaunay/cavity.h"
#include "kernels/delaunay/delaunay.h"
#include "kernels/parallel/grouping.h"
#include "kernels/parallel/parallel.h"

namespace overtet {

namespace {

using Tet = std::array<Index, 4>;
using Triple = std::array<Index, 3>;

constexpr std::int64_t kGrain = 1 << 13;

// A cavity with more tets than this is TetGen's, and one for which so many tets have been tried.
constexpr std::size_t kLargestCavity = 40;
// So are cavities with more pairs of a tet and a missing facet, where one facet goes after the other.
constexpr std::size_t kMostPairs = 300'000;
constexpr int kSteps = 300;

// So often all cavities are looked at, each time with one more layer of tets around them.
constexpr int kRounds = 3;

// TetGen's part is shared out in pieces of at least this many facets, which can run at the same time.
constexpr std::int64_t kFacetsPerPiece = 10'000;
constexpr std::int64_t kMostPieces = 4;

Triple sorted(Triple t) {
  std::sort(t.begin(), t.end());
  return t;
}

// True when b is an even permutation of a. pre: b is a permutation of a.
bool same_turn(const Triple& a, const Triple& b) {
  const int at = b[0] == a[0] ? 0 : b[1] == a[0] ? 1 : 2;
  return b[(at + 1) % 3] == a[1];
}

Triple face_of(const Tet& t, int k) { return {t[kTetFace[k][0]], t[kTetFace[k][1]], t[kTetFace[k][2]]}; }

// Finds triangles by their corners.
class TriangleTable {
 public:
  TriangleTable(Index vertices, const std::vector<Triple>& triangles) : triangles_(triangles) {
    group_items(vertices, start_, items_, [&](auto&& visit) {
      for (Index f = 0; f < static_cast<Index>(triangles.size()); ++f)
        visit(std::min({triangles[f][0], triangles[f][1], triangles[f][2]}), f);
    });
  }
  // Its number, or -1.
  Index find(const Triple& f) const {
    const Index least = std::min({f[0], f[1], f[2]});
    const std::int64_t sum = std::int64_t{f[0]} + f[1] + f[2];
    for (Index i = start_[least]; i < start_[least + 1]; ++i) {
      const Triple& t = triangles_[items_[i]];
      if (std::int64_t{t[0]} + t[1] + t[2] == sum &&
          std::max({t[0], t[1], t[2]}) == std::max({f[0], f[1], f[2]}))
        return items_[i];
    }
    return -1;
  }

 private:
  const std::vector<Triple>& triangles_;
  RawVector<Index> start_;
  RawVector<Index> items_;
};

Error unsolved(std::string message) { return Error{ErrorCode::unsolved, std::move(message)}; }

class DelaunayFirst {
 public:
  DelaunayFirst(const Plc& plc, const RunContext& context, const DelaunayFirstOptions& options)
      : plc_(plc), context_(context), options_(options) {}

  Result<TetgenResult> run() {
    const auto begin = RunContext::Clock::now();
    const Index n = static_cast<Index>(plc_.V.rows());
    if (auto error = context_.no_room_for(static_cast<std::size_t>(n) * 1500)) return *error;
    TetArrays all = delaunay(plc_.V.data(), n, [&] { return context_.stop().has_value(); });
    if (auto stop = context_.stop()) return *stop;
    if (all.tet.empty()) return unsolved("All points lie in a plane.");
    tet_.assign(all.tet.begin(), all.tet.end());
    next_.assign(all.next.begin(), all.next.end());
    all = {};
    facets_.resize(plc_.F.rows());
    for (std::size_t f = 0; f < facets_.size(); ++f) facets_[f] = {plc_.F(f, 0), plc_.F(f, 1), plc_.F(f, 2)};
    source_.resize(facets_.size());
    std::iota(source_.begin(), source_.end(), 0);

    match_facets();
    missing_at_first_ = static_cast<Index>(missing_.size());
    if (static_cast<double>(missing_.size()) > options_.most_missing * static_cast<double>(facets_.size()))
      return unsolved("Too many facets are no faces of Delaunay tets.");
    cavity_of_.assign(tet_.size(), -1);
    replaced_.assign(tet_.size(), 0);
    for (int round = 0; round < kRounds && !missing_.empty(); ++round) {
      find_crossed_tets();
      make_cavities(round);
      fill_cavities(round);
      if (auto stop = context_.stop()) return *stop;
    }
    if (auto error = fill_the_rest()) return *error;
    missing_.clear();
    if (auto stop = context_.stop()) return *stop;
    Result<TetgenResult> out = collect();
    if (out) {
      out.value().seconds = std::chrono::duration<double>(RunContext::Clock::now() - begin).count();
      out.value().missing_facets = missing_at_first_;
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

  Index& beside(Index f, bool front) { return beside_[2 * static_cast<std::size_t>(f) + front]; }

  void match_facets() {
    const TriangleTable table(static_cast<Index>(plc_.V.rows()), facets_);
    facet_on_.resize(tet_.size());
    beside_.assign(2 * facets_.size(), -1);
    parallel_for(static_cast<std::int64_t>(tet_.size()), kGrain, [&](std::int64_t begin, std::int64_t end) {
      for (std::int64_t t = begin; t < end; ++t)
        for (int k = 0; k < 4; ++k) {
          const Triple face = face_of(tet_[t], k);
          const Index f = facet_on_[t][k] = table.find(face);
          // One tet on either side: nobody else writes here.
          if (f >= 0) beside(f, !same_turn(facets_[f], face)) = static_cast<Index>(t);
        }
    });
    for (Index f = 0; f < static_cast<Index>(facets_.size()); ++f)
      if (beside(f, false) < 0 && beside(f, true) < 0) missing_.push_back(f);
  }

  // The tets that a missing facet passes through. Those that have a point of its inside are connected by
  // faces, and some of them are at its corners.
  void find_crossed_tets() {
    std::vector<Index> tet_at(plc_.V.rows(), -1);
    for (Index t = 0; t < static_cast<Index>(tet_.size()); ++t)
      for (int k = 0; !replaced_[t] && k < 4; ++k) tet_at[tet_[t][k]] = t;
    crossed_ = parallel_collect<std::pair<Index, Index>>(
        static_cast<std::int64_t>(missing_.size()), 256,
        [&](std::int64_t begin, std::int64_t end, std::vector<std::pair<Index, Index>>& out) {
          std::vector<Index> star, seen;
          for (std::int64_t i = begin; i < end; ++i) {
            const Index f = missing_[i];
            seen.clear();
            const Index v = facets_[f][0];
            star.assign(1, tet_at[v]);
            for (std::size_t head = 0; head < star.size(); ++head)
              for (int k = 0; k < 4; ++k) {
                const Index other = next_[star[head]][k];
                if (other < 0 || tet_[star[head]][k] == v) continue;
                if (std::find(star.begin(), star.end(), other) == star.end()) star.push_back(other);
              }
            for (const Index t : star)
              if (!apart(plc_.V.data(), tet_[t], facets_[f])) seen.push_back(t);
            for (std::size_t head = 0; head < seen.size(); ++head)
              for (const Index other : next_[seen[head]])
                if (other >= 0 && std::find(seen.begin(), seen.end(), other) == seen.end() &&
                    !apart(plc_.V.data(), tet_[other], facets_[f]))
                  seen.push_back(other);
            for (const Index t : seen) out.emplace_back(t, f);
          }
        });
  }

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
    std::vector<Index> parent(tets.size());
    std::iota(parent.begin(), parent.end(), 0);
    const auto find = [&](Index i) {
      while (parent[i] != i) i = parent[i] = parent[parent[i]];
      return i;
    };
    const auto join = [&](Index a, Index b) {
      a = find(a), b = find(b);
      if (a != b) parent[std::max(a, b)] = std::min(a, b);
    };
    for (std::size_t i = 0; i < tets.size(); ++i)
      for (int k = 0; k < 4; ++k) {
        const Index other = next_[tets[i]][k];
        if (other < tets[i] || facet_on_[tets[i]][k] >= 0 || cavity_of_[other] < 0) continue;
        join(static_cast<Index>(i), cavity_of_[other]);
      }
    for (std::size_t i = 1; i < crossed_.size(); ++i)
      if (crossed_[i].second == crossed_[i - 1].second)
        join(cavity_of_[crossed_[i].first], cavity_of_[crossed_[i - 1].first]);
    cavities_.clear();
    std::vector<Index> number(tets.size(), -1);
    for (std::size_t i = 0; i < tets.size(); ++i) {
      Index& c = number[find(static_cast<Index>(i))];
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
        const Triple f = face_of(tet_[t], k);
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
    std::vector<Wall> walls;
    std::vector<char> found(plc_.F.rows(), 0);
    for (const Cavity& cavity : cavities_) {
      if (cavity.found.empty()) continue;
      find_walls(cavity, walls);
      replace(walls, cavity.found, cavity.fill);
      for (const Index t : cavity.tets) replaced_[t] = 1;
      for (const Index f : cavity.found) found[f] = 1;
    }
    for (const Cavity& cavity : cavities_)
      for (const Index t : cavity.tets) cavity_of_[t] = -1;
    std::erase_if(missing_, [&](Index f) { return found[f] != 0; });
  }

  bool fill_whole(Cavity& cavity, CavityFiller& filler) const {
    if (cavity.tets.size() > kLargestCavity) return false;
    std::vector<Wall> walls;
    find_walls(cavity, walls);
    std::vector<Triple> faces;
    for (const Wall& w : walls) faces.push_back(w.face);
    for (const Index f : cavity.facets) add_both_sides(facets_[f], faces);
    if (!filler.fill(plc_.V.data(), faces, kSteps, cavity.fill)) return false;
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
          for (int k = 0; inside[t] && k < 4; ++k) sides.push_back({sorted(face_of(tets[t], k)), t, k});
        std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.key < b.key; });
        faces.clear();
        for (std::size_t i = 0; i < sides.size(); ++i) {
          const bool inner = (i > 0 && sides[i - 1].key == sides[i].key) ||
                             (i + 1 < sides.size() && sides[i + 1].key == sides[i].key);
          if (inner && !std::binary_search(kept.begin(), kept.end(), sides[i].key)) continue;
          const Triple face = face_of(tets[sides[i].tet], sides[i].corner);
          faces.push_back({face[0], face[2], face[1]});
        }
        add_both_sides(facet, faces);
        if (!filler.fill(plc_.V.data(), faces, kSteps, fill)) {
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
        if (const Triple key = sorted(face_of(tets[t], k));
            !std::binary_search(kept.begin(), kept.end(), key))
          faces.push_back(key);
    std::sort(faces.begin(), faces.end());
    for (std::size_t t = 0; t < tets.size(); ++t)
      for (int k = 0; !inside[t] && k < 4; ++k)
        inside[t] = std::binary_search(faces.begin(), faces.end(), sorted(face_of(tets[t], k)));
  }

  // Puts tets in the place of those of cavities: the faces of the new ones meet the walls, the given facets
  // or each other.
  void replace(const std::vector<Wall>& walls, const std::vector<Index>& facets,
               const std::vector<Tet>& added) {
    struct Side {
      Triple key;
      int kind;  // 0: a wall, 1: a facet, 2: a new tet's
      Index a;   // wall, facet or tet
      int corner;
    };
    std::vector<Side> sides;
    for (std::size_t i = 0; i < walls.size(); ++i)
      sides.push_back({sorted(walls[i].face), 0, static_cast<Index>(i), 0});
    for (const Index f : facets) sides.push_back({sorted(facets_[f]), 1, f, 0});
    const Index first = static_cast<Index>(tet_.size());
    for (std::size_t i = 0; i < added.size(); ++i) {
      const Index t = first + static_cast<Index>(i);
      tet_.push_back(added[i]);
      next_.push_back({-1, -1, -1, -1});
      facet_on_.push_back({-1, -1, -1, -1});
      cavity_of_.push_back(-1);
      replaced_.push_back(0);
      for (int k = 0; k < 4; ++k) sides.push_back({sorted(face_of(added[i], k)), 2, t, k});
    }
    std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
      return std::tie(a.key, a.kind, a.a, a.corner) < std::tie(b.key, b.kind, b.a, b.corner);
    });
    for (std::size_t b = 0; b < sides.size();) {
      std::size_t e = b + 1;
      while (e < sides.size() && sides[e].key == sides[b].key) ++e;
      for (std::size_t i = b; i < e; ++i) {
        if (sides[i].kind != 2) continue;
        const Index t = sides[i].a;
        const int k = sides[i].corner;
        for (std::size_t j = b; j < e; ++j) {
          if (j == i) continue;
          if (sides[j].kind == 2) {
            next_[t][k] = sides[j].a;
          } else if (sides[j].kind == 1) {
            facet_on_[t][k] = sides[j].a;
          } else {
            const Wall& wall = walls[sides[j].a];
            if (same_turn(wall.face, face_of(added[t - first], k))) continue;  // the wall's other side
            const Index f = facet_on_[wall.tet][wall.corner], outside = next_[wall.tet][wall.corner];
            facet_on_[t][k] = f;
            if (outside >= 0) {
              for (int m = 0; m < 4; ++m)
                if (next_[outside][m] == wall.tet) next_[outside][m] = t;
              next_[t][k] = outside;
            }
          }
        }
        if (const Index f = facet_on_[t][k]; f >= 0)
          beside(f, !same_turn(facets_[f], face_of(added[t - first], k))) = t;
      }
      b = e;
    }
  }

  // Cavities that TetGen meshes together.
  struct Piece {
    std::vector<Index> cavities;
    std::vector<Wall> walls;
    std::vector<Index> vertices;  // the numbers of TetGen's input vertices
    TetgenResult result;
    std::vector<Index> inside;   // the tets of the result that lie in the cavities
    std::vector<Index> sources;  // of its facets: the missing facet that each is part of, or -1
  };

  std::optional<Error> fill_the_rest();
  std::optional<Error> mesh_cavities(std::span<const Index> cavities, std::vector<Piece>& pieces) const;
  std::optional<Error> mesh_piece(Piece& piece) const;
  void put_in(const Piece& piece);
  Result<TetgenResult> collect();

  const Plc& plc_;
  const RunContext& context_;
  const DelaunayFirstOptions& options_;
  std::vector<Tet> tet_, next_, facet_on_;
  std::vector<Index> cavity_of_;  // of tets in cavities
  std::vector<char> replaced_;    // tets that are no more
  std::vector<Triple> facets_;    // the input's, then parts of those that had to be split
  std::vector<Index> source_;     // the input facet of each
  std::vector<Index> beside_;     // per facet: the tet behind it, the tet in front of it
  std::vector<Index> missing_;
  std::vector<std::pair<Index, Index>> crossed_;  // tet, missing facet; by facet
  std::vector<Cavity> cavities_;
  std::vector<Eigen::Vector3d> added_points_;
  Index missing_at_first_ = 0, tetgen_facets_ = 0;
  std::size_t peak_of_children_ = 0;
};

// TetGen meshes the cavities that are left, several lots at a time.
std::optional<Error> DelaunayFirst::fill_the_rest() {
  if (missing_.empty()) return std::nullopt;
  find_crossed_tets();
  make_cavities(kRounds - 1);
  std::vector<Index> left;
  std::vector<std::int64_t> before{0};  // facets of all cavities before each
  std::vector<Wall> walls;
  for (Index c = 0; c < static_cast<Index>(cavities_.size()); ++c) {
    left.push_back(c);
    find_walls(cavities_[c], walls);
    before.push_back(before.back() + static_cast<std::int64_t>(walls.size() + cavities_[c].facets.size()));
  }
  if (static_cast<double>(before.back()) > options_.most_left * static_cast<double>(plc_.F.rows()))
    return unsolved("Most facets are no faces of Delaunay tets.");
  const std::int64_t count = std::clamp<std::int64_t>(before.back() / kFacetsPerPiece, 1, kMostPieces);
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

std::optional<Error> DelaunayFirst::mesh_piece(Piece& piece) const {
  std::vector<Wall> walls;
  struct Entry {
    Triple key;
    Index wall, facet;
  };
  std::vector<Entry> entries;
  for (const Index c : piece.cavities) {
    find_walls(cavities_[c], walls);
    for (const Wall& w : walls) {
      entries.push_back({sorted(w.face), static_cast<Index>(piece.walls.size()), -1});
      piece.walls.push_back(w);
    }
    for (const Index f : cavities_[c].facets) entries.push_back({sorted(facets_[f]), -1, f});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) {
    return std::tie(a.key, a.wall, a.facet) < std::tie(b.key, b.wall, b.facet);
  });
  for (const Entry& e : entries) piece.vertices.insert(piece.vertices.end(), e.key.begin(), e.key.end());
  std::sort(piece.vertices.begin(), piece.vertices.end());
  piece.vertices.erase(std::unique(piece.vertices.begin(), piece.vertices.end()), piece.vertices.end());
  const auto local = [&](Index v) {
    return static_cast<Index>(std::lower_bound(piece.vertices.begin(), piece.vertices.end(), v) -
                              piece.vertices.begin());
  };
  // A facet between two cavities is a wall of both.
  std::vector<Entry> rows;
  std::vector<Index> second;
  for (const Entry& e : entries)
    if (!rows.empty() && rows.back().key == e.key)
      second.back() = e.wall;
    else
      rows.push_back(e), second.push_back(-1);
  Plc part;
  part.V.resize(piece.vertices.size(), 3);
  for (std::size_t v = 0; v < piece.vertices.size(); ++v) part.V.row(v) = plc_.V.row(piece.vertices[v]);
  part.F.resize(rows.size(), 3);
  for (std::size_t f = 0; f < rows.size(); ++f)
    part.F.row(f) << local(rows[f].key[0]), local(rows[f].key[1]), local(rows[f].key[2]);
  TetgenOptions options;
  options.quality = false;
  options.accept_split = true;
  Result<TetgenResult> result = piece.cavities.size() == 1 ? tetrahedralize_shuffled(part, options, context_)
                                                           : tetrahedralize(part, options, context_);
  if (!result) return result.error();
  piece.result = std::move(result).value();
  const TetgenResult& r = piece.result;

  std::vector<Triple> triangles(r.facets.rows());
  std::vector<Index> parts(rows.size(), 0);
  for (std::size_t i = 0; i < triangles.size(); ++i) {
    triangles[i] = {r.facets(i, 0), r.facets(i, 1), r.facets(i, 2)};
    const Index f = r.facet_sources[i];
    ++parts[f];
    if (rows[f].wall >= 0 &&
        sorted(triangles[i]) != Triple{local(rows[f].key[0]), local(rows[f].key[1]), local(rows[f].key[2])})
      return unsolved("TetGen split a face that must stay.");
  }
  for (const Index n : parts)
    if (n == 0) return unsolved("TetGen lost a face.");

  // What lies inside the walls, starting from them.
  const TriangleTable table(static_cast<Index>(r.V.rows()), triangles);
  const Index n = static_cast<Index>(r.T.rows());
  enum : char { unknown, inside, outside };
  std::vector<char> where(n, unknown);
  std::vector<std::array<char, 4>> closed(n);
  std::vector<Index> stack;
  const auto tet = [&](Index t) { return Tet{r.T(t, 0), r.T(t, 1), r.T(t, 2), r.T(t, 3)}; };
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
      const Triple face = face_of(tet(t), k);
      const Index row = table.find(face);
      if (row < 0 || rows[r.facet_sources[row]].wall < 0) continue;
      closed[t][k] = true;
      char place = outside;
      for (const Index w : {rows[r.facet_sources[row]].wall, second[r.facet_sources[row]]}) {
        if (w < 0) continue;
        const Triple& f = piece.walls[w].face;
        if (!same_turn({local(f[0]), local(f[1]), local(f[2])}, face)) place = inside;
      }
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
  piece.sources.resize(r.facet_sources.size());
  for (std::size_t i = 0; i < piece.sources.size(); ++i) piece.sources[i] = rows[r.facet_sources[i]].facet;
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
    beside_.insert(beside_.end(), 2, -1);
  }
  std::vector<Tet> tets;
  for (const Index t : piece.inside)
    tets.push_back({number(r.T(t, 0)), number(r.T(t, 1)), number(r.T(t, 2)), number(r.T(t, 3))});
  replace(piece.walls, facets, tets);
  for (const Index c : piece.cavities)
    for (const Index t : cavities_[c].tets) replaced_[t] = 1;
  tetgen_facets_ += r.tetgen_facets;
  peak_of_children_ = std::max(peak_of_children_, r.peak_rss_bytes);
}

// Leaves out what lies outside and what has been replaced.
Result<TetgenResult> DelaunayFirst::collect() {
  const std::int64_t n = static_cast<std::int64_t>(tet_.size());
  const Index facets = static_cast<Index>(facets_.size());
  std::vector<char> gone(n, 0);
  std::vector<Index> stack;
  for (std::int64_t t = 0; t < n; ++t) {
    if (replaced_[t]) {
      gone[t] = 1;
      continue;
    }
    for (int k = 0; k < 4; ++k)
      if (next_[t][k] < 0 && facet_on_[t][k] < 0 && !gone[t]) {
        gone[t] = 1;
        stack.push_back(static_cast<Index>(t));
      }
  }
  while (!stack.empty()) {
    const Index t = stack.back();
    stack.pop_back();
    for (int k = 0; k < 4; ++k)
      if (const Index other = next_[t][k]; other >= 0 && facet_on_[t][k] < 0 && !gone[other]) {
        gone[other] = 1;
        stack.push_back(other);
      }
  }
  std::vector<Index> number(n, -1);
  Index kept = 0;
  for (std::int64_t t = 0; t < n; ++t)
    if (!gone[t]) number[t] = kept++;
  if (kept == 0) return unsolved("There is no volume inside the facets; are they closed?");

  TetgenResult out;
  const Eigen::Index given = plc_.V.rows();
  out.T.resize(kept, 4);
  out.neighbours.resize(kept, 4);
  out.facet_on.resize(kept);
  parallel_for(n, kGrain, [&](std::int64_t begin, std::int64_t end) {
    for (std::int64_t t = begin; t < end; ++t) {
      if (number[t] < 0) continue;
      out.facet_on[number[t]] = facet_on_[t];
      for (int k = 0; k < 4; ++k) {
        out.T(number[t], k) = tet_[t][k];
        out.neighbours(number[t], k) = next_[t][k] < 0 ? -1 : number[next_[t][k]];
      }
    }
  });
  // Points that TetGen has added outside are not needed.
  std::vector<Index> place(given + added_points_.size(), -1);
  for (Index t = 0; t < kept; ++t)
    for (int k = 0; k < 4; ++k) place[out.T(t, k)] = 0;
  for (Eigen::Index v = 0; v < given; ++v) {
    if (place[v] < 0) return unsolved("Vertex " + std::to_string(v) + " lies outside the facets.");
    place[v] = static_cast<Index>(v);
  }
  out.V.resize(static_cast<Eigen::Index>(place.size()), 3);
  out.V.topRows(given) = plc_.V;
  Index next = static_cast<Index>(given);
  for (std::size_t v = given; v < place.size(); ++v)
    if (place[v] == 0) {
      place[v] = next;
      out.V.row(next++) = added_points_[v - given];
    }
  if (next < static_cast<Index>(place.size())) {
    out.V.conservativeResize(next, 3);
    for (Index t = 0; t < kept; ++t)
      for (int k = 0; k < 4; ++k) out.T(t, k) = place[out.T(t, k)];
  }
  out.facets.resize(facets, 3);
  out.facet_sources = source_;
  out.facet_markers.resize(facets);
  for (Index f = 0; f < facets; ++f) {
    out.facets.row(f) << place[facets_[f][0]], place[facets_[f][1]], place[facets_[f][2]];
    out.facet_markers[f] = plc_.markers.empty() ? 1 : plc_.markers[source_[f]];
  }
  return out;
}

}  // namespace

Result<TetgenResult> tetrahedralize_delaunay_first(const Plc& plc, const RunContext& context,
                                                   const DelaunayFirstOptions& options) {
  return DelaunayFirst(plc, context, options).run();
}

}  // namespace overtet
