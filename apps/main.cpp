// The program: its commands, its help, and what ends it.
#include <fmt/format.h>
#include <malloc.h>

#include <iostream>
#include <string>
#include <vector>

#include "apps/commands/command.h"
#include "apps/files/campaign/keys.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/program/streams.h"
#include "apps/text/output_file.h"
#include "fit/measurement.h"
#include "model/trajectory.h"
#include "vision/frame_source.h"

namespace tribotrack::apps {

namespace {

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

/// Parses a command line and carries it out. Errors go to stderr as one sentence; the result is the exit
/// code. CLI11's own codes (100-110) collide with those workflow engines retry on.
int run_program(int argc, const char* const* argv) {
  Context context;
  CLI::App app{
      "tribotrack: from high-speed video of a part on a vibrating platform to its friction parameters",
      "tribotrack"};
  app.require_subcommand(1);
  app.footer(topics() +
             "\nStart with `tribotrack open FOLDER`: a page from the recordings to the report. Without a "
             "browser: `tribotrack help start-here`, or `tribotrack init DIR`. tribotrack COMMAND --help "
             "explains each command.");
  add_options_of_all(app, context);
  add_commands(app, context);
  const std::vector<std::string> words(argv + 1, argv + argc), typed = arguments_of(app, words);
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
    try {
      parse(app, typed);
    } catch (const CLI::ParseError& error) {
      return print_help(app, error);
    }
    flush_output();
    return context.exit_code;
  } catch (const std::exception& error) {
    return complain_of(error);
  }
}

}  // namespace
}  // namespace tribotrack::apps

int main(int argc, char** argv) {
  // Pictures come and go with every frame. By default each returns its memory to the system, whose pages are
  // then cleared again for the next: a tenth of the time of tracking small ones.
  ::mallopt(M_MMAP_THRESHOLD, 1 << 25);
  ::mallopt(M_TRIM_THRESHOLD, 1 << 28);
  tribotrack::apps::occupy_standard_streams();
  tribotrack::apps::clean_up_on_signals();
  tribotrack::vision::set_up_process();
  return tribotrack::apps::run_program(argc, argv);
}
