#include "apps/commands/command.h"

#include <fmt/format.h>

#include <iostream>
#include <string>
#include <vector>

#include "apps/files/campaign/keys.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/program/streams.h"
#include "apps/text/angle.h"
#include "apps/text/output_file.h"
#include "apps/usage/commit.h"
#include "apps/usage/wrong_usage.h"
#include "fit/measurement.h"
#include "model/scenario.h"
#include "model/trajectory.h"
#include "vision/picture.h"

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

/// They may stand before the command as well as after it.
void add_options_of_all(CLI::App& command, Context& context) {
  command.add_flag("--quiet,-q", context.quiet, "No progress and no notes on stderr; errors only");
  command
      .add_option("--threads", context.threads,
                  "Threads to use, for one recording too (default: all this process may use)")
      ->check(whole_number(1, 4096));
  command.set_version_flag("--version,-V", version_text, "Version, commit and libraries");
}

void add_commands(CLI::App& app, Context& context) {
  add_open(app, context);
  add_run(app, context);
  add_watch(app, context);
  add_track(app, context);
  add_measure(app, context);
  add_fit(app, context);
  add_report(app, context);
  add_verify(app, context);
  add_probe(app, context);
  add_calibrate(app, context);
  add_simulate(app, context);
  add_sweep(app, context);
  add_synth(app, context);
  add_paper(app, context);
  add_bench(app, context);
  add_init(app, context);
}

}  // namespace

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

void add_angle(CLI::App& command, const std::string& flag, std::optional<double>& value,
               const std::string& help) {
  add_parsed(command, flag, value, help, parse_angle,
             "an angle such as 0.5 (radians), pi/2, 11pi/9 or 90deg");
}

void add_number(CLI::App& command, const std::string& flag, std::optional<double>& value,
                const std::string& help) {
  add_parsed(command, flag, value, help, parse_number, "a finite number");
}

namespace {

/// `help COMMAND` is COMMAND --help; of what is no command it is as wrong as that command.
std::vector<std::string> arguments_of(const CLI::App& app, std::vector<std::string> typed) {
  if (typed.empty() || typed.front() != "help") return typed;
  typed.erase(typed.begin());
  const bool known =
      typed.empty() || typed.front().starts_with('-') ||
      !app.get_subcommands([&](const CLI::App* command) { return command->get_name() == typed.front(); })
           .empty();
  if (known) typed.emplace_back("--help");
  return typed;
}

/// `help TOPIC`: a page of the manual, or the keys of campaigns, with --json as their JSON Schema.
std::optional<std::string> manual_page(const std::vector<std::string>& typed) {
  using Words = std::vector<std::string>;
  if (typed == Words{"help", "campaign"}) return campaign_reference();
  if (typed == Words{"help", "campaign", "--json"}) return text_of(campaign_schema());
  for (const ManualPage& page : manual_pages())
    if (typed == Words{"help", std::string(page.name)}) return std::string(page.text);
  return std::nullopt;
}

/// The manual's pages with their titles.
std::string topics() {
  std::string list = "Manual, `tribotrack help TOPIC`:\n  campaign                    Keys of a campaign\n";
  for (const ManualPage& page : manual_pages())
    list += fmt::format("  {:27} {}\n", page.name, page.text.substr(2, page.text.find('\n') - 2));
  return list;
}

/// Help and version go to stdout, through CLI11's own printing.
int print_help(const CLI::App& app, const CLI::ParseError& error) {
  app.exit(error);
  std::cout.flush();
  if (!std::cout) throw WriteError("write error: standard output takes no more");
  return kDone;
}

template <class... Kinds>
bool is_one_of(const std::exception& error) {
  return (... || (dynamic_cast<const Kinds*>(&error) != nullptr));
}

/// Says what ended the command; its exit code.
ExitCode complain_of(const std::exception& error) {
  if (is_one_of<UsageError>(error)) {
    complain(error.what());
    return kUsage;
  }
  if (is_one_of<model::StepLimitExceeded>(error)) {
    complain(fmt::format("{}; give it fewer cycles or more friction", error.what()));
    return kInvalidInput;
  }
  if (is_one_of<InvalidInput, vision::InputError, fit::DataError, std::invalid_argument>(error)) {
    complain(error.what());
    return kInvalidInput;
  }
  if (is_one_of<WriteError>(error))
    complain(error.what());
  else if (is_one_of<std::bad_alloc>(error))
    complain(
        "out of memory: give the process more, or less to do at once (--threads 1, fewer frames or samples)");
  else
    complain(
        fmt::format("unexpected error: {}; please report it with the input that shows it", error.what()));
  return kUnexpected;
}

}  // namespace

int run_program(int argc, const char* const* argv) {
  Context context;
  CLI::App app{
      "tribotrack: from high-speed video of a part on a vibrating platform to its friction parameters",
      "tribotrack"};
  app.require_subcommand(1);
  app.footer(
      topics() +
      "\nStart with `tribotrack open FOLDER`: a page from the recordings to the report. Without a browser: "
      "`tribotrack help start-here`, or `tribotrack init DIR`. tribotrack COMMAND --help explains each "
      "command.");
  add_options_of_all(app, context);
  add_commands(app, context);
  const std::vector<std::string> words(argv + 1, argv + argc), typed = arguments_of(app, words);
  const LastWords stopped("stopped: nothing half-written is left");
  try {
    if (const auto what = manual_page(words)) {
      print_text(*what);
      flush_output();
      return kDone;
    }
    if (typed.empty()) {  // nothing was asked: no result, so nothing on stdout
      print_error(app.help());
      return kUsage;
    }
    if (const std::string left = what_left(typed); !left.empty()) throw UsageError(left);
    try {
      app.parse(std::vector<std::string>(typed.rbegin(), typed.rend()));
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) return print_help(app, error);
      // CLI11's own codes (100-110) collide with those workflow engines retry on.
      complain(wrong_usage(app, error, typed) + " (see --help)");
      return kUsage;
    }
    flush_output();
    return context.exit_code;
  } catch (const std::exception& error) {
    return complain_of(error);
  }
}

}  // namespace tribotrack::apps
