#include "apps/usage/manual.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace tribotrack::apps {

namespace {

/// Text that roff takes literally.
std::string roff(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\\')
      safe += "\\e";
    else if (c == '-')
      safe += "\\-";
    else
      safe += c;
  }
  // A line that begins with a dot or an apostrophe would be a request.
  return safe.starts_with('.') || safe.starts_with('\'') ? "\\&" + safe : safe;
}

std::string lines_of_example(const std::string& text) {
  std::string out;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    out += roff(text.substr(begin, end - begin)) + "\n";
    begin = end + 1;
  }
  return out;
}

std::string page_name(const CommandFacts& command) {
  return command.name == "tribotrack" ? command.name : "tribotrack-" + command.name;
}

std::string upper(std::string text) {
  std::ranges::transform(text, text.begin(),
                         [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string heading(const std::string& name, int section, const std::string& version) {
  return fmt::format(".TH {} {} \"\" \"tribotrack {}\" \"tribotrack manual\"\n", roff(upper(name)), section,
                     version);
}

std::string synopsis(const CommandFacts& command) {
  std::string line =
      "\\fB" + roff(command.name == "tribotrack" ? "tribotrack" : "tribotrack " + command.name) + "\\fR";
  if (command.name == "tribotrack") return line + " \\fICOMMAND\\fR ...\n";
  for (const OptionFacts& argument : command.arguments)
    line += (argument.required ? " \\fI" : " [\\fI") + roff(argument.value) +
            (argument.required ? "\\fR" : "\\fR]");
  return line + " [options]\n";
}

std::string option_entry(const OptionFacts& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names) names.push_back("\\fB" + roff(name) + "\\fR");
  std::string entry = fmt::format(".TP\n{}", fmt::join(names, ", "));
  if (!option.value.empty()) entry += (names.empty() ? "\\fI" : " \\fI") + roff(option.value) + "\\fR";
  return entry + "\n" + roff(option.meaning) + (option.required && !names.empty() ? " (required)" : "") +
         "\n";
}

std::string names_of(const OptionFacts& option) {
  return fmt::format("{}", fmt::join(option.names, " "));
}

std::string bash(const std::vector<CommandFacts>& all) {
  std::string commands, cases;
  for (std::size_t k = 1; k < all.size(); ++k) {
    commands += " " + all[k].name;
    std::string options, words;
    for (const OptionFacts& option : all[k].options) {
      options += " " + names_of(option);
      if (const auto choices = option.words(); !choices.empty())
        words += fmt::format("        {}) COMPREPLY=($(compgen -W \"{}\" -- \"$word\")); return ;;\n",
                             fmt::join(option.names, "|"), fmt::join(choices, " "));
    }
    cases += fmt::format("    {})\n", all[k].name);
    if (!words.empty()) cases += fmt::format("      case $before in\n{}      esac\n", words);
    cases += fmt::format("      options=\"{}\" ;;\n", options.substr(1));
  }
  return fmt::format(
      "# bash completion for tribotrack\n"
      "_tribotrack() {{\n"
      "  local word=${{COMP_WORDS[COMP_CWORD]}} before=${{COMP_WORDS[COMP_CWORD-1]}} command= options= one\n"
      "  for one in \"${{COMP_WORDS[@]:1:COMP_CWORD-1}}\"; do\n"
      "    case $one in -*) ;; *) command=$one; break ;; esac\n"
      "  done\n"
      "  if [ -z \"$command\" ] || [ \"$command\" = help ]; then\n"
      "    COMPREPLY=($(compgen -W \"help campaign{} {}\" -- \"$word\"))\n"
      "    return\n"
      "  fi\n"
      "  case $command in\n{}  esac\n"
      "  case $word in\n"
      "    -*) COMPREPLY=($(compgen -W \"$options\" -- \"$word\")) ;;\n"
      "    *) COMPREPLY=($(compgen -f -- \"$word\")); compopt -o filenames 2>/dev/null ;;\n"
      "  esac\n"
      "}}\n"
      "complete -F _tribotrack tribotrack\n",
      commands, names_of(all[0].options.back()), cases);
}

/// Inside single quotes, with what zsh's _arguments reads in brackets taken literally.
std::string zsh_text(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\'')
      safe += "'\\''";
    else if (c == '[' || c == ']' || c == ':' || c == '\\')
      safe += std::string("\\") + c;
    else
      safe += c;
  }
  return safe;
}

std::string zsh(const std::vector<CommandFacts>& all) {
  std::string commands, cases;
  for (std::size_t k = 1; k < all.size(); ++k) {
    commands += fmt::format("    '{}:{}'\n", all[k].name, zsh_text(all[k].meaning));
    std::string options;
    for (const OptionFacts& option : all[k].options)
      for (const std::string& name : option.names) {
        const auto choices = option.words();
        const std::string value =
            option.value.empty()
                ? ""
                : ":" + zsh_text(option.value) + ":" +
                      (choices.empty() ? "_files" : fmt::format("({})", fmt::join(choices, " ")));
        options += fmt::format(" \\\n        '{}[{}]{}'", name, zsh_text(option.meaning), value);
      }
    cases += fmt::format("      {}) _arguments{} \\\n        '*:file:_files' ;;\n", all[k].name, options);
  }
  return fmt::format(
      "#compdef tribotrack\n"
      "_tribotrack() {{\n"
      "  local -a commands=(\n{}  )\n"
      "  _arguments -C '1:command:->command' '*::argument:->argument'\n"
      "  case $state in\n"
      "    command) _describe command commands ;;\n"
      "    argument) case $words[1] in\n{}    esac ;;\n"
      "  esac\n"
      "}}\n"
      "_tribotrack \"$@\"\n",
      commands, cases);
}

std::string fish_text(const std::string& text) {
  std::string safe;
  for (const char c : text) {
    if (c == '\'' || c == '\\') safe += '\\';
    safe += c;
  }
  return safe;
}

std::string fish(const std::vector<CommandFacts>& all) {
  std::string text = "# fish completion for tribotrack\n";
  for (std::size_t k = 1; k < all.size(); ++k) {
    text += fmt::format("complete -c tribotrack -n __fish_use_subcommand -f -a {} -d '{}'\n", all[k].name,
                        fish_text(all[k].meaning));
    for (const OptionFacts& option : all[k].options) {
      text += fmt::format("complete -c tribotrack -n '__fish_seen_subcommand_from {}'", all[k].name);
      for (const std::string& name : option.names)
        text += name.starts_with("--") ? " -l " + name.substr(2) : " -s " + name.substr(1);
      if (!option.value.empty()) text += " -r";
      if (const auto choices = option.words(); !choices.empty())
        text += fmt::format(" -f -a '{}'", fmt::join(choices, " "));
      text += fmt::format(" -d '{}'\n", fish_text(option.meaning));
    }
  }
  return text;
}

}  // namespace

std::string manual_page(const CommandFacts& command, const std::vector<CommandFacts>& all,
                        const std::string& version) {
  std::string page = heading(page_name(command), 1, version);
  page += fmt::format(".SH NAME\n{} \\- {}\n", roff(page_name(command)), roff(command.meaning));
  page += ".SH SYNOPSIS\n" + synopsis(command);
  if (command.name == "tribotrack") {
    page += ".SH COMMANDS\n";
    for (std::size_t k = 1; k < all.size(); ++k)
      page += fmt::format(".TP\n\\fB{}\\fR(1)\n{}\n", roff(page_name(all[k])), roff(all[k].meaning));
  }
  if (!command.arguments.empty()) page += ".SH ARGUMENTS\n";
  for (const OptionFacts& argument : command.arguments) page += option_entry(argument);
  page += ".SH OPTIONS\n";
  for (const OptionFacts& option : command.options) page += option_entry(option);
  page += ".SH NOTES AND EXAMPLES\n.nf\n" + lines_of_example(folded_lines(command.footer, 80)) + ".fi\n";
  page += ".SH SEE ALSO\n\\fBtribotrack\\fR(1), \\fBtribotrack\\-campaign\\fR(5)\n";
  return page;
}

std::string campaign_manual(const std::string& reference, const std::string& version) {
  return heading("tribotrack-campaign", 5, version) +
         ".SH NAME\ntribotrack\\-campaign \\- a lab's recordings and what is to be learnt from them\n"
         ".SH DESCRIPTION\n.nf\n" +
         lines_of_example(reference) +
         ".fi\n.SH SEE ALSO\n\\fBtribotrack\\-run\\fR(1), \\fBtribotrack\\-init\\fR(1)\n";
}

std::string completion(const std::vector<CommandFacts>& all, const std::string& shell) {
  if (shell == "bash") return bash(all);
  if (shell == "zsh") return zsh(all);
  if (shell == "fish") return fish(all);
  return "";
}

}  // namespace tribotrack::apps
