// The witnesses that the program finds, checked by a script that shares no code with it; and wrong ones.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <optional>
#include <string>
#include <vector>

#include "src/certificates/diagnose.h"
#include "src/covering/gluing.h"
#include "tests/support/files.h"
#include "tests/support/models.h"
#include "tests/support/noise.h"

namespace overtet {
namespace {

// One line a vertex, then one a face; the formats take three numbers each, faces count from `first`.
std::string rows_text(const Surface& s, const char* vertex, const char* face, int first) {
  std::string out;
  char line[128];
  for (Index v = 0; v < s.V.rows(); ++v) {
    std::snprintf(line, sizeof line, vertex, s.V(v, 0), s.V(v, 1), s.V(v, 2));
    out += line;
  }
  for (Index f = 0; f < s.F.rows(); ++f) {
    std::snprintf(line, sizeof line, face, s.F(f, 0) + first, s.F(f, 1) + first, s.F(f, 2) + first);
    out += line;
  }
  return out;
}

std::string off_text(const Surface& s) {
  return "OFF\n" + std::to_string(s.V.rows()) + " " + std::to_string(s.F.rows()) + " 0\n" +
         rows_text(s, "%.17g %.17g %.17g\n", "3 %d %d %d\n", 0);
}

std::string obj_text(const Surface& s) {
  return "# a comment\n" + rows_text(s, "v %.17g %.17g %.17g\n", "f %d %d//7 %d\n", 1);
}

std::string ply_text(const Surface& s) {
  return "ply\nformat ascii 1.0\ncomment made for a test\nelement vertex " + std::to_string(s.V.rows()) +
         "\nproperty double x\nproperty double y\nproperty double z\nproperty uchar red\nelement face " +
         std::to_string(s.F.rows()) + "\nproperty list uchar int vertex_indices\nend_header\n" +
         rows_text(s, "%.17g %.17g %.17g 255\n", "3 %d %d %d\n", 0);
}

template <class T>
void put(std::string& out, T x, bool big) {
  char bytes[sizeof x];
  std::memcpy(bytes, &x, sizeof x);
  if (big) std::reverse(bytes, bytes + sizeof x);  // made on a little-endian machine
  out.append(bytes, sizeof x);
}

std::string binary_ply(const Surface& s, bool big) {
  std::string out = std::string("ply\nformat binary_") + (big ? "big" : "little") +
                    "_endian 1.0\nelement vertex " + std::to_string(s.V.rows()) +
                    "\nproperty double x\nproperty double y\nproperty double z\nelement face " +
                    std::to_string(s.F.rows()) + "\nproperty list uchar int vertex_index\nend_header\n";
  for (Index v = 0; v < s.V.rows(); ++v)
    for (int k = 0; k < 3; ++k) put(out, s.V(v, k), big);
  for (Index f = 0; f < s.F.rows(); ++f) {
    out += '\3';
    for (int k = 0; k < 3; ++k) put(out, s.F(f, k), big);
  }
  return out;
}

std::string stl_text(const Surface& s) {
  std::string out = "solid made for a test\n";
  char line[128];
  for (Index f = 0; f < s.F.rows(); ++f) {
    out += "facet normal 0 0 0\nouter loop\n";
    for (int k = 0; k < 3; ++k) {
      const auto p = s.V.row(s.F(f, k));
      std::snprintf(line, sizeof line, "vertex %.17g %.17g %.17g\n", p[0], p[1], p[2]);
      out += line;
    }
    out += "endloop\nendfacet\n";
  }
  return out + "endsolid\n";
}

std::string binary_stl(const Surface& s) {
  std::string out(80, ' ');
  put(out, static_cast<std::uint32_t>(s.F.rows()), false);
  for (Index f = 0; f < s.F.rows(); ++f) {
    for (int k = 0; k < 3; ++k) put(out, 0.0f, false);
    for (int i = 0; i < 9; ++i) put(out, static_cast<float>(s.V(s.F(f, i / 3), i % 3)), false);
    out.append(2, '\0');
  }
  return out;
}

class CheckWitness : public testing::Test {
 protected:
  // The script's answer; `said` is what it printed.
  int answer(const std::string& surface_text, const std::string& report, const char* name = "s.off") {
    test::write_text(folder_.file(name), surface_text);
    test::write_text(folder_.file("r.json"), report);
    const auto r =
        test::shell(OVERTET_CHECK_WITNESS " '" + folder_.file(name) + "' '" + folder_.file("r.json") + "'");
    said_ = r.out + r.err;
    return r.exit_code;
  }
  int answer(const Surface& s, const std::string& witness) {
    return answer(off_text(s), "{\"status\": \"infeasible\", \"witness\": " + witness + "}");
  }

  // The script confirms the rule at the vertices given, and at no other hinge; of those `most` are tried. How
  // many were.
  int confirms_no_others(const Surface& s, const Diagnosis& d, const char* rule,
                         const std::vector<Index>& vertices, int most);

  test::TemporaryFolder folder_;
  std::string said_;
};

Diagnosis diagnosed(const Surface& s) {
  Result<Diagnosis> d = diagnose(s, {}, {});
  EXPECT_TRUE(d.ok());
  return std::move(d).value();
}

std::string vertex_witness(Index vertex, int b0) {
  return "{\"vertex\": " + std::to_string(vertex) + ", \"B0\": " + std::to_string(b0) + "}";
}

template <class Values>
std::string listed(const Values& values) {
  std::string out;
  for (const auto& v : values) out += (out.empty() ? "[" : ", ") + std::to_string(v);
  return out + "]";
}

std::string unpaired_witness(const std::vector<Index>& vertices, const std::vector<int>& b0) {
  return "{\"rule\": \"unpaired\", \"vertices\": " + listed(vertices) + ", \"B0\": " + listed(b0) + "}";
}

std::string apart_witness(const SeparatedCertificate& c) {
  std::string text = unpaired_witness(c.vertices, c.B0);
  text.back() = ',';
  return text + " \"apart\": " + listed(c.direction) + "}";
}

std::string shared_witness(const SharedPoint& p) {
  return "{\"rule\": \"shared\", \"vertices\": " + listed(p.vertices) + ", \"layers\": " + listed(p.layers) +
         ", \"room\": " + std::to_string(p.room) + "}";
}

std::optional<int> b0_of(const Diagnosis& d, Index vertex) {
  for (const Hinge& h : d.hinges)
    if (h.vertex == vertex) return h.B0;
  return std::nullopt;
}

std::string hinge_witness(const char* rule, Index vertex, int b0) {
  return "{\"rule\": \"" + std::string(rule) + "\", \"vertices\": [" + std::to_string(vertex) +
         "], \"B0\": [" + std::to_string(b0) + "]}";
}

int CheckWitness::confirms_no_others(const Surface& s, const Diagnosis& d, const char* rule,
                                     const std::vector<Index>& vertices, int most) {
  for (const Index v : vertices)
    EXPECT_EQ(answer(s, hinge_witness(rule, v, b0_of(d, v).value())), 0) << said_;
  int others = 0;
  for (const Hinge& h : d.hinges) {
    if (!h.B0 || others == most || std::count(vertices.begin(), vertices.end(), h.vertex)) continue;
    ++others;
    EXPECT_EQ(answer(s, hinge_witness(rule, h.vertex, *h.B0)), 1) << said_;
  }
  return others;
}

TEST_F(CheckWitness, PointsOfNegativeWinding) {
  const Surface models[] = {test::saucer(2), test::flipped(test::sphere(1)),
                            test::noisy(test::sphere(1), 4, 1.2)};
  for (const Surface& s : models) {
    const Diagnosis d = diagnosed(s);
    ASSERT_TRUE(d.winding.witness.has_value());
    const auto& w = *d.winding.witness;
    const auto witness = [&](int winding) {
      return "{\"point\": [\"" + w.exact[0] + "\", \"" + w.exact[1] + "\", \"" + w.exact[2] +
             "\"], \"winding\": " + std::to_string(winding) + "}";
    };
    EXPECT_EQ(answer(s, witness(w.winding)), 0) << said_;
    EXPECT_EQ(answer(s, witness(w.winding - 1)), 1) << said_;
    EXPECT_EQ(answer(s, "{\"point\": [100, 0.5, \"-1/3\"], \"winding\": -1}"), 1) << said_;
    EXPECT_EQ(answer(obj_text(s), witness(w.winding), "s.obj"), 0) << said_;
    if (&s != &models[0]) continue;
    EXPECT_EQ(answer(ply_text(s), witness(w.winding), "s.ply"), 0) << said_;
    EXPECT_EQ(answer(binary_ply(s, false), witness(w.winding), "s.ply"), 0) << said_;
    EXPECT_EQ(answer(binary_ply(s, true), witness(w.winding), "s.ply"), 0) << said_;
    EXPECT_EQ(answer(stl_text(s), witness(w.winding), "s.stl"), 0) << said_;
    EXPECT_EQ(answer(binary_stl(s), witness(w.winding), "s.stl"), 0) << said_;
  }
  // On the surface nothing is proven.
  const Surface s = test::box(1);
  EXPECT_EQ(answer(s, "{\"point\": [0.25, 0.125, 0], \"winding\": -1}"), 1) << said_;
  EXPECT_EQ(answer(s, "{\"point\": [0.5, 0.5, \"1/3\"], \"winding\": 1}"), 1) << said_;
}

// The integer of every hinge is what the program finds, whether that is a proof or not.
TEST_F(CheckWitness, IntegersOfVertices) {
  int negative = 0, positive = 0;
  for (const std::uint64_t seed : {1, 2, 3, 4}) {
    const Surface s =
        seed % 2 ? test::noisy(test::sphere(1), seed, 0.9) : test::noisy(test::elbow(150, 10), seed, 0.15);
    const Diagnosis d = diagnosed(s);
    int looked = 0;
    for (const Hinge& h : d.hinges) {
      if (!h.B0 || ++looked > 4) continue;
      const int got = answer(s, vertex_witness(h.vertex, *h.B0));
      EXPECT_EQ(got, *h.B0 < 0 ? 0 : 1) << "seed " << seed << ", B0 " << *h.B0 << ": " << said_;
      const std::string is = "B0 of vertex " + std::to_string(h.vertex) + " is " + std::to_string(*h.B0);
      EXPECT_NE(said_.find(is + "."), std::string::npos) << "seed " << seed << ": " << is << ", " << said_;
      ++(*h.B0 < 0 ? negative : positive);
      if (looked > 1) continue;
      const std::string fold = "{\"rule\": \"fold\", \"vertices\": [" + std::to_string(h.vertex) +
                               "], \"B0\": [" + std::to_string(*h.B0) + "]}";
      EXPECT_EQ(answer(s, fold), got) << said_;
      EXPECT_EQ(answer(s, vertex_witness(h.vertex, *h.B0 - 1)), 1) << said_;
    }
  }
  EXPECT_GT(negative, 0);
  EXPECT_GT(positive, 0);
  EXPECT_EQ(answer(test::sphere(1), vertex_witness(3, -1)), 1) << said_;
  EXPECT_NE(said_.find("is 0"), std::string::npos);
}

TEST_F(CheckWitness, UnpairedVertices) {
  for (int i = 0; i < 3; ++i) {
    const Surface s = test::obstructed_elbow(i);
    const Diagnosis d = diagnosed(s);
    ASSERT_EQ(d.verdict, Verdict::infeasible);
    ASSERT_FALSE(d.wound.odd_groups.empty());
    for (const auto& group : d.wound.odd_groups) {
      std::vector<int> b0;
      for (const Index v : group) b0.push_back(b0_of(d, v).value());
      EXPECT_EQ(answer(s, unpaired_witness(group, b0)), 0) << said_;
      b0[0] += 2;
      EXPECT_EQ(answer(s, unpaired_witness(group, b0)), 1) << said_;
    }
  }
}

TEST_F(CheckWitness, PairedVerticesAreNoProof) {
  const Surface s = test::elbow(150, 14);
  const Diagnosis d = diagnosed(s);
  ASSERT_EQ(d.verdict, Verdict::feasible);
  int looked = 0;
  for (const Hinge& h : d.hinges) {
    if (!h.B0 || ++looked > 4) continue;
    EXPECT_EQ(answer(s, unpaired_witness({h.vertex}, {*h.B0})), 1) << said_;
  }
  EXPECT_GT(looked, 0);
  EXPECT_EQ(answer(s, unpaired_witness({0}, {0})), 1) << said_;  // even
}

// Shaken, with a sphere around one of its hinges.
Surface pierced_at_hinge(const Surface& elbow, std::uint64_t seed) {
  const Surface s = test::noisy(elbow, seed, 0.02 + 0.03 * static_cast<double>(seed % 7));
  const std::vector<Hinge> hinges = diagnosed(s).hinges;
  const Eigen::Vector3d at = s.V.row(hinges[seed % hinges.size()].vertex);
  return test::joined(s, test::sphere(1, 0.1 + 0.1 * static_cast<double>(seed % 5),
                                      at + 0.05 * Eigen::Vector3d(0.3, 0.5, 0.7)));
}

// Elbows with a sphere around a hinge, at which B0 asks for more turns than the edges have room for, though
// nothing is wrong with its parity.
TEST_F(CheckWitness, CrowdedVertices) {
  for (const std::uint64_t seed : {271, 395}) {
    const Surface s =
        pierced_at_hinge(test::elbow(110 + 20.0 * static_cast<double>(seed % 4), 8 + seed % 3), seed);
    const Diagnosis d = diagnosed(s);
    ASSERT_EQ(d.verdict, Verdict::infeasible);
    EXPECT_TRUE(d.wound.odd_groups.empty());
    ASSERT_FALSE(d.wound.crowded.empty());
    confirms_no_others(s, d, "crowded", d.wound.crowded, 3);
    const Index v = d.wound.crowded[0];
    EXPECT_EQ(answer(s, hinge_witness("crowded", v, b0_of(d, v).value() + 2)), 1) << said_;
  }
}

// Elbows with a sphere around a hinge, whose integers are as they should be there, with room enough on the
// edges, but nothing fits into the link.
TEST_F(CheckWitness, LinksThatBoundNoDisc) {
  for (const std::uint64_t seed : {137, 353}) {
    const Surface s =
        pierced_at_hinge(test::elbow(90 + 20.0 * static_cast<double>(seed % 6), 8 + seed % 5), seed);
    const Diagnosis d = diagnosed(s);
    ASSERT_EQ(d.verdict, Verdict::infeasible);
    EXPECT_TRUE(d.wound.odd_groups.empty());
    EXPECT_TRUE(d.wound.crowded.empty());
    ASSERT_FALSE(d.wound.unfillable.empty());
    EXPECT_GT(confirms_no_others(s, d, "link", d.wound.unfillable, 6), 0);
    EXPECT_EQ(answer(s, hinge_witness("link", d.wound.unfillable[0], 0)), 1) << said_;
  }
}

std::string gluing_witness(const GluingCertificate& a, std::size_t without) {
  std::string pairs, layers, edges;
  const auto more = [](std::string& list, const std::string& x) { list += (list.empty() ? "" : ", ") + x; };
  for (std::size_t k = 0; k < a.crossings.size() + a.edges.size(); ++k) {
    if (k == without) continue;
    if (k >= a.crossings.size()) {
      more(edges, listed(a.edges[k - a.crossings.size()]));
      continue;
    }
    const auto& c = a.crossings[k];
    more(pairs, listed(c.faces));
    more(layers, std::to_string(c.layers));
  }
  return "{\"rule\": \"gluing\", \"pairs\": [" + pairs + "], \"layers\": [" + layers + "], \"edges\": [" +
         edges + "]}";
}

// Elbows with a sphere around a hinge: every hinge can be filled by itself, but not all at once.
TEST_F(CheckWitness, LayersThatCannotBeGlued) {
  for (const std::uint64_t seed : {87, 213, 403}) {  // the last one has a region with a handle
    const Surface s =
        pierced_at_hinge(test::elbow(110 + 20.0 * static_cast<double>(seed % 4), 8 + seed % 3), seed);
    const Diagnosis d = diagnosed(s);
    ASSERT_EQ(d.verdict, Verdict::feasible);
    const GluingAnswer a = check_gluing(s, d.topology.topology, *d.bvh, *d.graph, {}).value();
    ASSERT_EQ(a.verdict, GluingVerdict::conflict);
    const std::size_t n = a.conflict.crossings.size() + a.conflict.edges.size();
    EXPECT_EQ(answer(s, gluing_witness(a.conflict, n)), 0) << said_;
    EXPECT_EQ(answer(s, gluing_witness(a.conflict, seed % n)), 1) << said_;  // nothing in it is idle
  }
  const Surface s = test::elbow(150, 14);
  const Diagnosis d = diagnosed(s);
  GluingCertificate all;  // says much, and proves nothing
  for (const auto& pair : d.pairs)
    for (const int layers : {0, 1}) all.crossings.push_back({{pair.first, pair.second}, layers, {}});
  EXPECT_EQ(answer(s, gluing_witness(all, all.crossings.size())), 1) << said_;
  EXPECT_EQ(answer(s, "{\"rule\": \"gluing\", \"pairs\": [[1, 2]], \"layers\": [], \"edges\": []}"), 2)
      << said_;
}

// Two copies a hair apart, each of which covers the other's edges: too much for one search, but what
// contradicts itself lies around a hinge.
TEST_F(CheckWitness, LayersThatCannotBeGluedNearAHinge) {
  const std::uint64_t seed = 17;
  const Surface one =
      pierced_at_hinge(test::elbow(90 + 20.0 * static_cast<double>(seed % 6), 8 + seed % 5), seed);
  ASSERT_EQ(diagnosed(one).verdict, Verdict::infeasible);
  Surface other = one;
  other.V.rowwise() += 1e-4 * Eigen::RowVector3d(-0.8, 0.1, 0.6);
  const Surface s = test::joined(one, other);
  const Diagnosis d = diagnosed(s);
  ASSERT_EQ(d.verdict, Verdict::feasible);
  const GluingAnswer a = check_gluing(s, d.topology.topology, *d.bvh, *d.graph, {}).value();
  ASSERT_EQ(a.verdict, GluingVerdict::conflict) << a.message;
  EXPECT_EQ(answer(s, gluing_witness(a.conflict, a.conflict.crossings.size() + a.conflict.edges.size())), 0)
      << said_;
}

TEST_F(CheckWitness, FacesThatLieOnEachOther) {
  const Surface s = test::mirrored_folds();
  const Diagnosis d = diagnosed(s);
  ASSERT_TRUE(d.certificate && std::holds_alternative<StackCertificate>(*d.certificate)) << d.message;
  const auto& w = std::get<StackCertificate>(*d.certificate);
  EXPECT_EQ(answer(s, to_json(w)), 0) << said_;
  const auto text = [&](const std::vector<int>& moves, int winding) {
    return "{\"rule\": \"stack\", \"face\": " + std::to_string(w.face) + ", \"place\": [\"" + w.exact[0] +
           "\", \"" + w.exact[1] + "\", \"" + w.exact[2] + "\"], \"vertices\": " + listed(w.vertices) +
           ", \"moves\": " + listed(moves) + ", \"winding\": " + std::to_string(winding) + "}";
  };
  EXPECT_EQ(answer(s, text(w.moves, w.winding)), 0) << said_;
  EXPECT_EQ(answer(s, text(w.moves, w.winding - 1)), 1) << said_;
  std::vector<int> none(w.moves.size(), 0), other = w.moves;
  EXPECT_EQ(answer(s, text(none, w.winding)), 1) << said_;
  for (int& m : other) m = -m;
  EXPECT_EQ(answer(s, text(other, w.winding)), 1) << said_;
  EXPECT_EQ(answer(s, text({}, w.winding)), 2) << said_;
}

// Two vertices in one place may share what hinges ask for.
TEST_F(CheckWitness, VerticesInOnePlaceAreNoProof) {
  const Surface s = test::obstructed_elbow(0);
  const Diagnosis d = diagnosed(s);
  ASSERT_FALSE(d.wound.odd_groups.empty());
  const auto& group = d.wound.odd_groups[0];
  std::vector<int> b0;
  for (const Index v : group) b0.push_back(b0_of(d, v).value());
  Surface other = test::sphere(0, 0.05);
  const Eigen::RowVector3d move = s.V.row(group[0]) - other.V.row(0);
  for (Index v = 0; v < other.V.rows(); ++v) other.V.row(v) += move;
  other.V.row(0) = s.V.row(group[0]);
  const Surface touching = test::joined(s, other);
  EXPECT_NE(answer(touching, unpaired_witness(group, b0)), 0) << said_;
}

// Copies of what has no mesh, with a layer around them that is enough for one of them.
TEST_F(CheckWitness, PointsThatNeedMoreThanThereIs) {
  for (int i = 0; i < 2; ++i) {
    SCOPED_TRACE(i);
    const Surface one = test::obstructed_elbow(i), both = test::joined(one, one);
    const Surface s = i == 0 ? both : test::joined(test::sphere(0, 20), both);
    const Diagnosis d = diagnosed(s);
    ASSERT_TRUE(d.wound.shared);
    SharedPoint p = *d.wound.shared;
    EXPECT_EQ(p.room, i);
    EXPECT_EQ(answer(s, shared_witness(p)), 0) << said_;
    ++p.room;
    EXPECT_EQ(answer(s, shared_witness(p)), 1) << said_;
    p = *d.wound.shared;
    p.layers[0] = 0;
    EXPECT_EQ(answer(s, shared_witness(p)), 1) << said_;
    p.layers[0] = 2;
    EXPECT_EQ(answer(s, shared_witness(p)), i) << said_;  // one is enough where the edges are covered
    p.vertices[0] = (p.vertices[0] + 1) % static_cast<Index>(one.V.rows());
    EXPECT_EQ(answer(s, shared_witness(p)), 1) << said_;
    p.layers.clear();
    EXPECT_EQ(answer(s, shared_witness(p)), 2) << said_;
  }
}

// Two copies in one place of what has no mesh: none of their integers is defined.
TEST_F(CheckWitness, CopiesInOnePlaceAreMovedApart) {
  for (const std::uint64_t seed : {263, 293}) {
    SCOPED_TRACE(seed);
    const Surface one =
        pierced_at_hinge(test::elbow(90 + 20.0 * static_cast<double>(seed % 6), 8 + seed % 5), seed);
    const Surface s = test::joined(one, one);
    const Diagnosis d = diagnosed(s);
    ASSERT_EQ(d.verdict, Verdict::infeasible) << d.message;
    ASSERT_TRUE(d.certificate && std::holds_alternative<SeparatedCertificate>(*d.certificate));
    const auto& found = std::get<SeparatedCertificate>(*d.certificate);
    EXPECT_EQ(answer(s, to_json(found)), 0) << said_;
    EXPECT_EQ(answer(s, apart_witness(found)), 0) << said_;
    EXPECT_EQ(answer(s, unpaired_witness(found.vertices, found.B0)), 1) << said_;
    SeparatedCertificate other = found;
    for (int& x : other.direction) x = -x;  // into the copy, which covers the edges
    EXPECT_EQ(answer(s, apart_witness(other)), 1) << said_;
    other = found;
    other.B0[0] += 2;
    EXPECT_EQ(answer(s, apart_witness(other)), 1) << said_;
  }
  const Surface elbow = test::elbow(150, 14), both = test::joined(elbow, elbow);
  EXPECT_EQ(diagnosed(both).verdict, Verdict::feasible);
}

TEST_F(CheckWitness, WhatCannotBeReadIsNeitherProofNorRefutation) {
  const Surface s = test::saucer(1);
  EXPECT_EQ(answer(s, "{\"vertex\": 100000, \"B0\": -1}"), 2);
  EXPECT_EQ(answer(s, "{\"vertex\": \"a\", \"B0\": -1}"), 2);
  EXPECT_EQ(answer(s, "{\"point\": [1, 2], \"winding\": -1}"), 2);
  EXPECT_EQ(answer(s, "{\"point\": [1, 2, \"x\"], \"winding\": -1}"), 2);
  EXPECT_EQ(answer(s, "{\"point\": [1, 2, 3]}"), 2);
  EXPECT_EQ(answer(s, unpaired_witness({1, 2}, {1})), 2);
  EXPECT_EQ(answer(s, "{\"face\": 3}"), 2);
  EXPECT_EQ(answer(off_text(s), "{\"status\": \"exact\"}"), 2);
  EXPECT_EQ(answer(off_text(s), "no report"), 2);
  const std::string witness = "{\"vertex\": 0, \"B0\": -1}";
  Surface open = s;
  open.F.conservativeResize(open.F.rows() - 1, 3);
  EXPECT_EQ(answer(open, witness), 2);
  EXPECT_EQ(answer("OFF\n3 1 0\n0 0 0\n", witness), 2);
  EXPECT_EQ(answer("", witness), 2);
  EXPECT_EQ(test::shell(OVERTET_CHECK_WITNESS " /nowhere.off /nowhere.json").exit_code, 2);
  EXPECT_EQ(test::shell(OVERTET_CHECK_WITNESS).exit_code, 2);
}

}  // namespace
}  // namespace overtet
