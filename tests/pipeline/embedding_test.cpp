// Embeddings: no crossings, decided on the doubles, the same faces, nearly the same lengths.
#include <gtest/gtest.h>

#include <cmath>
#include <set>
#include <string>

#include "kernels/bvh/self_intersections.h"
#include "kernels/core/box.h"
#include "src/mesh/topology.h"
#include "src/pipeline/embedding.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

struct Made {
  Result<Embedding> embedding = Error{};
  Report report;
};

Made made(const Surface& s, int threads = 2) {
  Made m;
  RunContext context;
  context.threads = threads;
  m.embedding = embed_surface(s, {}, context, m.report);
  return m;
}

void expect_embedded(const Surface& s, const Made& m, double least_area) {
  ASSERT_TRUE(m.embedding.ok()) << m.embedding.error().message;
  const Embedding& e = m.embedding.value();
  EXPECT_EQ(e.surface.F, s.F);
  EXPECT_TRUE(e.surface.V.allFinite());
  EXPECT_TRUE(find_self_intersections(e.surface.V, e.surface.F).empty());
  const std::set<Index> moved(e.moved.begin(), e.moved.end());
  for (Index v = 0; v < s.V.rows(); ++v)
    EXPECT_EQ(e.surface.V.row(v) != s.V.row(v), moved.count(v) == 1) << v;
  const EmbeddingQuality& q = e.quality;
  for (const RatioRange* r : {&q.area, &q.edge}) {
    EXPECT_LE(r->least, r->p01);
    EXPECT_LE(r->p01, r->p50);
    EXPECT_LE(r->p50, r->p99);
    EXPECT_LE(r->p99, r->most);
  }
  EXPECT_GT(q.area.p01, least_area);
  EXPECT_LT(q.area.p99, 1 / least_area);
  EXPECT_FALSE(q.collapsed);
  EXPECT_EQ(m.report.status, RunStatus::embedded);
  ASSERT_TRUE(m.report.embedding.has_value());
  EXPECT_EQ(m.report.embedding->area.p01, q.area.p01);
  EXPECT_EQ(static_cast<std::size_t>(m.report.moved_vertices), e.moved.size());
  EXPECT_EQ(m.report.moved_ids.size(), e.moved.size());
}

TEST(Embedding, SurfacesThatCrossThemselves) {
  for (const Surface& s : {test::curled_worm(400, 12), test::elbow(150, 16)})
    expect_embedded(s, made(s), 0.3);
}

TEST(Embedding, OfAnyGenus) {
  const Surface s = test::bent_slab(3, 400, 2);
  expect_embedded(s, made(s), 0.3);
  EXPECT_EQ(made(s).report.input.genus, std::vector<std::int64_t>{3});
}

// It asks for no inside: one that no tets fill has an embedding, too.
TEST(Embedding, OfASurfaceThatHasNoMesh) {
  const Surface s = test::saucer(2);
  const Made m = made(s);
  ASSERT_TRUE(m.embedding.ok()) << m.embedding.error().message;
  EXPECT_TRUE(find_self_intersections(m.embedding.value().surface.V, s.F).empty());
}

TEST(Embedding, NothingMovesWhereNothingCrosses) {
  for (const Surface& s : {test::sphere_with_cavity(1), test::torus(12, 8)}) {
    const Made m = made(s);
    expect_embedded(s, m, 0.99);
    EXPECT_TRUE(m.embedding.value().moved.empty());
    EXPECT_EQ(m.embedding.value().surface.V, s.V);
    EXPECT_EQ(m.embedding.value().quality.edge.least, 1);
  }
}

// Components that cross each other: all but the largest are moved as they are, to where they cross nothing.
TEST(Embedding, ComponentsAreLaidAside) {
  const Surface two = test::joined(test::sphere(1), test::sphere(1, 0.9, {0.7, 0, 0}));
  const Surface more =
      test::joined(test::joined(two, test::sphere(1, 0.5, {0.3, 0.9, 0})), test::curled_worm(400, 10));
  for (const Surface& s : {two, more}) {
    const Made m = made(s);
    expect_embedded(s, m, 0.3);
    const Embedding& e = m.embedding.value();
    const SurfaceTopology topology = require_topology(s).value();
    ASSERT_GE(e.laid_aside.size(), 1u);
    EXPECT_LT(e.laid_aside.size(), topology.components.size());
    EXPECT_EQ(static_cast<std::size_t>(m.report.laid_aside), e.laid_aside.size());
    for (Index f = 0; f < two.F.rows(); ++f)  // balls stay balls
      for (int k = 0; k < 3; ++k) {
        const Index a = s.F(f, k), b = s.F(f, (k + 1) % 3);
        EXPECT_NEAR((e.surface.V.row(a) - e.surface.V.row(b)).norm(), (s.V.row(a) - s.V.row(b)).norm(),
                    1e-12 * diagonal_of(e.surface.V));
      }
  }
}

TEST(Embedding, SameBytesOnAnyNumberOfThreads) {
  const Surface s = test::elbow(150, 16);
  const VertexMatrix one = made(s, 1).embedding.value().surface.V;
  for (const int threads : {2, 5}) EXPECT_EQ(made(s, threads).embedding.value().surface.V, one);
}

// Lengths are those of the input, in whatever unit, also of a model that is much longer than thick.
TEST(Embedding, ScalesWithTheSurface) {
  Surface s = test::curled_worm(400, 10);
  const VertexMatrix U = made(s).embedding.value().surface.V;
  for (const double factor : {0x1p-300, 0x1p40}) {
    Surface other = s;
    other.V *= factor;
    EXPECT_EQ(made(other).embedding.value().surface.V, VertexMatrix(U * factor));
  }
}

TEST(Embedding, WhatHasNoShapeIsRefused) {
  Surface open = test::sphere(1);
  open.F.conservativeResize(open.F.rows() - 1, 3);
  Made m = made(open);
  EXPECT_EQ(m.embedding.error().code, ErrorCode::bad_input);
  EXPECT_EQ(m.report.status, RunStatus::bad_input);
  Surface flat = test::box(2);
  flat.V.row(flat.F(3, 0)) = (flat.V.row(flat.F(3, 1)) + flat.V.row(flat.F(3, 2))) / 2;
  m = made(flat);
  EXPECT_EQ(m.embedding.error().code, ErrorCode::bad_input);
  EXPECT_GE(m.embedding.error().face, 0);
  Report report;
  EXPECT_EQ(embed_surface(test::sphere(1), {.gap = 0}, {}, report).error().code, ErrorCode::usage);
  RunContext late;
  late.deadline = RunContext::Clock::now() - std::chrono::seconds(1);
  EXPECT_EQ(embed_surface(test::curled_worm(400, 10), {}, late, report).error().code, ErrorCode::limit);
}

}  // namespace
}  // namespace overtet
