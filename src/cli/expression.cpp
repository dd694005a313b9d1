#include "src/cli/expression.h"

#include <muParser.h>

#include <array>
#include <fstream>
#include <iterator>
#include <memory>

namespace overtet {

namespace {

struct Formula {
  mu::Parser parser;
  std::array<double, 3> place{};
  explicit Formula(const std::string& text) {
    parser.SetExpr(text);
    parser.DefineVar("x", &place[0]);
    parser.DefineVar("y", &place[1]);
    parser.DefineVar("z", &place[2]);
  }
};

}  // namespace

Result<std::string> text_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string text((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  if (!file) return Error{ErrorCode::io, "Cannot read " + path + "."};
  return text;
}

Result<ScalarFunction> function_of(const std::string& formula) {
  std::string text = formula;
  if (formula.starts_with('@')) {
    Result<std::string> read = text_of(formula.substr(1));
    if (!read) return read.error();
    text = std::move(read).value();
  }
  try {
    const auto f = std::make_shared<Formula>(text);
    (void)f->parser.Eval();  // says what is wrong with it
    return ScalarFunction([f](const Eigen::Vector3d& p) {
      f->place = {p[0], p[1], p[2]};
      return f->parser.Eval();
    });
  } catch (const mu::Parser::exception_type& e) {
    std::string why = e.GetMsg();
    while (why.ends_with('.') || why.ends_with('\n')) why.pop_back();
    return Error{
        ErrorCode::usage,
        "The formula '" + text + "' is wrong: " + why +
            ". It may use x, y, z, numbers, + - * / ^, comparisons, and functions like sin and sqrt."};
  }
}

}  // namespace overtet
