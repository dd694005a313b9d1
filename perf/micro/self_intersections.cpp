// All pairs of faces that intersect: this program's kernel beside CGAL's boxes with CGAL's exact test, and
// beside a collision query of an Embree tree built anew with this program's exact test.
//
// Counters: pairs (the same number for everybody, or the benchmark fails) and candidates (pairs of boxes that
// were decided exactly). Arguments of the overtet benchmarks: threads.
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/box_intersection_d.h>

#include <algorithm>
#include <atomic>
#include <memory>

#include "kernels/bvh/self_intersections.h"
#include "kernels/parallel/parallel.h"
#include "kernels/predicates/predicates.h"
#include "perf/micro/models.h"

#if defined(OVERTET_PERF_EMBREE)
#include <embree3/rtcore.h>
#endif

namespace {

using namespace overtet;
using perf::count;

// ------------------------------------------------------------------------------------------ this program

void build_and_search(benchmark::State& state, const Surface& s) {
  const ScopedThreads threads(static_cast<int>(state.range(0)));
  std::size_t pairs = 0;
  for (auto _ : state) pairs = find_self_intersections(s.V, s.F).size();
  count(state, "pairs", static_cast<double>(pairs));
  count(state, "faces", static_cast<double>(s.F.rows()));
}

void build(benchmark::State& state, const Surface& s) {
  const ScopedThreads threads(static_cast<int>(state.range(0)));
  TriangleBvh bvh;
  for (auto _ : state) bvh.build(s.V, s.F);
  count(state, "faces", static_cast<double>(s.F.rows()));
}

void refit(benchmark::State& state, const Surface& s) {
  const ScopedThreads threads(static_cast<int>(state.range(0)));
  TriangleBvh bvh(s.V, s.F);
  for (auto _ : state) bvh.refit(s.V, s.F);
}

void search(benchmark::State& state, const Surface& s) {
  const ScopedThreads threads(static_cast<int>(state.range(0)));
  TriangleBvh bvh(s.V, s.F);
  std::size_t pairs = 0;
  for (auto _ : state) pairs = find_self_intersections(s.V, s.F, bvh).size();
  count(state, "pairs", static_cast<double>(pairs));
}

// The same walk without the exact test: what the boxes alone cost.
void candidates(benchmark::State& state, const Surface& s) {
  const ScopedThreads threads(static_cast<int>(state.range(0)));
  TriangleBvh bvh(s.V, s.F);
  std::atomic<std::int64_t> total = 0;
  for (auto _ : state) {
    total = 0;
    bvh.collect_self_pairs<char>([&](Index, Index, std::vector<char>& out) {
      if (out.empty()) out.push_back(0);
      total.fetch_add(1, std::memory_order_relaxed);
    });
  }
  count(state, "candidates", static_cast<double>(total));
}

// ---------------------------------------------------------------------------------------------- CGAL

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using FaceBox = CGAL::Box_intersection_d::Box_with_info_d<double, 3, Index>;

// What CGAL::Polygon_mesh_processing::self_intersections does with a pair of boxes.
bool cgal_intersect(const std::vector<Kernel::Point_3>& points, const TriangleMatrix& F, Index f, Index g) {
  const auto p = [&](Index face, int k) -> const Kernel::Point_3& { return points[F(face, k)]; };
  int shared = 0, at_f[3], at_g[3];
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (F(f, i) == F(g, j)) at_f[shared] = i, at_g[shared++] = j;
  if (shared == 3) return true;
  if (shared == 2) {
    const auto &a = p(f, at_f[0]), &b = p(f, at_f[1]);
    const auto &c = p(f, 3 - at_f[0] - at_f[1]), &d = p(g, 3 - at_g[0] - at_g[1]);
    return CGAL::coplanar(a, b, c, d) && CGAL::coplanar_orientation(a, b, c, d) == CGAL::POSITIVE;
  }
  if (shared == 1) {
    const int i = at_f[0], j = at_g[0];
    const Kernel::Triangle_3 t1(p(f, i), p(f, (i + 1) % 3), p(f, (i + 2) % 3));
    const Kernel::Triangle_3 t2(p(g, j), p(g, (j + 1) % 3), p(g, (j + 2) % 3));
    return CGAL::do_intersect(t1, Kernel::Segment_3(t2[1], t2[2])) ||
           CGAL::do_intersect(t2, Kernel::Segment_3(t1[1], t1[2]));
  }
  return CGAL::do_intersect(Kernel::Triangle_3(p(f, 0), p(f, 1), p(f, 2)),
                            Kernel::Triangle_3(p(g, 0), p(g, 1), p(g, 2)));
}

std::vector<FacePair> cgal_pairs(const Surface& s, std::int64_t& candidates) {
  std::vector<Kernel::Point_3> points;
  points.reserve(s.V.rows());
  for (Index v = 0; v < s.V.rows(); ++v) points.emplace_back(s.V(v, 0), s.V(v, 1), s.V(v, 2));
  std::vector<FaceBox> boxes;
  boxes.reserve(s.F.rows());
  for (Index f = 0; f < s.F.rows(); ++f)
    boxes.emplace_back(points[s.F(f, 0)].bbox() + points[s.F(f, 1)].bbox() + points[s.F(f, 2)].bbox(), f);
  std::vector<const FaceBox*> pointers;
  pointers.reserve(boxes.size());
  for (const FaceBox& b : boxes) pointers.push_back(&b);
  std::vector<FacePair> pairs;
  candidates = 0;
  CGAL::box_self_intersection_d(
      pointers.begin(), pointers.end(),
      [&](const FaceBox* a, const FaceBox* b) {
        ++candidates;
        const Index f = std::min(a->info(), b->info()), g = std::max(a->info(), b->info());
        if (cgal_intersect(points, s.F, f, g)) pairs.emplace_back(f, g);
      },
      std::ptrdiff_t{2000});  // the cutoff that Polygon_mesh_processing uses
  std::sort(pairs.begin(), pairs.end());
  return pairs;
}

void cgal(benchmark::State& state, const Surface& s) {
  std::vector<FacePair> pairs;
  std::int64_t candidates = 0;
  for (auto _ : state) pairs = cgal_pairs(s, candidates);
  count(state, "pairs", static_cast<double>(pairs.size()));
  count(state, "candidates", static_cast<double>(candidates));
  if (pairs != find_self_intersections(s.V, s.F)) state.SkipWithError("CGAL finds other pairs");
}

// ---------------------------------------------------------------------------------------------- Embree

#if defined(OVERTET_PERF_EMBREE)

// Faces as user geometry, because rtcCollide takes nothing else; built anew every time. One thread.
struct EmbreeSearch {
  explicit EmbreeSearch(const Surface& surface) : s(surface) {}

  const Surface& s;
  RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
  std::vector<FacePair> pairs;
  std::int64_t candidates = 0;

  ~EmbreeSearch() { rtcReleaseDevice(device); }

  static void bounds(const RTCBoundsFunctionArguments* a) {
    const Surface& s = *static_cast<const Surface*>(a->geometryUserPtr);
    float lo[3], hi[3];
    for (int k = 0; k < 3; ++k) {
      double low = HUGE_VAL, high = -HUGE_VAL;
      for (int c = 0; c < 3; ++c) {
        const double x = s.V(s.F(a->primID, c), k);
        low = std::min(low, x);
        high = std::max(high, x);
      }
      lo[k] = std::nextafterf(static_cast<float>(low), -HUGE_VALF);
      hi[k] = std::nextafterf(static_cast<float>(high), HUGE_VALF);
    }
    *a->bounds_o = {lo[0], lo[1], lo[2], 0, hi[0], hi[1], hi[2], 0};
  }

  static void collide(void* self, RTCCollision* found, unsigned int n) {
    EmbreeSearch& e = *static_cast<EmbreeSearch*>(self);
    for (unsigned int i = 0; i < n; ++i) {
      const Index f = static_cast<Index>(found[i].primID0), g = static_cast<Index>(found[i].primID1);
      if (f >= g) continue;  // every pair comes twice
      ++e.candidates;
      if (faces_intersect(e.s.V.data(), e.s.F.data() + 3 * std::int64_t{f},
                          e.s.F.data() + 3 * std::int64_t{g}))
        e.pairs.emplace_back(f, g);
    }
  }

  void run() {
    pairs.clear();
    candidates = 0;
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_USER);
    rtcSetGeometryUserPrimitiveCount(geometry, static_cast<unsigned>(s.F.rows()));
    rtcSetGeometryUserData(geometry, const_cast<Surface*>(&s));
    rtcSetGeometryBoundsFunction(geometry, bounds, nullptr);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene);
    rtcCollide(scene, scene, collide, this);
    rtcReleaseScene(scene);
    std::sort(pairs.begin(), pairs.end());
  }
};

void embree(benchmark::State& state, const Surface& s) {
  const ScopedThreads one(1);
  EmbreeSearch search(s);
  for (auto _ : state) search.run();
  count(state, "pairs", static_cast<double>(search.pairs.size()));
  count(state, "candidates", static_cast<double>(search.candidates));
  if (search.pairs != find_self_intersections(s.V, s.F)) state.SkipWithError("Embree finds other pairs");
}

#endif

void register_all() {
  for (auto* b : perf::for_each_model("intersections/overtet", build_and_search))
    b->Arg(1)->Arg(2)->UseRealTime();
  perf::for_each_model("intersections/cgal", cgal);
#if defined(OVERTET_PERF_EMBREE)
  for (auto* b : perf::for_each_model("intersections/embree_rebuild", embree)) b->UseRealTime();
#endif
  for (auto* b : perf::for_each_model("bvh/build", build)) b->Arg(1)->Arg(2)->UseRealTime();
  for (auto* b : perf::for_each_model("bvh/refit", refit)) b->Arg(1)->Arg(2)->UseRealTime();
  for (auto* b : perf::for_each_model("bvh/search", search)) b->Arg(1)->Arg(2)->UseRealTime();
  for (auto* b : perf::for_each_model("bvh/candidates", candidates)) b->Arg(1)->UseRealTime();
}

}  // namespace

int main(int argc, char** argv) { return overtet::perf::run(argc, argv, register_all); }
