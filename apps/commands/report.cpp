// tribotrack report: the page of a folder that `run` has filled.
#include <fmt/format.h>

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
  command
      .add_option("-o,--output", *output, "The page; it is self-contained and loads nothing from elsewhere")
      ->type_name("report.html")
      ->required();
  add_common(command, context, "  tribotrack report out -o report.html");
  command.callback([folder, output, &context] {
    const RunFolder run_folder{*folder};
    require_writable({{*output}}, run_folder.files_of_report());
    if (const auto writer = writer_of(run_folder))
      say(context.quiet,
          fmt::format("note: {} is being written by {}: the page shows what is there now", *folder, *writer));
    const ReportOfFolder report = report_of(run_folder);
    write_file(*output, report.page);
    for (const std::string& file : report.missing) say(context.quiet, "warning: " + file);
    say(context.quiet, *output + ": written");
  });
}

}  // namespace tribotrack::apps
