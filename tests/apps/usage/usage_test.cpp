// What the command line says of itself.
#include <gmock/gmock.h>

#include <filesystem>
#include <regex>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

class Usage : public ProgramTest {};

// Every page of the manual is listed by its title, printed by its name, and leads to pages that there are.
TEST_F(Usage, HelpPrintsTheManual) {
  const std::string listed = run("help").out;
  EXPECT_EQ(listed, run("--help").out);
  const std::filesystem::path manual = TRIBOTRACK_SOURCE_DIR "/apps/manual";
  for (const auto& file : std::filesystem::directory_iterator(manual)) {
    if (file.path().extension() != ".md") continue;
    const std::string page = content_of(file.path()), topic = file.path().stem();
    EXPECT_THAT(listed, HasSubstr("  " + topic + " ")) << topic;
    EXPECT_THAT(listed, HasSubstr(" " + page.substr(2, page.find('\n') - 2) + "\n")) << topic;
    EXPECT_EQ(run("help " + topic).out, page);
    const std::regex named("tribotrack help ([a-z][-a-z]*)");
    for (std::sregex_iterator at(page.begin(), page.end(), named), end; at != end; ++at)
      EXPECT_THAT(listed, HasSubstr("  " + (*at)[1].str() + " ")) << topic;
  }
  expect_refused(run("help no-such-page"), 2, {"no-such-page"});
}

// Made from --help when the package is.
TEST_F(Usage, CompletionKnowsCommandsOptionsAndWords) {
  put(in_folder("c.bash"),
      test::output_of(TRIBOTRACK_SOURCE_DIR "/apps/install/bash_completion.sh " TRIBOTRACK_BINARY));
  const auto complete = [&](const std::string& words, int at) {
    return test::output_of("bash -c 'source " + in_folder("c.bash").string() + "; COMP_WORDS=(" + words +
                           "); COMP_CWORD=" + std::to_string(at) +
                           "; _tribotrack; echo \"${COMPREPLY[*]}\"' 2>&1");
  };
  EXPECT_EQ(complete("tribotrack wa", 1), "watch\n");
  EXPECT_EQ(complete("tribotrack track --disc-d", 2), "--disc-diameter-mm\n");
  EXPECT_EQ(complete("tribotrack track a.cine --marker \"\"", 4), "auto texture none\n");
}

// One quantity has one meaning under both of its names.
TEST_F(Usage, CampaignNamesOfTheDriveAreFlagsToo) {
  const std::string ours =
      run("simulate --json -q --omega-rad-s 70 --epsilon-rad 1.5 --lag-rad 0.1 --dtau-rad 1").out;
  EXPECT_EQ(run("simulate --json -q --angular-frequency-rad-s 70 --phase-shift-rad 1.5 --phase-lag-rad 0.1 "
                "--dtau-rad 1")
                .out,
            ours);
  put(in_folder("s.toml"), "[friction]\ndtau_rad = 1\nphase_lag_rad = 0.1\n");
  put(in_folder("t.toml"), "[friction]\ndtau_rad = 1\nlag_rad = 0.1\n");
  EXPECT_EQ(run("simulate s.toml --json -q").out, run("simulate t.toml --json -q").out);
  EXPECT_THAT(run("sweep t.toml --over phase_lag_rad=0,1 -o - -q").out, HasSubstr("phase_lag_rad,alpha_rad"));
  expect_refused(run("simulate --angular-frequency-rad-s fast"), 2, {"--omega-rad-s", "fast"});
}

}  // namespace
}  // namespace tribotrack::apps
