#include "overtet/prepare.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <random>
#include <set>

#include "kernels/bvh/self_intersections.h"
#include "overtet/meshing.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using test::joined;
using test::shifted;

Preparation prepared(const Surface& s, const PrepareOptions& options, const RunContext& context = {}) {
  Result<Preparation> r = prepare(s, options, {}, context);
  EXPECT_TRUE(r.ok()) << r.error().message;
  return r.ok() ? std::move(r).value() : Preparation{};
}

PrepareOptions filling(Index edges) {
  PrepareOptions o;
  o.fill_holes = edges;
  return o;
}

// The faces for which keep(f) holds; all vertices.
template <class Keep>
Surface some_faces(const Surface& s, const Keep& keep) {
  Surface out{s.V, s.F};
  Index n = 0;
  for (Index f = 0; f < s.F.rows(); ++f)
    if (keep(f)) out.F.row(n++) = s.F.row(f);
  out.F.conservativeResize(n, 3);
  return out;
}

Eigen::RowVector3d centre(const Surface& s, Index f) {
  return (s.V.row(s.F(f, 0)) + s.V.row(s.F(f, 1)) + s.V.row(s.F(f, 2))) / 3;
}

Surface without_ball(const Surface& s, const Eigen::RowVector3d& at, double radius) {
  return some_faces(s, [&](Index f) { return (centre(s, f) - at).norm() > radius; });
}

std::array<std::array<double, 3>, 3> corners(const Surface& s, Index f) {
  std::array<std::array<double, 3>, 3> c;
  for (int k = 0; k < 3; ++k)
    for (int i = 0; i < 3; ++i) c[k][i] = s.V(s.F(f, k), i);
  std::rotate(c.begin(), std::min_element(c.begin(), c.end()), c.end());
  return c;
}

// Vertices have their bits, faces their corners; all faces are there. Empty: so it is.
std::string what_changed(const Preparation& p, const Surface& given) {
  const Surface& s = p.result.surface;
  for (Index v = 0; v < s.V.rows(); ++v)
    if (const Index u = p.result.vertex_of[v]; u >= 0)
      if (std::memcmp(s.V.row(v).data(), given.V.row(u).data(), 3 * sizeof(double)) != 0)
        return "vertex " + std::to_string(u) + " moved";
  std::set<Index> there;
  for (Index f = 0; f < s.F.rows(); ++f)
    if (const Index g = p.result.face_of[f]; g >= 0) {
      if (corners(s, f) != corners(given, g)) return "face " + std::to_string(g) + " changed";
      there.insert(g);
    }
  if (static_cast<Index>(there.size()) != given.F.rows()) return "faces are gone";
  return {};
}

// Pairs that intersect, of which one face is new.
std::size_t new_crossings(const Preparation& p) {
  std::size_t n = 0;
  for (const auto& [f, g] : find_self_intersections(p.result.surface.V, p.result.surface.F))
    n += p.result.face_of[f] < 0 || p.result.face_of[g] < 0 ? 1 : 0;
  return n;
}

TEST(Prepare, FillsHolesAndChangesNothingElse) {
  const Surface ball = test::sphere(4);
  Surface open = without_ball(ball, {0, 0, 1}, 0.3);
  open = without_ball(open, {1, 0, 0}, 0.15);
  open = some_faces(open, [&](Index f) { return f != 7; });
  const Preparation p = prepared(open, filling(200));
  EXPECT_TRUE(p.remaining.empty());
  EXPECT_TRUE(test::is_closed_oriented(p.result.surface));
  EXPECT_EQ(what_changed(p, open), "");
  EXPECT_EQ(new_crossings(p), 0u);
  EXPECT_TRUE(p.moved.empty());
  ASSERT_EQ(p.steps.size(), 1u);
  EXPECT_EQ(p.steps[0].done, 3);
  EXPECT_EQ(p.steps[0].left, 0);
  // Fair: the volume is nearly the ball's, of which a flat filling of the first hole alone lacks .6 %.
  EXPECT_NEAR(test::signed_volume(p.result.surface), test::signed_volume(ball),
              3e-3 * test::signed_volume(ball));
}

TEST(Prepare, LeavesHolesWithMoreEdgesAndSaysWhere) {
  const Surface open = without_ball(test::sphere(4), {0, 0, 1}, 0.3);
  const Preparation p = prepared(open, filling(10));
  ASSERT_EQ(p.steps[0].left, 1);
  EXPECT_EQ(p.steps[0].done, 0);
  ASSERT_EQ(p.steps[0].places.size(), 1u);
  EXPECT_GT(p.steps[0].places[0].edges, 10);
  EXPECT_EQ(p.steps[0].places[0].why, "it has more than 10 edges");
  ASSERT_EQ(p.remaining.size(), 1u);
  EXPECT_EQ(p.remaining[0].kind, DefectKind::hole);
  EXPECT_EQ(p.remaining[0].places[0].edges, p.steps[0].places[0].edges);
  EXPECT_NE(p.steps[0].message.find("it has more than 10 edges"), std::string::npos) << p.steps[0].message;
}

// A ball sits in the hole: every filling passes through it.
TEST(Prepare, NeverCrossesAnythingUnlessAllowed) {
  const Surface open = joined(without_ball(test::sphere(4), {0, 0, 1}, 0.3),
                              test::sphere(2, 0.2, Eigen::Vector3d(0, 0, 0.97)));
  const Preparation p = prepared(open, filling(200));
  EXPECT_EQ(p.steps[0].done, 0);
  EXPECT_EQ(p.steps[0].left, 1);
  EXPECT_NE(p.steps[0].places[0].why.find("crosses"), std::string::npos);
  EXPECT_EQ(p.remaining.size(), 1u);
  EXPECT_EQ(what_changed(p, open), "");
  PrepareOptions allowed = filling(200);
  allowed.allow_crossings = true;
  const Preparation q = prepared(open, allowed);
  EXPECT_EQ(q.steps[0].done, 1);
  EXPECT_TRUE(q.remaining.empty());
  EXPECT_GT(new_crossings(q), 0u);
}

// The ball only reaches into the bulge of a fair filling: a flat one passes below it.
TEST(Prepare, FillsFlatWhereSmoothWouldCross) {
  const Surface open = joined(without_ball(test::sphere(4), {0, 0, 1}, 0.3),
                              test::sphere(1, 0.01, Eigen::Vector3d(0, 0, 0.995)));
  const Preparation p = prepared(open, filling(200));
  EXPECT_EQ(p.steps[0].done, 1);
  EXPECT_TRUE(p.remaining.empty());
  EXPECT_EQ(new_crossings(p), 0u);
}

// Two holes with one vertex in common are two holes, and that is one vertex again.
TEST(Prepare, FillsHolesThatTouchInAVertex) {
  const Surface ball = test::sphere(3);
  const Index v = 100;
  std::vector<Index> around;  // faces at the vertex, in order
  for (Index f = 0; f < ball.F.rows(); ++f)
    if ((ball.F.row(f).array() == v).any()) around.push_back(f);
  ASSERT_EQ(around.size(), 6u);
  const auto beside = [&](Index f, Index g) {
    int n = 0;
    for (int i = 0; i < 3; ++i) n += (ball.F.row(g).array() == ball.F(f, i)).any() ? 1 : 0;
    return n == 2;
  };
  const Index gone = around[0];
  const auto other =
      std::find_if(around.begin() + 1, around.end(), [&](Index g) { return !beside(gone, g); });
  ASSERT_NE(other, around.end());
  const Surface open = some_faces(ball, [&](Index f) { return f != gone && f != *other; });
  const Preparation p = prepared(open, filling(3));
  EXPECT_EQ(p.steps[0].done, 2);
  EXPECT_TRUE(p.remaining.empty());
  EXPECT_EQ(p.result.surface.V.rows(), ball.V.rows());
  EXPECT_EQ(p.result.surface.F.rows(), ball.F.rows());
  EXPECT_EQ(what_changed(p, open), "");
}

// One flat sheet would be filled by its own copy.
TEST(Prepare, LeavesFlatSheetsOpen) {
  const Surface box = test::box(3);
  const Surface sheet = some_faces(box, [&](Index f) { return centre(box, f).z() == 0; });
  const Preparation p = prepared(sheet, filling(100));
  EXPECT_EQ(p.steps[0].done, 0);
  EXPECT_EQ(p.steps[0].left, 1);
  EXPECT_EQ(what_changed(p, sheet), "");
}

// Holes anywhere in surfaces that cross themselves or not: what is new crosses nothing, the rest stays.
TEST(Prepare, RandomHoles) {
  const std::uint64_t seed = 20261130;
  std::mt19937_64 random(seed);
  int filled = 0, all = 0;
  for (const Surface& s : {test::torus(), test::curled_worm(), test::two_spheres(), test::elbow(),
                           test::bent_slab(), test::sphere_with_cavity(), test::capsule(), test::box(6)})
    for (int round = 0; round < 4; ++round) {
      SCOPED_TRACE("seed " + std::to_string(seed) + ", surface of " + std::to_string(s.F.rows()) +
                   " faces, round " + std::to_string(round));
      std::set<Index> gone;
      for (int i = 0; i < 3; ++i) {
        const Index f = std::uniform_int_distribution<Index>(0, static_cast<Index>(s.F.rows()) - 1)(random);
        const double radius = std::uniform_real_distribution<double>(0, 0.3)(random);
        gone.insert(f);
        for (Index g = 0; g < s.F.rows(); ++g)
          if ((centre(s, g) - centre(s, f)).norm() < radius) gone.insert(g);
      }
      if (2 * static_cast<Index>(gone.size()) > s.F.rows()) continue;
      const Surface open = some_faces(s, [&](Index f) { return !gone.contains(f); });
      const Preparation p = prepared(open, filling(200));
      EXPECT_EQ(what_changed(p, open), "");
      EXPECT_EQ(new_crossings(p), 0u);
      EXPECT_EQ(p.remaining.empty(), test::is_closed_oriented(p.result.surface));
      filled += static_cast<int>(p.steps[0].done);
      all += static_cast<int>(p.steps[0].done + p.steps[0].left);
    }
  EXPECT_GT(filled, all * 3 / 4) << "of " << all << ", seed " << seed;
}

// The upper half with vertices of its own, a little off those of the lower one.
Surface cracked(const Surface& s, double off, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> by(-off, off);
  Surface out = s;
  const Index n = static_cast<Index>(s.V.rows());
  out.V.conservativeResize(2 * n, 3);
  for (Index v = 0; v < n; ++v)
    for (int k = 0; k < 3; ++k) out.V(n + v, k) = s.V(v, k) + by(random);
  for (Index f = 0; f < s.F.rows(); ++f)
    if (centre(s, f).z() > 0) out.F.row(f).array() += n;
  return out;
}

TEST(Prepare, WeldsCracks) {
  const Surface whole = test::sphere(3), open = cracked(whole, 1e-4, 1);
  PrepareOptions o;
  o.weld = 2e-4;  // of a diagonal of 3.5
  const Preparation p = prepared(open, o);
  EXPECT_TRUE(p.remaining.empty());
  EXPECT_EQ(p.result.surface.F.rows(), whole.F.rows());
  EXPECT_EQ(p.result.surface.V.rows(), whole.V.rows());
  EXPECT_GT(p.steps[0].done, 10);
  // Only vertices along the crack have moved, and by no more than allowed.
  for (const Index v : p.moved)
    EXPECT_LE((p.result.surface.V.row(v) - open.V.row(p.result.vertex_of[v])).norm(),
              2e-4 * 2 * std::sqrt(3) + 1e-12);
  EXPECT_LE(static_cast<std::int64_t>(p.moved.size()), p.steps[0].done);
  o.weld = 1e-6;
  const Preparation q = prepared(open, o);
  EXPECT_EQ(q.steps[0].done, 0);
  EXPECT_EQ(what_changed(q, open), "");  // vertices that were put together for nothing are back
  ASSERT_EQ(q.remaining.size(), 1u);
  EXPECT_EQ(q.remaining[0].count, 2);
}

// Layers of a closed surface stay apart, however near they are.
TEST(Prepare, WeldsNothingThatIsClosed) {
  const Surface s = joined(test::sphere(2), test::flipped(test::sphere(2, 0.999)));
  PrepareOptions o;
  o.weld = 0.01;
  const Preparation p = prepared(s, o);
  EXPECT_EQ(p.steps[0].done, 0);
  EXPECT_EQ(what_changed(p, s), "");
  EXPECT_TRUE(p.remaining.empty());
}

// The six sides of the unit cube, each with vertices of its own, in as many squares a side as given.
Surface box_of_sides(const std::array<int, 6>& cells) {
  Surface out{VertexMatrix(0, 3), TriangleMatrix(0, 3)};
  for (int side = 0; side < 6; ++side) {
    const int n = cells[side], axis = side / 2;
    const bool high = side % 2 == 1;
    Surface one{VertexMatrix((n + 1) * (n + 1), 3), TriangleMatrix(2 * n * n, 3)};
    for (int i = 0; i <= n; ++i)
      for (int j = 0; j <= n; ++j) {
        Eigen::RowVector3d p;
        p[axis] = high ? 1 : 0;
        p[(axis + 1) % 3] = static_cast<double>(i) / n;
        p[(axis + 2) % 3] = static_cast<double>(j) / n;
        one.V.row(i * (n + 1) + j) = p;
      }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < n; ++j) {
        const Index a = i * (n + 1) + j, b = a + n + 1, c = b + 1, d = a + 1;
        one.F.row(2 * (i * n + j)) << a, b, c;
        one.F.row(2 * (i * n + j) + 1) << a, c, d;
      }
    out = joined(out, high ? one : test::flipped(one));
  }
  return out;
}

TEST(Prepare, ClosesCracksWhereVerticesLieBesideEdges) {
  const Surface open = box_of_sides({1, 2, 4, 1, 2, 3});
  PrepareOptions o;
  o.close_cracks = true;
  const Preparation p = prepared(open, o);
  EXPECT_TRUE(p.remaining.empty()) << p.remaining.front().message;
  EXPECT_TRUE(test::is_closed_oriented(p.result.surface));
  EXPECT_NEAR(test::signed_volume(p.result.surface), 1, 1e-9);
  EXPECT_TRUE(p.moved.empty());
  // Pieces lead to the face that they are of: all given faces are there.
  std::set<Index> there(p.result.face_of.begin(), p.result.face_of.end());
  EXPECT_EQ(static_cast<Index>(there.size()), open.F.rows());
}

// The sides do not quite meet.
TEST(Prepare, ClosesCracksWithAGap) {
  Surface open = box_of_sides({4, 3, 2, 4, 1, 3});
  Index v = 0;
  for (const int cells : {4, 3, 2, 4, 1, 3}) {
    const Index end = v + (cells + 1) * (cells + 1);
    const Eigen::RowVector3d out =
        (open.V.row(v) + open.V.row(end - 1)) / 2 - Eigen::RowVector3d(0.5, 0.5, 0.5);
    for (; v < end; ++v) open.V.row(v) += 0.01 * out;
  }
  PrepareOptions o;
  o.close_cracks = true;
  o.tolerance = 0.01;  // of a diagonal of 1.75
  const Preparation p = prepared(open, o);
  EXPECT_TRUE(p.remaining.empty()) << p.remaining.front().message;
  EXPECT_NEAR(test::signed_volume(p.result.surface), 1.01, 0.02);
  EXPECT_TRUE(find_self_intersections(p.result.surface.V, p.result.surface.F).empty());
  for (const Index u : p.moved)
    EXPECT_LE((p.result.surface.V.row(u) - open.V.row(p.result.vertex_of[u])).norm(), 0.0176);
}

TEST(Prepare, DropsSmallComponents) {
  Surface s = joined(test::sphere(2), shifted(test::box(1), 3, 0, 0));
  s = joined(s, shifted(test::sphere(1, 0.1), 0, 3, 0));  // 80 faces, small
  PrepareOptions o;
  o.remove_small = 13;
  const Preparation p = prepared(s, o);
  EXPECT_EQ(p.steps[0].done, 1);
  EXPECT_EQ(p.result.surface.F.rows(), 320 + 80);
  o.remove_small = 1000;  // the largest stays all the same
  EXPECT_EQ(prepared(s, o).result.surface.F.rows(), 320);
  PrepareOptions largest;
  largest.largest = true;
  const Preparation q = prepared(s, largest);
  EXPECT_EQ(q.steps[0].done, 2);
  EXPECT_EQ(q.result.surface.F.rows(), 320);
  EXPECT_TRUE(q.remaining.empty());
}

// A vertex on an edge, very near one of its ends: four faces become needles, or two.
Surface with_needles(Surface s, Index face, double share) {
  const Index a = s.F(face, 0), b = s.F(face, 1), m = static_cast<Index>(s.V.rows()),
              faces = static_cast<Index>(s.F.rows());
  s.V.conservativeResize(m + 1, 3);
  s.V.row(m) = (1 - share) * s.V.row(a) + share * s.V.row(b);
  for (Index f = 0; f < faces; ++f)
    for (int k = 0; k < 3; ++k) {
      const Index p = s.F(f, k), q = s.F(f, (k + 1) % 3), r = s.F(f, (k + 2) % 3);
      if (std::minmax(p, q) != std::minmax(a, b)) continue;
      s.F.row(f) << p, m, r;
      s.F.conservativeResize(s.F.rows() + 1, 3);
      s.F.row(s.F.rows() - 1) << m, q, r;
      break;
    }
  return s;
}

TEST(Prepare, CollapsesNeedles) {
  Surface s = test::sphere(3);
  for (const Index f : {10, 300, 777}) s = with_needles(s, f, 1e-6);
  PrepareOptions o;
  o.collapse_needles = true;
  const Preparation p = prepared(s, o);
  EXPECT_EQ(p.steps[0].done, 6);
  EXPECT_EQ(p.steps[0].left, 0) << p.steps[0].message;
  EXPECT_TRUE(p.remaining.empty());
  EXPECT_TRUE(test::is_closed_oriented(p.result.surface));
  EXPECT_EQ(p.result.surface.F.rows(), test::sphere(3).F.rows());
  EXPECT_TRUE(p.moved.empty());
  EXPECT_TRUE(find_self_intersections(p.result.surface.V, p.result.surface.F).empty());
  // Far from the needles nothing changed: all but some ten faces are given ones.
  int changed = 0;
  for (Index f = 0; f < p.result.surface.F.rows(); ++f)
    changed += corners(p.result.surface, f) != corners(s, p.result.face_of[f]) ? 1 : 0;
  EXPECT_LE(changed, 40);
  o.tolerance = 1e-9;
  const Preparation q = prepared(s, o);
  EXPECT_EQ(q.steps[0].done, 0);
  EXPECT_EQ(q.steps[0].left, 6);
  EXPECT_EQ(what_changed(q, s), "");
}

TEST(Prepare, AllTogetherOnAnyNumberOfThreads) {
  Surface s = cracked(without_ball(test::sphere(4), {0.6, 0.8, 0}, 0.2), 1e-5, 3);
  s = joined(with_needles(s, 1000, 1e-6),
             some_faces(shifted(test::box(1), 5, 0, 0), [](Index f) { return f < 3; }));
  Preparation results[2];
  for (const int threads : {1, 4}) {
    RunContext context;
    context.threads = threads;
    results[threads / 4] = prepared(s, PrepareOptions::all(), context);
  }
  const Preparation &a = results[0], &b = results[1];
  EXPECT_TRUE(a.remaining.empty());
  EXPECT_EQ(a.steps.size(), 4u);
  EXPECT_EQ(a.result.surface.F, b.result.surface.F);
  ASSERT_EQ(a.result.surface.V.rows(), b.result.surface.V.rows());
  EXPECT_EQ(std::memcmp(a.result.surface.V.data(), b.result.surface.V.data(),
                        sizeof(double) * static_cast<std::size_t>(a.result.surface.V.size())),
            0);
  EXPECT_EQ(a.result.vertex_of, b.result.vertex_of);
  EXPECT_EQ(a.result.face_of, b.result.face_of);
  MeshingOptions meshing;
  meshing.improve_degrees = 0;
  EXPECT_TRUE(tetrahedralize(a.result.surface, meshing).ok());
}

// Three sheets that share an edge come apart there; what is left is a surface with borders.
TEST(Prepare, TakesSurfacesThatACleanUpRefuses) {
  const Surface box = test::box(1);
  Surface s = box;
  s.V.conservativeResize(s.V.rows() + 1, 3);
  s.V.row(s.V.rows() - 1) << 2, 2, 2;
  s.F.conservativeResize(s.F.rows() + 1, 3);
  s.F.row(s.F.rows() - 1) << box.F(0, 0), box.F(0, 1), s.V.rows() - 1;
  PrepareOptions o;
  o.remove_small = 2;
  const Preparation p = prepared(s, o);
  EXPECT_FALSE(p.result.defects.empty());
  EXPECT_GT(p.result.surface.F.rows(), 0);
  for (Index f = 0; f < p.result.surface.F.rows(); ++f)
    EXPECT_EQ(corners(p.result.surface, f), corners(s, p.result.face_of[f]));
}

TEST(Prepare, RefusesWhatItCannotDo) {
  const Surface s = test::sphere(1);
  EXPECT_EQ(prepare(s, PrepareOptions{}).error().code, ErrorCode::usage);
  PrepareOptions o = PrepareOptions::all();
  o.fill_holes = 2;
  EXPECT_EQ(prepare(s, o).error().code, ErrorCode::usage);
  o = PrepareOptions::all();
  o.tolerance = std::nan("");
  EXPECT_EQ(prepare(s, o).error().code, ErrorCode::usage);
  Surface broken = s;
  broken.V(3, 1) = std::nan("");
  EXPECT_EQ(prepare(broken, PrepareOptions::all()).error().code, ErrorCode::bad_input);
  std::atomic<bool> cancel{true};
  RunContext context;
  context.cancel = &cancel;
  EXPECT_EQ(prepare(s, PrepareOptions::all(), {}, context).error().code, ErrorCode::interrupted);
}

// Sizes at which squares of lengths overflow or vanish.
TEST(Prepare, AnySize) {
  for (const double size : {1e-60, 1e60}) {
    Surface s = without_ball(test::sphere(3), {0, 0, 1}, 0.3);
    s.V *= size;
    const Preparation p = prepared(s, filling(100));
    EXPECT_EQ(what_changed(p, s), "");
    EXPECT_EQ(new_crossings(p), 0u);
  }
}

}  // namespace
}  // namespace overtet
