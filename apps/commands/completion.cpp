// tribotrack completion, tribotrack manual: what shells and man(1) are to know of the command line.
#include <fmt/format.h>

#include <memory>

#include "apps/commands/command.h"
#include "apps/program/streams.h"
#include "apps/survey/campaign_keys.h"
#include "apps/text/output_file.h"
#include "apps/usage/manual.h"
#include "apps/usage/wrong_usage.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

void write_manual(const CLI::App& app, const fs::path& folder) {
  const std::string version = TRIBOTRACK_VERSION;
  const auto all = facts_of(app);
  create_folder(folder);
  for (const CommandFacts& command : all) {
    const std::string name = command.name == "tribotrack" ? "tribotrack" : "tribotrack-" + command.name;
    write_file(folder / (name + ".1"), manual_page(command, all, version));
  }
  write_file(folder / "tribotrack-campaign.5", campaign_manual(campaign_reference(), version));
}

}  // namespace

void add_completion(CLI::App& app, Context& context) {
  auto shell = std::make_shared<std::string>();
  CLI::App& completions = *app.add_subcommand("completion", "Print the completion script of a shell");
  completions.add_option("SHELL", *shell, "bash, zsh or fish")
      ->required()
      ->check(one_of({"bash", "zsh", "fish"}));
  add_common(completions, context,
             "  tribotrack completion bash > ~/.local/share/bash-completion/completions/tribotrack");
  completions.callback([&app, shell] { print_text(completion(facts_of(app), *shell)); });

  auto folder = std::make_shared<std::string>();
  CLI::App& manual =
      *app.add_subcommand("manual", "Write the manual pages, tribotrack.1 and one for each command");
  manual.add_option("-o,--output", *folder, "Folder for the pages")->type_name("DIR")->required();
  add_common(manual, context, "  tribotrack manual -o man && man man/tribotrack-run.1");
  manual.callback([&app, folder] { write_manual(app, *folder); });
}

}  // namespace tribotrack::apps
