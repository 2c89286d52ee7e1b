// tribotrack doctor: what to send along with a question.
#include "apps/doctor/doctor.h"

#include <fmt/format.h>

#include <memory>

#include "apps/commands/command.h"
#include "apps/doctor/version.h"
#include "apps/program/streams.h"
#include "apps/text/json.h"

namespace tribotrack::apps {

namespace {

void doctor(bool as_json, Context& context) {
  const auto findings = examine(threads_to_use(context));
  Json json = {{"version", version_text()}, {"findings", Json::array()}};
  if (!as_json) print("{}\n", version_text());
  for (const Finding& finding : findings) {
    const bool well = finding.remedy.empty();
    json["findings"].push_back(
        {{"what", finding.what}, {"state", finding.state}, {"ok", well}, {"remedy", finding.remedy}});
    if (!as_json)
      print("{:<8} {:<30} {}{}\n",
            well             ? "ok"
            : finding.needed ? "MISSING"
                             : "note",
            finding.what, finding.state, well ? "" : fmt::format(": {}", finding.remedy));
    if (!well && finding.needed) context.exit_code = kInvalidInput;
  }
  if (as_json) print_text(text_of(json));
}

}  // namespace

void add_doctor(CLI::App& app, Context& context) {
  auto json = std::make_shared<bool>(false);
  CLI::App& command = *app.add_subcommand(
      "doctor", "Is all there that the program needs? What to send along with a question");
  command.add_flag("--json", *json, "Print one JSON object");
  add_common(command, context, "  tribotrack doctor");
  command.callback([json, &context] { doctor(*json, context); });
}

}  // namespace tribotrack::apps
