#include "src/cli/arguments.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

namespace overtet {

namespace {

// Letters put in, left out, changed, or two neighbours exchanged: how many of these lead from a to b.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> before, last(b.size() + 1), now(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) last[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    now[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t change = last[j - 1] + (a[i - 1] != b[j - 1]);
      now[j] = std::min({change, last[j] + 1, now[j - 1] + 1});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1])
        now[j] = std::min(now[j], before[j - 2] + 1);
    }
    before = last;
    last = now;
  }
  return last[b.size()];
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    names.push_back(command->get_name());
  return names;
}

std::vector<std::string> options_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  return names;
}

std::string listed(const std::vector<std::string>& words) {
  std::string text;
  for (std::size_t i = 0; i < words.size(); ++i)
    text.append(i == 0 ? "" : i + 1 == words.size() ? " and " : ", ").append(words[i]);
  return text;
}

bool is_file_like(const std::string& word) {
  std::error_code ignored;
  return word == "-" || word.find_first_of("./") != std::string::npos ||
         std::filesystem::exists(word, ignored);
}

Error no_command(const std::string& word, const std::vector<std::string>& commands) {
  const std::string meant = most_like(word, commands);
  return {ErrorCode::usage, "There is no command " + word +
                                (meant.empty() ? "; the commands are " + listed(commands) + "."
                                               : "; do you mean " + meant + "?")};
}

std::string plain(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.15g", x);
  std::string s = text;
  if (s.find('e') == std::string::npos) return s;
  std::snprintf(text, sizeof text, "%.9f", x);
  s = text;
  s.erase(s.find_last_not_of('0') + 1);
  return s;
}

// What is wrong with a number, or nothing.
std::string outside(const std::string& text, const std::string& wanted, bool (*right)(double, double, double),
                    double low, double high) {
  char* end = nullptr;
  const double x = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != 0 || std::isnan(x)) return text + " is not a number";
  return right(x, low, high) ? std::string() : text + " is not " + wanted;
}

}  // namespace

std::string most_like(const std::string& word, const std::vector<std::string>& candidates) {
  std::string best;
  std::size_t least = std::max<std::size_t>(1, word.size() / 3) + 1;
  for (const std::string& c : candidates)
    if (const std::size_t d = distance(word, c); d < least) least = d, best = c;
  if (!best.empty()) return best;
  for (const std::string& c : candidates)  // the beginning of a word is like it, too
    if (word.size() > 3 && c.starts_with(word)) return c;
  return "";
}

Result<std::vector<std::string>> understood(std::vector<std::string> words, const CLI::App& app) {
  const std::vector<std::string> commands = commands_of(app);
  const auto known = [&](const std::string& w) {
    return std::find(commands.begin(), commands.end(), w) != commands.end();
  };
  if (words.empty())
    return Error{ErrorCode::usage,
                 "Say what to do: the commands are " + listed(commands) + " (see overtet --help)."};
  if (words[0] == "version" || words[0] == "-V") return std::vector<std::string>{"--version"};
  if (words[0] == "--version" || words[0] == "--help" || words[0] == "-h") return words;
  if (words[0] == "help") {
    if (words.size() == 1) return std::vector<std::string>{"--help"};
    if (!known(words[1])) return no_command(words[1], commands);
    return std::vector<std::string>{words[1], "--help"};
  }
  if (!known(words[0])) {
    if (!is_file_like(words[0]) && !words[0].starts_with("-")) return no_command(words[0], commands);
    words.insert(words.begin(), "mesh");
  }
  const CLI::App& command = *app.get_subcommand(words[0]);
  const std::vector<std::string> options = options_of(command);
  for (std::size_t i = 1; i < words.size() && words[i] != "--"; ++i) {
    const std::string name = words[i].substr(0, words[i].find('='));
    if (!name.starts_with("--") || std::find(options.begin(), options.end(), name) != options.end()) continue;
    const std::string meant = most_like(name, options);
    return Error{ErrorCode::usage, words[0] + " has no option " + name +
                                       (meant.empty() ? " (see overtet " + words[0] + " --help)."
                                                      : "; do you mean " + meant + "?")};
  }
  return words;
}

CLI::Validator between(double low, double high) {
  const std::string range = "from " + plain(low) + " to " + plain(high);
  return CLI::Validator(
      [=](const std::string& text) {
        return outside(
            text, range, [](double x, double a, double b) { return x >= a && x <= b; }, low, high);
      },
      range);
}

CLI::Validator more_than_zero() {
  return CLI::Validator(
      [](const std::string& text) {
        return outside(
            text, "more than 0", [](double x, double, double) { return x > 0; }, 0, 0);
      },
      "more than 0");
}

}  // namespace overtet
