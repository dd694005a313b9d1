#include "overtet/view.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "src/io/base64.h"
#include "src/io/filled_file.h"
#include "src/view/checks.h"
#include "src/view/page_parts.h"

namespace overtet {

namespace {

using Json = nlohmann::json;

// Blocks of little-endian numbers, put into the page as text.
class Page {
 public:
  explicit Page(TextWriter& out) : out_(out) {}
  Page& text(std::string_view words) {
    out_.text(words);
    return *this;
  }
  template <class T>
  Page& block(const char* id, const std::vector<T>& numbers) {
    if (numbers.empty()) return *this;
    text("<script type=\"application/octet-stream\" id=\"").text(id).text("\">");
    // A multiple of three bytes at a time, so that the pieces join.
    const auto* bytes = reinterpret_cast<const char*>(numbers.data());
    const std::size_t size = numbers.size() * sizeof(T), piece = std::size_t{3} << 18;
    for (std::size_t at = 0; at < size; at += piece)
      text(io_detail::encode_base64({bytes + at, std::min(piece, size - at)}));
    return text("</script>\n");
  }

 private:
  TextWriter& out_;
};

std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '&')
      out += "&amp;";
    else if (c == '<')
      out += "&lt;";
    else
      out += static_cast<unsigned char>(c) < ' ' ? ' ' : c;
  }
  return out;
}

// JSON that can stand in a script element.
std::string in_script(const Json& json) {
  std::string text = json.dump(-1, ' ', false, Json::error_handler_t::replace), out;
  for (const char c : text) {
    if (c == '<')
      out += "\\u003c";
    else
      out += c;
  }
  return out;
}

Json names_of(const Labels& labels) {
  Json names = Json::object();
  for (const auto& [number, name] : labels.names) names[std::to_string(number)] = name;
  return names;
}

template <class Matrix>
std::vector<Index> flat(const Matrix& m) {
  return {m.data(), m.data() + m.size()};
}

// Single precision is enough for a picture if the middle of the box is the origin.
struct Places {
  Eigen::RowVector3d middle = Eigen::RowVector3d::Zero();
  explicit Places(const VertexMatrix& V) {
    if (V.rows() > 0) middle = V.colwise().minCoeff() / 2 + V.colwise().maxCoeff() / 2;
  }
  void add(const Eigen::RowVector3d& p, std::vector<float>& to) const {
    for (int k = 0; k < 3; ++k) to.push_back(static_cast<float>(p[k] - middle[k]));
  }
  std::vector<float> of(const VertexMatrix& V) const {
    std::vector<float> all;
    all.reserve(static_cast<std::size_t>(V.size()));
    for (Eigen::Index i = 0; i < V.rows(); ++i) add(V.row(i), all);
    return all;
  }
};

std::vector<float> lines_of(const Curves* curves, const Places& places) {
  std::vector<float> lines;
  if (!curves) return lines;
  const auto add = [&](const CurveNode& n) {
    places.add({n.position[0], n.position[1], n.position[2]}, lines);
  };
  for (const Curve& c : curves->curves)
    for (std::size_t i = 0; i < c.segments.size(); ++i) {
      add(c.nodes[i]);
      add(c.nodes[(i + 1) % c.nodes.size()]);
    }
  return lines;
}

void begin(Page& page, const PageOptions& options, Json info, const Places& places) {
  info["title"] = options.title;
  info["middle"] = {places.middle[0], places.middle[1], places.middle[2]};
  page.text(
          "<!DOCTYPE html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
          "content=\"width=device-width\"><link rel=\"icon\" href=\"data:,\"><title>")
      .text(escaped(options.title))
      .text("</title>\n<style>\n")
      .text(page_style())
      .text("</style></head><body>\n")
      .text(page_body())
      .text("<script type=\"application/json\" id=\"info\">")
      .text(in_script(info))
      .text("</script>\n");
}

void end(Page& page, const PageOptions& options, const Places& places) {
  std::vector<float> marks;
  for (const auto& p : options.marks) places.add({p[0], p[1], p[2]}, marks);
  page.block("lines", lines_of(options.curves, places))
      .block("marks", marks)
      .text("<script>")
      .text(page_script())
      .text("</script>\n</body></html>\n");
}

}  // namespace

Status write_page(const std::string& path, const LabelledTetMesh& labelled, const PageOptions& options,
                  const RunContext& context) {
  const auto& [mesh, a] = labelled;
  if (Status s = view::check(labelled); !s) return s;
  return io_detail::write_file(path, context, [&](TextWriter& out) {
    Page page(out);
    const Places places(mesh.V);
    begin(page, options,
          {{"kind", "tets"}, {"label_names", names_of(a.labels)}, {"region_names", names_of(a.regions)}},
          places);
    page.block("V", places.of(mesh.V))
        .block("T", flat(mesh.T))
        .block("F", flat(a.triangles))
        .block("labels", a.labels.of)
        .block("regions", a.regions.of)
        .block("layers", a.layers);
    end(page, options, places);
  });
}

Status write_page(const std::string& path, const Surface& surface, const SurfaceAttributes& attributes,
                  const PageOptions& options, const RunContext& context) {
  if (Status s = view::check(surface, attributes); !s) return s;
  return io_detail::write_file(path, context, [&](TextWriter& out) {
    Page page(out);
    const Places places(surface.V);
    begin(page, options, {{"kind", "surface"}, {"label_names", names_of(attributes.faces)}}, places);
    page.block("V", places.of(surface.V)).block("F", flat(surface.F)).block("labels", attributes.faces.of);
    end(page, options, places);
  });
}

}  // namespace overtet
