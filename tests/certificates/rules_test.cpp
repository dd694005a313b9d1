// The rules as a list: each certificate has a name, a sentence and its properties, and a rule of someone
// else's has its say like any other.
#include "src/certificates/rules.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

#include "overtet/report.h"
#include "src/certificates/diagnose.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

using Json = nlohmann::json;

Diagnosis diagnosed(const Surface& s, const DiagnoseOptions& options = {}) {
  const auto d = diagnose(s, options, {});
  EXPECT_TRUE(d.ok());
  return d.value();
}

// A rule that is no part of the library: vertices in one plane that someone has marked are not to be meshed.
class Marked {
 public:
  explicit Marked(double height) : height_(height) {}

  rules::Finding operator()(rules::Case& c) const {
    CustomCertificate found{"marked", "No mesh exists: someone has marked the surface.", {}, {}};
    for (Index v = 0; v < c.surface.V.rows(); ++v)
      if (c.surface.V(v, 2) == height_) {
        found.vertices.push_back(v);
        found.positions.push_back(position_of(c.surface, v));
      }
    if (found.vertices.empty()) return std::optional<Certificate>();
    return std::optional<Certificate>(found);
  }

 private:
  double height_;
};

TEST(Rules, OneMoreComesOutInVerdictMessageAndReport) {
  Surface s = test::curled_worm();
  DiagnoseOptions options;
  options.rules.push_back({Marked(77)});
  EXPECT_EQ(diagnosed(s, options).verdict, Verdict::feasible);  // nothing is marked
  s.V(5, 2) = 77;
  for (const bool on_request : {false, true}) {
    options.rules.back().on_request = on_request;
    Diagnosis d = diagnosed(s, options);
    EXPECT_EQ(d.certificate.has_value(), !on_request);
    ASSERT_TRUE(diagnose_further(s, options, d, {}).ok());
    EXPECT_EQ(std::string(verdict_name(d.verdict)), "infeasible");
    EXPECT_EQ(d.message, "No mesh exists: someone has marked the surface.");
    const auto refused = refuse(d);
    ASSERT_TRUE(refused);
    EXPECT_EQ(refused->code, ErrorCode::infeasible);
    EXPECT_EQ(refused->message, d.message);
    ASSERT_TRUE(refused->certificate);
    EXPECT_STREQ(rule_name(*refused->certificate), "marked");
    Report report;
    report.certificate = *refused->certificate;
    const Json witness = Json::parse(to_json(report))["witness"];
    EXPECT_EQ(witness["rule"], "marked");
    EXPECT_EQ(witness["vertices"], Json({5}));
    EXPECT_EQ(witness["positions"][0][2], 77);
  }
}

// A cube of edge 4 with a funnel from the top, whose tip is at `top`, and perhaps one from below.
Surface with_funnels(const Eigen::RowVector3d& top, const Eigen::RowVector3d* below) {
  Surface s;
  s.V.resize(below ? 10 : 9, 3);
  for (int v = 0; v < 8; ++v) s.V.row(v) << 4 * ((v + 1) / 2 % 2), 4 * (v / 2 % 2), 4 * (v / 4);
  s.V.row(8) = top;
  if (below) s.V.row(9) = *below;
  std::vector<std::array<Index, 3>> faces;
  for (Index k = 0; k < 4; ++k) {
    const Index next = (k + 1) % 4;
    faces.push_back({k, next, 4 + next});
    faces.push_back({k, 4 + next, 4 + k});
    faces.push_back({4 + k, 4 + next, 8});
    if (below) faces.push_back({next, k, 9});
  }
  if (!below) faces.insert(faces.end(), {{0, 2, 1}, {0, 3, 2}});
  s.F.resize(static_cast<Eigen::Index>(faces.size()), 3);
  for (std::size_t f = 0; f < faces.size(); ++f)
    s.F.row(static_cast<Eigen::Index>(f)) << faces[f][0], faces[f][1], faces[f][2];
  return s;
}

// inspect said "feasible" of tips in one place with nothing between them, and mesh said "bad input".
TEST(Rules, TipsThatMeetWithNothingBetweenThemHadNoCertificate) {
  const Eigen::RowVector3d middle(2, 2, 2), on_floor(2, 1, 0), on_edge(1, 1, 0), at_corner(0, 0, 0);
  for (const Surface& s :
       {with_funnels(middle, &middle), with_funnels(on_floor, nullptr), with_funnels(on_edge, nullptr)}) {
    ASSERT_TRUE(test::is_closed_oriented(s));
    const Diagnosis d = diagnosed(s, {});
    EXPECT_EQ(d.verdict, Verdict::infeasible) << d.message;
    ASSERT_TRUE(d.certificate);
    EXPECT_STREQ(rule_name(*d.certificate), "shared");
    // Inside of something larger there is room.
    EXPECT_EQ(diagnosed(test::joined(test::sphere(2, 30), s), {}).verdict, Verdict::feasible);
  }
  EXPECT_EQ(diagnosed(with_funnels(at_corner, nullptr), {}).verdict, Verdict::infeasible);
  // Not quite in one place, or from outside.
  const Eigen::RowVector3d above(2, 2, 3), tip(2, 2, -1);
  EXPECT_EQ(diagnosed(with_funnels(above, &middle), {}).verdict, Verdict::embedded);
  Surface two =
      test::joined(with_funnels(above, &tip), test::shifted(with_funnels(above, nullptr), 2, 2, -5));
  EXPECT_NE(diagnosed(two, {}).verdict, Verdict::infeasible);
}

TEST(Rules, TheFirstThatObjectsDecides) {
  DiagnoseOptions options;
  const Surface s = test::saucer(2);
  options.rules.push_back({Marked(s.V(0, 2))});
  EXPECT_STREQ(rule_name(*diagnosed(s, options).certificate), "winding");
  std::rotate(options.rules.begin(), options.rules.end() - 1, options.rules.end());
  EXPECT_STREQ(rule_name(*diagnosed(s, options).certificate), "marked");
}

template <std::size_t I = 0>
void add_empty(std::vector<Certificate>& all) {
  if constexpr (I < std::variant_size_v<Certificate>) {
    using C = std::variant_alternative_t<I, Certificate>;
    C c;
    if constexpr (requires { c.vertices; }) c.vertices = {0};
    if constexpr (requires { c.B0.size(); }) c.B0 = {1};
    if constexpr (requires { c.positions; }) c.positions.resize(1);
    all.emplace_back(std::move(c));
    add_empty<I + 1>(all);
  }
}

// One object on one line that begins with the rule, and a sentence, of each; no two rules have the same keys.
TEST(Rules, EachHasASentenceAndProperties) {
  std::vector<Certificate> all;
  add_empty(all);
  std::set<std::string> sentences;
  std::map<std::string, int> names;
  for (const Certificate& c : all) {
    const std::string json = to_json(c);
    EXPECT_EQ(json.find("{\"rule\":\"" + std::string(rule_name(c)) + "\""), 0u) << json;
    EXPECT_EQ(json.find('\n'), std::string::npos);
    EXPECT_GT(Json::parse(json).size(), 1u) << json;
    if (std::holds_alternative<CustomCertificate>(c)) continue;
    EXPECT_EQ(explain(c).find("No mesh exists: "), 0u) << explain(c);
    EXPECT_EQ(explain(c).back(), '.');
    EXPECT_TRUE(sentences.insert(explain(c)).second) << explain(c);
    ++names[rule_name(c)];
  }
  EXPECT_EQ(names.size(), 10u);
  EXPECT_EQ(names["unpaired"], 2);
}

// What CONTRIBUTING.md says: a rule is its certificate, its file, its lines in the list, and nothing else of
// the library knows it.
TEST(Rules, NothingElseKnowsOneByName) {
  namespace fs = std::filesystem;
  const fs::path root = OVERTET_SOURCE_DIR;
  std::map<std::string, std::set<std::string>> at;
  const std::string kinds[] = {"Vertex", "Fold", "Unpaired", "Crowded", "Link", "Shared"};
  for (const char* top : {"include", "src"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      if (!entry.is_regular_file()) continue;
      std::ifstream in(entry.path());
      const std::string text((std::istreambuf_iterator<char>(in)), {});
      for (const std::string& kind : kinds)
        if (text.find(kind + "Certificate") != std::string::npos)
          at[kind].insert(fs::relative(entry.path(), root).string());
    }
  for (const std::string& kind : kinds) {
    std::string file = kind;
    file[0] = static_cast<char>(std::tolower(file[0]));
    EXPECT_EQ(at[kind], (std::set<std::string>{"include/overtet/certificate.h", "src/certificates/rules.h",
                                               "src/certificates/" + file + "_rule.cpp"}));
  }
}

}  // namespace
}  // namespace overtet
