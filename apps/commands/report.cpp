// tribotrack report: the page of a folder that `run` has filled.
#include <fmt/format.h>

#include <memory>

#include "apps/commands/command.h"
#include "apps/figures/printed.h"
#include "apps/page/assets/embedded_assets.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/report/report.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

void add_report(CLI::App& app, Context& context) {
  auto folder = std::make_shared<std::string>();
  auto output = std::make_shared<std::string>();
  auto figures = std::make_shared<std::string>();
  auto tables = std::make_shared<std::string>();
  auto json = std::make_shared<bool>(false);
  CLI::App& command =
      *app.add_subcommand("report", "One self-contained HTML page from the folder of a `run`");
  command.add_option("DIR", *folder, "Folder that `tribotrack run` has filled")->required();
  command
      .add_option("-o,--output", *output, "The page; it is self-contained and loads nothing from elsewhere")
      ->type_name("report.html");
  command
      .add_option("--figures", *figures,
                  "Folder for the figures as SVG and PDF, 84 and 174 mm wide, drawn by matplotlib (Debian's "
                  "python3-matplotlib), with their numbers as CSV and the script that drew them")
      ->type_name("DIR");
  command
      .add_option("--tables", *tables,
                  "Folder for runs.csv, parameters.csv and report.txt (DIR itself: where `run` has them)")
      ->type_name("DIR");
  command.add_flag("--json", *json, "Print what was written as one JSON object");
  add_common(command, context,
             "  tribotrack report out -o report.html\n  tribotrack report out --figures figures");
  command.callback([folder, output, figures, tables, json, &context] {
    const RunFolder run_folder{*folder};
    if (output->empty() && figures->empty() && tables->empty())
      throw CLI::RequiredError("--output report.html, --figures DIR or --tables DIR");
    std::vector<Output> outputs;
    if (!output->empty()) outputs.push_back({*output});
    if (!tables->empty()) {
      create_folder(*tables);
      const RunFolder to{*tables};
      for (const auto& file : {to.runs_table(), to.parameter_table(), to.text()}) outputs.push_back({file});
    }
    require_writable(outputs, run_folder.files_of_report());
    if (const auto writer = writer_of(run_folder))
      say(context.quiet,
          fmt::format("note: {} is being written by {}: the page shows what is there now", *folder, *writer));
    const Report report = report_of(run_folder);
    for (const std::string& file : report.missing) say(context.quiet, "warning: " + file);
    if (!output->empty()) {
      write_file(*output, report.page);
      say(context.quiet, *output + ": written");
    }
    if (!tables->empty()) {
      const RunFolder to{*tables};
      write_file(to.runs_table(), report.runs_csv);
      write_file(to.parameter_table(), report.parameters_csv);
      write_file(to.text(), report.text);
      say(context.quiet, fmt::format("{}: runs.csv, parameters.csv, report.txt written", *tables));
    }
    if (!figures->empty()) {
      std::vector<Output> files;
      create_folder(*figures);
      for (const auto& file : printed_files(report.figures, *figures)) files.push_back({file});
      require_writable(files, run_folder.files_of_report());
      print_figures(report.figures, *figures, embedded_assets().figures_py);
      say(context.quiet, fmt::format("{}: {} figures written", *figures, report.figures.size()));
    }
    if (!*json) return;
    Json ids = Json::array();
    for (const Figure& figure : report.figures) ids.push_back(figure.id);
    print_text(text_of(Json{{"page", output->empty() ? Json() : Json(*output)},
                            {"figures_folder", figures->empty() ? Json() : Json(*figures)},
                            {"figures", ids},
                            {"tables_folder", tables->empty() ? Json() : Json(*tables)},
                            {"missing", report.missing}}));
  });
}

}  // namespace tribotrack::apps
