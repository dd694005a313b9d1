#include "overtet/cleanup.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstring>
#include <map>

#include "overtet/diagnosis.h"
#include "overtet/meshing.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using test::joined;
using test::shifted;

Cleanup cleaned(const Surface& s, const CleanupOptions& options = {}) {
  Result<Cleanup> r = clean_up(s, options);
  EXPECT_TRUE(r.ok()) << r.error().message;
  return r.ok() ? std::move(r).value() : Cleanup{};
}

std::int64_t count_of(const Cleanup& c, DefectKind kind) {
  for (const Defect& d : c.defects)
    if (d.kind == kind) return d.count;
  return 0;
}

// As a format without vertex numbers has it: equal corners are one vertex.
Surface merged(const Surface& s) {
  Surface out{s.V, s.F};
  for (Index f = 0; f < s.F.rows(); ++f)
    for (int k = 0; k < 3; ++k)
      for (Index v = 0; v <= s.F(f, k); ++v)
        if (s.V.row(v) == s.V.row(s.F(f, k))) {
          out.F(f, k) = v;
          break;
        }
  return out;
}

int components(const Surface& s) {
  const Result<SurfaceDiagnosis> d = diagnose(s);
  return d.ok() ? static_cast<int>(d.value().components.size()) : -1;
}

int winding_max(const Surface& s) {
  const Result<SurfaceDiagnosis> d = diagnose(s);
  return d.ok() ? d.value().winding_max.value_or(-1) : -1;
}

TEST(Cleanup, LeavesCleanSurfacesAsTheyAre) {
  for (const Surface& s :
       {test::sphere(), test::torus(), test::two_spheres(), test::sphere_with_cavity(), test::elbow(),
        test::curled_worm(), test::saucer(), test::mirrored_folds(), joined(test::box(), test::box()),
        joined(test::box(), shifted(test::box(), 1, 0, 0))}) {
    const Cleanup c = cleaned(s);
    EXPECT_FALSE(c.changed()) << c.summary();
    EXPECT_FALSE(c.problem);
    EXPECT_TRUE(c.defects.empty());
    EXPECT_EQ(
        std::memcmp(c.surface.V.data(), s.V.data(), sizeof(double) * static_cast<std::size_t>(s.V.size())),
        0);
    EXPECT_EQ(c.surface.F, s.F);
    EXPECT_EQ(c.summary(), "");
  }
}

// Cleaned as far as that goes: faces turned, vertices dropped, odd edges cut open; a hole stays.
TEST(Cleanup, MayLeaveSurfacesOpen) {
  CleanupOptions options;
  options.allow_open = true;
  Surface s = test::sphere(2);
  s.F = TriangleMatrix(s.F.bottomRows(s.F.rows() - 1));
  std::swap(s.F(9, 1), s.F(9, 2));
  s.V.conservativeResize(s.V.rows() + 1, 3);
  s.V.row(s.V.rows() - 1) << 9, 9, 9;
  const Cleanup c = cleaned(s, options);
  EXPECT_FALSE(c.problem);
  EXPECT_EQ(count_of(c, DefectKind::hole), 1);
  EXPECT_EQ(c.turned, std::vector<Index>{9});
  EXPECT_EQ(c.surface.V.rows(), s.V.rows() - 1);
  EXPECT_TRUE(cleaned(s).problem);

  Surface fin = test::box(1);  // and a face that stands on one of its edges
  const Index n = static_cast<Index>(fin.V.rows()), faces = static_cast<Index>(fin.F.rows());
  fin.V.conservativeResize(n + 1, 3);
  fin.V.row(n) << 2, 2, 2;
  fin.F.conservativeResize(faces + 1, 3);
  fin.F.row(faces) << fin.F(0, 0), fin.F(0, 1), n;
  const Cleanup d = cleaned(fin, options);
  EXPECT_FALSE(d.problem);
  EXPECT_EQ(count_of(d, DefectKind::odd_edge), 1);
  EXPECT_EQ(d.surface.F.rows(), faces + 1);
  EXPECT_EQ(d.surface.V.rows(), n + 1 + 2);  // the fin has two of its own
  // Nothing else to do.
  EXPECT_FALSE(cleaned(d.surface, options).changed());
}

// Solids that touch in an edge, a face, or a part of a face come apart, merged as a file without vertex
// numbers merges them.
TEST(Cleanup, SolidsThatTouchComeApart) {
  const Surface box = test::box(2);
  for (const Surface& other : {shifted(box, 1, 1, 0), shifted(box, 1, 0, 0), shifted(box, 1, 0.5, 0),
                               shifted(box, 1, 1, 1), shifted(box, 0, -1, 0.5)}) {
    const Surface both = joined(box, other);
    const Cleanup c = cleaned(merged(both));
    ASSERT_FALSE(c.problem) << c.problem->message;
    EXPECT_EQ(c.surface.V.rows(), both.V.rows());
    EXPECT_EQ(c.surface.F.rows(), both.F.rows());
    EXPECT_EQ(components(c.surface), 2);
    EXPECT_EQ(winding_max(c.surface), 1);
    EXPECT_NEAR(test::signed_volume(c.surface), 2, 1e-12);
  }
}

// Four boxes around an edge, two of them: all ways.
TEST(Cleanup, BoxesAroundAnEdgeComeApart) {
  const Surface box = test::box(1);
  const double at[4][2] = {{0, 0}, {-1, 0}, {-1, -1}, {0, -1}};
  for (int mask = 1; mask < 16; ++mask) {
    Surface all;
    int boxes = 0;
    for (int i = 0; i < 4; ++i) {
      if (!(mask >> i & 1)) continue;
      const Surface one = shifted(box, at[i][0], at[i][1], 0);
      all = boxes++ == 0 ? one : joined(all, one);
    }
    SCOPED_TRACE(mask);
    const Cleanup c = cleaned(merged(all));
    ASSERT_FALSE(c.problem) << c.problem->message;
    EXPECT_EQ(c.surface.V.rows(), all.V.rows());
    EXPECT_EQ(components(c.surface), boxes);
    EXPECT_EQ(winding_max(c.surface), 1);
  }
}

// One solid that touches itself in an edge: a ring of boxes whose last one meets the first only there.
TEST(Cleanup, ASolidThatTouchesItselfIsOpenedThere) {
  // An L of three cells, and a fourth one that touches the first along an edge: made of the cells' outer
  // faces.
  const int cells[][3] = {
      {0, 0, 0}, {0, 0, 1}, {1, 0, 1}, {1, 1, 1}, {1, 1, 0}};  // (0,0,0) and (1,1,0) share an edge
  std::map<std::array<int, 3>, bool> filled;
  for (const auto& c : cells) filled[{c[0], c[1], c[2]}] = true;
  std::map<std::array<int, 3>, Index> number;
  std::vector<std::array<Index, 3>> faces;
  std::vector<std::array<int, 3>> points;
  const auto vertex = [&](std::array<int, 3> p) {
    const auto [at, added] = number.try_emplace(p, static_cast<Index>(points.size()));
    if (added) points.push_back(p);
    return at->second;
  };
  for (const auto& c : cells)
    for (int k = 0; k < 3; ++k)
      for (const int side : {0, 1}) {
        std::array<int, 3> next{c[0], c[1], c[2]};
        next[k] += side ? 1 : -1;
        if (filled.count(next)) continue;
        std::array<Index, 4> q;
        for (int i = 0; i < 4; ++i) {
          std::array<int, 3> p{c[0], c[1], c[2]};
          p[k] += side;
          p[(k + 1) % 3] += i == 1 || i == 2;
          p[(k + 2) % 3] += i >= 2;
          q[i] = vertex(p);
        }
        if (!side) std::swap(q[1], q[3]);
        faces.push_back({q[0], q[1], q[2]});
        faces.push_back({q[0], q[2], q[3]});
      }
  Surface s{VertexMatrix(static_cast<Index>(points.size()), 3),
            TriangleMatrix(static_cast<Index>(faces.size()), 3)};
  for (Index v = 0; v < s.V.rows(); ++v) s.V.row(v) << points[v][0], points[v][1], points[v][2];
  for (Index f = 0; f < s.F.rows(); ++f) s.F.row(f) << faces[f][0], faces[f][1], faces[f][2];
  const Cleanup c = cleaned(s);
  ASSERT_FALSE(c.problem) << c.problem->message;
  EXPECT_EQ(count_of(c, DefectKind::crowded_edge), 1);
  EXPECT_EQ(components(c.surface), 1);
  EXPECT_DOUBLE_EQ(test::signed_volume(c.surface), 5);
  const Result<Meshing> mesh = tetrahedralize(c.surface);
  EXPECT_TRUE(mesh.ok()) << mesh.error().message;
}

// A solid whose two sides have an edge in common, in the midst of them: it would take new vertices to cut it
// there.
TEST(Cleanup, ASolidPinchedOffAtAnEdgeStaysInOnePiece) {
  Surface s = test::box(4);
  // The edge from (.25, .5) to (.5, .5) on the bottom and on the top, moved to the middle: into one place.
  const auto at = [&](double x, double y, double z) {
    for (Index v = 0; v < s.V.rows(); ++v)
      if (s.V.row(v) == Eigen::RowVector3d(x, y, z)) return v;
    return Index{-1};
  };
  const Index ends[4] = {at(0.25, 0.5, 0), at(0.5, 0.5, 0), at(0.25, 0.5, 1), at(0.5, 0.5, 1)};
  for (const Index v : ends) {
    ASSERT_GE(v, 0);
    s.V(v, 2) = 0.5;
  }
  EXPECT_FALSE(cleaned(s).changed());
  const Cleanup c = cleaned(merged(s));
  ASSERT_FALSE(c.problem) << c.problem->message;
  EXPECT_EQ(c.surface.V.rows(), s.V.rows());
  EXPECT_EQ(components(c.surface), 1);
}

// Two solids that overlap and have triangles in common: dropping one of each would leave a hole.
TEST(Cleanup, SidesThatTwoSolidsHaveInCommonStay) {
  Surface low = test::box(2);
  for (Index v = 0; v < low.V.rows(); ++v) low.V(v, 2) *= 0.5;
  const Surface both = joined(test::box(2), low);
  const Cleanup c = cleaned(merged(both));
  ASSERT_FALSE(c.problem) << c.problem->message;
  EXPECT_EQ(c.surface.F.rows(), both.F.rows());
  EXPECT_NEAR(test::signed_volume(c.surface), 1.5, 1e-12);
}

TEST(Cleanup, ASheetWithTwoSidesBecomesASolid) {
  const Surface s = test::sphere(1);
  Surface twice = joined(s, test::flipped(s));
  const Cleanup c = cleaned(merged(twice));
  ASSERT_FALSE(c.problem) << c.problem->message;
  EXPECT_EQ(c.surface.F.rows(), s.F.rows());
  EXPECT_GT(test::signed_volume(c.surface), 0);
  EXPECT_EQ(count_of(c, DefectKind::repeated_face), s.F.rows());
}

// Something that fills a cavity has the cavity's faces, too: both stay.
TEST(Cleanup, AFilledCavityStays) {
  const Surface hollow = test::sphere_with_cavity(1, 0.5), core = test::sphere(1, 0.5);
  const Surface both = joined(hollow, core);
  const Cleanup c = cleaned(merged(both));
  ASSERT_FALSE(c.problem) << c.problem->message;
  EXPECT_EQ(c.surface.F.rows(), both.F.rows());
  EXPECT_EQ(components(c.surface), 3);
}

TEST(Cleanup, CavitiesAreToldFromComponentsThatFaceInwards) {
  const Surface out = test::sphere(1), in = test::flipped(test::sphere(1, 0.5)), deep = test::sphere(1, 0.25);
  const double volume = test::signed_volume(out);
  const auto turned = [&](const Surface& s) { return count_of(cleaned(s), DefectKind::inward_component); };
  EXPECT_EQ(turned(joined(out, in)), 0);                               // a cavity
  EXPECT_EQ(turned(joined(joined(out, in), deep)), 0);                 // with something in it
  EXPECT_EQ(turned(joined(out, test::flipped(in))), 0);                // a solid in a solid
  EXPECT_EQ(turned(joined(test::flipped(out), in)), 1);                // the outer one only
  EXPECT_EQ(turned(test::flipped(joined(out, in))), 2);                // the whole model
  EXPECT_EQ(turned(test::flipped(joined(joined(out, in), deep))), 3);  // the same, with something in it
  EXPECT_EQ(turned(joined(joined(out, in), test::flipped(deep))), 1);  // what is in it only
  EXPECT_EQ(turned(joined(out, shifted(in, 2, 0, 0))), 1);             // beside, not inside
  EXPECT_EQ(turned(joined(out, shifted(in, 0.8, 0, 0))), 1);           // half inside
  const Cleanup c = cleaned(test::flipped(joined(out, in)));
  EXPECT_LT(test::signed_volume(c.surface), volume);
  EXPECT_EQ(winding_max(c.surface), 1);
  // A cavity that touches the wall from inside, in a vertex.
  Surface touching = joined(test::box(2), test::flipped(test::box(1)));
  for (Index v = touching.V.rows() - 8; v < touching.V.rows(); ++v) touching.V.row(v) *= 0.5;
  EXPECT_EQ(turned(touching), 0);
}

// What has no negative winding number stays as it is, whatever its components' volumes are.
TEST(Cleanup, SurfacesThatAreFineStayAsTheyAre) {
  // A cavity that reaches out of one ball into another one.
  const Surface both = joined(joined(test::sphere(2), shifted(test::sphere(2), 1.2, 0, 0)),
                              test::flipped(shifted(test::sphere(1, 0.35), 0.6, 0, 0)));
  EXPECT_FALSE(cleaned(both).changed());
}

// What faces both ways would be as wrong when turned; its witness is one of the file.
TEST(Cleanup, ComponentsThatFaceBothWaysStayAsTheyAre) {
  EXPECT_FALSE(cleaned(test::saucer(2)).changed());
  EXPECT_FALSE(cleaned(test::flipped(test::saucer(2))).changed());
  EXPECT_TRUE(cleaned(test::flipped(test::curled_worm())).changed());
}

TEST(Cleanup, StrictRefusesWhatItWouldChange) {
  Surface s = test::sphere(1);
  std::swap(s.F(3, 1), s.F(3, 2));
  CleanupOptions strict;
  strict.strict = true;
  const Cleanup c = cleaned(s, strict);
  ASSERT_TRUE(c.problem);
  EXPECT_EQ(c.problem->code, ErrorCode::bad_input);
  EXPECT_NE(c.problem->message.find("face 3"), std::string::npos) << c.problem->message;
  EXPECT_EQ(c.surface.F, s.F);
  EXPECT_FALSE(c.changed());
  EXPECT_FALSE(cleaned(test::sphere(1), strict).problem);
}

TEST(Cleanup, MessagesNameThePlaceInTheFile) {
  Surface s = test::sphere(1);
  s.F.conservativeResize(s.F.rows() - 1, 3);
  SurfaceSource source;
  source.first = 1;
  source.vertex_line.assign(s.V.rows(), 100);
  for (Index f = 0; f < s.F.rows(); ++f) source.face_line.push_back(static_cast<std::uint32_t>(200 + f));
  const Result<Cleanup> c = clean_up(s, {}, source);
  ASSERT_TRUE(c.ok() && c.value().problem);
  const std::string& text = c.value().problem->message;
  for (const char* part : {"hole of 3 edges", "lines 100, 100, 100", "line 2"})
    EXPECT_NE(text.find(part), std::string::npos) << text;
  EXPECT_EQ(text.find('\n'), std::string::npos);
  const Defect& hole = c.value().defects.at(0);
  EXPECT_EQ(hole.kind, DefectKind::hole);
  ASSERT_EQ(hole.places.size(), 1u);
  EXPECT_EQ(hole.places[0].edges, 3);
  EXPECT_GT(hole.places[0].length, 0);
  EXPECT_EQ(hole.places[0].vertices.size(), 3u);
}

TEST(Cleanup, HolesAreCountedAndMeasured) {
  Surface s = test::box(4);
  // Two squares are taken out, far from each other: 4 edges each, of a quarter.
  std::vector<Index> gone = {0, 1, static_cast<Index>(s.F.rows() - 2), static_cast<Index>(s.F.rows() - 1)};
  TriangleMatrix F(s.F.rows() - 4, 3);
  for (Index f = 0, n = 0; f < s.F.rows(); ++f)
    if (std::find(gone.begin(), gone.end(), f) == gone.end()) F.row(n++) = s.F.row(f);
  s.F = F;
  const Cleanup c = cleaned(s);
  ASSERT_TRUE(c.problem);
  ASSERT_EQ(count_of(c, DefectKind::hole), 2);
  for (const DefectPlace& p : c.defects[0].places) {
    EXPECT_EQ(p.edges, 4);
    EXPECT_DOUBLE_EQ(p.length, 1);
  }
}

// Sewn together at their borders they would be closed, and nothing.
TEST(Cleanup, AnOpenSheetAndItsCopyAreNotSewnTogether) {
  Surface sheet = test::sphere(2);
  sheet.F.conservativeResize(sheet.F.rows() / 2, 3);
  const Cleanup c = cleaned(joined(sheet, sheet));
  ASSERT_TRUE(c.problem);
  EXPECT_GT(count_of(c, DefectKind::hole), 0);
}

TEST(Cleanup, OneSidedSurfacesAreRefused) {
  // The projective plane of ten triangles on six vertices.
  Surface s{VertexMatrix(6, 3), TriangleMatrix(10, 3)};
  s.V << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 0.5, 0.3, 0.7, 1;
  s.F << 0, 1, 2, 0, 2, 3, 0, 3, 4, 0, 4, 5, 0, 5, 1, 1, 2, 4, 2, 3, 5, 3, 4, 1, 4, 5, 2, 5, 1, 3;
  const Cleanup c = cleaned(s);
  ASSERT_TRUE(c.problem);
  EXPECT_EQ(count_of(c, DefectKind::one_sided), 1);
  EXPECT_NE(c.problem->message.find("one-sided"), std::string::npos) << c.problem->message;
}

TEST(Cleanup, MalformedSurfacesAreRefused) {
  Surface s = test::sphere(1);
  s.F(2, 1) = 4000;
  EXPECT_TRUE(cleaned(s).problem);
  s = test::sphere(1);
  s.V(2, 1) = std::nan("");
  EXPECT_TRUE(cleaned(s).problem);
  EXPECT_TRUE(cleaned(Surface{}).problem);
  s = test::sphere(1);
  for (Index f = 0; f < s.F.rows(); ++f) s.F(f, 1) = s.F(f, 0);
  EXPECT_TRUE(cleaned(s).problem);
  CleanupOptions options;
  options.most_places = 0;
  EXPECT_EQ(clean_up(test::sphere(1), options).error().code, ErrorCode::usage);
}

TEST(Cleanup, TheContextEndsIt) {
  RunContext context;
  const std::atomic<bool> cancel = true;
  context.cancel = &cancel;
  EXPECT_EQ(clean_up(test::sphere(), {}, {}, context).error().code, ErrorCode::interrupted);
}

}  // namespace
}  // namespace overtet
