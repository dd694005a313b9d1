// Faces that lie on each other.
#include "src/certificates/stacks.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include "src/certificates/diagnose.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

Diagnosis diagnosed(const Surface& s) { return diagnose(s, {}, {}).value(); }

// What the witness says: the same surface with its vertices moved by very little is inside out somewhere.
TEST(Stacks, MovesThatTurnAPartInsideOut) {
  const Surface s = test::mirrored_folds();
  const Diagnosis d = diagnosed(s);
  EXPECT_EQ(d.verdict, Verdict::infeasible) << d.message;
  ASSERT_TRUE(d.certificate);
  const StackCertificate* found = std::get_if<StackCertificate>(&*d.certificate);
  ASSERT_TRUE(found) << d.message;
  const StackCertificate& w = *found;
  EXPECT_LT(w.winding, 0);
  ASSERT_EQ(w.vertices.size(), w.moves.size());
  const Eigen::RowVector3d a = s.V.row(s.F(w.face, 0)), b = s.V.row(s.F(w.face, 1)),
                           c = s.V.row(s.F(w.face, 2));
  const Eigen::RowVector3d n = (b - a).cross(c - a).normalized();
  Surface moved = s;
  for (std::size_t k = 0; k < w.vertices.size(); ++k) moved.V.row(w.vertices[k]) += 1e-9 * w.moves[k] * n;
  EXPECT_LT(diagnosed(moved).winding.min, 0);
}

TEST(Stacks, AFoldByItselfIsOneToo) {
  const Surface s = test::pressed_fold();
  const Diagnosis d = diagnosed(s);
  EXPECT_EQ(d.verdict, Verdict::infeasible) << d.message;
  const auto found = find_stack_certificate(s, *d.bvh, d.pairs, {});
  ASSERT_TRUE(found.ok());
  EXPECT_TRUE(found.value());
}

// Faces that may well lie on each other: solids side by side, one inside another, one twice.
TEST(Stacks, SolidsThatTouchOrOverlap) {
  const auto moved = [](const Surface& s, double x, double y, double z) {
    return test::transformed(s, Eigen::Matrix3d::Identity(), {x, y, z});
  };
  const Surface box = test::box(3);
  for (const Surface& other :
       {box, moved(box, 1, 0, 0), moved(box, 1, 0.25, 0.5), moved(box, 0.5, 0, 0), moved(box, 0.5, 0.25, 0),
        test::transformed(box, 0.5 * Eigen::Matrix3d::Identity(), {0, 0, 0.25})}) {
    const Diagnosis d = diagnosed(test::joined(box, other));
    EXPECT_FALSE(d.certificate);
    EXPECT_EQ(d.verdict, Verdict::feasible) << d.message;
  }
}

}  // namespace
}  // namespace overtet
