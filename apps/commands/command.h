// The commands of the program: what they share, and one function each that adds them to the command line.
#pragma once

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "apps/program/context.h"

namespace tribotrack::apps {

/// Adds --quiet, --threads and --version; they may stand before the command as well as after it.
void add_options_of_all(CLI::App& command, Context& context);
/// The same, and the example at the end of --help.
void add_common(CLI::App& command, Context& context, const std::string& example);

/// Adds an option or an argument whose value is called `type` in the help.
template <class Value>
CLI::Option* add_option(CLI::App& command, const std::string& name, Value& value, const char* type,
                        const std::string& help) {
  return command.add_option(name, value, help)->type_name(type);
}
/// Adds an option that takes an angle in radians: a number or "11pi/9".
void add_angle(CLI::App& command, const std::string& flag, std::optional<double>& value,
               const std::string& help);
/// Adds an option that takes a finite number.
void add_number(CLI::App& command, const std::string& flag, std::optional<double>& value,
                const std::string& help);

/// Does a result go to standard output? Throws UsageError where the object of --json would go there, too.
bool is_printed(const std::string& output, bool json);
/// The same, and refuses an output, if there is one, that cannot be written or would replace an input.
void check_output(const std::string& output, bool json, const std::vector<std::filesystem::path>& inputs);

/// At the end of the help of `run` and `fit`.
inline constexpr const char* kOfSds =
    "\n\nA campaign may give KEY_sd beside each quantity (amplitude_mm_sd, gravity_m_s2_sd, phi_rad_sd, "
    "...): the intervals include it. Without one they have that of the last digit or a typical one, unless "
    "[fit] exact names them.";

void add_simulate(CLI::App& app, Context& context);
void add_sweep(CLI::App& app, Context& context);
void add_synth(CLI::App& app, Context& context);
void add_probe(CLI::App& app, Context& context);
void add_track(CLI::App& app, Context& context);
void add_measure(CLI::App& app, Context& context);
void add_fit(CLI::App& app, Context& context);
void add_report(CLI::App& app, Context& context);
void add_verify(CLI::App& app, Context& context);
void add_paper(CLI::App& app, Context& context);
void add_run(CLI::App& app, Context& context);
void add_bench(CLI::App& app, Context& context);
void add_calibrate(CLI::App& app, Context& context);
void add_init(CLI::App& app, Context& context);
void add_watch(CLI::App& app, Context& context);
void add_open(CLI::App& app, Context& context);

/// Parses the words after the program's name and carries out what they say. Throws UsageError for what cannot
/// be parsed, CLI::ParseError where help or version are asked for, and what the command throws.
void parse(CLI::App& app, const std::vector<std::string>& typed);

}  // namespace tribotrack::apps
