#include <Eigen/Dense>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <set>
#include <utility>

#include "src/io/base64.h"
#include "src/io/face_groups.h"
#include "src/io/file.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet::io_detail {

namespace {

using Json = nlohmann::json;

std::uint32_t word_at(std::string_view bytes, std::size_t at) {
  std::uint32_t x = 0;
  for (std::size_t k = 0; k < 4; ++k)
    x |= static_cast<std::uint32_t>(static_cast<unsigned char>(bytes[at + k])) << (8 * k);
  return x;
}

// Bytes of a component, by glTF's number of its type; 0: unknown.
std::size_t component_size(std::int64_t type) {
  switch (type) {
    case 5120:
    case 5121:
      return 1;
    case 5122:
    case 5123:
      return 2;
    case 5125:
    case 5126:
      return 4;
    default:
      return 0;
  }
}

double component(const char* p, std::int64_t type, bool normalized) {
  std::uint32_t bits = 0;
  for (std::size_t k = 0; k < component_size(type); ++k)
    bits |= static_cast<std::uint32_t>(static_cast<unsigned char>(p[k])) << (8 * k);
  switch (type) {
    case 5120:
      return normalized ? std::max(static_cast<std::int8_t>(bits) / 127.0, -1.0)
                        : static_cast<std::int8_t>(bits);
    case 5121:
      return normalized ? bits / 255.0 : bits;
    case 5122:
      return normalized ? std::max(static_cast<std::int16_t>(bits) / 32767.0, -1.0)
                        : static_cast<std::int16_t>(bits);
    case 5123:
      return normalized ? bits / 65535.0 : bits;
    case 5126:
      return std::bit_cast<float>(bits);
    default:
      return bits;
  }
}

struct Malformed {
  std::string what;
};

// Reads the nodes of the scene one after the other. Inside it, what is malformed is thrown as Malformed (or
// by nlohmann's json), because it may be anywhere in the tree; parse_gltf() makes errors of it.
class GltfReader {
 public:
  GltfReader(std::string folder, SurfaceReadInfo& info) : folder_(std::move(folder)), info_(info) {}

  Result<Polygons> read(std::string_view bytes) {
    std::string_view text = bytes;
    if (bytes.starts_with("glTF")) {
      text = chunk(bytes, "JSON");
      binary_ = chunk(bytes, std::string_view("BIN\0", 4));
      info_.format = "glTF, binary";
    } else {
      info_.format = "glTF";
    }
    json_ = Json::parse(text);
    for (const Json& e : list(json_, "extensionsRequired"))
      if (e != "KHR_mesh_quantization" && e.get<std::string>().find("mesh") != std::string::npos)
        throw Malformed{"the meshes are stored with the extension " + overtet::quoted(e.get<std::string>()) +
                        "; save them plainly"};
    const Json& scenes = list(json_, "scenes");
    const std::size_t scene = json_.contains("scene") ? number(json_["scene"]) : 0;
    if (scene < scenes.size()) {
      nodes(list(scenes[scene], "nodes"));
    } else {
      for (std::size_t m = 0; m < list(json_, "meshes").size(); ++m) mesh(m, Eigen::Matrix4d::Identity(), "");
    }
    finish();
    return std::move(out_);
  }

 private:
  static std::string_view chunk(std::string_view bytes, std::string_view type) {
    for (std::size_t at = 12; at + 8 <= bytes.size();) {
      const std::size_t length = word_at(bytes, at);
      if (length > bytes.size() - at - 8) throw Malformed{"the file is cut short"};
      if (bytes.substr(at + 4, 4) == type) return bytes.substr(at + 8, length);
      at += 8 + length + (4 - length % 4) % 4;
    }
    return {};
  }

  // References into the file's tree: a copy would take its time for every look, and go as deep as the tree
  // does.
  static const Json& list(const Json& of, const char* key) {
    static const Json none = Json::array();
    const auto at = of.find(key);
    if (at == of.end()) return none;
    if (!at->is_array()) throw Malformed{overtet::quoted(key) + " is no list"};
    return *at;
  }
  static std::size_t number(const Json& j) {
    if (!j.is_number_unsigned()) throw Malformed{"there is something else where a whole number should be"};
    return j.get<std::size_t>();
  }

  // The trees of nodes, each before its children and those in order; with a list of its own of what comes
  // next, as a tree may be as deep as the file is long.
  void nodes(const Json& roots) {
    struct Next {
      const Json* number;
      Eigen::Matrix4d outer;
    };
    std::vector<Next> next;
    const auto add = [&](const Json& numbers, const Eigen::Matrix4d& outer) {
      for (auto n = numbers.rbegin(); n != numbers.rend(); ++n) next.push_back({&*n, outer});
    };
    add(roots, Eigen::Matrix4d::Identity());
    while (!next.empty()) {
      const Next one = next.back();
      next.pop_back();
      const std::size_t n = number(*one.number);
      const Eigen::Matrix4d place = node(n, one.outer);
      add(list(json_["nodes"][n], "children"), place);
    }
  }

  // The place of what is in it.
  Eigen::Matrix4d node(std::size_t which, const Eigen::Matrix4d& outer) {
    const Json& n = json_.at("nodes").at(which);
    if (!met_.insert(which).second) throw Malformed{"node " + std::to_string(which) + " has two parents"};
    Eigen::Matrix4d own = Eigen::Matrix4d::Identity();
    if (n.contains("matrix")) {
      for (int k = 0; k < 16; ++k)
        own(k % 4, k / 4) = n["matrix"].at(static_cast<std::size_t>(k)).get<double>();
    } else {
      const auto numbers = [&](const char* key, std::vector<double> otherwise) {
        return n.contains(key) ? n[key].get<std::vector<double>>() : otherwise;
      };
      const auto t = numbers("translation", {0, 0, 0}), q = numbers("rotation", {0, 0, 0, 1}),
                 s = numbers("scale", {1, 1, 1});
      if (t.size() != 3 || q.size() != 4 || s.size() != 3)
        throw Malformed{"a node has a transformation of the wrong size"};
      if (q != std::vector<double>{0, 0, 0, 1})
        own.topLeftCorner<3, 3>() = Eigen::Quaterniond(q[3], q[0], q[1], q[2]).toRotationMatrix();
      for (int k = 0; k < 3; ++k) {
        own.topLeftCorner<3, 3>().col(k) *= s[static_cast<std::size_t>(k)];
        own(k, 3) = t[static_cast<std::size_t>(k)];
      }
    }
    const Eigen::Matrix4d place = outer * own;
    if (n.contains("mesh")) mesh(number(n["mesh"]), place, n.value("name", ""));
    return place;
  }

  // Primitives of one mesh that have the same places have the same vertices.
  void mesh(std::size_t which, const Eigen::Matrix4d& place, std::string name) {
    const Json& m = json_.at("meshes").at(which);
    if (name.empty()) name = m.value("name", "mesh " + std::to_string(which));
    std::map<std::size_t, Index> first_of;
    for (const Json& p : m.at("primitives")) {
      const std::size_t mode = p.contains("mode") ? number(p["mode"]) : 4;
      if (mode < 4) continue;  // points and lines
      if (mode != 4)
        throw Malformed{"mesh " + overtet::quoted(name) +
                        " has strips or fans of triangles; save them as triangles"};
      const Json& attributes = p.at("attributes");
      const std::size_t places = number(attributes.at("POSITION"));
      const auto [at, is_new] = first_of.try_emplace(places, static_cast<Index>(out_.xyz.size() / 3));
      const std::size_t count = number(json_.at("accessors").at(places).at("count"));
      if (is_new) add_vertices(attributes, place);
      groups_.begin(FaceGroups::solid, name, out_.sizes.size());
      groups_.begin(FaceGroups::material,
                    p.contains("material") ? json_.at("materials")
                                                 .at(number(p["material"]))
                                                 .value("name", "material " + p["material"].dump())
                                           : std::string(),
                    out_.sizes.size());
      std::vector<double> corners;
      if (p.contains("indices"))
        corners = accessor(number(p["indices"]), 1);
      else
        for (std::size_t v = 0; v < count; ++v) corners.push_back(static_cast<double>(v));
      if (corners.size() % 3 != 0)
        throw Malformed{"mesh " + overtet::quoted(name) + " has a triangle without three corners"};
      const bool mirrored = place.topLeftCorner<3, 3>().determinant() < 0;
      for (std::size_t i = 0; i < corners.size(); ++i) {
        const double v = corners[mirrored && i % 3 != 0 ? i + (i % 3 == 1 ? 1 : -1) : i];
        if (!(v >= 0 && v < static_cast<double>(count)))
          throw Malformed{"mesh " + overtet::quoted(name) + " names a vertex that does not exist"};
        out_.corners.push_back(at->second + static_cast<Index>(v));
      }
      out_.sizes.resize(out_.corners.size() / 3, 3);
    }
  }

  void add_vertices(const Json& attributes, const Eigen::Matrix4d& place) {
    const std::vector<double> xyz = accessor(number(attributes["POSITION"]), 3);
    if ((out_.xyz.size() + xyz.size()) / 3 > static_cast<std::size_t>(kMaxCount))
      throw Malformed{"there are too many vertices"};
    const bool moved = place != Eigen::Matrix4d::Identity();
    for (std::size_t i = 0; i < xyz.size(); i += 3) {
      Eigen::Vector4d p(xyz[i], xyz[i + 1], xyz[i + 2], 1);
      if (moved) p = place * p;
      for (int k = 0; k < 3; ++k) {
        if (!std::isfinite(p[k])) throw Malformed{"a coordinate is not a finite number"};
        out_.xyz.push_back(p[k]);
      }
    }
    for (const auto& [key, name] : {std::pair{"TEXCOORD_0", "uv"}, {"COLOR_0", "colour"}}) {
      Attribute& all = data_.try_emplace(name, Attribute{name, NumberType::float64, 0, {}}).first->second;
      if (!attributes.contains(key)) {
        all.width = -1;
        continue;
      }
      const std::size_t which = number(attributes[key]);
      const Json& type = json_.at("accessors").at(which).at("type");
      const int width = type == "VEC2" ? 2 : type == "VEC3" ? 3 : 4;
      if (all.width == 0) all.width = width;
      if (all.width != width) all.width = -1;
      const std::vector<double> values = accessor(which, width);
      all.values.insert(all.values.end(), values.begin(), values.end());
    }
  }

  std::string_view buffer(std::size_t which) {
    const Json& b = json_.at("buffers").at(which);
    if (!b.contains("uri")) return binary_;
    const auto [at, is_new] = buffers_.try_emplace(which);
    if (!is_new) return at->second;
    const auto uri = b["uri"].get<std::string>();
    if (uri.starts_with("data:")) {
      std::optional<std::string> decoded =
          decode_base64(std::string_view(uri).substr(std::min(uri.find(',') + 1, uri.size())));
      if (!decoded) throw Malformed{"a buffer is not base64"};
      at->second = *std::move(decoded);
    } else {
      // A file from elsewhere may name a device, which has no end, or a pipe, which no one writes to.
      std::error_code unknown;
      if (!std::filesystem::is_regular_file(folder_ + uri, unknown))
        throw Malformed{"there is no file " + overtet::quoted(uri) + ", in which it says its buffer is"};
      Result<std::string> file = read_file(folder_ + uri);
      if (!file) throw Malformed{"its buffer " + overtet::quoted(uri) + " cannot be read"};
      at->second = std::move(file).value();
    }
    return at->second;
  }

  // All numbers of an accessor, `width` an element.
  std::vector<double> accessor(std::size_t which, int width) {
    const Json& a = json_.at("accessors").at(which);
    const auto type = static_cast<std::int64_t>(number(a.at("componentType")));
    const std::size_t count = number(a.at("count"));
    const std::size_t size = component_size(type), element = size * static_cast<std::size_t>(width);
    static constexpr const char* names[] = {"", "SCALAR", "VEC2", "VEC3", "VEC4"};
    if (size == 0 || a.at("type") != names[width])
      throw Malformed{"accessor " + std::to_string(which) + " has another type than it should"};
    if (a.contains("sparse"))
      throw Malformed{"accessor " + std::to_string(which) + " is sparse; save it plainly"};
    const Json& view = json_.at("bufferViews").at(number(a.at("bufferView")));
    const std::string_view bytes = buffer(number(view.at("buffer")));
    const auto or_else = [](const Json& of, const char* key, std::size_t otherwise) {
      return of.contains(key) ? number(of[key]) : otherwise;
    };
    const std::size_t stride = or_else(view, "byteStride", element);
    const std::size_t begin = or_else(view, "byteOffset", 0) + or_else(a, "byteOffset", 0);
    if (stride < element || begin > bytes.size() ||
        (count > 0 &&
         (element > bytes.size() - begin || count - 1 > (bytes.size() - begin - element) / stride)))
      throw Malformed{"accessor " + std::to_string(which) + " points outside its buffer"};
    std::vector<double> out;
    out.reserve(count * static_cast<std::size_t>(width));
    const bool normalized = a.value("normalized", false);
    for (std::size_t i = 0; i < count; ++i)
      for (std::size_t k = 0; k < static_cast<std::size_t>(width); ++k)
        out.push_back(component(bytes.data() + begin + i * stride + k * size, type, normalized));
    return out;
  }

  void finish() {
    groups_.finish(out_.sizes.size(), out_.attributes);
    for (auto& [name, data] : data_)
      if (data.width > 0 && data.values.size() == out_.xyz.size() / 3 * static_cast<std::size_t>(data.width))
        out_.attributes.vertex_data.push_back(std::move(data));
  }

  std::string folder_;
  SurfaceReadInfo& info_;
  Json json_;
  std::string_view binary_;
  std::set<std::size_t> met_;  // nodes
  std::map<std::size_t, std::string> buffers_;
  Polygons out_;
  FaceGroups groups_;
  std::map<std::string, Attribute> data_;
};

}  // namespace

bool is_gltf(std::string_view bytes) {
  if (bytes.starts_with("glTF") && bytes.size() >= 12) return true;
  const std::size_t brace = bytes.find_first_not_of(" \t\r\n");
  return brace != std::string_view::npos && bytes[brace] == '{' &&
         bytes.find("\"asset\"") != std::string_view::npos;
}

Result<Polygons> parse_gltf(std::string_view name, const std::string& folder, std::string_view bytes,
                            SurfaceReadInfo& info) {
  if (bytes.starts_with("glTF") && word_at(bytes, 4) != 2)
    return malformed(name, "this is not version 2 of glTF");
  try {
    return GltfReader(folder, info).read(bytes);
  } catch (const Malformed& m) {
    return malformed(name, m.what);
  } catch (const Json::parse_error& e) {  // whose words quote the file
    return malformed(name, "this is no JSON that Overtet can read (at byte " + std::to_string(e.byte) + ")");
  } catch (const Json::exception& e) {
    return malformed(name, std::string("this is no glTF that Overtet can read (") + e.what() + ")");
  }
}

}  // namespace overtet::io_detail
