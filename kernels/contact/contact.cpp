#include "kernels/contact/contact.h"

#include <algorithm>
#include <utility>

#include "kernels/contact/tuning.h"
#include "kernels/core/assertions.h"
#include "kernels/core/indices.h"
#include "kernels/parallel/counts.h"
#include "kernels/parallel/parallel.h"
#include "kernels/parallel/tuning.h"
#include "kernels/predicates/predicates.h"

namespace overtet {

namespace {

Box box_of_face(const VertexMatrix& X, const TriangleMatrix& F, Index f) {
  Box box;
  for (int k = 0; k < 3; ++k) {
    const double a = X(F(f, 0), k), b = X(F(f, 1), k), c = X(F(f, 2), k);
    box.low[k] = std::min({a, b, c});
    box.high[k] = std::max({a, b, c});
  }
  return box;
}

std::array<Eigen::Vector3d, 4> corners(const VertexMatrix& X, const std::array<Index, 4>& v) {
  return {X.row(v[0]).transpose(), X.row(v[1]).transpose(), X.row(v[2]).transpose(), X.row(v[3]).transpose()};
}

// Boxes of the two parts of a primitive pair on the way from X to Y.
bool sweeps_overlap(PairKind kind, const std::array<Index, 4>& v, const VertexMatrix& X,
                    const VertexMatrix& Y) {
  const int split = kind == PairKind::vertex_triangle ? 1 : 2;
  for (int k = 0; k < 3; ++k) {
    double low[2], high[2];
    for (int part = 0; part < 2; ++part) {
      const int begin = part == 0 ? 0 : split, end = part == 0 ? split : 4;
      low[part] = high[part] = X(v[begin], k);
      for (int i = begin; i < end; ++i) {
        low[part] = std::min({low[part], X(v[i], k), Y(v[i], k)});
        high[part] = std::max({high[part], X(v[i], k), Y(v[i], k)});
      }
    }
    if (low[0] > high[1] || low[1] > high[0]) return false;
  }
  return true;
}

}  // namespace

ContactMesh::ContactMesh(const VertexMatrix& X, const TriangleMatrix& F, const std::vector<char>& free)
    : ContactMesh(X, F, free, VertexMatrix(), Eigen::VectorXd(), {}) {}

ContactMesh::ContactMesh(const VertexMatrix& X, const TriangleMatrix& F, const std::vector<char>& free,
                         const VertexMatrix& rest, const Eigen::VectorXd& h, const ContactRule& rule)
    : F_(F), free_(free), rest_(rest), h_(h), rule_(rule) {
  lists_.most_h = h;
  OVERTET_EXPECTS(all_below(F, X.rows()) && X.allFinite() && rest.allFinite() && h.allFinite());
  const Index vertices = static_cast<Index>(X.rows()), faces = static_cast<Index>(F.rows());
  std::vector<std::pair<Index, Index>> edges;
  edges.reserve(6 * static_cast<std::size_t>(faces));
  for (Index f = 0; f < faces; ++f)
    for (int k = 0; k < 3; ++k) {
      edges.emplace_back(F(f, k), F(f, (k + 1) % 3));
      edges.emplace_back(F(f, (k + 1) % 3), F(f, k));
    }
  std::sort(edges.begin(), edges.end());
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  rings_.begin.assign(static_cast<std::size_t>(vertices) + 1, 0);
  rings_.to.reserve(edges.size());
  for (const auto& [a, b] : edges) {
    ++rings_.begin[a + 1];
    rings_.to.push_back(b);
  }
  for (Index v = 0; v < vertices; ++v) rings_.begin[v + 1] += rings_.begin[v];

  owns_.assign(static_cast<std::size_t>(faces), 0);
  std::vector<char> vertex_taken(static_cast<std::size_t>(vertices), 0), edge_taken(rings_.to.size(), 0);
  for (Index f = 0; f < faces; ++f) {
    bool any_free = false;
    for (int k = 0; k < 3; ++k) {
      any_free = any_free || free_[F(f, k)];
      if (!std::exchange(vertex_taken[F(f, k)], 1)) owns_[f] |= static_cast<unsigned char>(1 << k);
      const Index a = std::min(F(f, (k + 1) % 3), F(f, (k + 2) % 3)),
                  b = std::max(F(f, (k + 1) % 3), F(f, (k + 2) % 3));
      const auto at =
          std::lower_bound(rings_.to.begin() + rings_.begin[a], rings_.to.begin() + rings_.begin[a + 1], b);
      if (!std::exchange(edge_taken[at - rings_.to.begin()], 1))
        owns_[f] |= static_cast<unsigned char>(8 << k);
    }
    (any_free ? free_faces_.list : frozen_faces_.list).push_back(f);
  }

  std::vector<Box> boxes(frozen_faces_.list.size());
  for (std::size_t i = 0; i < boxes.size(); ++i) {
    boxes[i] = box_of_face(X, F_, frozen_faces_.list[i]);
    boxes[i].grow(margin(frozen_faces_.list[i]));
  }
  frozen_faces_.tree.build(boxes);
  for (Index v = 0; v < vertices; ++v)
    if (free_[v]) free_vertices_.push_back(v);
  boxes_.resize(free_faces_.list.size());
  for (std::size_t i = 0; i < boxes_.size(); ++i) boxes_[i] = box_of_face(X, F_, free_faces_.list[i]);
  free_faces_.tree.build(boxes_);
}

bool ContactMesh::adjacent(Index a, Index b) const {
  return std::binary_search(rings_.to.begin() + rings_.begin[a], rings_.to.begin() + rings_.begin[a + 1], b);
}

// Half of the largest dhat of any pair of this face, and its skin: two grown boxes overlap when the pair is,
// or soon can be, in reach.
double ContactMesh::margin(Index face) const {
  if (h_.size() == 0) return 0;
  const double h = std::max({h_[F_(face, 0)], h_[F_(face, 1)], h_[F_(face, 2)]});
  return (0.5 * std::max(rule_.reach, rule_.ring_floor) + kSkinMost) * h;
}

double ContactMesh::mean_edge(const std::array<Index, 4>& v, PairKind kind, const Eigen::VectorXd& h) const {
  if (kind == PairKind::vertex_triangle) return std::min(h[v[0]], (h[v[1]] + h[v[2]] + h[v[3]]) / 3);
  return std::min((h[v[0]] + h[v[1]]) / 2, (h[v[2]] + h[v[3]]) / 2);
}

double ContactMesh::reach_of(bool near, double rest, double h) const {
  const double dhat = rule_.reach * h;
  return near ? std::max(std::min(dhat, rule_.ring_reach * rest), rule_.ring_floor * h) : dhat;
}

bool ContactMesh::remembered(const VertexMatrix& X) const {
  if (lists_.X.rows() != X.rows()) return false;
  return parallel_reduce(
      static_cast<std::int64_t>(free_vertices_.size()), kLightGrain, true,
      [&](std::int64_t begin, std::int64_t end) {
        for (std::int64_t i = begin; i < end; ++i) {
          const Index v = free_vertices_[i];
          if (h_[v] > lists_.h[v] ||
              !((X.row(v) - lists_.X.row(v)).squaredNorm() <= lists_.skin[v] * lists_.skin[v]))
            return false;
        }
        return true;
      },
      [](bool a, bool b) { return a && b; });
}

template <class BoxOf>
std::vector<IndexPair> ContactMesh::candidates(const BoxOf& box_of) {
  parallel_for(static_cast<std::int64_t>(free_faces_.list.size()), kLightGrain,
               [&](std::int64_t begin, std::int64_t end) {
                 for (std::int64_t i = begin; i < end; ++i) boxes_[i] = box_of(free_faces_.list[i]);
               });
  free_faces_.tree.refit(boxes_);
  std::vector<IndexPair> pairs =
      free_faces_.tree.collect_self_pairs<IndexPair>([&](Index a, Index b, std::vector<IndexPair>& out) {
        out.push_back({free_faces_.list[a], free_faces_.list[b]});
      });
  const std::vector<IndexPair> mixed = free_faces_.tree.collect_pairs<IndexPair>(
      frozen_faces_.tree, [&](Index a, Index b, std::vector<IndexPair>& out) {
        out.push_back({free_faces_.list[a], frozen_faces_.list[b]});
      });
  pairs.insert(pairs.end(), mixed.begin(), mixed.end());
  return pairs;
}

template <class Visit>
void ContactMesh::primitives(const IndexPair& faces, Visit&& visit) const {
  const auto corner = [&](Index f, int k) { return F_(f, k % 3); };
  for (const auto& [f, g] : {std::pair{faces.a, faces.b}, std::pair{faces.b, faces.a}}) {
    const Index a = F_(g, 0), b = F_(g, 1), c = F_(g, 2);
    for (int k = 0; k < 3; ++k) {
      if (!(owns_[f] >> k & 1)) continue;
      const Index v = F_(f, k);
      if (v == a || v == b || v == c) continue;
      if (free_[v] || free_[a] || free_[b] || free_[c])
        visit(PairKind::vertex_triangle, std::array{v, a, b, c});
    }
  }
  for (int i = 0; i < 3; ++i) {
    if (!(owns_[faces.a] >> (3 + i) & 1)) continue;
    const Index a = corner(faces.a, i + 1), b = corner(faces.a, i + 2);
    for (int j = 0; j < 3; ++j) {
      if (!(owns_[faces.b] >> (3 + j) & 1)) continue;
      const Index c = corner(faces.b, j + 1), d = corner(faces.b, j + 2);
      if (a == c || a == d || b == c || b == d) continue;
      if (free_[a] || free_[b] || free_[c] || free_[d]) visit(PairKind::edge_edge, std::array{a, b, c, d});
    }
  }
}

void ContactMesh::remember(const VertexMatrix& X) {
  // How far the fastest vertex went per use of the last list: a list that would not last is not worth a skin.
  double pace = kSkinMost;
  if (lists_.X.rows() == X.rows() && lists_.uses > 0) {
    pace = 0;
    for (Index v : free_vertices_) pace = std::max(pace, (X.row(v) - lists_.X.row(v)).norm() / lists_.h[v]);
    pace /= lists_.uses;
  }
  lists_.relative_skin = 2 * pace <= kSkinMost ? std::clamp(10 * pace, kSkinLeast, kSkinMost) : kSkinLeast;
  const Eigen::VectorXd now = h_;
  lists_.X = X;
  lists_.h = lists_.most_h.cwiseMin(kSkinGrowth * h_);
  lists_.uses = 0;
  lists_.skin = lists_.relative_skin * lists_.h;
  for (Eigen::Index v = 0; v < lists_.skin.size(); ++v)
    if (!free_[v]) lists_.skin[v] = 0;
  h_ = lists_.h;  // margins of the lengths to come
  const std::vector<IndexPair> pairs = candidates([&](Index f) {
    Box box = box_of_face(X, F_, f);
    box.grow(margin(f) -
             (kSkinMost - lists_.relative_skin) * std::max({h_[F_(f, 0)], h_[F_(f, 1)], h_[F_(f, 2)]}));
    return box;
  });
  h_ = now;
  const auto skin_of_face = [&](Index f) {
    return std::max({lists_.skin[F_(f, 0)], lists_.skin[F_(f, 1)], lists_.skin[F_(f, 2)]});
  };
  lists_.primitives = parallel_collect<Primitive>(
      static_cast<std::int64_t>(pairs.size()), kMediumGrain,
      [&](std::int64_t begin, std::int64_t end, std::vector<Primitive>& out) {
        for (std::int64_t i = begin; i < end; ++i) {
          primitives(pairs[i], [&](PairKind kind, const std::array<Index, 4>& v) {
            const int split = kind == PairKind::vertex_triangle ? 1 : 2;
            double skin[2] = {0, 0};
            for (int k = 0; k < 4; ++k) skin[k >= split] = std::max(skin[k >= split], lists_.skin[v[k]]);
            const double reach =
                std::max(rule_.reach, rule_.ring_floor) * mean_edge(v, kind, lists_.h) + skin[0] + skin[1];
            for (int axis = 0; axis < 3; ++axis) {
              double low[2], high[2];
              for (int part = 0; part < 2; ++part) {
                const int first = part == 0 ? 0 : split, last = part == 0 ? split : 4;
                low[part] = high[part] = X(v[first], axis);
                for (int k = first + 1; k < last; ++k) {
                  low[part] = std::min(low[part], X(v[k], axis));
                  high[part] = std::max(high[part], X(v[k], axis));
                }
              }
              if (low[0] - high[1] >= reach || low[1] - high[0] >= reach) return;
            }
            const double distance = closest_points(kind, corners(X, v)).distance;
            if (distance >= reach) return;
            bool near = false;
            for (int a = 0; a < split && !near; ++a)
              for (int b = split; b < 4 && !near; ++b) near = adjacent(v[a], v[b]);
            const double rest = near ? closest_points(kind, corners(rest_, v)).distance : 0;
            if (distance >= reach_of(near, rest, mean_edge(v, kind, lists_.h)) + skin[0] + skin[1]) return;
            out.push_back({v, kind, near, rest});
          });
        }
      });
  lists_.faces = parallel_collect<IndexPair>(
      static_cast<std::int64_t>(pairs.size()), kMediumGrain,
      [&](std::int64_t begin, std::int64_t end, std::vector<IndexPair>& out) {
        for (std::int64_t i = begin; i < end; ++i) {
          Box a = box_of_face(X, F_, pairs[i].a), b = box_of_face(X, F_, pairs[i].b);
          a.grow(skin_of_face(pairs[i].a));
          b.grow(skin_of_face(pairs[i].b));
          if (a.overlaps(b)) out.push_back(pairs[i]);
        }
      });
}

void ContactMesh::set_mean_edges(const Eigen::VectorXd& h) {
  OVERTET_EXPECTS(h.size() == lists_.most_h.size() && (h.array() <= lists_.most_h.array()).all());
  h_ = h;
}

std::vector<Contact> ContactMesh::find_contacts(const VertexMatrix& X) {
  OVERTET_EXPECTS(X.allFinite());
  if (!remembered(X)) remember(X);
  ++lists_.uses;
  auto found = parallel_collect<Contact>(
      static_cast<std::int64_t>(lists_.primitives.size()), kMediumGrain,
      [&](std::int64_t begin, std::int64_t end, std::vector<Contact>& out) {
        for (std::int64_t i = begin; i < end; ++i) {
          const Primitive& p = lists_.primitives[i];
          const double h = mean_edge(p.v, p.kind, h_);
          double dhat = rule_.reach * h;
          if (p.near) dhat = std::max(std::min(dhat, rule_.ring_reach * p.rest), rule_.ring_floor * h);
          const Closest closest = closest_points(p.kind, corners(X, p.v));
          if (closest.distance < dhat) out.push_back({p.v, p.kind, closest, dhat, h});
        }
      });
  count(Count::contacts, static_cast<std::int64_t>(found.size()));
  return found;
}

std::vector<IndexPair> ContactMesh::intersections(const VertexMatrix& X) {
  OVERTET_EXPECTS(X.allFinite());
  const std::vector<IndexPair> pairs = candidates([&](Index f) { return box_of_face(X, F_, f); });
  std::vector<IndexPair> found =
      parallel_collect<IndexPair>(static_cast<std::int64_t>(pairs.size()), kMediumGrain,
                                  [&](std::int64_t begin, std::int64_t end, std::vector<IndexPair>& out) {
                                    for (std::int64_t i = begin; i < end; ++i) {
                                      const auto [f, g] = pairs[i];
                                      if (faces_intersect(X.data(), F_.row(f).data(), F_.row(g).data()))
                                        out.push_back({std::min(f, g), std::max(f, g)});
                                    }
                                  });
  std::sort(found.begin(), found.end());
  return found;
}

std::vector<ContactMesh::Hit> ContactMesh::check_step(const VertexMatrix& X, const VertexMatrix& P) {
  OVERTET_EXPECTS(X.allFinite() && P.allFinite());
  OVERTET_EXPECTS([&] {
    for (Eigen::Index v = 0; v < P.rows(); ++v)
      if (!free_[v] && !P.row(v).isZero(0)) return false;
    return true;
  }());
  OVERTET_EXPECTS_COSTLY(intersections(X).empty());
  const VertexMatrix Y = X + P;
  const auto check_primitive = [&](PairKind kind, const std::array<Index, 4>& v, std::vector<Hit>& out) {
    if (!sweeps_overlap(kind, v, X, Y)) return;
    const double safe = safe_step(kind, corners(X, v), corners(P, v));
    if (safe < 1) out.push_back({v, safe});
  };
  const auto check_faces = [&](const IndexPair& p, std::vector<Hit>& out) {
    const auto [f, g] = p;
    if (!box_of_face(Y, F_, f).overlaps(box_of_face(Y, F_, g)) ||
        !faces_intersect(Y.data(), F_.row(f).data(), F_.row(g).data()))
      return;
    // Both faces' corners in two records: every vertex that could help to part them.
    out.push_back({{F_(f, 0), F_(f, 1), F_(f, 2), F_(g, 0)}, 0});
    out.push_back({{F_(g, 0), F_(g, 1), F_(g, 2), F_(f, 0)}, 0});
  };
  // A skin is convex: when both ends of the way lie in it, so does the way.
  if (h_.size() > 0 && remembered(X) && remembered(Y)) {
    std::vector<Hit> hits =
        parallel_collect<Hit>(static_cast<std::int64_t>(lists_.primitives.size()), kMediumGrain,
                              [&](std::int64_t begin, std::int64_t end, std::vector<Hit>& out) {
                                for (std::int64_t i = begin; i < end; ++i)
                                  check_primitive(lists_.primitives[i].kind, lists_.primitives[i].v, out);
                              });
    const std::vector<Hit> more =
        parallel_collect<Hit>(static_cast<std::int64_t>(lists_.faces.size()), kMediumGrain,
                              [&](std::int64_t begin, std::int64_t end, std::vector<Hit>& out) {
                                for (std::int64_t i = begin; i < end; ++i) check_faces(lists_.faces[i], out);
                              });
    hits.insert(hits.end(), more.begin(), more.end());
    return hits;
  }
  const std::vector<IndexPair> pairs = candidates([&](Index f) {
    Box box = box_of_face(X, F_, f);
    box.include(box_of_face(Y, F_, f));
    return box;
  });
  return parallel_collect<Hit>(static_cast<std::int64_t>(pairs.size()), kMediumGrain,
                               [&](std::int64_t begin, std::int64_t end, std::vector<Hit>& out) {
                                 for (std::int64_t i = begin; i < end; ++i) {
                                   primitives(pairs[i], [&](PairKind kind, const std::array<Index, 4>& v) {
                                     check_primitive(kind, v, out);
                                   });
                                   check_faces(pairs[i], out);
                                 }
                               });
}

}  // namespace overtet
