#include "src/cdt/tetgen.h"

#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>
#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <thread>

#include "tests/support/tet_shapes.h"

namespace overtet {
namespace {

Plc unmarked(const Surface& s) { return {s.V, s.F, {}, {}}; }

// Rounded once: differences of doubles of like size are exact in 113 bits.
double volume6(const VertexMatrix& V, const TetMatrix& T, Eigen::Index t) {
  __float128 e[3][3];
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      e[i][k] = static_cast<__float128>(V(T(t, i + 1), k)) - static_cast<__float128>(V(T(t, 0), k));
  return static_cast<double>(e[0][0] * (e[1][1] * e[2][2] - e[1][2] * e[2][1]) -
                             e[0][1] * (e[1][0] * e[2][2] - e[1][2] * e[2][0]) +
                             e[0][2] * (e[1][0] * e[2][1] - e[1][1] * e[2][0]));
}

void expect_positive(const TetgenResult& r, const Plc& plc) {
  ASSERT_GE(r.V.rows(), plc.V.rows());
  EXPECT_EQ(0, std::memcmp(r.V.data(), plc.V.data(), sizeof(double) * plc.V.size()));
  for (Eigen::Index t = 0; t < r.T.rows(); ++t) ASSERT_GT(volume6(r.V, r.T, t), 0) << "tet " << t;
  // Neighbours against brute force.
  std::map<std::array<Index, 3>, std::vector<Index>> faces;
  const auto key = [&](Eigen::Index t, int k) {
    std::array<Index, 3> f{r.T(t, (k + 1) % 4), r.T(t, (k + 2) % 4), r.T(t, (k + 3) % 4)};
    std::sort(f.begin(), f.end());
    return f;
  };
  for (Eigen::Index t = 0; t < r.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) faces[key(t, k)].push_back(static_cast<Index>(t));
  for (Eigen::Index t = 0; t < r.T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      const auto& owners = faces[key(t, k)];
      const Index want = owners.size() == 1 ? -1 : (owners[0] == t ? owners[1] : owners[0]);
      ASSERT_EQ(want, r.neighbours(t, k));
    }
}

std::vector<pid_t> children_of(pid_t parent) {
  std::vector<pid_t> list;
  for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
    std::ifstream stat(entry.path() / "stat");
    std::string pid, name, state, of;
    if (stat >> pid >> name >> state >> of && of == std::to_string(parent)) list.push_back(std::stoi(pid));
  }
  return list;
}

TEST(Tetgen, BoxAndSphereAreFilledWithPositiveTets) {
  for (const Surface& s :
       {test::box_surface(1, 2, 3), test::sphere_surface(2), test::torus_surface(24, 12, 2, .7)})
    for (const bool quality : {false, true}) {
      TetgenOptions options;
      options.quality = quality;
      const Plc plc = unmarked(s);
      const auto r = tetrahedralize(plc, options, {});
      ASSERT_TRUE(r.ok()) << r.error().message;
      expect_positive(r.value(), plc);
      EXPECT_EQ(s.F.rows(), r.value().facets.rows());
      double sum = 0, surface = 0;
      for (Eigen::Index t = 0; t < r.value().T.rows(); ++t) sum += volume6(r.value().V, r.value().T, t);
      for (Eigen::Index f = 0; f < s.F.rows(); ++f) {
        const Eigen::Vector3d a = s.V.row(s.F(f, 0)), b = s.V.row(s.F(f, 1)), c = s.V.row(s.F(f, 2));
        surface += a.dot(b.cross(c));
      }
      EXPECT_NEAR(surface, sum, 1e-9 * surface);
      EXPECT_GT(r.value().peak_rss_bytes, 0u);
    }
}

TEST(Tetgen, ScaleByPowersOfTwoChangesNoBit) {
  const Surface s = test::torus_surface(20, 10, 2, .7);
  const auto one = tetrahedralize(unmarked(s), {}, {});
  ASSERT_TRUE(one.ok());
  for (const int e : {-700, -30, 11, 600}) {
    Plc plc = unmarked(s);
    plc.V = plc.V.unaryExpr([e](double x) { return std::ldexp(x, e); });
    const auto other = tetrahedralize(plc, {}, {});
    ASSERT_TRUE(other.ok()) << other.error().message;
    EXPECT_EQ(one.value().T, other.value().T);
    EXPECT_EQ(one.value().V,
              VertexMatrix(other.value().V.unaryExpr([e](double x) { return std::ldexp(x, -e); })));
  }
}

TEST(Tetgen, InternalFacetsMarkersHolesAndHull) {
  // A small box inside a big one.
  const Surface big = test::box_surface(4, 4, 4);
  Surface small = test::box_surface(1, 1, 1);
  Plc plc;
  plc.V.resize(16, 3);
  plc.V << big.V, (small.V.array() + 1.5).matrix();
  plc.F.resize(24, 3);
  plc.F << big.F, (small.F.array() + 8).matrix();
  for (int f = 0; f < 24; ++f) plc.markers.push_back(f < 12 ? 7 : 9);
  TetgenOptions options;
  auto r = tetrahedralize(plc, options, {});
  ASSERT_TRUE(r.ok()) << r.error().message;
  expect_positive(r.value(), plc);
  ASSERT_EQ(24, r.value().facets.rows());
  for (int f = 0; f < 24; ++f) {
    EXPECT_EQ(r.value().facet_markers[f], r.value().facet_sources[f] < 12 ? 7 : 9);
    std::set<Index> want, got;
    for (int k = 0; k < 3; ++k) {
      want.insert(plc.F(r.value().facet_sources[f], k));
      got.insert(r.value().facets(f, k));
    }
    EXPECT_EQ(want, got);
  }
  const auto volume = [](const TetgenResult& x) {
    double sum = 0;
    for (Eigen::Index t = 0; t < x.T.rows(); ++t) sum += volume6(x.V, x.T, t) / 6;
    return sum;
  };
  EXPECT_NEAR(64, volume(r.value()), 1e-9);
  plc.holes.resize(1, 3);
  plc.holes << 2, 2, 2;
  r = tetrahedralize(plc, options, {});
  ASSERT_TRUE(r.ok());
  EXPECT_NEAR(63, volume(r.value()), 1e-9);

  options.fill_convex_hull = true;
  const Surface torus = test::torus_surface(24, 12, 2, .7);
  r = tetrahedralize(unmarked(torus), options, {});
  ASSERT_TRUE(r.ok()) << r.error().message;
  expect_positive(r.value(), unmarked(torus));
  EXPECT_GT(volume(r.value()), 1.2 * 2 * M_PI * M_PI * 2 * .7 * .7);
}

TEST(Tetgen, BadInputIsAnErrorThatNamesTheElement) {
  const auto code = [](const Plc& plc) {
    const auto r = tetrahedralize(plc, {}, {});
    return r.ok() ? std::string("ok")
                  : std::to_string(static_cast<int>(r.error().code)) + " " + r.error().message;
  };
  Plc plc = unmarked(test::sphere_surface(1));
  Plc bad = plc;
  bad.V(3, 1) = std::nan("");
  EXPECT_EQ('3', code(bad)[0]) << code(bad);
  bad = plc;
  bad.F(5, 2) = 1000;
  EXPECT_NE(std::string::npos, code(bad).find("Facet 5")) << code(bad);
  bad = plc;
  bad.F(5, 2) = bad.F(5, 1);
  EXPECT_NE(std::string::npos, code(bad).find("Facet 5")) << code(bad);
  bad = plc;
  bad.V.row(7) = bad.V.row(30);
  EXPECT_NE(std::string::npos, code(bad).find("7 and 30")) << code(bad);
  EXPECT_EQ('3', code({})[0]);
  TetgenOptions options;
  options.radius_edge = 0.5;
  EXPECT_FALSE(options.validate().ok());
}

// What kills the library must only kill the child: every answer here is an error, and no child stays.
TEST(Tetgen, CrashesStayInTheChild) {
  Plc open = unmarked(test::sphere_surface(1));
  open.F.conservativeResize(open.F.rows() - 1, 3);
  Plc crossing = unmarked(test::box_surface(1, 1, 1));
  crossing.V.conservativeResize(16, 3);
  crossing.V.bottomRows(8) = (crossing.V.topRows(8).array() * 0.9 + 0.3).matrix();
  crossing.F.conservativeResize(24, 3);
  crossing.F.bottomRows(12) = (crossing.F.topRows(12).array() + 8).matrix();
  Plc twice = unmarked(test::sphere_surface(1));
  const auto F = twice.F;
  twice.F.resize(2 * F.rows(), 3);
  twice.F << F, F;
  Plc flat = unmarked(test::sphere_surface(1));
  flat.V.col(2).setZero();
  for (Eigen::Index i = 0; i < flat.V.rows(); ++i) flat.V(i, 0) += 1e-3 * i;
  for (const Plc& plc : {open, crossing, twice, flat}) {
    const auto r = tetrahedralize(plc, {}, {});
    ASSERT_FALSE(r.ok());
    EXPECT_EQ(ErrorCode::unsolved, r.error().code) << r.error().message;
    EXPECT_FALSE(r.error().message.empty());
  }
  EXPECT_EQ(0, static_cast<int>(children_of(getpid()).size()));
}

TEST(Tetgen, StopsForCancelDeadlineAndMemory) {
  const Surface s = test::sphere_surface(6);
  TetgenOptions options;
  options.radius_edge = 1.1;
  RunContext context;
  context.deadline = RunContext::Clock::now();  // over by the time anybody looks
  auto r = tetrahedralize(unmarked(s), options, context);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(ErrorCode::limit, r.error().code);

  std::atomic<bool> cancel = false;
  context = {};
  context.cancel = &cancel;
  // In the middle of the work: when the child is there (or has been: `over`).
  std::atomic<bool> over = false;
  std::thread canceller([&] {
    while (!over && children_of(getpid()).empty()) std::this_thread::yield();
    cancel = true;
  });
  r = tetrahedralize(unmarked(s), options, context);
  over = true;
  canceller.join();
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(ErrorCode::interrupted, r.error().code);

  context = {};
  context.memory_limit_bytes = 1;
  r = tetrahedralize(unmarked(s), options, context);
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(ErrorCode::limit, r.error().code) << r.error().message;
  EXPECT_EQ(0, static_cast<int>(children_of(getpid()).size()));
}

// A killed program leaves no TetGen running behind it.
TEST(Tetgen, TheChildDiesWithItsParent) {
  const Plc plc = unmarked(test::sphere_surface(6));
  const pid_t middle = fork();
  ASSERT_GE(middle, 0);
  if (middle == 0) {
    TetgenOptions options;
    options.radius_edge = 1.1;
    (void)tetrahedralize(plc, options, {}).ok();
    _exit(0);
  }
  std::vector<pid_t> grandchildren;
  for (int wait = 0; wait < 500 && grandchildren.empty(); ++wait) {
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    grandchildren = children_of(middle);
  }
  ASSERT_EQ(1u, grandchildren.size());
  std::this_thread::sleep_for(std::chrono::milliseconds(20));
  kill(middle, SIGKILL);
  waitpid(middle, nullptr, 0);
  bool gone = false;
  for (int wait = 0; wait < 500 && !gone; ++wait) {
    std::ifstream stat("/proc/" + std::to_string(grandchildren[0]) + "/stat");
    std::string pid, name, state;
    gone = !(stat >> pid >> name >> state) || state == "Z";
    if (!gone) std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
  EXPECT_TRUE(gone);
}

// Its work is counted, so that where it is given up does not depend on the machine.
TEST(Tetgen, WorkIsTheSameEveryTime) {
  const Plc plc = unmarked(test::sphere_surface(2));
  const auto first = tetrahedralize(plc, {}, {}), again = tetrahedralize(plc, {}, {});
  ASSERT_TRUE(first.ok() && again.ok());
  EXPECT_GT(first.value().predicates, plc.F.rows());
  EXPECT_EQ(first.value().predicates, again.value().predicates);
}

TEST(Tetgen, WorkWithoutEndIsGivenUp) {
  TetgenOptions options;
  options.patience = 1e-7;
  const auto r = tetrahedralize(unmarked(test::sphere_surface(2)), options, {});
  ASSERT_FALSE(r.ok());
  EXPECT_EQ(ErrorCode::unsolved, r.error().code);
  EXPECT_NE(std::string::npos, r.error().message.find("did not end"));
}

TEST(Tetgen, SeveralCallsAtOnce) {
  std::vector<std::thread> threads;
  std::array<TetMatrix, 4> T;
  for (int i = 0; i < 4; ++i)
    threads.emplace_back([i, &T] {
      const auto r = tetrahedralize(unmarked(test::sphere_surface(1 + i % 2)), {}, {});
      if (r.ok()) T[i] = r.value().T;
    });
  for (auto& t : threads) t.join();
  EXPECT_GT(T[0].rows(), 0);
  EXPECT_EQ(T[0], T[2]);
  EXPECT_EQ(T[1], T[3]);
}

}  // namespace
}  // namespace overtet
