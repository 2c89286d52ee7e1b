#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/Version.hpp>
#include <Eigen/Core>
#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>
#include <string_view>
#include <thread>

#include "apps/program/context.h"
#include "apps/text/strict_toml.h"
#include "apps/usage/commit.h"
#include "apps/usage/wrong_usage.h"
#include "fit/estimate.h"
#include "vision/frame_source.h"
#include "vision/temporary_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

std::string temporary_files() {
  std::error_code error;
  const fs::path folder = fs::temp_directory_path(error);
  if (error) return fmt::format("none ({}): let TMPDIR name a folder that exists", error.message());
  try {
    const vision::TemporaryFile attempt(folder / "tribotrack-version");
  } catch (const vision::OutputError& failure) {
    return fmt::format("none ({}): let TMPDIR name a folder that is yours to write to", failure.what());
  }
  const auto space = fs::space(folder, error);
  return fmt::format("{}, {:.1f} GB free", folder.string(), 1e-9 * static_cast<double>(space.available));
}

}  // namespace

std::string version_text() {
  const std::string commit = source_commit();
  std::string text =
      "tribotrack " TRIBOTRACK_VERSION + (commit.empty() ? "" : fmt::format(" ({})", commit)) + "\nwith ";
  text += fmt::format("{}, {}, Eigen {}.{}.{}, CLI11 {}, fmt {}.{}.{}, nlohmann-json {}.{}.{}",
                      vision::libraries(), fit::solver(), EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION,
                      EIGEN_MINOR_VERSION, CLI11_VERSION, FMT_VERSION / 10000, FMT_VERSION / 100 % 100,
                      FMT_VERSION % 100, NLOHMANN_JSON_VERSION_MAJOR, NLOHMANN_JSON_VERSION_MINOR,
                      NLOHMANN_JSON_VERSION_PATCH);
  return text + fmt::format("\nthreads: {} of {} processors\ntemporary files: {}", threads_to_use({}),
                            std::thread::hardware_concurrency(), temporary_files());
}

namespace {

bool contains(const std::vector<std::string>& words, const std::string& word) {
  return std::find(words.begin(), words.end(), word) != words.end();
}

std::vector<std::string> commands_of(const CLI::App& app) {
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands({}))
    if (!command->get_group().empty()) commands.push_back(command->get_name());
  return commands;
}

std::vector<std::string> options_of(const CLI::App& app) {
  std::vector<std::string> options;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) options.push_back("--" + name);
    for (const std::string& name : option->get_snames()) options.push_back("-" + name);
  }
  return options;
}

/// The command among the words, or the word that stands where it should.
std::string command_word(const std::vector<std::string>& typed) {
  for (std::size_t k = 0; k < typed.size(); ++k) {
    if (typed[k] == "--threads")
      ++k;  // the one option of all commands that takes a value
    else if (!typed[k].starts_with('-'))
      return typed[k];
  }
  return "";
}

bool is_command(const CLI::App& app, const std::string& word) {
  return !app.get_subcommands([&](const CLI::App* command) { return command->check_name(word); }).empty();
}

/// The option that was probably meant: one that begins with the word, holds it, or is spelt much like it.
std::string nearest_option(const std::string& word, const std::vector<std::string>& options) {
  const auto only = [&](const auto& fits) {
    std::string found;
    for (const std::string& option : options)
      if (fits(option)) {
        if (!found.empty()) return std::string();
        found = option;
      }
    return found;
  };
  if (std::string begun = only([&](const std::string& option) { return option.starts_with(word); });
      !begun.empty())
    return begun;
  // Dashes are no letters: `--overwrite` is not spelt much like `--version`.
  const std::string stem = word.substr(std::min(word.find_first_not_of('-'), word.size()));
  if (stem.size() < 3) return "";
  if (std::string held =
          only([&](const std::string& option) { return option.find(stem) != std::string::npos; });
      !held.empty())
    return held;
  std::vector<std::string> names;
  for (const std::string& option : options)
    if (option.starts_with("--")) names.push_back(option.substr(2));
  const std::string near = nearest_word(stem, names);
  return near.empty() ? near : "--" + near;
}

std::string meant(const std::string& near) {
  return near.empty() ? "" : fmt::format("; did you mean `{}`?", near);
}

/// "CAMPAIGN.toml and DIR": what the command takes without a flag.
std::string arguments_of(const CLI::App& command) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options())
    if (option->get_positional())
      names.push_back("one " +
                      (option->get_type_name() == "TEXT" ? option->get_name() : option->get_type_name()));
  return names.empty() ? "no file" : fmt::format("{}", fmt::join(names, " and "));
}

std::string unexpected_word(const CLI::App& command, const std::vector<std::string>& typed) {
  const std::vector<std::string> options = options_of(command), left = command.remaining();
  for (const std::string& word : typed) {
    const std::string flag = word.substr(0, word.find('='));
    if (flag.starts_with('-') && contains(left, word) && !contains(options, flag))
      return fmt::format("`{}` is not an option of `{}`{}", flag, command.get_name(),
                         meant(nearest_option(flag, options)));
  }
  const auto first =
      std::ranges::find_if(typed, [&](const std::string& word) { return contains(left, word); });
  const std::string extra = first != typed.end() ? *first : left.empty() ? "" : left.front();
  return fmt::format(
      "`{}` is one too many: `{}` takes {}{}", extra, command.get_name(), arguments_of(command),
      command.get_name() == "track" ? "; many recordings are what `tribotrack run` is for" : "");
}

}  // namespace

std::string wrong_usage(const CLI::App& app, const CLI::ParseError& error,
                        const std::vector<std::string>& typed) {
  const std::vector<std::string> commands = commands_of(app);
  const std::string word = command_word(typed);
  if (word.empty()) {
    const std::vector<std::string> options = options_of(app);
    for (const std::string& option : typed)
      if (option.starts_with('-') && !contains(options, option.substr(0, option.find('='))))
        return fmt::format("`{}` is not an option of tribotrack itself{}", option,
                           meant(nearest_option(option, options)));
    return fmt::format("a command is needed: {}", fmt::join(commands, ", "));
  }
  if (!is_command(app, word)) {
    std::vector<std::string> known = commands;
    known.insert(known.end(), {"--version", "--help"});
    return fmt::format("`{}` is not a command{}", word, meant(nearest_word(word, known)));
  }
  if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::ExtrasError))
    return unexpected_word(*app.get_subcommand(word), typed);
  return error.what();
}

CLI::Validator whole_number(long least, long most) {
  return {[least, most](const std::string& text) {
            long value = 0;
            const auto [end, failed] = std::from_chars(text.data(), text.data() + text.size(), value);
            const bool whole = failed == std::errc() && end == text.data() + text.size();
            if (whole && value >= least && value <= most) return std::string();
            if (most == std::numeric_limits<long>::max())
              return fmt::format("must be a whole number, {} or more, not \"{}\"", least, text);
            return fmt::format("must be a whole number, {} to {}, not \"{}\"", least, most, text);
          },
          "", "whole number"};
}

CLI::Validator one_of(const std::vector<std::string>& words) {
  return {[words](const std::string& text) {
            if (contains(words, text)) return std::string();
            return fmt::format("must be one of {}, not \"{}\"{}", fmt::join(words, ", "), text,
                               meant(nearest_word(text, words)));
          },
          "", "word"};
}

}  // namespace tribotrack::apps
