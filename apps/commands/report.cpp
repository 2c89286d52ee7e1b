// tribotrack report: the page of a folder that `run` has filled.
#include <memory>

#include "apps/commands/command.h"
#include "apps/program/progress.h"
#include "apps/report/report.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

void add_report(CLI::App& app, Context& context) {
  auto folder = std::make_shared<std::string>();
  auto output = std::make_shared<std::string>();
  CLI::App& command =
      *app.add_subcommand("report", "One self-contained HTML page from the folder of a `run`");
  command.add_option("DIR", *folder, "Folder that `tribotrack run` has filled")->required();
  command.add_option("-o,--output", *output, "The page; it holds all it needs and fetches nothing")
      ->type_name("report.html")
      ->required();
  add_common(command, context, "  tribotrack report out -o report.html");
  command.callback([folder, output, &context] {
    require_writable(*output);
    const std::string page = report_page_of(RunFolder{*folder});
    write_file(*output, page);
    say(context.quiet, *output + ": written");
  });
}

}  // namespace tribotrack::apps
