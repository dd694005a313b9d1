#include "src/cli/shell_help.h"

#include <algorithm>
#include <functional>
#include <sstream>
#include <vector>

#include "overtet/version.h"

namespace overtet {

namespace {

struct OptionHelp {
  std::vector<std::string> names;  // "-o", "--output"; a positional one's only name
  std::string text;
  std::vector<std::string> words;  // that it takes; empty: any
  bool positional = false, takes_value = false, is_required = false, repeats = false;
};

struct CommandHelp {
  std::string name, text, footer;
  std::vector<OptionHelp> options;  // positional ones first
};

// The words of a validator that lets through only some: it describes itself as "{a,b,c}".
std::vector<std::string> words_of(CLI::Option& option) {
  std::vector<std::string> words;
  const std::string type = option.get_type_name();
  for (int i = 0;; ++i) {
    std::string set;
    try {
      set = option.get_validator(i)->get_description();
    } catch (const CLI::OptionNotFound&) {
      return words;
    }
    if (set.size() < 2 || set.front() != '{' || set.back() != '}') continue;
    std::istringstream in(set.substr(1, set.size() - 2));
    for (std::string word; std::getline(in, word, ',');) words.push_back(word);
  }
}

CommandHelp help_of(const CLI::App& app) {
  CommandHelp help{app.get_name(), app.get_description(), app.get_footer(), {}};
  for (const CLI::Option* given : app.get_options()) {
    auto& option = const_cast<CLI::Option&>(*given);  // CLI11 shows validators of what may be changed only
    OptionHelp o;
    o.positional = option.get_positional();
    if (o.positional)
      o.names = {option.get_name(true)};
    else {
      for (const std::string& name : option.get_snames()) o.names.push_back("-" + name);
      for (const std::string& name : option.get_lnames()) o.names.push_back("--" + name);
    }
    o.text = option.get_description();
    o.words = words_of(option);
    o.takes_value = option.get_items_expected_max() > 0;
    o.repeats = option.get_items_expected_max() > 1;
    o.is_required = option.get_required();
    help.options.push_back(std::move(o));
  }
  std::stable_partition(help.options.begin(), help.options.end(),
                        [](const OptionHelp& o) { return o.positional; });
  return help;
}

std::vector<CommandHelp> commands_of(const CLI::App& app) {
  std::vector<CommandHelp> all;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; }))
    all.push_back(help_of(*command));
  return all;
}

std::string replaced(std::string text, const std::string& what, const std::string& with) {
  for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + with.size()))
    text.replace(at, what.size(), with);
  return text;
}

// ---- man pages

// A backslash, a hyphen in a name, and a dot or quote at the beginning of a line mean something to roff.
std::string roff(const std::string& text) {
  std::string out = replaced(replaced(text, "\\", "\\e"), "-", "\\-");
  if (!out.empty() && (out[0] == '.' || out[0] == '\'')) out.insert(0, "\\&");
  return replaced(out, "\n", "\n.br\n");
}

// "FILE" for "--csv" and the like would have to be invented; the last word of the long name does.
std::string value_name(const OptionHelp& o) {
  if (!o.words.empty()) {
    std::string all;
    for (const std::string& word : o.words) all += (all.empty() ? "" : "|") + word;
    return all;
  }
  std::string name = o.names.back().substr(o.names.back().rfind('-') + 1);
  std::transform(name.begin(), name.end(), name.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return name;
}

std::string roff_option(const OptionHelp& o) {
  std::string text = ".TP\n";
  for (std::size_t i = 0; i < o.names.size(); ++i)
    text.append(i > 0 ? ", " : "").append("\\fB").append(roff(o.names[i])).append("\\fR");
  if (o.takes_value && !o.positional) text += " \\fI" + roff(value_name(o)) + "\\fR";
  return text + "\n" + roff(o.text) + "\n";
}

std::string synopsis(const CommandHelp& command) {
  std::string text = ".B overtet " + command.name + "\n";
  for (const OptionHelp& o : command.options) {
    if (o.positional)
      text += ".I " + o.names[0] + (o.repeats ? "..." : "") + "\n";
    else if (o.is_required)
      text += ".B " + roff(o.names.back()) + "\n.I " + value_name(o) + "\n";
  }
  return text + "[\\fIoptions\\fR]\n";
}

std::string manual_of_command(const CommandHelp& command) {
  const std::string name = "overtet-" + command.name;
  std::string text = ".TH " + roff(name) + " 1 \"\" \"Overtet " + version() +
                     "\" \"User Commands\"\n.SH NAME\n" + roff(name) + " \\- " + roff(command.text) +
                     "\n.SH SYNOPSIS\n" + synopsis(command) + ".SH DESCRIPTION\n" + roff(command.text) +
                     ".\n";
  text += ".SH OPTIONS\n";
  for (const OptionHelp& o : command.options) text += roff_option(o);
  if (!command.footer.empty()) text += ".SH NOTES\n" + roff(command.footer) + "\n";
  return text + ".SH SEE ALSO\n.BR overtet (1)\n";
}

std::string manual_of_program(const CLI::App& app) {
  std::string text =
      ".TH overtet 1 \"\" \"Overtet " + version() +
      "\" \"User Commands\"\n.SH NAME\novertet \\- tetrahedral meshes of surfaces that pass through "
      "themselves\n.SH SYNOPSIS\n.B overtet\n.I COMMAND\n[\\fIoptions\\fR]\n.SH DESCRIPTION\n" +
      roff(app.get_description()) + "\n.SH COMMANDS\n";
  for (const CommandHelp& c : commands_of(app))
    text += ".TP\n\\fB" + c.name + "\\fR\n" + roff(c.text) + ".\n";
  text += ".SH OPTIONS\n";
  for (const OptionHelp& o : help_of(app).options) text += roff_option(o);
  text += ".SH NOTES\n" + roff(app.get_footer()) + "\n.SH SEE ALSO\n";
  std::string pages;
  for (const CommandHelp& c : commands_of(app))
    pages += std::string(pages.empty() ? "" : " ,\n") + ".BR overtet\\-" + c.name + " (1)";
  return text + pages + "\n";
}

// ---- completions

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& word : words) all += (all.empty() ? "" : " ") + word;
  return all;
}

std::vector<std::string> option_names(const CommandHelp& c) {
  std::vector<std::string> names;
  for (const OptionHelp& o : c.options)
    if (!o.positional) names.insert(names.end(), o.names.begin(), o.names.end());
  return names;
}

// What all completions of bash have in common: the command, and what stands before the word.
std::string bash_completion(const std::vector<CommandHelp>& commands) {
  std::vector<std::string> names = {"help", "--help", "--version"};
  for (const CommandHelp& c : commands) names.push_back(c.name);
  std::string text =
      "# Completion of overtet for bash; made by overtet completion bash.\n_overtet() {\n"
      "  local word=${COMP_WORDS[COMP_CWORD]} before=${COMP_WORDS[COMP_CWORD-1]} command=${COMP_WORDS[1]}\n"
      "  COMPREPLY=()\n  if [ \"$COMP_CWORD\" = 1 ]; then\n    COMPREPLY=($(compgen -W '" +
      joined(names) + "' -- \"$word\") $(compgen -f -- \"$word\"))\n    return\n  fi\n  case $command in\n";
  for (const CommandHelp& c : commands) {
    text += "    " + c.name + ")\n      case $before in\n";
    for (const OptionHelp& o : c.options)
      if (!o.words.empty() && !o.positional) {
        std::string pattern;
        for (const std::string& name : o.names) pattern += (pattern.empty() ? "" : "|") + name;
        text += "        " + pattern + ") COMPREPLY=($(compgen -W '" + joined(o.words) +
                "' -- \"$word\")); return ;;\n";
      }
    text += "      esac\n      case $word in\n        -*) COMPREPLY=($(compgen -W '" +
            joined(option_names(c)) + "' -- \"$word\")); return ;;\n      esac ;;\n";
    for (const OptionHelp& o : c.options)
      if (o.positional && !o.words.empty())
        text.insert(text.size() - std::string(" ;;\n").size(),
                    "\n      COMPREPLY=($(compgen -W '" + joined(o.words) + "' -- \"$word\")); return");
  }
  names.erase(names.begin(), names.begin() + 3);
  return text + "    help) COMPREPLY=($(compgen -W '" + joined(names) +
         "' -- \"$word\")); return ;;\n  esac\n  COMPREPLY=($(compgen -f -- \"$word\"))\n}\ncomplete -o "
         "filenames -F _overtet overtet\n";
}

// Within [ ] and : of zsh, and within its quotes.
std::string zsh(std::string text) {
  for (const char* c : {"\\", "[", "]", ":"}) text = replaced(text, c, std::string("\\") + c);
  return replaced(replaced(text, "'", "'\\''"), "\n", " ");
}

std::string zsh_completion(const std::vector<CommandHelp>& commands) {
  std::string text =
      "#compdef overtet\n# Completion of overtet for zsh; made by overtet completion zsh.\n_overtet() {\n"
      "  local -a commands\n  commands=(\n";
  for (const CommandHelp& c : commands) text += "    '" + c.name + ":" + zsh(c.text) + "'\n";
  text +=
      "    'help:Explain a command'\n  )\n  if (( CURRENT == 2 )); then\n    _describe command commands\n    "
      "_files\n    return\n  fi\n"
      "  local command=$words[2]\n  shift words\n  (( CURRENT-- ))\n  case $command in\n";
  for (const CommandHelp& c : commands) {
    text += "    " + c.name + ")\n      _arguments -S";
    for (const OptionHelp& o : c.options) {
      const std::string words = o.words.empty() ? "_files" : "(" + joined(o.words) + ")";
      if (o.positional) {
        text += std::string(" \\\n        '") + (o.repeats ? "*" : "") + ":" + zsh(o.names[0]) + ":" + words +
                "'";
        continue;
      }
      for (const std::string& name : o.names) {
        text.append(" \\\n        '").append(name);
        if (o.takes_value) text += name.starts_with("--") ? '=' : '+';
        text.append("[").append(zsh(o.text)).append("]");
        if (o.takes_value) text.append(":").append(zsh(value_name(o))).append(":").append(words);
        text += '\'';
      }
    }
    text += " ;;\n";
  }
  return text + "    help) _describe command commands ;;\n  esac\n}\n_overtet \"$@\"\n";
}

std::string fish(const std::string& text) {
  return "'" + replaced(replaced(replaced(text, "\\", "\\\\"), "'", "\\'"), "\n", " ") + "'";
}

std::string fish_completion(const std::vector<CommandHelp>& commands) {
  std::string text = "# Completion of overtet for fish; made by overtet completion fish.\n";
  for (const CommandHelp& c : commands)
    text += "complete -c overtet -n __fish_use_subcommand -a " + c.name + " -d " + fish(c.text) + "\n";
  text += "complete -c overtet -n __fish_use_subcommand -a help -d 'Explain a command'\n";
  for (const CommandHelp& c : commands)
    for (const OptionHelp& o : c.options) {
      const std::string here = "complete -c overtet -n '__fish_seen_subcommand_from " + c.name + "'";
      if (o.positional) {
        if (!o.words.empty()) text += here + " -f -a " + fish(joined(o.words)) + "\n";
        continue;
      }
      text += here;
      for (const std::string& name : o.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (o.takes_value) text += o.words.empty() ? " -r -F" : " -x -a " + fish(joined(o.words));
      text += " -d " + fish(o.text) + "\n";
    }
  return text;
}

}  // namespace

Result<std::string> manual_of(const CLI::App& app, const std::string& command) {
  if (command.empty()) return manual_of_program(app);
  for (const CommandHelp& c : commands_of(app))
    if (c.name == command) return manual_of_command(c);
  return Error{ErrorCode::usage, "There is no command " + command + "; see overtet help."};
}

std::string completion_for(const std::string& shell, const CLI::App& app) {
  const std::vector<CommandHelp> commands = commands_of(app);
  return shell == "bash"  ? bash_completion(commands)
         : shell == "zsh" ? zsh_completion(commands)
                          : fish_completion(commands);
}

}  // namespace overtet
