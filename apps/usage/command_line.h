// What the program's command line consists of, as plain data: the one source of help, manual pages and
// completion.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace tribotrack::apps {

struct OptionFacts {
  std::vector<std::string> names;  ///< "-o", "--output"; empty: an argument by its place
  std::string value;               ///< "FILE", "auto|on|off", "NUMBER"; empty for a flag
  std::string meaning;
  bool required = false, repeated = false;
  /// The words that the value may be, where it is one of some.
  std::vector<std::string> words() const;
};

struct CommandFacts {
  std::string name, meaning;
  std::vector<OptionFacts> arguments, options;
  std::string footer;  ///< examples and remarks
};

/// The program itself, then its commands as --help lists them.
std::vector<CommandFacts> facts_of(const CLI::App& app);

/// A text folded at blanks: lines of at most `width` characters, each but the first after `indent` blanks.
std::string folded(const std::string& text, std::size_t width, std::size_t indent);

/// The same for each line by itself; lines that begin with a blank, examples, stay as they are.
std::string folded_lines(const std::string& text, std::size_t width);

/// --help in lines of at most `width` characters.
class FoldedHelp : public CLI::Formatter {
 public:
  explicit FoldedHelp(std::size_t width) : width_(width) {}
  std::string make_option(const CLI::Option* option, bool is_positional) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_footer(const CLI::App* app) const override;
  std::string make_description(const CLI::App* app) const override;

 private:
  std::string entry(const std::string& name, const std::string& meaning) const;
  std::size_t width_;
};

/// Of the terminal, between 80 and 120; 80 where there is none.
std::size_t width_of_terminal();

}  // namespace tribotrack::apps
