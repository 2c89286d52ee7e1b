#include "apps/usage/command_line.h"

#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>

namespace tribotrack::apps {

namespace {

constexpr std::size_t kColumn = 26;  ///< where meanings begin

OptionFacts facts_of(const CLI::Option& option) {
  OptionFacts facts;
  for (const std::string& name : option.get_snames()) facts.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) facts.names.push_back("--" + name);
  if (option.get_positional()) facts.value = option.get_name();
  if (!facts.names.empty() && option.get_items_expected_max() > 0) facts.value = option.get_type_name();
  facts.meaning = option.get_description();
  facts.required = option.get_required();
  facts.repeated = option.get_items_expected_max() > 1;
  return facts;
}

CommandFacts facts_of_one(const CLI::App& app) {
  CommandFacts facts;
  facts.name = app.get_name();
  facts.meaning = app.get_description();
  facts.footer = app.get_footer();
  for (const CLI::Option* option : app.get_options()) {
    OptionFacts one = facts_of(*option);
    (option->get_positional() ? facts.arguments : facts.options).push_back(std::move(one));
  }
  return facts;
}

}  // namespace

std::vector<std::string> OptionFacts::words() const {
  std::vector<std::string> words;
  if (value.find('|') == std::string::npos) return words;
  for (std::size_t begin = 0; begin <= value.size();) {
    const std::size_t end = std::min(value.find('|', begin), value.size());
    const std::string word = value.substr(begin, end - begin);
    // What is written in capitals stands for a value: X,Y,R|auto|none.
    if (std::ranges::none_of(word, [](unsigned char c) { return std::isupper(c) || c == ',' || c == '.'; }))
      words.push_back(word);
    begin = end + 1;
  }
  return words;
}

std::vector<CommandFacts> facts_of(const CLI::App& app) {
  std::vector<CommandFacts> all = {facts_of_one(app)};
  for (const CLI::App* command : app.get_subcommands({}))
    if (!command->get_group().empty()) all.push_back(facts_of_one(*command));
  return all;
}

std::string folded(const std::string& text, std::size_t width, std::size_t indent) {
  std::string lines;
  std::size_t column = indent;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find(' ', begin), text.size());
    const std::string word = text.substr(begin, end - begin);
    if (column > indent && column + 1 + word.size() > width) {
      lines += "\n" + std::string(indent, ' ');
      column = indent;
    } else if (column > indent) {
      lines += ' ';
      ++column;
    }
    lines += word;
    column += word.size();
    begin = end + 1;
  }
  return lines;
}

std::string folded_lines(const std::string& text, std::size_t width) {
  std::string lines;
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string line = text.substr(begin, end - begin);
    lines += line.starts_with(' ') ? line : folded(line, width, 0);
    if (end < text.size()) lines += '\n';
    begin = end + 1;
  }
  return lines;
}

std::string FoldedHelp::entry(const std::string& name, const std::string& meaning) const {
  std::string line = "  " + name;
  if (line.size() + 2 > kColumn)
    line += "\n" + std::string(kColumn, ' ');
  else
    line.resize(kColumn, ' ');
  return line + folded(meaning, width_, kColumn) + "\n";
}

std::string FoldedHelp::make_option(const CLI::Option* option, bool is_positional) const {
  const OptionFacts facts = facts_of(*option);
  std::string name;
  if (is_positional) {
    name = facts.value;
  } else {
    for (const std::string& one : facts.names) name += (name.empty() ? "" : ", ") + one;
    if (!facts.value.empty()) name += " " + facts.value;
  }
  return entry(name, facts.meaning + (facts.required && !is_positional ? " (required)" : ""));
}

std::string FoldedHelp::make_subcommand(const CLI::App* command) const {
  return entry(command->get_name(), command->get_description());
}

std::string FoldedHelp::make_footer(const CLI::App* app) const {
  const std::string footer = app->get_footer();
  return footer.empty() ? "" : folded_lines(footer, width_) + "\n";
}

std::string FoldedHelp::make_description(const CLI::App* app) const {
  const std::string description = app->get_description();
  return description.empty() ? "" : folded(description, width_, 0) + "\n";
}

std::size_t width_of_terminal() {
  winsize window{};
  if (!isatty(STDOUT_FILENO) || ioctl(STDOUT_FILENO, TIOCGWINSZ, &window) != 0) return 80;
  return std::clamp<std::size_t>(window.ws_col, 80, 120);
}

}  // namespace tribotrack::apps
