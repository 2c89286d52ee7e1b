// tribotrack open: one page on this machine from a folder of recordings to its report.
#include <fmt/format.h>

#include <cstdlib>
#include <memory>

#include "apps/commands/command.h"
#include "apps/open/server.h"
#include "apps/open/session.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/text/json.h"
#include "apps/usage/wrong_usage.h"

namespace tribotrack::apps {

namespace {

struct OpenOptions {
  std::string given = ".";
  int port = 0;
  bool no_browser = false, json = false;
};

/// By the desktop, where there is one; nothing waits for it, and Ctrl-C here does not end it.
void show_in_browser(const std::string& url) {
  [[maybe_unused]] const int ignored =
      std::system(fmt::format("setsid xdg-open '{}' >/dev/null 2>&1 &", url).c_str());
}

void open_command(const OpenOptions& options, const Context& context) {
  OpenSession session(options.given, context);
  LocalServer server(options.port, [&session](const Asked& asked) { return session.answer(asked); });
  print_text(options.json ? text_of(Json{{"url", server.url()}, {"folder", session.folder().string()}})
                          : server.url() + "\n");
  flush_output();
  say(context.quiet,
      fmt::format("the page for {}: open this address in a browser on this machine; Ctrl-C ends it",
                  session.folder().string()));
  if (!options.no_browser) show_in_browser(server.url());
  server.listen();
}

}  // namespace

void add_open(CLI::App& app, Context& context) {
  auto options = std::make_shared<OpenOptions>();
  CLI::App& command = *app.add_subcommand(
      "open",
      "A page in the browser for the whole path: recordings, pointing, tracking, checks, fit and report");
  add_option(command, "FOLDER", options->given, "FOLDER|CAMPAIGN.toml",
             "Folder of recordings, with or without a campaign.toml, or a campaign (default: this folder)");
  add_option(command, "--port", options->port, "PORT", "Port on 127.0.0.1 (default: a free one)")
      ->check(whole_number(1, 65535));
  command.add_flag("--json", options->json, "Print address and folder as one JSON object");
  command.add_flag("--no-browser", options->no_browser, "Print the address only");
  add_common(command, context,
             "  tribotrack open recordings\n\nThe page is served to this machine alone, to whoever has its "
             "secret address. It reads and writes the campaign in that folder and fills CAMPAIGN-out beside "
             "it; whatever it does is a command that it shows.");
  command.callback([options, &context] { open_command(*options, context); });
}

}  // namespace tribotrack::apps
