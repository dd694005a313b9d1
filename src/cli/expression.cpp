#include "src/cli/expression.h"

#include <dlfcn.h>
#include <muParserDLL.h>

#include <array>
#include <fstream>
#include <iterator>
#include <memory>
#include <sstream>
#include <string>
#include <vector>

namespace overtet {

namespace {

// muParser's C functions, loaded when the first formula is read: with it comes the run-time library of
// OpenMP, and most runs read none.
struct MuParser {
  MuParser() {
    module = dlopen("libmuparser.so.2", RTLD_NOW | RTLD_LOCAL);
    // Where the loader does not look: as it was found when this was built.
    if (!module) module = dlopen(OVERTET_MUPARSER_FILE, RTLD_NOW | RTLD_LOCAL);
    if (!module) return;
    find("mupCreate", create);
    find("mupRelease", release);
    find("mupSetExpr", set_formula);
    find("mupDefineVar", define_variable);
    find("mupEval", evaluate);
    find("mupError", has_failed);
    find("mupGetErrorMsg", message);
  }
  template <class Function>
  void find(const char* name, Function*& function) {
    function = reinterpret_cast<Function*>(dlsym(module, name));
    complete = complete && function;
  }

  void* module = nullptr;
  bool complete = true;  // every function was found
  decltype(mupCreate)* create;
  decltype(mupRelease)* release;
  decltype(mupSetExpr)* set_formula;
  decltype(mupDefineVar)* define_variable;
  decltype(mupEval)* evaluate;
  decltype(mupError)* has_failed;
  decltype(mupGetErrorMsg)* message;
};

const MuParser& mu_parser() {
  static const MuParser functions;
  return functions;
}

// pre: mu_parser() is complete.
class Formula {
 public:
  // variables: of x, y, z and t the first ones that it may use.
  Formula(const std::string& text, std::size_t variables) : handle_(mu_parser().create(muBASETYPE_FLOAT)) {
    mu_parser().set_formula(handle_, text.c_str());
    const char* const names[] = {"x", "y", "z", "t"};
    for (std::size_t k = 0; k < variables; ++k) mu_parser().define_variable(handle_, names[k], &given_[k]);
  }
  ~Formula() { mu_parser().release(handle_); }
  Formula(const Formula&) = delete;
  Formula& operator=(const Formula&) = delete;

  double at(const Eigen::Vector3d& p, double t = 0) {
    given_ = {p[0], p[1], p[2], t};
    return mu_parser().evaluate(handle_);
  }
  // What is wrong with it, once it was evaluated; empty: nothing.
  std::string problem() const {
    if (!mu_parser().has_failed(handle_)) return {};
    std::string why = mu_parser().message(handle_);
    while (why.ends_with('.') || why.ends_with('\n')) why.pop_back();
    return why;
  }

 private:
  muParserHandle_t handle_;
  std::array<double, 4> given_{};
};

}  // namespace

Result<std::string> text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file) return Error{ErrorCode::io, "Cannot read " + path + "."};
  return text;
}

namespace {

// What stands there, or in the file that @ names.
Result<std::string> words_of(const std::string& formula) {
  return formula.starts_with('@') ? text_of(formula.substr(1)) : Result<std::string>(formula);
}

Result<std::shared_ptr<Formula>> parsed(const std::string& text, std::size_t variables) {
  if (!mu_parser().module || !mu_parser().complete)
    return Error{
        ErrorCode::io,
        "Formulas are read by muParser, and libmuparser.so.2 cannot be loaded; install libmuparser2v5."};
  const auto f = std::make_shared<Formula>(text, variables);
  (void)f->at({0, 0, 0});
  if (const std::string why = f->problem(); !why.empty())
    return Error{ErrorCode::usage, "The formula '" + text + "' is wrong: " + why + ". It may use x, y, z, " +
                                       (variables > 3 ? "t, " : "") +
                                       "numbers, + - * / ^, comparisons, and functions like sin and sqrt."};
  return f;
}

}  // namespace

Result<ScalarFunction> function_of(const std::string& formula) {
  const Result<std::string> text = words_of(formula);
  if (!text) return text.error();
  const Result<std::shared_ptr<Formula>> f = parsed(text.value(), 3);
  if (!f) return f.error();
  return ScalarFunction([f = f.value()](const Eigen::Vector3d& p) { return f->at(p); });
}

Result<VectorFunction> vector_function_of(const std::string& formulas) {
  const Result<std::string> text = words_of(formulas);
  if (!text) return text.error();
  std::vector<std::shared_ptr<Formula>> f;
  std::istringstream parts(text.value());
  for (std::string part; std::getline(parts, part, ';');) {
    const Result<std::shared_ptr<Formula>> one = parsed(part, 4);
    if (!one) return one.error();
    f.push_back(one.value());
  }
  if (f.size() != 3)
    return Error{ErrorCode::usage,
                 "'" + text.value() +
                     "' is no direction; write three formulas with semicolons between them, as "
                     "'0;0;0.1*t', in quotes."};
  return VectorFunction([f](const Eigen::Vector3d& p, double t) {
    return Eigen::Vector3d(f[0]->at(p, t), f[1]->at(p, t), f[2]->at(p, t));
  });
}

}  // namespace overtet
