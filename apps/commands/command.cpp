#include "apps/commands/command.h"

#include <fmt/format.h>

#include <string>
#include <vector>

#include "apps/text/angle.h"
#include "apps/text/output_file.h"
#include "apps/usage/commit.h"
#include "apps/usage/wrong_usage.h"

namespace tribotrack::apps {

namespace {

using Parser = std::optional<double> (*)(std::string_view);

/// "; did you mean 250.5?" for a number with a decimal comma.
std::string with_point(std::string text, Parser parse) {
  const auto comma = text.find(',');
  if (comma == std::string::npos) return "";
  text[comma] = '.';
  return parse(text) ? fmt::format("; did you mean {}?", text) : "";
}

void add_parsed(CLI::App& command, const std::string& flag, std::optional<double>& value,
                const std::string& help, Parser parse, const std::string& kind) {
  command
      .add_option_function<std::string>(
          flag,
          [&value, name = flag.substr(0, flag.find(',')), parse, kind](const std::string& text) {
            value = parse(text);
            if (!value)
              throw CLI::ValidationError(
                  name, fmt::format("must be {}, not \"{}\"{}", kind, text, with_point(text, parse)));
            if (parse != parse_angle) return;
            if (const std::string slip = angle_slip(*value); !slip.empty())
              throw CLI::ValidationError(name, slip);
          },
          help)
      ->type_name(parse == parse_angle ? "ANGLE" : "NUMBER");
}

}  // namespace

void add_options_of_all(CLI::App& command, Context& context) {
  command.add_flag("--quiet,-q", context.quiet, "No progress and no notes on stderr; errors only");
  command
      .add_option("--threads", context.threads,
                  "Threads to use, for one recording too (default: all this process may use)")
      ->check(whole_number(1, 4096));
  command.set_version_flag("--version,-V", version_text, "Version, commit and libraries");
}

void add_common(CLI::App& command, Context& context, const std::string& example) {
  add_options_of_all(command, context);
  command.footer(
      "Example:\n" + example +
      "\n\nExit codes: 0 done, 2 usage, 3 bad input or output, 4 a quality gate failed, 5 fit unusable.");
}

bool is_printed(const std::string& output, bool json) {
  const bool printed = is_standard_output(output);
  if (printed && json) throw UsageError("give -o - or --json: both would go to standard output");
  return printed;
}

void check_output(const std::string& output, bool json, const std::vector<std::filesystem::path>& inputs) {
  if (!output.empty() && !is_printed(output, json)) require_writable({{output}}, inputs);
}

void add_angle(CLI::App& command, const std::string& flag, std::optional<double>& value,
               const std::string& help) {
  add_parsed(command, flag, value, help, parse_angle,
             "an angle such as 0.5 (radians), pi/2, 11pi/9 or 90deg");
}

void add_number(CLI::App& command, const std::string& flag, std::optional<double>& value,
                const std::string& help) {
  add_parsed(command, flag, value, help, parse_number, "a finite number");
}

void parse(CLI::App& app, const std::vector<std::string>& typed) {
  try {
    app.parse(std::vector<std::string>(typed.rbegin(), typed.rend()));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) throw;  // of --help and --version
    throw UsageError(wrong_usage(app, error, typed) + " (see --help)");
  }
}

}  // namespace tribotrack::apps
