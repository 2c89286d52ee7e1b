#include "apps/commands/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iostream>
#include <limits>
#include <string>

#include "apps/program/streams.h"
#include "apps/text/angle.h"
#include "apps/text/strict_toml.h"
#include "fit/measurement.h"
#include "model/scenario.h"
#include "vision/picture.h"

namespace tribotrack::apps {

namespace {

using Parser = std::optional<double> (*)(std::string_view);

void add_parsed(CLI::App& command, const std::string& flag, std::optional<double>& value,
                const std::string& help, Parser parse, const std::string& kind) {
  command
      .add_option_function<std::string>(
          flag,
          [&value, flag, parse, kind](const std::string& text) {
            value = parse(text);
            if (!value) throw CLI::ValidationError(flag, fmt::format("must be {}, not \"{}\"", kind, text));
            if (parse != parse_angle) return;
            if (const std::string slip = angle_slip(*value); !slip.empty())
              throw CLI::ValidationError(flag, slip);
          },
          help)
      ->type_name(parse == parse_angle ? "ANGLE" : "NUMBER");
}

void add_commands(CLI::App& app, Context& context) {
  add_run(app, context);
  add_track(app, context);
  add_measure(app, context);
  add_fit(app, context);
  add_report(app, context);
  add_probe(app, context);
  add_calibrate(app, context);
  add_simulate(app, context);
  add_sweep(app, context);
  add_synth(app, context);
  add_bench(app, context);
  add_bench_peer(app);
  add_init(app, context);
}

}  // namespace

void add_common(CLI::App& command, Context& context, const std::string& example) {
  command.add_flag("--quiet,-q", context.quiet, "No progress and no notes on stderr; errors only");
  command
      .add_option("--threads", context.threads,
                  "Threads to use, for one recording too (default: all this process may use)")
      ->check(CLI::Range(1, 4096));
  command.set_version_flag("--version", "tribotrack " TRIBOTRACK_VERSION);
  command.footer(
      "Example:\n" + example +
      "\n\nExit codes: 0 done, 2 usage, 3 bad input or output, 4 a quality gate failed, 5 fit unusable.");
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

void add_count(CLI::App& command, const std::string& flag, int& value, int least, int most,
               const std::string& help) {
  command
      .add_option_function<std::string>(
          flag,
          [&value, flag, least, most](const std::string& text) {
            const auto number = parse_number(text);
            if (!number || *number != std::floor(*number) || *number < least || *number > most)
              throw CLI::ValidationError(
                  flag, most == std::numeric_limits<int>::max()
                            ? fmt::format("must be a whole number, {} or more, not \"{}\"", least, text)
                            : fmt::format("must be a whole number, {} to {}, not \"{}\"", least, most, text));
            value = static_cast<int>(*number);
          },
          help)
      ->type_name("N");
}

CLI::Validator one_of(const std::vector<std::string>& words) {
  const auto refuse = [words](const std::string& word) {
    if (std::find(words.begin(), words.end(), word) != words.end()) return std::string();
    const std::string near = nearest_word(word, words);
    return fmt::format("must be one of {}, not \"{}\"{}", fmt::join(words, ", "), word,
                       near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near));
  };
  return {refuse, fmt::format("{}", fmt::join(words, "|"))};
}

namespace {

/// "; did you mean `track`?" for a command or an option that does not exist but is nearly one that does.
std::string nearest_to(const CLI::App& app, int argc, const char* const* argv) {
  std::vector<std::string> commands;
  for (const CLI::App* command : app.get_subcommands({}))
    if (!command->get_group().empty()) commands.push_back(command->get_name());
  const std::string word = argc > 1 ? argv[1] : "";
  const auto suggest = [](const std::string& near) {
    return near.empty() ? "" : fmt::format("; did you mean `{}`?", near);
  };
  if (std::find(commands.begin(), commands.end(), word) == commands.end())
    return word.starts_with('-') ? "" : suggest(nearest_word(word, commands));
  std::vector<std::string> flags;
  for (const CLI::Option* option : app.get_subcommand(word)->get_options())
    for (const std::string& name : option->get_lnames()) flags.push_back("--" + name);
  for (int k = 2; k < argc; ++k) {
    const std::string flag = std::string(argv[k]).substr(0, std::string(argv[k]).find('='));
    if (!flag.starts_with("--") || std::find(flags.begin(), flags.end(), flag) != flags.end()) continue;
    return suggest(nearest_word(flag, flags));
  }
  return "";
}

/// Help and version go to stdout, through CLI11's own printing.
int print_help(const CLI::App& app, const CLI::ParseError& error) {
  app.exit(error);
  std::cout.flush();
  if (!std::cout) throw WriteError("write error: standard output takes no more");
  return kDone;
}

}  // namespace

int run_program(int argc, const char* const* argv) {
  Context context;
  CLI::App app{
      "tribotrack: from high-speed video of a part on a vibrating platform to its friction parameters"};
  app.set_version_flag("--version", "tribotrack " TRIBOTRACK_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Start with `tribotrack init DIR`, edit the campaign it writes, then `tribotrack run DIR/campaign.toml "
      "-o OUT`.\n"
      "Each command explains itself: tribotrack COMMAND --help");
  add_commands(app, context);
  try {
    try {
      app.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
      if (error.get_exit_code() == 0) return print_help(app, error);
      // CLI11's own codes (100-110) collide with those workflow engines retry on.
      complain(fmt::format("{}{} (see --help)", error.what(), nearest_to(app, argc, argv)));
      return kUsage;
    }
    flush_output();
    return context.exit_code;
  } catch (const WriteError& error) {
    complain(error.what());
    return kUnexpected;
  } catch (const UsageError& error) {
    complain(error.what());
    return kUsage;
  } catch (const InvalidInput& error) {
    complain(error.what());
    return kInvalidInput;
  } catch (const vision::InputError& error) {
    complain(error.what());
    return kInvalidInput;
  } catch (const fit::DataError& error) {
    complain(error.what());
    return kInvalidInput;
  } catch (const model::InvalidParameter& error) {
    complain(error.what());
    return kInvalidInput;
  } catch (const std::invalid_argument& error) {
    complain(error.what());
    return kInvalidInput;
  } catch (const std::bad_alloc&) {
    complain("out of memory");
    return kUnexpected;
  } catch (const std::exception& error) {
    complain(
        fmt::format("unexpected error: {}; please report it with the input that shows it", error.what()));
    return kUnexpected;
  }
}

}  // namespace tribotrack::apps
