#include "src/cli/places.h"

#include <charconv>
#include <sstream>
#include <utility>

#include "src/cli/expression.h"

namespace overtet {

namespace {

Error bad_words(const std::string& what) { return {ErrorCode::usage, what}; }

// Numbers of vertices, counted from 0, with commas, blanks or line ends between them.
Result<std::vector<Index>> numbers_in(const std::string& text, const std::string& where) {
  std::vector<Index> out;
  std::string spaced = text;
  for (char& c : spaced)
    if (c == ',') c = ' ';
  std::istringstream words(spaced);
  for (std::string word; words >> word;) {
    Index n = 0;
    const auto [end, wrong] = std::from_chars(word.data(), word.data() + word.size(), n);
    if (wrong != std::errc() || end != word.data() + word.size() || n < 0)
      return bad_words(where + ": '" + word + "' is no number of a vertex.");
    out.push_back(n);
  }
  if (out.empty()) return bad_words(where + ": no vertex is named.");
  return out;
}

// A label by its number or its name.
Result<Index> label_in(const std::string& text, const LabelledTetMesh& mesh) {
  for (const auto& [number, name] : mesh.attributes.labels.names)
    if (name == text) return number;
  Index n = 0;
  const auto [end, wrong] = std::from_chars(text.data(), text.data() + text.size(), n);
  if (wrong == std::errc() && end == text.data() + text.size()) return n;
  return bad_words("The mesh has no label named '" + text + "'.");
}

}  // namespace

Result<BoundaryValue> place_in(const std::string& text, const LabelledTetMesh& mesh) {
  BoundaryValue out;
  if (text == "all") return out;
  const std::size_t colon = text.find(':');
  const std::string kind = text.substr(0, colon),
                    rest = colon == std::string::npos ? "" : text.substr(colon + 1);
  if (kind == "label" && !rest.empty()) {
    const Result<Index> label = label_in(rest, mesh);
    if (!label) return label.error();
    out.label = label.value();
    return out;
  }
  if (kind == "vertices" && !rest.empty()) {
    std::string list = rest;
    if (rest.starts_with('@')) {
      Result<std::string> read = text_of(rest.substr(1));
      if (!read) return read.error();
      list = std::move(read).value();
    }
    Result<std::vector<Index>> numbers = numbers_in(list, text);
    if (!numbers) return numbers.error();
    out.vertices = std::move(numbers).value();
    return out;
  }
  return bad_words("'" + text +
                   "' is no place; write all, label:NUMBER, label:NAME, vertices:N,N,... or vertices:@FILE.");
}

namespace {

// WHERE=FORMULA, read by `function_in`.
template <class Condition, class Function>
Result<std::vector<Condition>> conditions(const std::vector<std::string>& words, const LabelledTetMesh& mesh,
                                          const char* form,
                                          Result<Function> (*function_in)(const std::string&)) {
  std::vector<Condition> out;
  for (const std::string& word : words) {
    const std::size_t equals = word.find('=');
    if (equals == std::string::npos) return bad_words("'" + word + "' gives no value; write " + form + ".");
    Result<BoundaryValue> place = place_in(word.substr(0, equals), mesh);
    if (!place) return place.error();
    Result<Function> function = function_in(word.substr(equals + 1));
    if (!function) return function.error();
    out.push_back({place.value().label, std::move(place.value().vertices), std::move(function).value()});
  }
  return out;
}

}  // namespace

Result<std::vector<BoundaryValue>> conditions_in(const std::vector<std::string>& words,
                                                 const LabelledTetMesh& mesh) {
  return conditions<BoundaryValue>(words, mesh, "WHERE=FORMULA", function_of);
}

Result<std::vector<ElasticCondition>> vector_conditions_in(const std::vector<std::string>& words,
                                                           const LabelledTetMesh& mesh) {
  return conditions<ElasticCondition>(words, mesh, "'WHERE=FORMULA;FORMULA;FORMULA'", vector_function_of);
}

Result<std::vector<Index>> vertices_of(const std::vector<std::string>& words, const LabelledTetMesh& mesh) {
  std::vector<Index> out;
  for (const std::string& word : words) {
    const Result<BoundaryValue> place = place_in(word, mesh);
    if (!place) return place.error();
    const BoundaryValue& p = place.value();
    out.insert(out.end(), p.vertices.begin(), p.vertices.end());
    if (!p.vertices.empty()) continue;
    const TriangleMatrix& F = mesh.attributes.triangles;
    const std::size_t before = out.size();
    for (Eigen::Index f = 0; f < F.rows(); ++f)
      if (!p.label || mesh.attributes.labels.of[static_cast<std::size_t>(f)] == *p.label)
        for (int k = 0; k < 3; ++k) out.push_back(F(f, k));
    if (out.size() == before) return bad_words("No triangle of the mesh is in " + word + ".");
  }
  return out;
}

}  // namespace overtet
