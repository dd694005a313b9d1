// Skinning weights as text, and as a skinned mesh of glTF 2 (overtet/weights.h).
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numeric>

#include "kernels/core/tet_tables.h"
#include "overtet/weights.h"
#include "src/io/file.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"
#include "src/io/tuning.h"

namespace overtet {

namespace {

using Json = nlohmann::ordered_json;

Status fits(const Handles& handles, const Eigen::MatrixXd& weights, Eigen::Index vertices) {
  if (weights.cols() == std::ssize(handles.handles) && weights.rows() == vertices) return success();
  return Error{ErrorCode::usage, "There are weights for " + std::to_string(weights.rows()) +
                                     " vertices and " + std::to_string(weights.cols()) + " handles, but " +
                                     std::to_string(vertices) + " vertices and " +
                                     std::to_string(handles.handles.size()) + " handles."};
}

// A field of a line with commas [RFC 4180].
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? std::string("\"\"") : std::string(1, c);
  return out + "\"";
}

std::vector<std::string> fields_of(std::string_view line) {
  std::vector<std::string> out(1);
  bool inside = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (inside && c == '"' && i + 1 < line.size() && line[i + 1] == '"')
      out.back() += line[++i];
    else if (c == '"')
      inside = !inside;
    else if (c == ',' && !inside)
      out.emplace_back();
    else if (c != '\r')
      out.back() += c;
  }
  return out;
}

// The binary chunk of a .glb, with its views and accessors.
class GlbBuffer {
 public:
  // Numbers of an accessor: rows x width, of a type that glTF numbers so. Its number.
  template <class T>
  int add(const std::vector<T>& values, int width, int component, const char* type, int target) {
    while (bytes_.size() % 4) bytes_ += '\0';
    views_.push_back(
        {{"buffer", 0}, {"byteOffset", bytes_.size()}, {"byteLength", values.size() * sizeof(T)}});
    if (target) views_.back()["target"] = target;
    for (const T x : values) put(x);
    accessors_.push_back({{"bufferView", views_.size() - 1},
                          {"componentType", component},
                          {"count", values.size() / static_cast<std::size_t>(width)},
                          {"type", type}});
    return static_cast<int>(accessors_.size()) - 1;
  }
  Json& accessor(int i) { return accessors_[static_cast<std::size_t>(i)]; }

  // The whole file.
  std::string file(Json j) {
    while (bytes_.size() % 4) bytes_ += '\0';
    j["bufferViews"] = views_;
    j["accessors"] = accessors_;
    j["buffers"] = Json::array();
    j["buffers"].push_back({{"byteLength", bytes_.size()}});
    std::string text = j.dump(-1, ' ', false, Json::error_handler_t::replace);
    while (text.size() % 4) text += ' ';
    const std::string body = std::move(bytes_);
    bytes_.clear();
    const auto total = static_cast<std::uint32_t>(12 + 8 + text.size() + 8 + body.size());
    for (const std::uint32_t word :
         {0x46546C67u, 2u, total, static_cast<std::uint32_t>(text.size()), 0x4E4F534Au})
      put(word);
    bytes_ += text;
    put(static_cast<std::uint32_t>(body.size()));
    put(0x004E4942u);
    return bytes_ + body;
  }

  std::size_t size() const { return bytes_.size(); }

 private:
  void put(std::uint32_t x) {  // little endian
    for (int k = 0; k < 4; ++k) bytes_ += static_cast<char>(x >> (8 * k) & 255);
  }
  void put(std::uint16_t x) {
    for (int k = 0; k < 2; ++k) bytes_ += static_cast<char>(x >> (8 * k) & 255);
  }
  void put(float x) { put(std::bit_cast<std::uint32_t>(x)); }

  std::string bytes_;
  std::vector<Json> views_, accessors_;
};

// Faces of one tet only, as seen from outside, in the order of the tets.
std::vector<std::array<Index, 3>> boundary_of(const TetMatrix& T) {
  struct Face {
    std::array<Index, 3> sorted;
    Index tet;
    int k;
  };
  std::vector<Face> faces;
  for (Index t = 0; t < T.rows(); ++t)
    for (int k = 0; k < 4; ++k) {
      std::array<Index, 3> c = tet_face(T.row(t), k);
      std::sort(c.begin(), c.end());
      faces.push_back({c, t, k});
    }
  std::sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) { return a.sorted < b.sorted; });
  std::vector<Face> single;
  for (std::size_t i = 0, n = 0; i < faces.size(); i = n) {
    for (n = i + 1; n < faces.size() && faces[n].sorted == faces[i].sorted;) ++n;
    if (n == i + 1) single.push_back(faces[i]);
  }
  std::sort(single.begin(), single.end(),
            [](const Face& a, const Face& b) { return a.tet != b.tet ? a.tet < b.tet : a.k < b.k; });
  std::vector<std::array<Index, 3>> out;
  for (const Face& f : single) out.push_back(tet_face(T.row(f.tet), f.k));
  return out;
}

// The weights of one vertex that count, the largest first; what was left out goes into dropped.
std::vector<std::pair<int, double>> counting(const Eigen::MatrixXd& weights, Index v, double& dropped) {
  std::vector<std::pair<int, double>> out;
  for (Eigen::Index h = 0; h < weights.cols(); ++h)
    if (weights(v, h) > 0) out.emplace_back(static_cast<int>(h), weights(v, h));
  std::stable_sort(out.begin(), out.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  double all = 0, kept = 0;
  for (const auto& [h, w] : out) all += w;
  // At least one.
  while (out.size() > 1 && (out.back().second < kLeastSkinWeight * all || out.size() > 8)) out.pop_back();
  for (const auto& [h, w] : out) kept += w;
  for (auto& [h, w] : out) w /= kept;
  dropped = std::max(dropped, all > 0 ? 1 - kept / all : 0.0);
  return out;
}

std::vector<float> floats(const Eigen::Vector3d& p) {
  return {static_cast<float>(p[0]), static_cast<float>(p[1]), static_cast<float>(p[2])};
}

// The skeleton: the nodes of the handles from 2 on, below node 1; node 0 is the mesh.
void add_skeleton(Json& j, GlbBuffer& buffer, const Handles& handles, const VertexMatrix& V) {
  const auto head = [&](std::size_t h) -> Eigen::Vector3d {
    const HandlePlace& p = handles.places[static_cast<std::size_t>(handles.handles[h].place)];
    return p.vertex ? Eigen::Vector3d(V.row(*p.vertex)) : p.position;
  };
  const std::size_t n = handles.handles.size();
  Json nodes = Json::array();
  nodes.push_back({{"name", "skin"}, {"mesh", 0}, {"skin", 0}});
  nodes.push_back({{"name", "handles"}, {"children", Json::array()}});
  std::vector<float> inverse;
  Json joints = Json::array();
  for (std::size_t h = 0; h < n; ++h) {
    const Handle& handle = handles.handles[h];
    Eigen::Vector3d from = head(h);
    if (handle.parent >= 0) from -= head(static_cast<std::size_t>(handle.parent));
    nodes.push_back({{"name", handle.name}, {"translation", floats(from)}});
    joints.push_back(h + 2);
    const std::vector<float> back = floats(-head(h));
    for (const float x :
         {1.f, 0.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 0.f, 1.f, 0.f, back[0], back[1], back[2], 1.f})
      inverse.push_back(x);
  }
  for (std::size_t h = 0; h < n; ++h)
    nodes[handles.handles[h].parent >= 0 ? static_cast<std::size_t>(handles.handles[h].parent) + 2 : 1]
         ["children"]
             .push_back(h + 2);
  j["nodes"] = nodes;
  j["scene"] = 0;
  j["scenes"] = Json::array();
  j["scenes"].push_back({{"nodes", Json::array({0, 1})}});
  j["skins"] = Json::array();
  j["skins"].push_back({{"joints", joints},
                        {"skeleton", 1},
                        {"inverseBindMatrices", buffer.add(inverse, 16, 5126, "MAT4", 0)}});
}

}  // namespace

Status write_weights_csv(const std::string& path, const Handles& handles, const Eigen::MatrixXd& weights,
                         const RunContext& context) {
  if (Status s = fits(handles, weights, weights.rows()); !s) return s;
  const ScopedThreads threads(context.threads > 0 ? context.threads : thread_cap());
  AtomicFile file;
  if (Status s = file.open(path); !s) return s;
  TextWriter out(file);
  out.text("vertex");
  for (const Handle& h : handles.handles) out.character(',').text(field(h.name));
  out.end_line();
  out.lines(weights.rows(), [&](TextBuffer& line, std::int64_t v) {
    line.number(v);
    for (Eigen::Index h = 0; h < weights.cols(); ++h) line.character(',').number(weights(v, h));
    line.end_line();
  });
  if (Status s = out.finish(); !s) return s;
  if (auto no = context.no_name()) return *no;
  return file.commit();
}

Result<Eigen::MatrixXd> read_weights_csv(const std::string& path, const Handles& handles) {
  const Result<std::string> bytes = read_file(path);
  return bytes ? parse_weights_csv(path, bytes.value(), handles) : Result<Eigen::MatrixXd>(bytes.error());
}

Result<Eigen::MatrixXd> parse_weights_csv(std::string_view name, std::string_view text,
                                          const Handles& handles) {
  const auto bad = [&](std::size_t line, const std::string& what) {
    return Error{ErrorCode::bad_input,
                 std::string(name) + ", line " + std::to_string(line) + ": " + what + "."};
  };
  std::vector<std::string_view> lines;
  for (std::string_view rest = text; !rest.empty();) {
    const std::size_t end = std::min(rest.find('\n'), rest.size());
    lines.push_back(rest.substr(0, end));
    rest.remove_prefix(std::min(end + 1, rest.size()));
  }
  if (lines.empty()) return bad(1, "a file of weights begins with a line of names");
  const std::vector<std::string> names = fields_of(lines[0]);
  std::vector<std::size_t> column;
  for (const Handle& h : handles.handles) {
    const auto found = std::find(names.begin(), names.end(), h.name);
    if (found == names.end()) return bad(1, "no column is named " + overtet::quoted(h.name));
    column.push_back(static_cast<std::size_t>(found - names.begin()));
  }
  while (lines.size() > 1 && lines.back().find_first_not_of(" \r\t") == std::string_view::npos)
    lines.pop_back();
  Eigen::MatrixXd out(std::ssize(lines) - 1, std::ssize(column));
  for (std::size_t n = 1; n < lines.size(); ++n) {
    const std::vector<std::string> fields = fields_of(lines[n]);
    if (fields.size() != names.size())
      return bad(n + 1,
                 std::to_string(fields.size()) + " fields, but " + std::to_string(names.size()) + " names");
    for (std::size_t h = 0; h < column.size(); ++h) {
      const std::string& word = fields[column[h]];
      double x = 0;
      const auto [end, wrong] = std::from_chars(word.data(), word.data() + word.size(), x);
      if (wrong != std::errc() || end != word.data() + word.size() || !std::isfinite(x))
        return bad(n + 1, overtet::quoted(word) + " is not a number");
      out(static_cast<Eigen::Index>(n) - 1, static_cast<Eigen::Index>(h)) = x;
    }
  }
  return out;
}

Result<SkinFigures> write_skin(const std::string& path, const TetMesh& mesh, const Handles& handles,
                               const Eigen::MatrixXd& weights, const RunContext& context) {
  if (Status s = fits(handles, weights, mesh.V.rows()); !s) return s.error();
  for (const HandlePlace& p : handles.places)
    if (p.vertex && (*p.vertex < 0 || *p.vertex >= mesh.V.rows()))
      return Error{ErrorCode::usage,
                   "A handle is at vertex " + std::to_string(*p.vertex) + ", which does not exist."};
  const std::vector<std::array<Index, 3>> faces = boundary_of(mesh.T);
  // The boundary's vertices, in their order.
  std::vector<Index> number(static_cast<std::size_t>(mesh.V.rows()), -1);
  for (const auto& f : faces)
    for (const Index v : f) number[static_cast<std::size_t>(v)] = 0;
  std::vector<Index> vertices;
  for (std::size_t v = 0; v < number.size(); ++v)
    if (number[v] == 0) {
      number[v] = static_cast<Index>(vertices.size());
      vertices.push_back(static_cast<Index>(v));
    }
  SkinFigures figures;
  std::vector<std::vector<std::pair<int, double>>> of;
  for (const Index v : vertices) {
    of.push_back(counting(weights, v, figures.dropped));
    if (of.back().size() > 4) figures.sets = 2;
  }
  GlbBuffer buffer;
  Json j;
  j["asset"] = {{"version", "2.0"}, {"generator", "Overtet"}};
  std::vector<float> positions;
  std::array<float, 3> low{}, high{};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const std::vector<float> p = floats(mesh.V.row(vertices[i]));
    for (std::size_t k = 0; k < 3; ++k) {
      low[k] = i ? std::min(low[k], p[k]) : p[k];
      high[k] = i ? std::max(high[k], p[k]) : p[k];
      positions.push_back(p[k]);
    }
  }
  std::vector<std::uint32_t> corners;
  for (const auto& f : faces)
    for (const Index v : f)
      corners.push_back(static_cast<std::uint32_t>(number[static_cast<std::size_t>(v)]));
  Json attributes;
  const int places = buffer.add(positions, 3, 5126, "VEC3", 34962);
  buffer.accessor(places)["min"] = low;
  buffer.accessor(places)["max"] = high;
  attributes["POSITION"] = places;
  for (int set = 0; set < figures.sets; ++set) {
    std::vector<std::uint16_t> joints;
    std::vector<float> shares;
    for (const auto& list : of)
      for (std::size_t k = 4 * static_cast<std::size_t>(set); k < 4 * static_cast<std::size_t>(set) + 4;
           ++k) {
        joints.push_back(k < list.size() ? static_cast<std::uint16_t>(list[k].first) : std::uint16_t{0});
        shares.push_back(k < list.size() ? static_cast<float>(list[k].second) : 0.f);
      }
    const std::string n = std::to_string(set);
    attributes["JOINTS_" + n] = buffer.add(joints, 4, 5123, "VEC4", 34962);
    attributes["WEIGHTS_" + n] = buffer.add(shares, 4, 5126, "VEC4", 34962);
  }
  Json triangles = {
      {"attributes", attributes}, {"indices", buffer.add(corners, 1, 5125, "SCALAR", 34963)}, {"mode", 4}};
  Json skin = {{"name", "skin"}, {"primitives", Json::array()}};
  skin["primitives"].push_back(std::move(triangles));
  j["meshes"] = Json::array();
  j["meshes"].push_back(std::move(skin));
  add_skeleton(j, buffer, handles, mesh.V);
  // Sizes in the file are 32 bits wide.
  if (handles.handles.size() > 65535 || buffer.size() > (std::size_t{1} << 31))
    return Error{ErrorCode::usage, "This skin is too large for a .glb file."};
  AtomicFile file;
  if (Status s = file.open(path); !s) return s.error();
  if (Status s = file.write(buffer.file(std::move(j))); !s) return s.error();
  if (auto no = context.no_name()) return *no;
  if (Status s = file.commit(); !s) return s.error();
  return figures;
}

}  // namespace overtet
