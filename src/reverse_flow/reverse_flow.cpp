#include "src/reverse_flow/reverse_flow.h"

#include <Eigen/Dense>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "kernels/arap/arap.h"
#include "kernels/bvh/self_intersections.h"
#include "kernels/contact/contact.h"
#include "kernels/core/assertions.h"
#include "kernels/core/indices.h"
#include "kernels/core/tuning.h"
#include "kernels/laplacian/laplacian.h"
#include "kernels/laplacian/tuning.h"
#include "kernels/parallel/parallel.h"
#include "kernels/sparse/cholesky.h"
#include "src/reverse_flow/tuning.h"

namespace overtet {

namespace {

// Mean length of the edges at each vertex, and not less than a small part of the overall mean: collapsed
// rest states must not switch the barrier off.
Eigen::VectorXd mean_edges(const VertexMatrix& W, const TriangleMatrix& F) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(W.rows()), count = Eigen::VectorXd::Zero(W.rows());
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) {
      const Index a = F(f, k), b = F(f, (k + 1) % 3);
      const double l = (W.row(a) - W.row(b)).norm();
      sum[a] += l, sum[b] += l;
      count[a] += 1, count[b] += 1;
    }
  }
  const double mean = sum.sum() / std::max(1.0, count.sum());
  return (sum.array() / count.array().max(1.0)).max(kSmallestShare * mean).matrix();
}

// The mesh of all faces with a free vertex, with numbers of its own: linear algebra sees only that.
struct Local {
  std::vector<Index> global;      // local vertex -> vertex
  std::vector<Index> local;       // vertex -> local vertex, -1
  std::vector<Index> unknown;     // local vertex -> row of the system, -1: frozen
  std::vector<Index> row_vertex;  // row -> vertex
  TriangleMatrix F;

  Local(const TriangleMatrix& faces, const std::vector<char>& free) {
    local.assign(free.size(), -1);
    std::vector<Eigen::Index> used;
    for (Eigen::Index f = 0; f < faces.rows(); ++f)
      if (free[faces(f, 0)] || free[faces(f, 1)] || free[faces(f, 2)]) used.push_back(f);
    for (Eigen::Index f : used)
      for (int k = 0; k < 3; ++k) local[faces(f, k)] = 0;
    for (std::size_t v = 0; v < free.size(); ++v) {
      if (local[v] < 0) continue;
      local[v] = static_cast<Index>(global.size());
      global.push_back(static_cast<Index>(v));
      unknown.push_back(free[v] ? static_cast<Index>(row_vertex.size()) : -1);
      if (free[v]) row_vertex.push_back(static_cast<Index>(v));
    }
    F.resize(static_cast<Eigen::Index>(used.size()), 3);
    for (std::size_t i = 0; i < used.size(); ++i)
      for (int k = 0; k < 3; ++k) F(i, k) = local[faces(used[i], k)];
  }

  VertexMatrix gather(const VertexMatrix& X) const {
    VertexMatrix x(static_cast<Eigen::Index>(global.size()), 3);
    for (std::size_t i = 0; i < global.size(); ++i) x.row(i) = X.row(global[i]);
    return x;
  }
};

// Q = base + contacts, on a pattern that only grows while the contacts stay about the same, so that most
// iterations need no new symbolic analysis.
class System {
 public:
  explicit System(SymmetricMatrix base) : base_(std::move(base)) {}

  struct Entry {
    std::int64_t key;  // column * rows + row, row > column
    double value;
  };

  // entries: off-diagonal, any order, equal keys are summed in the order given.
  bool factor(std::vector<Entry>& entries, const Eigen::VectorXd& diagonal) {
    std::stable_sort(entries.begin(), entries.end(),
                     [](const Entry& a, const Entry& b) { return a.key < b.key; });
    std::vector<std::int64_t> keys;
    for (const Entry& e : entries)
      if (keys.empty() || keys.back() != e.key) keys.push_back(e.key);
    if (!analyzed_ || !std::ranges::includes(extra_, keys) || extra_.size() > 2 * keys.size() + 1000) {
      extra_ = std::move(keys);
      build_pattern();
      if (!factor_.analyze(Q_)) return false;
      analyzed_ = true;
    }
    std::fill(Q_.valuePtr(), Q_.valuePtr() + Q_.nonZeros(), 0.0);
    for (Eigen::Index i = 0; i < base_.nonZeros(); ++i) Q_.valuePtr()[base_slot_[i]] = base_.valuePtr()[i];
    for (Eigen::Index i = 0; i < diagonal.size(); ++i) Q_.valuePtr()[Q_.outerIndexPtr()[i]] += diagonal[i];
    std::size_t at = 0;
    for (const Entry& e : entries) {
      while (extra_[at] != e.key) ++at;
      Q_.valuePtr()[extra_slot_[at]] += e.value;
    }
    return factor_.factor(Q_);
  }

  bool solve(const VertexMatrix& b, VertexMatrix& x) const { return factor_.solve(b, x); }
  const SymmetricMatrix& base() const { return base_; }

 private:
  void build_pattern() {
    const Index n = static_cast<Index>(base_.rows());
    Q_ = SymmetricMatrix(n, n);
    Q_.resizeNonZeros(base_.nonZeros() + static_cast<Eigen::Index>(extra_.size()));
    base_slot_.resize(base_.nonZeros());
    extra_slot_.resize(extra_.size());
    int at = 0;
    std::size_t next = 0;
    for (Index c = 0; c < n; ++c) {
      Q_.outerIndexPtr()[c] = at;
      int b = base_.outerIndexPtr()[c];
      const int b_end = base_.outerIndexPtr()[c + 1];
      while (b < b_end || (next < extra_.size() && extra_[next] / n == c)) {
        const std::int64_t none = n;
        const std::int64_t from_base = b < b_end ? base_.innerIndexPtr()[b] : none;
        const std::int64_t from_extra =
            next < extra_.size() && extra_[next] / n == c ? extra_[next] % n : none;
        const std::int64_t row = std::min(from_base, from_extra);
        if (from_base == row) base_slot_[b++] = at;
        if (from_extra == row) extra_slot_[next++] = at;
        Q_.innerIndexPtr()[at++] = static_cast<int>(row);
      }
    }
    Q_.outerIndexPtr()[n] = at;
    Q_.resizeNonZeros(at);
  }

  SymmetricMatrix base_, Q_;
  std::vector<std::int64_t> extra_;
  std::vector<int> base_slot_, extra_slot_;
  SparseCholesky factor_;
  bool analyzed_ = false;
};

// The rows of L that belong to unknowns, as a matrix of the unknowns.
SymmetricMatrix restrict_to_unknowns(const SymmetricMatrix& L, const Local& local) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int c = 0; c < L.outerSize(); ++c)
    for (SymmetricMatrix::InnerIterator it(L, c); it; ++it) {
      const Index a = local.unknown[it.row()], b = local.unknown[c];
      if (a >= 0 && b >= 0) entries.emplace_back(std::max(a, b), std::min(a, b), it.value());
    }
  const Index n = static_cast<Index>(local.row_vertex.size());
  SymmetricMatrix R(n, n);
  R.setFromTriplets(entries.begin(), entries.end());
  R.makeCompressed();
  return R;
}

class Reverse {
 public:
  Reverse(const Surface& s, const std::vector<char>& free, const ReverseFlowOptions& options,
          const RunContext& context, ReverseFlowResult& result)
      : s_(s), free_(free), o_(options), context_(context), result_(result), local_(s.F, free) {
    area_ = surface_area(s.V, s.F);
    began_ = std::chrono::steady_clock::now();
  }

  // One rest shape. False: out of time or locked, U is what there is.
  Result<bool> stage(const VertexMatrix& W, int iterations, int number, int stages, VertexMatrix& U) {
    const Eigen::VectorXd mass_all = lumped_mass(W, s_.F);
    const double total = mass_all.sum();
    if (!(total > 0)) return true;  // a collapsed state has no shape to go back to
    Rest rest(*this, W, U);
    const Index n = static_cast<Index>(local_.row_vertex.size());
    rest.mass.resize(n);
    for (Index i = 0; i < n; ++i)
      rest.mass[i] =
          std::max(mass_all[local_.row_vertex[i]] / total, kAreaFloor / s_.V.rows()) / (o_.eps * o_.eps);

    VertexMatrix before = U;  // the state before U, for inertia
    VertexMatrix force = VertexMatrix::Zero(n, 3);
    int standstill = 0, struggling = 0;
    for (int iteration = 1; iteration <= iterations; ++iteration) {
      if (const auto stop = context_.stop()) return *stop;
      if (result_.work > o_.max_work || seconds() > o_.max_seconds) {
        result_.termination = result_.work > o_.max_work ? ReverseFlowResult::Termination::work
                                                         : ReverseFlowResult::Termination::time;
        return false;
      }
      ReverseFlowStep record;
      record.stage = number;
      record.iteration = iteration;
      VertexMatrix P;
      if (!find_step(rest, U, before, force, P, record)) return true;
      if (const auto stop = context_.stop()) return *stop;  // the line search may have ended early
      take_step(P, rest.h, U, before, record);
      context_.report("reverse_flow", (number + static_cast<double>(iteration) / iterations) / stages,
                      std::to_string(record.contacts) + " contacts");
      struggling = record.halvings >= o_.lock_halvings ? struggling + 1 : 0;
      if (struggling >= o_.lock_iterations) {
        result_.termination = ReverseFlowResult::Termination::locked;
        return false;
      }
      standstill = record.move > 0 ? 0 : standstill + 1;
      // Pins may be put back for ever: in a stage on the way what moves decides.
      if (standstill >= kInVain || (record.move < o_.still && record.halvings == 0) ||
          (number + 1 < stages && record.move < o_.stage_still))
        break;
    }
    return true;
  }

 private:
  // What belongs to one rest shape W.
  struct Rest {
    Eigen::VectorXd h;  // mean edges
    ContactMesh mesh;
    Arap arap;
    System system;
    System pinned;          // the same with vertices held
    bool factored = false;  // nothing changes in it but by contacts
    Eigen::VectorXd mass;   // by row, relative to the area, over the squared time step

    Rest(const Reverse& flow, const VertexMatrix& W, const VertexMatrix& U)
        : h(mean_edges(W, flow.s_.F)),
          mesh(U, flow.s_.F, flow.free_, W, h, flow.contact_rule()),
          arap(flow.local_.gather(W), flow.local_.F),
          system(restrict_to_unknowns(arap.matrix(), flow.local_)),
          pinned(system.base()) {}
  };

  // Of one step: (system's base + diagonal + entries) step = gradient.
  struct Equations {
    VertexMatrix gradient;
    Eigen::VectorXd diagonal;
    std::vector<System::Entry> entries;
  };

  ContactRule contact_rule() const {
    ContactRule rule;
    rule.reach = o_.reach;
    rule.ring_reach = o_.ring_reach;
    rule.ring_floor = o_.ring_floor;
    return rule;
  }

  Equations equations(Rest& rest, const VertexMatrix& U, const VertexMatrix& before,
                      const VertexMatrix& force, ReverseFlowStep& record) const {
    const Index n = static_cast<Index>(local_.row_vertex.size());
    rest.mesh.set_mean_edges((o_.growth * mean_edges(U, s_.F)).cwiseMin(rest.h));
    const VertexMatrix u = local_.gather(U);
    rest.arap.fit_rotations(u);
    VertexMatrix gradient;
    rest.arap.gradient(u, gradient);
    record.energy = rest.arap.energy(u) / area_;
    Equations e{VertexMatrix(n, 3), rest.mass, {}};
    for (std::size_t i = 0; i < local_.global.size(); ++i)
      if (const Index r = local_.unknown[i]; r >= 0) e.gradient.row(r) = gradient.row(i);
    if (o_.inertia)
      for (Index r = 0; r < n; ++r)
        e.gradient.row(r) -= rest.mass[r] * (U.row(local_.row_vertex[r]) - before.row(local_.row_vertex[r]));
    e.gradient -= force;
    if (o_.response == ReverseFlowOptions::ContactResponse::barrier)
      record.contacts = add_contacts(rest.mesh.find_contacts(U), e);
    return e;
  }

  // The step P from U, as far as it is safe. before: the state before U; force: what pushes faces apart, in
  // this step and then in the next one. False: the stage ends early.
  bool find_step(Rest& rest, const VertexMatrix& U, const VertexMatrix& before, VertexMatrix& force,
                 VertexMatrix& P, ReverseFlowStep& record) const {
    Equations e = equations(rest, U, before, force, record);
    VertexMatrix step;
    bool solved = false;
    for (int tries = 0; tries <= kInVain && !solved; ++tries) {
      if (tries > 0) e.diagonal += std::pow(kMoreMass, tries) * rest.mass;
      const bool known = rest.factored && tries == 0;
      solved = (known || rest.system.factor(e.entries, e.diagonal)) && rest.system.solve(e.gradient, step) &&
               step.allFinite();
      rest.factored = solved && tries == 0 && o_.response == ReverseFlowOptions::ContactResponse::pins;
    }
    if (!solved) {
      // The rest shape is too degenerate for its Laplacian: what there is stays valid.
      context_.note(LogLevel::warning,
                    "The reverse flow ended early because a linear system could not be solved.");
      return false;
    }
    P = VertexMatrix::Zero(U.rows(), 3);
    for (Index r = 0; r < step.rows(); ++r) P.row(local_.row_vertex[r]) = -step.row(r);
    force.setZero();
    if (o_.response != ReverseFlowOptions::ContactResponse::barrier) return pin(rest, e, U, P, force, record);
    search_line(rest.mesh, U, P, record);
    return true;
  }

  void take_step(const VertexMatrix& P, const Eigen::VectorXd& h, VertexMatrix& U, VertexMatrix& before,
                 ReverseFlowStep& record) {
    VertexMatrix next = U + P;
    for (Index v : local_.row_vertex) record.move = std::max(record.move, P.row(v).norm() / h[v]);
    record.seconds = seconds();
    before = std::move(U);
    U = std::move(next);
    if (o_.on_state) o_.on_state(U);
    result_.steps.push_back(record);
    result_.rollbacks += record.held;
    result_.work += static_cast<double>(local_.F.rows() + record.contacts) * (1 + record.halvings);
    ++result_.iterations;
  }

  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }

  Index row_of(Index v) const { return local_.local[v] < 0 ? -1 : local_.unknown[local_.local[v]]; }

  Index add_contacts(const std::vector<Contact>& contacts, Equations& e) const {
    const std::int64_t n = e.gradient.rows();
    e.entries.reserve(6 * contacts.size());
    for (const Contact& c : contacts) {
      if (!(c.closest.distance > 0)) continue;
      const double x = std::max(c.closest.distance / c.dhat, kSmallestShare);
      const double slope = o_.kappa * c.h * c.h / c.dhat * barrier_slope(x);
      const double stiffness = o_.kappa * c.h * c.h / (c.dhat * c.dhat) * barrier_curvature(x);
      const Eigen::RowVector3d direction = c.closest.difference.transpose() / c.closest.distance;
      Index row[4];
      for (int i = 0; i < 4; ++i) row[i] = row_of(c.v[i]);
      for (int i = 0; i < 4; ++i) {
        if (row[i] < 0 || c.closest.w[i] == 0) continue;
        e.gradient.row(row[i]) += slope * c.closest.w[i] * direction;
        e.diagonal[row[i]] += stiffness * c.closest.w[i] * c.closest.w[i];
        for (int j = 0; j < i; ++j) {
          if (row[j] < 0 || c.closest.w[j] == 0) continue;
          const std::int64_t a = std::max(row[i], row[j]), b = std::min(row[i], row[j]);
          e.entries.push_back({b * n + a, stiffness * c.closest.w[i] * c.closest.w[j]});
        }
      }
    }
    return static_cast<Index>(contacts.size());
  }

  // Scales P down until the step is safe.
  void search_line(ContactMesh& mesh, const VertexMatrix& U, VertexMatrix& P, ReverseFlowStep& record) const {
    for (int round = 0;; ++round) {
      const std::vector<ContactMesh::Hit> hits = mesh.check_step(U, P);
      if (hits.empty()) return;
      if (context_.stop()) {
        P.setZero();  // the caller's loop says why
        return;
      }
      // By vertex, how much of its step is certain to be safe: the least of its pairs.
      std::vector<std::pair<Index, double>> offenders;
      for (const auto& hit : hits)
        for (Index v : hit.v) offenders.emplace_back(v, hit.safe);
      std::sort(offenders.begin(), offenders.end());
      offenders.erase(std::unique(offenders.begin(), offenders.end(),
                                  [](const auto& x, const auto& y) { return x.first == y.first; }),
                      offenders.end());
      ++record.halvings;
      if (round < o_.ramp_halvings) {
        ramp(mesh, offenders, P);
      } else if (round < o_.ramp_halvings + o_.global_halvings) {
        P *= 0.5;
      } else {
        for (const auto& [v, safe] : offenders) {
          if (!free_[v] || P.row(v).isZero(0)) continue;
          P.row(v).setZero();
          ++record.held;
        }
        // Faces that hit each other only because of a neighbour that still moves: in the end nothing does.
        if (round > o_.ramp_halvings + o_.global_halvings + 20) P.setZero();
      }
    }
  }

  // Scales P down at the offenders, less and less over the rings around them.
  void ramp(const ContactMesh& mesh, const std::vector<std::pair<Index, double>>& offenders,
            VertexMatrix& P) const {
    std::vector<Index> layer, next;
    std::vector<int> reached(free_.size(), -1);           // in which ring
    std::vector<double> source(free_.size(), kMostRamp);  // the smallest factor of the offenders it came from
    for (const auto& [v, safe] : offenders) {
      layer.push_back(v);
      reached[v] = 0;
      source[v] = std::clamp(0.8 * safe, kLeastRamp, kMostRamp);
    }
    for (int ring = 0; ring <= o_.ramp_rings && !layer.empty(); ++ring) {
      next.clear();
      const double fade = 1 - static_cast<double>(ring) / (o_.ramp_rings + 1);
      for (Index v : layer) {
        P.row(v) *= 1 - (1 - source[v]) * fade;
        for (Index w : mesh.ring(v)) {
          if (reached[w] < 0) {
            reached[w] = ring + 1;
            next.push_back(w);
          }
          if (reached[w] == ring + 1) source[w] = std::min(source[w], source[v]);
        }
      }
      std::swap(layer, next);
    }
  }

  // The paper's response: vertices of faces that would meet are put back and held, and the step is solved
  // again, until nothing meets; the same vertices are pushed apart in the next step. Each round holds more of
  // them, and faces that are held do not meet, so there is an end.
  bool pin(Rest& rest, Equations& e, const VertexMatrix& U, VertexMatrix& P, VertexMatrix& force,
           ReverseFlowStep& record) const {
    const Index n = static_cast<Index>(e.gradient.rows());
    std::vector<char> pinned(n, 0);
    // Stiff enough to hold a vertex to rounding; its step is then set to zero exactly.
    const double stiff = 1e10 * rest.system.base().diagonal().cwiseAbs().maxCoeff();
    for (;;) {
      const std::vector<IndexPair> hits = rest.mesh.intersections(U + P);
      if (hits.empty()) return true;
      ++record.halvings;
      Index fresh = 0;
      for (const IndexPair& hit : hits) {
        if (o_.repulsion > 0) push_apart(hit, U, rest, force);
        for (const Index f : {hit.a, hit.b})
          for (int k = 0; k < 3; ++k)
            if (const Index r = row_of(s_.F(f, k)); r >= 0 && !std::exchange(pinned[r], 1)) ++fresh;
      }
      record.held += fresh;
      if (fresh == 0 || context_.stop()) {
        P.setZero();
        return true;
      }
      Eigen::VectorXd held = e.diagonal;
      VertexMatrix b = e.gradient, step;
      for (Index r = 0; r < n; ++r)
        if (pinned[r]) held[r] += stiff, b.row(r).setZero();
      if (!rest.pinned.factor(e.entries, held) || !rest.pinned.solve(b, step) || !step.allFinite())
        return false;
      for (Index r = 0; r < n; ++r) {
        if (pinned[r])
          P.row(local_.row_vertex[r]).setZero();
        else
          P.row(local_.row_vertex[r]) = -step.row(r);
      }
    }
  }

  // Weighted by mass and capped: with the stiffness on the diagonal instead it explodes (measured).
  void push_apart(const IndexPair& hit, const VertexMatrix& U, const Rest& rest, VertexMatrix& force) const {
    const auto barycentre = [&](Index f) -> Eigen::RowVector3d {
      return (U.row(s_.F(f, 0)) + U.row(s_.F(f, 1)) + U.row(s_.F(f, 2))) / 3;
    };
    const Eigen::RowVector3d away = o_.repulsion * (barycentre(hit.a) - barycentre(hit.b));
    for (const Index f : {hit.a, hit.b})
      for (int k = 0; k < 3; ++k) {
        const Index v = s_.F(f, k), r = row_of(v);
        if (r < 0) continue;
        Eigen::RowVector3d push = f == hit.a ? away : Eigen::RowVector3d(-away);
        const double cap = o_.repulsion_cap * rest.h[v], length = push.norm();
        if (length > cap) push *= cap / length;
        force.row(r) += rest.mass[r] * push;
      }
  }

  const Surface& s_;
  const std::vector<char>& free_;
  const ReverseFlowOptions& o_;
  const RunContext& context_;
  ReverseFlowResult& result_;
  Local local_;
  double area_ = 1;
  std::chrono::steady_clock::time_point began_;
};

double percentile(std::vector<double>& values, double p) {
  if (values.empty()) return 1;
  const std::size_t k = std::min(values.size() - 1, static_cast<std::size_t>(p * (values.size() - 1) + 0.5));
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[k];
}

// The rigid motion of U that fits V best, as new positions.
VertexMatrix rigidly_aligned(const VertexMatrix& U, const VertexMatrix& V, const Eigen::VectorXd& mass) {
  const double total = mass.sum();
  const Eigen::RowVector3d cu = (mass.transpose() * U) / total, cv = (mass.transpose() * V) / total;
  const Eigen::Matrix3d S = (U.rowwise() - cu).transpose() * mass.asDiagonal() * (V.rowwise() - cv);
  return ((U.rowwise() - cu) * best_rotation(S).transpose()).rowwise() + cv;
}

// Moves U rigidly to where it fits W best. Rounding moves every vertex on its own, so that is a new state, to
// be tested like any other; false: it would intersect itself, and nothing changes.
bool align(const TriangleMatrix& F, const VertexMatrix& W, VertexMatrix& U) {
  VertexMatrix moved = rigidly_aligned(U, W, lumped_mass(W, F));
  const std::vector<char> free(static_cast<std::size_t>(U.rows()), 1);
  if (!moved.allFinite() || !ContactMesh(moved, F, free).intersections(moved).empty()) return false;
  U = std::move(moved);
  return true;
}

}  // namespace

FlowQuality measure_quality(const VertexMatrix& U, const VertexMatrix& V0, const TriangleMatrix& F) {
  std::vector<double> area, edge;
  double within = 0;
  for (Eigen::Index f = 0; f < F.rows(); ++f) {
    const auto double_area = [&](const VertexMatrix& X) {
      const Eigen::RowVector3d a = X.row(F(f, 0));
      return (X.row(F(f, 1)) - a).cross(X.row(F(f, 2)) - a).norm();
    };
    const double rest = double_area(V0);
    if (rest > 0) {
      area.push_back(double_area(U) / rest);
      within += area.back() >= 0.8 && area.back() <= 1.2;
    }
    for (int k = 0; k < 3; ++k) {
      const Index a = F(f, k), b = F(f, (k + 1) % 3);
      if (a > b) continue;
      const double length = (V0.row(a) - V0.row(b)).norm();
      if (length > 0) edge.push_back((U.row(a) - U.row(b)).norm() / length);
    }
  }
  FlowQuality q;
  q.area_within_20 = area.empty() ? 1 : within / static_cast<double>(area.size());
  q.area_p01 = percentile(area, 0.01), q.area_p50 = percentile(area, 0.5),
  q.area_p99 = percentile(area, 0.99);
  q.edge_p01 = percentile(edge, 0.01), q.edge_p50 = percentile(edge, 0.5),
  q.edge_p99 = percentile(edge, 0.99);
  return q;
}

Status ReverseFlowOptions::validate() const {
  const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
  const auto bad = [](const std::string& what) { return Error{ErrorCode::usage, "Reverse flow: " + what}; };
  if (stage_iterations < 0 || final_iterations < 0 || max_stages < 0 || lock_iterations < 1)
    return bad("iteration counts must not be negative.");
  if (!positive(eps) || !positive(kappa) || !positive(reach) || !positive(growth) || !positive(ring_reach) ||
      !positive(ring_floor))
    return bad("eps, kappa and the reaches must be positive.");
  if (!(repulsion >= 0) || !(repulsion_cap >= 0) || !std::isfinite(repulsion))
    return bad("repulsion must not be negative.");
  if (ramp_rings < 0 || ramp_halvings < 0 || global_halvings < 0)
    return bad("halvings must not be negative.");
  if (!(still >= 0) || !(max_seconds > 0) || !(max_work > 0))
    return bad("still, max_work and max_seconds must be positive.");
  return success();
}

ReverseFlowOptions paper_reverse_flow() {
  ReverseFlowOptions o;
  o.response = ReverseFlowOptions::ContactResponse::pins;
  o.staged = true;
  o.inertia = true;
  o.repulsion = 1000;
  o.align_stages = true;
  o.stage_still = 0.05;
  o.max_stages = 1 << 30;                            // all
  o.lock_iterations = o.locked_rollbacks = 1 << 30;  // it goes on to the end
  return o;
}

std::vector<ReverseFlowOptions> reverse_flow_ladder() {
  ReverseFlowOptions direct, staged, patient;
  staged.staged = true;
  patient.staged = true;
  patient.max_stages = 80;
  return {direct, staged, direct, patient};
}

Result<ReverseFlowResult> reverse_flow(const Surface& surface, const VertexMatrix& start,
                                       std::span<const VertexMatrix> stages, const std::vector<char>& free,
                                       const ReverseFlowOptions& options, const RunContext& context) {
  if (const Status valid = options.validate(); !valid) return valid.error();
  const auto bad = [](const std::string& what) {
    return Error{ErrorCode::bad_input, "Reverse flow: " + what};
  };
  const std::size_t n = static_cast<std::size_t>(surface.V.rows());
  if (start.rows() != surface.V.rows() || free.size() != n)
    return bad("the start has another number of vertices.");
  if (!all_below(surface.F, surface.V.rows())) return bad("a face names a vertex that does not exist.");
  if (!start.allFinite() || !surface.V.allFinite()) return bad("a coordinate is not finite.");
  for (const VertexMatrix& W : stages)
    if (W.rows() != surface.V.rows() || !W.allFinite()) return bad("a stored state is broken.");
  const ScopedThreads threads(context.threads);
  const auto left = find_self_intersections(start, surface.F);
  if (!left.empty())
    return bad("the start has " + std::to_string(left.size()) + " intersecting pairs of faces.");
  ReverseFlowResult result;
  result.U0 = start;
  for (std::size_t v = 0; v < n; ++v)
    if (!free[v] && start.row(v) != surface.V.row(v))
      return bad("a vertex that is not free is not at its rest position.");
  const Index count =
      static_cast<Index>(std::count_if(free.begin(), free.end(), [](char f) { return f != 0; }));
  if (count == 0 || start == surface.V) {
    result.termination = ReverseFlowResult::Termination::nothing_to_do;
    return result;
  }
  const bool all_free = count == static_cast<Index>(n);
  Reverse reverse(surface, free, options, context, result);
  const int stored = options.staged ? static_cast<int>(stages.size()) : 0;
  const int used = std::min(stored, options.max_stages), total = used + 1;
  for (int i = 0; i < total; ++i) {
    const bool last = i + 1 == total;
    // Backwards; evenly spaced, the one next to t* among them.
    const std::size_t at =
        last ? 0 : static_cast<std::size_t>(stored - 1 - static_cast<long>(i) * stored / used);
    const VertexMatrix& W = last ? surface.V : stages[at];
    const auto done =
        reverse.stage(W, last ? options.final_iterations : options.stage_iterations, i, total, result.U0);
    if (!done) return done.error();
    if (!done.value()) break;
    if (options.align_stages && all_free && !last) align(surface.F, W, result.U0);
  }
  if (options.align && all_free) result.aligned = align(surface.F, surface.V, result.U0);
  result.quality = measure_quality(result.U0, surface.V, surface.F);
  result.locked = result.termination == ReverseFlowResult::Termination::locked ||
                  result.rollbacks > options.locked_rollbacks ||
                  result.quality.area_p01 < options.locked_area_p01;
  for (Eigen::Index f = 0; f < surface.F.rows(); ++f) {
    const auto double_area = [&](const VertexMatrix& X) {
      const Eigen::RowVector3d a = X.row(surface.F(f, 0));
      return (X.row(surface.F(f, 1)) - a).cross(X.row(surface.F(f, 2)) - a).norm();
    };
    const double rest = double_area(surface.V);
    if (rest > 0) result.worst_face = std::min(result.worst_face, double_area(result.U0) / rest);
  }
  OVERTET_ENSURES(check_postconditions(surface, free, result));
  return result;
}

Status check_postconditions(const Surface& surface, const std::vector<char>& free,
                            const ReverseFlowResult& result) {
  const auto bad = [](const std::string& what) {
    return Error{ErrorCode::internal, "Reverse flow: " + what};
  };
  if (result.U0.rows() != surface.V.rows() || free.size() != static_cast<std::size_t>(surface.V.rows()))
    return bad("the result has another number of vertices.");
  if (!result.U0.allFinite()) return bad("a coordinate is not finite.");
  for (std::size_t v = 0; v < free.size(); ++v)
    if (!free[v] && result.U0.row(v) != surface.V.row(v)) return bad("a frozen vertex moved.");
  const auto left = find_self_intersections(result.U0, surface.F);  // not the code that made it
  if (!left.empty()) return bad(std::to_string(left.size()) + " pairs intersect.");
  return success();
}

}  // namespace overtet
