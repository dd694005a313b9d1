#include "src/mesh/polyhedron.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>

#include "kernels/core/assertions.h"
#include "kernels/tet_energy/tet_quality.h"

namespace overtet {

namespace {

using Eigen::Vector3d;

// (a, b, c) sorted; odd: by an odd number of swaps.
bool sort_face(Polyhedron::Face& f) {
  bool odd = false;
  const auto order = [&](int i, int j) {
    if (f[i] > f[j]) {
      std::swap(f[i], f[j]);
      odd = !odd;
    }
  };
  order(0, 1);
  order(1, 2);
  order(0, 1);
  return odd;
}

bool has(const Polyhedron::Face& f, int v) { return f[0] == v || f[1] == v || f[2] == v; }

// The faces of t as seen from inside. The search follows their order and their first corners: not those of
// kTetInnerFace.
std::array<Polyhedron::Face, 4> inner_faces(const Polyhedron::Tet& t) {
  return {{{t[0], t[1], t[2]}, {t[1], t[0], t[3]}, {t[2], t[1], t[3]}, {t[0], t[2], t[3]}}};
}

double det(const Vector3d& a, const Vector3d& b, const Vector3d& c, const Vector3d& d) {
  return (b - a).cross(c - a).dot(d - a);
}

// The line through p and q goes through the inside of the triangle.
bool line_pierces(const Vector3d& p, const Vector3d& q, const Vector3d& a, const Vector3d& b,
                  const Vector3d& c) {
  const double u = det(p, q, a, b), v = det(p, q, b, c);
  if (!((u > 0 && v > 0) || (u < 0 && v < 0))) return false;
  const double w = det(p, q, c, a);
  return (u > 0 && w > 0) || (u < 0 && w < 0);
}

// n choose k, for numbers of points.
template <int k>
int choose(int n) {
  static constexpr auto all = [] {
    std::array<int, kMostPoints> table{};
    for (int i = k; i < kMostPoints; ++i) {
      table[i] = 1;
      for (int j = 0; j < k; ++j) table[i] = table[i] * (i - j) / (j + 1);
    }
    return table;
  }();
  return all[n];
}

}  // namespace

void Polyhedron::clear() {
  count_ = 0;
  barred_.fill(0);
  faces_.clear();
  open_.clear();
  tets_.clear();
  state_.fill(State::unused);
}

int Polyhedron::add_point(const Vector3d& p) {
  point_[count_] = p;
  return count_++;
}

int Polyhedron::triple(int i, int j, int k) {
  Face f{i, j, k};
  sort_face(f);
  return choose<3>(f[2]) + choose<2>(f[1]) + f[0];
}

void Polyhedron::add_face(const Face& face) {
  faces_.push_back(face);
  Face f = face;
  const bool odd = sort_face(f);
  open(face, triple(f[0], f[1], f[2]), odd);
}

void Polyhedron::open(const Face& face, int at, bool odd) {
  state_[at] = odd ? State::open_odd : State::open_even;
  place_[at] = static_cast<std::int16_t>(open_.size());
  open_.push_back({face, at});
}

void Polyhedron::close(int at) {
  const int place = place_[at];
  open_[place] = open_.back();
  place_[open_[place].triple] = static_cast<std::int16_t>(place);
  open_.pop_back();
}

void Polyhedron::bar_edge(int i, int j) {
  OVERTET_EXPECTS(0 <= i && i < count_ && 0 <= j && j < count_);
  barred_[i] |= 1u << j, barred_[j] |= 1u << i;
}

void Polyhedron::bar_face(int i, int j, int k) {
  OVERTET_EXPECTS(0 <= i && i < count_ && 0 <= j && j < count_ && 0 <= k && k < count_);
  State& s = state_[triple(i, j, k)];
  if (s == State::unused) s = State::barred;
}

double Polyhedron::quality(const Face& face, int v) {
  int i[4] = {face[0], face[1], face[2], v};
  bool odd = false;
  for (int a = 0; a < 3; ++a)
    for (int b = 0; b < 3 - a; ++b)
      if (i[b] > i[b + 1]) {
        std::swap(i[b], i[b + 1]);
        odd = !odd;
      }
  const int at = choose<4>(i[3]) + choose<3>(i[2]) + choose<2>(i[1]) + i[0];
  double& q = quality_[odd][at];
  if (q < 0) {
    q = min_dihedral_sine(point_[face[0]], point_[face[1]], point_[face[2]], point_[v]);
    if (q > 0) quality_[!odd][at] = 0;
  }
  return q;
}

const std::vector<double>& Polyhedron::sides_of(int p) {
  std::vector<double>& sides = sides_[p];
  if (sides.empty())
    for (std::size_t i = 0; i < faces_.size(); ++i)
      sides.push_back(normals_[i].dot(point_[p] - point_[faces_[i][0]]));
  return sides;
}

// Rounded, as face_leaves(): this only makes the search shorter.
bool Polyhedron::edge_leaves(int p, int q) {
  std::int8_t& known = edge_leaves_[std::min(p, q)][std::max(p, q)];
  if (known >= 0) return known != 0;
  const std::vector<double>&sides_p = sides_of(p), &sides_q = sides_of(q);
  known = 0;
  for (std::size_t i = 0; i < faces_.size() && known == 0; ++i) {
    if (!(sides_p[i] * sides_q[i] < 0)) continue;
    const Face& g = faces_[i];
    if (has(g, p) || has(g, q)) continue;
    known = line_pierces(point_[p], point_[q], point_[g[0]], point_[g[1]], point_[g[2]]);
  }
  return known != 0;
}

bool Polyhedron::face_leaves(const Face& f) {
  const Vector3d &a = point_[f[0]], &b = point_[f[1]], &c = point_[f[2]], normal = (b - a).cross(c - a);
  std::array<double, kMostPoints> sides;
  std::uint32_t above = 0, below = 0;
  for (int v = 0; v < count_; ++v) {
    sides[v] = normal.dot(point_[v] - a);
    above |= static_cast<std::uint32_t>(sides[v] > 0) << v;
    below |= static_cast<std::uint32_t>(sides[v] < 0) << v;
  }
  const std::uint32_t others = ~(1u << f[0] | 1u << f[1] | 1u << f[2]);
  for (std::uint32_t from = above & others; from != 0; from &= from - 1) {
    const int p = std::countr_zero(from);
    for (std::uint32_t to = edges_[p] & below & others; to != 0; to &= to - 1) {
      const int q = std::countr_zero(to);
      if (sides[p] * sides[q] < 0 && line_pierces(point_[std::min(p, q)], point_[std::max(p, q)], a, b, c))
        return true;
    }
  }
  return false;
}

bool Polyhedron::leaves(const Face& f) {
  std::int8_t& known = leaves_[triple(f[0], f[1], f[2])];
  if (known < 0)
    known = edge_leaves(f[0], f[1]) || edge_leaves(f[1], f[2]) || edge_leaves(f[2], f[0]) || face_leaves(f);
  return known != 0;
}

std::uint32_t Polyhedron::choices(const Face& f, int at, bool odd) {
  Choices& c = choices_[odd][at];
  if (c.age == age_) return c.mask;
  const bool first = c.age == 0;  // later there can only be fewer
  const std::uint32_t own = 1u << f[0] | 1u << f[1] | 1u << f[2];
  std::uint32_t left =
      first ? ((1u << count_) - 1) & ~(own | barred_[f[0]] | barred_[f[1]] | barred_[f[2]]) : c.mask;
  c = {0, age_};
  for (; left != 0; left &= left - 1) {
    const int v = std::countr_zero(left);
    if (!(quality(f, v) > bound_)) continue;
    if (first && (leaves({f[0], f[1], v}) || leaves({f[1], f[2], v}) || leaves({f[2], f[0], v}))) continue;
    c.mask |= 1u << v;
  }
  return c.mask;
}

bool Polyhedron::push(const Tet& t) {
  const std::array<Face, 4> inner = inner_faces(t);
  int at[4];
  bool odd[4], closes[4];
  for (int k = 0; k < 4; ++k) {
    Face f = inner[k];
    odd[k] = sort_face(f);
    at[k] = triple(f[0], f[1], f[2]);
    const State s = state_[at[k]];
    closes[k] = s == (odd[k] ? State::open_odd : State::open_even);
    if (!closes[k] && s != State::unused) return false;
  }
  for (int k = 0; k < 4; ++k) {
    if (closes[k]) {
      state_[at[k]] = State::closed;
      close(at[k]);
    } else {
      open({inner[k][1], inner[k][0], inner[k][2]}, at[k], !odd[k]);
    }
  }
  tets_.push_back(t);
  return true;
}

void Polyhedron::pop() {
  const Tet t = tets_.back();
  tets_.pop_back();
  for (const Face& face : inner_faces(t)) {
    Face f = face;
    const bool odd = sort_face(f);
    const int at = triple(f[0], f[1], f[2]);
    if (state_[at] == State::closed) {
      open(face, at, odd);
    } else {
      state_[at] = State::unused;
      close(at);
    }
  }
}

void Polyhedron::search(double worst) {
  if (open_.empty()) {
    bound_ = worst;
    best_tets_ = tets_;
    ++age_;
    return;
  }
  if (--steps_left_ <= 0) return;
  int fewest = kMostPoints + 1;
  std::uint32_t mask = 0;
  Face face{};
  for (const Open& o : open_) {
    const std::uint32_t here = choices(o.face, o.triple, state_[o.triple] == State::open_odd);
    const int n = std::popcount(here);
    if (n >= fewest) continue;
    fewest = n;
    mask = here;
    face = o.face;
    if (n == 0) return;
  }
  std::array<std::pair<double, int>, kMostPoints> order;
  int n = 0;
  for (; mask != 0; mask &= mask - 1) {
    const int v = std::countr_zero(mask);
    order[n++] = {-quality(face, v), v};
  }
  std::sort(order.begin(), order.begin() + n);
  for (int i = 0; i < n && steps_left_ > 0; ++i) {
    const double q = -order[i].first;
    if (!(std::min(q, worst) > bound_)) return;
    if (!push({face[0], face[1], face[2], order[i].second})) continue;
    search(std::min(q, worst));
    pop();
  }
}

double Polyhedron::fill(double must, std::int64_t most_steps, std::vector<Tet>& tets) {
  const int triples = count_ * (count_ - 1) * (count_ - 2) / 6;
  for (auto& q : quality_) q.assign(static_cast<std::size_t>(triples * (count_ - 3) / 4), -1);
  std::fill(leaves_.begin(), leaves_.begin() + triples, std::int8_t{-1});
  for (int i = 0; i < count_; ++i) edge_leaves_[i].fill(-1);
  for (auto& c : choices_) std::fill(c.begin(), c.begin() + triples, Choices{0, 0});
  edges_.fill(0);
  normals_.clear();
  for (auto& sides : sides_) sides.clear();
  for (const Face& f : faces_) {
    normals_.push_back((point_[f[1]] - point_[f[0]]).cross(point_[f[2]] - point_[f[0]]));
    for (int k = 0; k < 3; ++k) edges_[f[k]] |= 1u << f[(k + 1) % 3] | 1u << f[(k + 2) % 3];
  }
  age_ = 1;
  bound_ = must;
  steps_left_ = most_steps;
  best_tets_.clear();
  search(1);
  tets = best_tets_;
  return tets.empty() ? 0 : bound_;
}

}  // namespace overtet
