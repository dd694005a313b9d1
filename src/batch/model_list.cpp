#include "src/batch/model_list.h"

#include <algorithm>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <nlohmann/json.hpp>
#include <queue>
#include <set>
#include <sstream>
#include <utility>

namespace overtet {

namespace {

namespace fs = std::filesystem;

std::string lower(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return text;
}

// "a/b.obj.gz" -> "a/b": what is left without the ending of a surface.
std::string without_ending(const std::string& name) {
  fs::path path = name;
  if (lower(path.extension()) == ".gz") path.replace_extension();
  path.replace_extension();
  // "...obj" has a name with its ending only.
  return path.filename() == "." || path.filename() == ".." ? name : path.string();
}

// What a manifest has, as a message quotes it: on one line, and not longer than a path may be.
std::string quoted(const std::string& text) {
  std::string out = text.substr(0, 256);
  for (char& c : out)
    if (static_cast<unsigned char>(c) < ' ' || c == 127) c = '?';
  return "\"" + out + (text.size() > out.size() ? "...\"" : "\"");
}

// A relative path that stays inside the folder that it is put into.
std::string inside(const std::string& name) {
  fs::path kept;
  for (const fs::path& part : fs::path(name).relative_path())
    if (part != "." && part != ".." && !part.empty()) kept /= part;
  return kept;
}

struct Listed {
  Model model;
  std::string full;  // its name with the ending
  bool named = false;
};

// Gives names that differ.
std::vector<Model> with_names(std::vector<Listed> listed) {
  const auto count_names = [&] {
    std::map<std::string, int> counts;
    for (const Listed& l : listed) ++counts[l.model.name];
    return counts;
  };
  const auto first = count_names();
  for (Listed& l : listed)
    if (!l.named && first.at(l.model.name) > 1) l.model.name = l.full;
  const auto second = count_names();
  std::set<std::string> taken;
  for (const auto& [name, count] : second) taken.insert(name);
  std::map<std::string, int> seen;
  std::vector<Model> models;
  for (Listed& l : listed) {
    const std::string name = l.model.name;
    if (const int before = seen[name]++; before > 0) {
      int number = before + 1;
      while (!taken.insert(name + "_" + std::to_string(number)).second) ++number;
      l.model.name = name + "_" + std::to_string(number);
    }
    models.push_back(std::move(l.model));
  }
  std::sort(models.begin(), models.end(), [](const Model& a, const Model& b) { return a.name < b.name; });
  return models;
}

std::int64_t size_of(const std::string& path) {
  std::error_code none;
  const auto bytes = fs::is_regular_file(path, none) ? fs::file_size(path, none) : 0;
  return none ? 0 : static_cast<std::int64_t>(bytes);
}

Listed listed_as(const std::string& path, const std::string& name) {
  Listed l;
  l.model.path = path;
  l.full = inside(name);
  l.model.name = without_ending(l.full);
  l.model.bytes = size_of(path);
  return l;
}

// One line of a manifest that is JSON.
Result<Listed> read_json_line(const std::string& line, const fs::path& folder) {
  const auto wrong = [](const std::string& what) { return Error{ErrorCode::bad_input, what}; };
  const auto json = nlohmann::json::parse(line, nullptr, false);
  if (!json.is_object()) return wrong("is no JSON object");
  for (const auto& [key, value] : json.items())
    if (key != "input" && key != "output" && key != "options")
      return wrong("has the key " + quoted(key) + "; known are input, output and options");
  const auto input = json.find("input");
  if (input == json.end() || !input->is_string() || input->get<std::string>().empty())
    return wrong("has no \"input\" that is a path");
  Listed l = listed_as(folder / input->get<std::string>(), *input);
  if (const auto output = json.find("output"); output != json.end()) {
    if (!output->is_string() || inside(*output).empty()) return wrong("has an \"output\" that is no name");
    l.full = l.model.name = inside(*output);
    l.named = true;
  }
  if (const auto options = json.find("options"); options != json.end()) {
    if (!options->is_array()) return wrong("has \"options\" that are no list of words");
    for (const auto& word : *options) {
      if (!word.is_string()) return wrong("has \"options\" that are no list of words");
      l.model.options.push_back(word);
    }
  }
  return l;
}

Result<std::vector<Model>> models_in_folder(const std::string& folder, const std::string& except) {
  std::error_code code;
  std::vector<Listed> found;
  fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied, code), end;
  for (; !code && at != end; at.increment(code)) {
    std::error_code none;
    if (at->is_directory(none) && !except.empty() && fs::equivalent(at->path(), except, none)) {
      at.disable_recursion_pending();
      continue;
    }
    if (!is_surface_name(at->path()) || !at->is_regular_file(none)) continue;
    found.push_back(listed_as(at->path(), at->path().lexically_relative(folder)));
  }
  if (code) return Error{ErrorCode::io, "Cannot read the folder " + folder + ": " + code.message() + "."};
  // The order of a folder is nobody's.
  std::sort(found.begin(), found.end(), [](const Listed& a, const Listed& b) { return a.full < b.full; });
  return with_names(std::move(found));
}

}  // namespace

bool is_surface_name(const std::string& name) {
  fs::path path = lower(name);
  if (path.extension() == ".gz") path = path.stem();
  static const std::set<std::string> endings = {".obj", ".off", ".ply", ".stl", ".glb", ".gltf", ".vtp"};
  return endings.contains(path.extension());
}

Result<std::vector<Model>> models_of_manifest(const std::string& text, const std::string& folder,
                                              const std::string& manifest_name) {
  std::vector<Listed> list;
  std::istringstream in(text);
  int number = 0;
  for (std::string line; std::getline(in, line);) {
    ++number;
    if (!line.empty() && line.back() == '\r') line.pop_back();
    if (line.empty() || line[0] == '#') continue;
    if (line[0] != '{') {
      list.push_back(listed_as(fs::path(folder) / line, line));
      continue;
    }
    Result<Listed> read = read_json_line(line, folder);
    if (!read)
      return Error{ErrorCode::bad_input,
                   manifest_name + ": line " + std::to_string(number) + " " + read.error().message + "."};
    list.push_back(std::move(read).value());
  }
  for (const Listed& l : list)
    if (l.model.name.empty() || l.model.path.find('\0') != std::string::npos ||
        l.model.name.find('\0') != std::string::npos)
      return Error{ErrorCode::bad_input,
                   manifest_name + ": " + quoted(l.model.path) + " is no path of a file."};
  return with_names(std::move(list));
}

Result<std::vector<Model>> models_of(const std::string& manifest_or_folder, const std::string& except) {
  std::error_code none;
  if (fs::is_directory(manifest_or_folder, none)) return models_in_folder(manifest_or_folder, except);
  std::ifstream in(manifest_or_folder, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in || in.bad())
    return Error{ErrorCode::io,
                 "Cannot read " + manifest_or_folder + ": there is no such folder or manifest."};
  return models_of_manifest(text, fs::path(manifest_or_folder).parent_path(), manifest_or_folder);
}

void sort_by_size(std::vector<Model>& models) {
  std::sort(models.begin(), models.end(), [](const Model& a, const Model& b) {
    return a.bytes != b.bytes ? a.bytes > b.bytes : a.name < b.name;
  });
}

std::vector<Model> shard_of(std::vector<Model> models, int index, int count) {
  sort_by_size(models);
  using Load = std::pair<std::int64_t, int>;  // bytes, shard
  std::priority_queue<Load, std::vector<Load>, std::greater<>> loads;
  for (int i = 1; i <= count; ++i) loads.push({0, i});
  std::vector<Model> own;
  for (Model& model : models) {
    const auto [bytes, shard] = loads.top();
    loads.pop();
    loads.push({bytes + std::max<std::int64_t>(model.bytes, 1), shard});
    if (shard == index) own.push_back(std::move(model));
  }
  return own;
}

}  // namespace overtet
