// Functions that fit on a screen, and classes that can be kept in mind: at most 80 lines, at most 12 members
// that hold data, or a comment that says why.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <regex>
#include <string>
#include <vector>

namespace {

namespace fs = std::filesystem;

// A function or class of a source file that clang-format has formatted: where it begins, how many lines it
// has (of a class: how many members hold data), and the comment above it.
struct Block {
  int line = 0;
  std::string head, comment;
  int size = 0;
};

class Blocks {
 public:
  std::vector<Block> functions, classes;

  explicit Blocks(std::vector<std::string> lines) : lines_(std::move(lines)) { scan(0, lines_.size(), 0); }

 private:
  bool begins_at(std::size_t i, std::size_t indent) const {
    const std::string& l = lines_[i];
    return l.size() > indent && l.find_first_not_of(' ') == indent && !std::strchr("}#/", l[indent]);
  }
  static std::string code_of(const std::string& line) {
    const std::string code = line.substr(0, line.find("//"));
    return code.substr(0, code.find_last_not_of(' ') + 1);
  }

  // What begins in lines [begin, end) at an indentation.
  void scan(std::size_t begin, std::size_t end, std::size_t indent) {
    const std::string closing = std::string(indent, ' ') + "}";
    for (std::size_t i = begin; i < end; ++i) {
      if (!begins_at(i, indent)) continue;
      std::string head;
      std::size_t open = i;
      while (open < end && !lines_[open].empty()) {
        head += code_of(lines_[open]) + " ";
        const char last = head.size() > 1 ? head[head.size() - 2] : ' ';
        if (last == '{' || last == ';' || last == '}' || last == ':') break;
        ++open;
      }
      if (open >= end || !head.ends_with("{ ")) {
        i = std::max(i, open);
        continue;
      }
      std::size_t close = open + 1;
      while (close < end && !lines_[close].starts_with(closing)) ++close;
      take(i, open, close, head, indent);
      i = close;
    }
  }

  void take(std::size_t first, std::size_t open, std::size_t close, const std::string& head,
            std::size_t indent) {
    static const std::regex is_class(R"re(^(template\s*<.*>\s*)?(class|struct)\s+\w+[^()]*\{ $)re");
    if (head.starts_with("namespace") || head.starts_with("extern")) return scan(open + 1, close, indent);
    Block block{static_cast<int>(first) + 1, head, comment_above(first, indent), 0};
    if (std::regex_match(head, is_class)) {
      block.size = members(open + 1, close, indent + 2);
      classes.push_back(block);
      scan(open + 1, close, indent + 2);
    } else if (head.find('(') != std::string::npos) {
      block.size = static_cast<int>(close - first) + 1;
      functions.push_back(block);
    }
  }

  std::string comment_above(std::size_t first, std::size_t indent) const {
    std::string comment;
    const std::string start = std::string(indent, ' ') + "//";
    for (std::size_t i = first; i > 0 && lines_[i - 1].starts_with(start); --i)
      comment = lines_[i - 1] + comment;
    return comment;
  }

  // Declarations without parentheses; several names in one count each.
  int members(std::size_t begin, std::size_t end, std::size_t indent) const {
    static const std::regex no_data(
        R"re(^(using|friend|typedef|enum|class|struct|static|template|public|private)\b)re");
    static const std::regex angles(R"re(<[^<>]*>)re"), braces(R"re(\{[^{}]*\})re");
    int count = 0;
    for (std::size_t i = begin; i < end; ++i) {
      if (!begins_at(i, indent)) continue;
      std::string text;
      for (; i < end; ++i) {
        text += code_of(lines_[i]) + " ";
        const char last = text.size() > 1 ? text[text.size() - 2] : ' ';
        if (last == ';' || last == '{' || last == '}' || last == ':') break;
      }
      text = text.substr(std::min(text.find_first_not_of(' '), text.size()));
      if (text.ends_with("{ ")) {  // a body
        while (i + 1 < end && !lines_[i + 1].starts_with(std::string(indent, ' ') + "}")) ++i;
        ++i;
        continue;
      }
      for (std::string before; before != text;) before = text, text = std::regex_replace(text, angles, "");
      for (std::string before; before != text;) before = text, text = std::regex_replace(text, braces, "");
      const bool data = text.ends_with("; ") && !std::regex_search(text, no_data) &&
                        text.substr(0, text.find('=')).find('(') == std::string::npos;
      if (data) count += 1 + static_cast<int>(std::count(text.begin(), text.end(), ','));
    }
    return count;
  }

  const std::vector<std::string> lines_;
};

std::vector<std::string> lines_of(const fs::path& file) {
  std::vector<std::string> lines;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) lines.push_back(line);
  return lines;
}

TEST(Lengths, TheScannerSeesFunctionsAndMembers) {
  const Blocks blocks({"namespace a {",
                       "",
                       "// Why.",
                       "class B {",
                       " public:",
                       "  explicit B(int x)",
                       "      : x_(x) {",
                       "    f();",
                       "  }",
                       "  int g() const { return x_; }",
                       "",
                       " private:",
                       "  void h();",
                       "  std::map<int, int> m_, n_{1, 2};",
                       "  int x_ = f(3);",
                       "};",
                       "",
                       "// Long.",
                       "int k(",
                       "    int x) {",
                       "  if (x) {",
                       "  }",
                       "  return x;",
                       "}",
                       "}  // namespace a"});
  ASSERT_EQ(blocks.classes.size(), 1u);
  EXPECT_EQ(blocks.classes[0].size, 3);
  EXPECT_EQ(blocks.classes[0].comment, "// Why.");
  ASSERT_EQ(blocks.functions.size(), 2u);
  EXPECT_EQ(blocks.functions[0].size, 4);
  EXPECT_EQ(blocks.functions[1].line, 19);
  EXPECT_EQ(blocks.functions[1].size, 6);
  EXPECT_EQ(blocks.functions[1].comment, "// Long.");
}

// Those that are larger say why in the comment above them: "More than 80 lines: ...", "More than 12 members:
// ...".
TEST(Lengths, FunctionsAndClassesCanBeReadAtOnce) {
  constexpr int kMostLines = 80, kMostMembers = 12;
  const fs::path root = OVERTET_SOURCE_DIR;
  int functions = 0, classes = 0;
  for (const char* top : {"include", "kernels", "src"})
    for (const auto& entry : fs::recursive_directory_iterator(root / top)) {
      const std::string extension = entry.path().extension().string();
      if (extension != ".h" && extension != ".cpp") continue;
      const std::string file = fs::relative(entry.path(), root).string();
      const Blocks blocks(lines_of(entry.path()));
      functions += static_cast<int>(blocks.functions.size());
      classes += static_cast<int>(blocks.classes.size());
      for (const Block& f : blocks.functions)
        EXPECT_TRUE(f.size <= kMostLines || f.comment.find("More than 80 lines: ") != std::string::npos)
            << file << ":" << f.line << " has " << f.size << " lines: " << f.head;
      for (const Block& c : blocks.classes)
        EXPECT_TRUE(c.size <= kMostMembers || c.comment.find("More than 12 members: ") != std::string::npos)
            << file << ":" << c.line << " has " << c.size << " members: " << c.head;
    }
  EXPECT_GT(functions, 700);
  EXPECT_GT(classes, 150);
}

}  // namespace
