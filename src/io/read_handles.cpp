// Handles and poses: JSON and TGF (overtet/weights.h, docs/handles.md).
#include <algorithm>
#include <array>
#include <cmath>
#include <initializer_list>
#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <set>

#include "overtet/weights.h"
#include "src/io/file.h"
#include "src/io/names.h"
#include "src/io/surface_parts.h"
#include "src/io/text.h"

namespace overtet {

namespace {

using Json = nlohmann::json;
using io_detail::kMaxCount;

Error in_file(std::string_view file, const std::string& what) {
  return {ErrorCode::bad_input, std::string(file) + ": " + what + "."};
}

bool is_index(const Json& j) {
  return j.is_number_integer() && j.get<double>() >= 0 && j.get<double>() < kMaxCount;
}

bool read_numbers(const Json& j, std::size_t count, double* out) {
  if (!j.is_array() || j.size() != count) return false;
  for (std::size_t k = 0; k < count; ++k) {
    if (!j[k].is_number()) return false;
    out[k] = j[k].get<double>();
    if (!std::isfinite(out[k])) return false;
  }
  return true;
}

// The first key that is none of these.
std::optional<std::string> strange_key(const Json& j, std::initializer_list<const char*> known) {
  for (const auto& [key, value] : j.items())
    if (std::none_of(known.begin(), known.end(), [&](const char* k) { return key == k; })) return key;
  return std::nullopt;
}

class HandleReader {
 public:
  explicit HandleReader(std::string_view file) : file_(file) {}

  Result<Handles> read(const Json& j) {
    if (!j.is_object() || !j.contains("handles") || !j["handles"].is_array())
      return in_file(file_, "a file of handles is an object with a list \"handles\"");
    if (const auto key = strange_key(j, {"handles", "cage_edges", "cage_faces"}))
      return in_file(file_, "there is no \"" + one_line(*key) + "\" beside \"handles\"");
    std::vector<std::string> parents;
    for (const Json& entry : j["handles"]) {
      parents.emplace_back();
      if (Status s = add(entry, parents.back()); !s) return s.error();
    }
    for (std::size_t h = 0; h < parents.size(); ++h) {
      if (parents[h].empty()) continue;
      const auto found = numbers_.find(parents[h]);
      if (found == numbers_.end())
        return in_file(file_, "the parent " + overtet::quoted(parents[h]) + " of handle " +
                                  overtet::quoted(out_.handles[h].name) + " is none of the handles");
      out_.handles[h].parent = found->second;
    }
    if (Status s = cage(j, "cage_edges", out_.cage_edges); !s) return s.error();
    if (Status s = cage(j, "cage_faces", out_.cage_faces); !s) return s.error();
    if (Status s = out_.validate(); !s)
      return Error{ErrorCode::bad_input, std::string(file_) + ": " + s.error().message};
    return std::move(out_);
  }

 private:
  Status add(const Json& j, std::string& parent) {
    const std::string number = "handle " + std::to_string(out_.handles.size()) + " (counted from 0)";
    if (!j.is_object() || !j.contains("name") || !j["name"].is_string() ||
        j["name"].get<std::string>().empty())
      return in_file(file_, number + " is no object with a \"name\"");
    Handle h;
    h.name = one_line(j["name"].get<std::string>());
    const std::string what = "handle " + overtet::quoted(h.name);
    if (const auto key =
            strange_key(j, {"name", "position", "vertex", "layer", "head", "tail", "tail_layer", "parent"}))
      return in_file(file_, what + " has a \"" + one_line(*key) + "\", which no handle has");
    if (j.contains("parent")) {
      if (!j["parent"].is_string()) return in_file(file_, "the \"parent\" of " + what + " is no name");
      parent = one_line(j["parent"].get<std::string>());
    }
    const bool bone = j.contains("tail");
    if (bone ? j.contains("position") || j.contains("vertex")
             : j.contains("head") || j.contains("tail_layer") ||
                   j.contains("position") == j.contains("vertex"))
      return in_file(file_, what +
                                " needs either a \"position\" or a \"vertex\" (a point), or a \"head\" and a "
                                "\"tail\" (a bone)");
    if (bone) {
      if (Status s = add_bone(j, what, parent, h); !s) return s;
    } else {
      HandlePlace place;
      if (Status s = end(j, j.contains("vertex") ? "vertex" : "position", "layer", what, place); !s) return s;
      if (j.contains("vertex") != place.vertex.has_value())
        return in_file(file_, what + ": a \"vertex\" is a number, a \"position\" are three");
      h.place = add_place(place);
    }
    if (!numbers_.emplace(h.name, static_cast<int>(out_.handles.size())).second)
      return in_file(file_, "two handles are named " + overtet::quoted(h.name));
    out_.handles.push_back(h);
    return success();
  }

  // A head that is left out is the parent's tail; one that is where an earlier bone ends or begins is that
  // place.
  Status add_bone(const Json& j, const std::string& what, const std::string& parent, Handle& h) {
    if (j.contains("head")) {
      HandlePlace head;
      if (Status s = end(j, "head", "layer", what, head); !s) return s;
      const auto there = ends_.find(key(head));
      h.place = there != ends_.end() && !head.layer ? there->second : add_place(head);
      ends_.emplace(key(head), h.place);
    } else {
      const auto found = numbers_.find(parent);
      if (found == numbers_.end() || !out_.handles[static_cast<std::size_t>(found->second)].bone())
        return in_file(file_, what + " has no \"head\", and no bone before it is its parent");
      h.place = out_.handles[static_cast<std::size_t>(found->second)].tail;
    }
    HandlePlace tail;
    if (Status s = end(j, "tail", "tail_layer", what, tail); !s) return s;
    h.tail = add_place(tail);
    ends_.emplace(key(tail), h.tail);
    return success();
  }

  using Key = std::array<double, 4>;
  static Key key(const HandlePlace& p) {
    return p.vertex ? Key{static_cast<double>(*p.vertex), 0, 0, 1}
                    : Key{p.position[0], p.position[1], p.position[2], 0};
  }

  int add_place(const HandlePlace& place) {
    out_.places.push_back(place);
    return static_cast<int>(out_.places.size()) - 1;
  }

  // A place: three coordinates, or the number of a vertex.
  Status end(const Json& j, const char* key, const char* layer, const std::string& what,
             HandlePlace& place) const {
    const Json& at = j[key];
    if (is_index(at))
      place.vertex = at.get<Index>();
    else if (!read_numbers(at, 3, place.position.data()))
      return in_file(file_, std::string("the \"") + key + "\" of " + what +
                                " must be three numbers, or the number of a vertex");
    if (!j.contains(layer)) return success();
    if (!is_index(j[layer]))
      return in_file(file_, std::string("the \"") + layer + "\" of " + what + " is no number of a layer");
    place.layer = j[layer].get<Index>();
    return success();
  }

  template <std::size_t N>
  Status cage(const Json& j, const char* key, std::vector<std::array<int, N>>& out) const {
    if (!j.contains(key)) return success();
    const auto bad = [&] {
      return in_file(file_, std::string("\"") + key + "\" are lists of " + std::to_string(N) +
                                " names of point handles each");
    };
    if (!j[key].is_array()) return bad();
    for (const Json& entry : j[key]) {
      if (!entry.is_array() || entry.size() != N) return bad();
      std::array<int, N> places{};
      for (std::size_t k = 0; k < N; ++k) {
        if (!entry[k].is_string()) return bad();
        const auto found = numbers_.find(one_line(entry[k].get<std::string>()));
        if (found == numbers_.end()) return bad();
        places[k] = out_.handles[static_cast<std::size_t>(found->second)].place;
      }
      out.push_back(places);
    }
    return success();
  }

  std::string_view file_;
  Handles out_;
  std::map<std::string, int> numbers_;  // of the handles, by name
  std::map<Key, int> ends_;             // of bones: the first place there
};

// Points of no bone are handles, then the bones.
Result<Handles> read_tgf(std::string_view file, std::string_view text) {
  TextCursor in(file, text, false);
  Handles out;
  std::vector<std::array<int, 2>> bones;
  std::map<std::int64_t, int> number;
  bool edges = false;
  for (; !in.at_end(); in.next_line()) {
    if (in.at_line_end()) continue;
    const std::int64_t line = in.line();
    if (in.is_at('#')) {
      if (edges) break;  // what comes after a second one is no matter of handles
      edges = true;
      continue;
    }
    std::int64_t a = 0, b = 0;
    const auto integer = [&](std::int64_t& x, const char* what) {
      return in.integer(x, [&] { return what; });
    };
    if (!edges) {
      HandlePlace p;
      if (!integer(a, "number of a point")) return in.error();
      for (double& x : p.position)
        if (!in.real(x, [&] { return "coordinate of a point"; })) return in.error();
      if (!number.emplace(a, static_cast<int>(out.places.size())).second) {
        in.fail_at(line, "two points have the number " + std::to_string(a));
        return in.error();
      }
      out.places.push_back(p);
      continue;
    }
    if (!integer(a, "number of a point") || !integer(b, "number of a point")) return in.error();
    std::int64_t is[3] = {0, 0, 0};
    for (std::int64_t& flag : is)
      if (!in.at_line_end() && !integer(flag, "0 or 1")) return in.error();
    if (!number.contains(a) || !number.contains(b) || a == b) {
      in.fail_at(line, "an edge joins two different points that come before the #");
      return in.error();
    }
    const std::array<int, 2> edge{number[a], number[b]};
    if (is[0]) bones.push_back(edge);
    if (is[2]) out.cage_edges.push_back(edge);
  }
  std::set<int> of_bones;
  for (const auto& [a, b] : bones) of_bones.insert({a, b});
  for (const auto& [n, place] : number)
    if (!of_bones.contains(place)) {
      Handle h;
      h.name = "point_" + std::to_string(n);
      h.place = place;
      out.handles.push_back(h);
    }
  const int first = static_cast<int>(out.handles.size());
  std::map<int, int> ending;  // the first bone that ends at a place
  for (std::size_t i = 0; i < bones.size(); ++i) ending.emplace(bones[i][1], static_cast<int>(i));
  for (std::size_t i = 0; i < bones.size(); ++i) {
    Handle h;
    h.name = "bone_" + std::to_string(i + 1);
    h.place = bones[i][0];
    h.tail = bones[i][1];
    if (const auto before = ending.find(h.place);
        before != ending.end() && before->second != static_cast<int>(i))
      h.parent = first + before->second;
    out.handles.push_back(h);
  }
  if (Status s = out.validate(); !s)
    return Error{ErrorCode::bad_input, std::string(file) + ": " + s.error().message};
  return out;
}

Result<Json> json_of(std::string_view file, std::string_view text) {
  Json j = Json::parse(text, nullptr, false);
  if (j.is_discarded()) return in_file(file, "this is no JSON");
  return j;
}

Status read_motion(std::string_view file, const std::string& name, const Json& j, HandlePose& pose) {
  const std::string what = "the motion of " + overtet::quoted(name);
  if (!j.is_object()) return in_file(file, what + " is no object");
  if (const auto key = strange_key(j, {"axis", "degrees", "quaternion", "translation", "matrix"}))
    return in_file(file, what + " has a \"" + one_line(*key) + "\", which no motion has");
  if (j.contains("matrix")) {
    if (j.size() != 1) return in_file(file, what + " has a \"matrix\" and what that already says");
    AffineMatrix m;
    bool right = j["matrix"].is_array() && j["matrix"].size() == 3;
    for (std::size_t r = 0; r < 3 && right; ++r) right = read_numbers(j["matrix"][r], 4, m.data() + 4 * r);
    if (!right) return in_file(file, "the \"matrix\" of " + what + " must be three rows of four numbers");
    pose.matrix = m;
    return success();
  }
  if (j.contains("axis") != j.contains("degrees") || (j.contains("axis") && j.contains("quaternion")))
    return in_file(file, what + " has an \"axis\" with \"degrees\", or a \"quaternion\"");
  if (j.contains("axis")) {
    Eigen::Vector3d axis;
    if (!read_numbers(j["axis"], 3, axis.data()) || !(axis.norm() > 0) || !j["degrees"].is_number())
      return in_file(file, what + ": an \"axis\" is three numbers, not all 0, and \"degrees\" is one");
    pose.rotation =
        Eigen::AngleAxisd(j["degrees"].get<double>() * (std::acos(-1.0) / 180), axis.normalized());
  }
  if (j.contains("quaternion") &&
      (!read_numbers(j["quaternion"], 4, pose.rotation.coeffs().data()) || !(pose.rotation.norm() > 0)))
    return in_file(file, what + ": a \"quaternion\" is four numbers x, y, z, w, not all 0");
  if (j.contains("translation") && !read_numbers(j["translation"], 3, pose.translation.data()))
    return in_file(file, what + ": a \"translation\" is three numbers");
  return success();
}

}  // namespace

Result<Handles> parse_handles(std::string_view name, std::string_view text) {
  if (io_detail::parts_of_name(name).extension == "tgf") return read_tgf(name, text);
  const Result<Json> j = json_of(name, text);
  if (!j) return j.error();
  return HandleReader(name).read(j.value());
}

Result<Handles> read_handles(const std::string& path) {
  const Result<std::string> text = read_file(path);
  if (!text) return text.error();
  return parse_handles(path, text.value());
}

Result<std::vector<HandlePose>> parse_pose(std::string_view file, std::string_view json,
                                           const Handles& handles) {
  const Result<Json> j = json_of(file, json);
  if (!j) return j.error();
  if (!j.value().is_object())
    return in_file(file, "a pose is an object: of each handle that moves, by its name, its motion");
  std::vector<HandlePose> out(handles.handles.size());
  for (const auto& [name, motion] : j.value().items()) {
    const std::string known = one_line(name);
    const auto found = std::find_if(handles.handles.begin(), handles.handles.end(),
                                    [&](const Handle& h) { return h.name == known; });
    if (found == handles.handles.end())
      return in_file(file, overtet::quoted(name) + " is none of the handles");
    HandlePose& pose = out[static_cast<std::size_t>(found - handles.handles.begin())];
    if (Status s = read_motion(file, name, motion, pose); !s) return s.error();
  }
  return out;
}

Result<std::vector<HandlePose>> read_pose(const std::string& path, const Handles& handles) {
  const Result<std::string> text = read_file(path);
  return text ? parse_pose(path, text.value(), handles) : Result<std::vector<HandlePose>>(text.error());
}

}  // namespace overtet
