// tribotrack init: a commented campaign to start from, filled in from recordings where there are some.
#include <fmt/format.h>

#include <memory>

#include "apps/commands/command.h"
#include "apps/program/progress.h"
#include "apps/program/streams.h"
#include "apps/survey/campaign_draft.h"
#include "apps/text/json.h"
#include "apps/text/output_file.h"

namespace tribotrack::apps {

namespace fs = std::filesystem;

namespace {

struct InitOptions {
  std::string folder, from;
  std::optional<double> diameter_mm, fps;
  bool json = false;
};

CampaignDraft draft_for(const InitOptions& options, const Context& context) {
  if (options.from.empty()) {
    CampaignDraft draft;
    if (options.diameter_mm)
      draft.tables["part"]["diameter_mm"] = {fmt::format("{}", *options.diameter_mm), "given"};
    if (options.fps) draft.tables["camera"]["frame_rate_hz"] = {fmt::format("{}", *options.fps), "given"};
    return draft;
  }
  const std::vector<fs::path> recordings = recordings_in(options.from);
  if (recordings.empty())
    throw InvalidInput(
        fmt::format("{}: holds no recording (.cine, video, TIFF stack or folders of pictures); give the "
                    "folder that does",
                    options.from));
  return draft_of(recordings, {options.folder, options.diameter_mm, options.fps}, context);
}

void init(const InitOptions& options, const Context& context) {
  const fs::path file = fs::path(options.folder) / "campaign.toml";
  if (fs::exists(file))
    throw InvalidInput(
        fmt::format("{}: exists already and is not overwritten; give another folder", file.string()));
  const CampaignDraft draft = draft_for(options, context);
  create_folder(options.folder);
  write_file(file, toml_of(draft));
  if (options.json)
    print_text(text_of(Json{{"campaign", file.string()},
                            {"runs", draft.runs.size()},
                            {"to_fill_in", draft.missing},
                            {"left_out", draft.left_out}}));
  else
    print("{}\n", file.string());
  for (const std::string& left_out : draft.left_out) complain(fmt::format("left out: {}", left_out));
  if (!options.from.empty())
    say(context.quiet, fmt::format("{} recordings; every guess is marked as one", draft.runs.size()));
  for (const std::string& missing : draft.missing) say(context.quiet, fmt::format("to fill in: {}", missing));
  say(context.quiet,
      fmt::format("{}: tribotrack run {} -o {}", draft.runs.empty() ? "add the recordings, then" : "then",
                  file.string(), (fs::path(options.folder) / "out").string()));
}

}  // namespace

void add_init(CLI::App& app, Context& context) {
  auto options = std::make_shared<InitOptions>();
  CLI::App& command = *app.add_subcommand("init", "Write a commented campaign to start from");
  command.add_option("DIR", options->folder, "Folder to write campaign.toml into; made if it is not there")
      ->type_name("DIR")
      ->required();
  command
      .add_option("--from", options->from,
                  "Look into every recording of this folder: one [[run]] each, with part, mark and lamp "
                  "found, phi and "
                  "dtau by the name (phi045_dtau060, 45deg_60deg)")
      ->type_name("RECORDINGS");
  add_number(command, "--disc-diameter-mm", options->diameter_mm,
             "The part's diameter, which sets the scale");
  add_number(command, "--fps", options->fps, "Frame rate, where the recordings do not say it");
  command.add_flag("--json", options->json, "Print what was found as one JSON object");
  add_common(command, context, "  tribotrack init my_campaign --from recordings --disc-diameter-mm 6");
  command.callback([options, &context] { init(*options, context); });
}

}  // namespace tribotrack::apps
