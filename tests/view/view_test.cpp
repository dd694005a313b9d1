// Pages as files: what is in them reads back, whatever names say, and what cannot be shown is refused.
#include "overtet/view.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "overtet/diagnosis.h"
#include "src/io/base64.h"
#include "tests/support/files.h"
#include "tests/support/models.h"

namespace overtet {
namespace {

TEST(Base64, ReadsBackAndJoins) {
  const unsigned seed = 5;
  std::mt19937 random(seed);
  for (std::size_t size = 0; size < 200; ++size) {
    std::string bytes(size, ' ');
    for (char& c : bytes) c = static_cast<char>(random());
    const std::string text = io_detail::encode_base64(bytes);
    EXPECT_EQ(text.size(), (size + 2) / 3 * 4);
    EXPECT_EQ(io_detail::decode_base64(text), bytes) << "seed " << seed;
    const std::size_t cut = size / 6 * 3;
    EXPECT_EQ(io_detail::encode_base64(bytes.substr(0, cut)) + io_detail::encode_base64(bytes.substr(cut)),
              text);
  }
  EXPECT_EQ(io_detail::encode_base64("Man"), "TWFu");  // RFC 4648 has the alphabet
  EXPECT_EQ(io_detail::encode_base64("M"), "TQ==");
}

class View : public ::testing::Test {
 protected:
  // The text of the element with this id.
  std::string element(const std::string& id) {
    const std::string page = test::read_text(page_);
    const std::size_t at = page.find("id=\"" + id + "\">");
    if (at == std::string::npos) return "";
    const std::size_t begin = page.find('>', at) + 1;
    return page.substr(begin, page.find("</script>", begin) - begin);
  }
  template <class T>
  std::vector<T> numbers(const std::string& id) {
    const std::string bytes = io_detail::decode_base64(element(id)).value_or("");
    std::vector<T> all(bytes.size() / sizeof(T));
    std::memcpy(all.data(), bytes.data(), all.size() * sizeof(T));
    return all;
  }
  static LabelledTetMesh two_tets() {
    LabelledTetMesh m;
    m.mesh.V.resize(5, 3);
    m.mesh.V << 1e6, 0, 0, 1e6 + 1, 0, 0, 1e6, 1, 0, 1e6, 0, 1, 1e6 + 1, 1, 1;
    m.mesh.T.resize(2, 4);
    m.mesh.T << 0, 1, 2, 3, 1, 2, 3, 4;
    m.attributes.regions.of = {1, 2};
    m.attributes.regions.names = {{2, "</script><b>\"&\xff"}};
    m.attributes.layers = {1, 2};
    return m;
  }
  test::TemporaryFolder folder_;
  std::string page_ = folder_.file("page.html");
};

TEST_F(View, TetsAreInThePage) {
  const LabelledTetMesh m = two_tets();
  PageOptions options;
  options.title = "<i>odd & \n name</i>";
  ASSERT_TRUE(write_page(page_, m, options).ok());
  EXPECT_EQ(numbers<Index>("T"), (std::vector<Index>{0, 1, 2, 3, 1, 2, 3, 4}));
  EXPECT_EQ(numbers<Index>("regions"), (std::vector<Index>{1, 2}));
  EXPECT_EQ(numbers<Index>("layers"), (std::vector<Index>{1, 2}));
  EXPECT_EQ(element("labels"), "");
  const auto info = nlohmann::json::parse(element("info"));
  EXPECT_EQ(info["kind"], "tets");
  EXPECT_EQ(info["title"], options.title);
  EXPECT_EQ(info["region_names"]["2"], "</script><b>\"&\xef\xbf\xbd");
  // Far from the origin nothing is lost: places are about the middle.
  const std::vector<float> V = numbers<float>("V");
  ASSERT_EQ(V.size(), 15u);
  for (Eigen::Index v = 0; v < 5; ++v)
    for (int k = 0; k < 3; ++k)
      EXPECT_EQ(info["middle"][static_cast<std::size_t>(k)].get<double>() +
                    static_cast<double>(V[static_cast<std::size_t>(3 * v + k)]),
                m.mesh.V(v, k));
  const std::string page = test::read_text(page_);
  EXPECT_NE(page.find("<title>&lt;i>odd &amp;   name&lt;/i></title>"), std::string::npos);
  for (const char* other : {"http://", "https://", "src=", "url("}) {
    const auto at = page.substr(0, page.find("application/json")).find(other);
    EXPECT_EQ(at, std::string::npos) << "the page needs something else: " << other;
  }
}

TEST_F(View, SurfacesComeWithTheirCurves) {
  const Surface s = test::curled_worm();
  const auto diagnosis = diagnose(s);
  ASSERT_TRUE(diagnosis.ok());
  PageOptions options;
  options.curves = &diagnosis.value().curves;
  ASSERT_TRUE(write_page(page_, s, SurfaceAttributes{}, options).ok());
  std::size_t segments = 0;
  for (const Curve& c : diagnosis.value().curves.curves) segments += c.segments.size();
  EXPECT_GT(segments, 0u);
  EXPECT_EQ(numbers<float>("lines").size(), 6 * segments);
  EXPECT_EQ(numbers<Index>("F").size(), static_cast<std::size_t>(s.F.size()));
}

TEST_F(View, WhatCannotBeShownIsRefused) {
  LabelledTetMesh m = two_tets();
  m.mesh.T(1, 2) = 5;
  EXPECT_EQ(write_page(page_, m).error().code, ErrorCode::bad_input);
  m = two_tets();
  m.mesh.V(2, 1) = std::numeric_limits<double>::infinity();
  EXPECT_EQ(write_page(page_, m).error().code, ErrorCode::bad_input);
  m = two_tets();
  m.attributes.layers = {1};
  EXPECT_EQ(write_page(page_, m).error().code, ErrorCode::bad_input);
  m = two_tets();
  m.attributes.triangles.resize(1, 3);
  m.attributes.triangles << 0, -1, 2;
  EXPECT_EQ(write_page(page_, m).error().code, ErrorCode::bad_input);
  EXPECT_EQ(folder_.entries(), 0);
  EXPECT_EQ(write_page(folder_.file("no/such/page.html"), two_tets()).error().code, ErrorCode::io);
  EXPECT_TRUE(write_page(page_, LabelledTetMesh{}).ok());
  EXPECT_TRUE(write_page(page_, Surface{}, {}).ok());
}

}  // namespace
}  // namespace overtet
