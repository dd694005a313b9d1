#include "overtet/view.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <nlohmann/json.hpp>

#include "src/io/base64.h"
#include "src/io/file.h"
#include "src/view/page_parts.h"

namespace overtet {

namespace {

using Json = nlohmann::json;

// Blocks of little-endian numbers, put into the page as text.
class Page {
 public:
  Status open(const std::string& path) { return file_.open(path); }
  Page& text(std::string_view words) {
    if (status_.ok()) status_ = file_.write(words);
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
  Status finish() {
    if (status_.ok()) status_ = file_.commit();
    return status_;
  }

 private:
  AtomicFile file_;
  Status status_ = success();
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

Error wrong(const std::string& what) { return {ErrorCode::bad_input, "Cannot show this: " + what + "."}; }

template <class Matrix>
Status check(const VertexMatrix& V, const Matrix& elements, const char* what) {
  if (!V.allFinite()) return wrong("a coordinate is not finite");
  if (elements.size() > 0 && (elements.minCoeff() < 0 || elements.maxCoeff() >= V.rows()))
    return wrong(std::string("a ") + what + " has a vertex that there is not");
  return success();
}

Status check_size(std::size_t size, Eigen::Index wanted, const char* what) {
  if (size == 0 || static_cast<Eigen::Index>(size) == wanted) return success();
  return wrong(std::string("there are ") + std::to_string(size) + " " + what + " for " +
               std::to_string(wanted) + " elements");
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

Status end(Page& page, const PageOptions& options, const Places& places) {
  std::vector<float> marks;
  for (const auto& p : options.marks) places.add({p[0], p[1], p[2]}, marks);
  return page.block("lines", lines_of(options.curves, places))
      .block("marks", marks)
      .text("<script>")
      .text(page_script())
      .text("</script>\n</body></html>\n")
      .finish();
}

}  // namespace

Status write_page(const std::string& path, const LabelledTetMesh& labelled, const PageOptions& options) {
  const auto& [mesh, a] = labelled;
  if (Status s = check(mesh.V, mesh.T, "tet"); !s) return s;
  if (Status s = check(mesh.V, a.triangles, "triangle"); !s) return s;
  if (Status s = check_size(a.labels.of.size(), a.triangles.rows(), "labels"); !s) return s;
  if (Status s = check_size(a.regions.of.size(), mesh.T.rows(), "regions"); !s) return s;
  if (Status s = check_size(a.layers.size(), mesh.T.rows(), "numbers of layers"); !s) return s;
  Page page;
  if (Status s = page.open(path); !s) return s;
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
  return end(page, options, places);
}

Status write_page(const std::string& path, const Surface& surface, const SurfaceAttributes& attributes,
                  const PageOptions& options) {
  if (Status s = check(surface.V, surface.F, "face"); !s) return s;
  if (Status s = check_size(attributes.faces.of.size(), surface.F.rows(), "labels"); !s) return s;
  Page page;
  if (Status s = page.open(path); !s) return s;
  const Places places(surface.V);
  begin(page, options, {{"kind", "surface"}, {"label_names", names_of(attributes.faces)}}, places);
  page.block("V", places.of(surface.V)).block("F", flat(surface.F)).block("labels", attributes.faces.of);
  return end(page, options, places);
}

}  // namespace overtet
