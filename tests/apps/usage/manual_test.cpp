#include "apps/usage/manual.h"

#include <gmock/gmock.h>

#include <sstream>

#include "apps/chromium.h"
#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) lines.push_back(line);
  return lines;
}

TEST(Folded, BreaksAtBlanksAndIndentsWhatFollows) {
  EXPECT_EQ(folded("one two three four", 12, 4), "one two\n    three\n    four");
  EXPECT_EQ(folded("", 12, 4), "");
  EXPECT_EQ(folded("a-word-longer-than-the-line b", 10, 2), "a-word-longer-than-the-line\n  b");
}

TEST(Folded, NothingIsLostOrAdded) {
  const std::string text =
      "Rate of recording, frames/s, where the file does not give it reliably (default: none)";
  for (std::size_t width = 10; width < 90; ++width) {
    std::string again;
    for (const std::string& line : lines_of(folded(text, width, 3))) {
      const auto begin = line.find_first_not_of(' ');
      again += (again.empty() ? "" : " ") + line.substr(begin);
    }
    EXPECT_EQ(again, text) << width;
  }
}

TEST(Folded, ExamplesStayAsTheyAre) {
  EXPECT_EQ(folded_lines("Example:\n  tribotrack run a/very/long/name.toml -o out\n\nSome words here", 12),
            "Example:\n  tribotrack run a/very/long/name.toml -o out\n\nSome words\nhere");
}

TEST(OptionFacts, WordsAreThoseInSmallLetters) {
  EXPECT_THAT((OptionFacts{.names = {"--marker"}, .value = "X,Y,R|auto|texture|none", .meaning = ""}.words()),
              ElementsAre("auto", "texture", "none"));
  EXPECT_THAT((OptionFacts{.names = {"-o"}, .value = "FILE", .meaning = ""}.words()), IsEmpty());
}

class Manual : public ProgramTest {};

TEST_F(Manual, HasAPageForEveryCommandThatManReadsWithoutAWarning) {
  ASSERT_EQ(run("manual -o man").exit_code, 0);
  const bool has_man = std::system("command -v man >/dev/null") == 0;
  int pages = 0;
  for (const auto& entry : std::filesystem::directory_iterator(in_folder("man"))) {
    ++pages;
    const std::string page = content_of(entry.path());
    EXPECT_THAT(page, AllOf(HasSubstr(".TH TRIBOTRACK"), HasSubstr(".SH NAME")));
    for (const std::string& line : lines_of(page)) EXPECT_FALSE(line.starts_with("'")) << entry.path();
    EXPECT_EQ(has_man ? test::output_of("MANWIDTH=80 man --warnings -l " + entry.path().string() +
                                        " 2>&1 >/dev/null")
                      : "",
              "");
  }
  EXPECT_GE(pages, 18);
  const std::string page = content_of(in_folder("man/tribotrack-track.1"));
  EXPECT_THAT(page, AllOf(HasSubstr("\\fB\\-\\-marker\\fR"), HasSubstr("sub\\-pixel")));
  EXPECT_THAT(content_of(in_folder("man/tribotrack-campaign.5")), HasSubstr("marker_px"));
}

TEST_F(Manual, IsTheSameEveryTime) {
  ASSERT_EQ(run("manual -o one").exit_code, 0);
  ASSERT_EQ(run("manual -o two").exit_code, 0);
  for (const auto& entry : std::filesystem::directory_iterator(in_folder("one")))
    EXPECT_EQ(content_of(entry.path()), content_of(in_folder("two") / entry.path().filename()));
}

TEST_F(Manual, CompletionKnowsCommandsOptionsAndWords) {
  put(in_folder("c.bash"), run("completion bash").out);
  const auto complete = [&](const std::string& words, int at) {
    return test::output_of("bash -c 'source " + in_folder("c.bash").string() + "; COMP_WORDS=(" + words +
                           "); COMP_CWORD=" + std::to_string(at) +
                           "; _tribotrack; echo \"${COMPREPLY[*]}\"' 2>&1");
  };
  EXPECT_EQ(complete("tribotrack wa", 1), "watch\n");
  EXPECT_EQ(complete("tribotrack track --disc-d", 2), "--disc-diameter-mm\n");
  EXPECT_EQ(complete("tribotrack track a.cine --marker \"\"", 4), "auto texture none\n");
  EXPECT_THAT(run("completion fish").out,
              HasSubstr("complete -c tribotrack -n '__fish_seen_subcommand_from track'"));
  EXPECT_THAT(run("completion zsh").out, AllOf(HasSubstr("#compdef tribotrack"), HasSubstr("--marker[")));
  expect_refused(run("completion tcsh"), 2, {"tcsh", "bash"});
}

TEST_F(Manual, HelpIsFoldedAndStatesDefaults) {
  for (const char* command :
       {"", "run ", "watch ", "track ", "simulate ", "bench ", "calibrate ", "probe "}) {
    const Outcome outcome = run(std::string(command) + "--help");
    EXPECT_EQ(outcome.exit_code, 0);
    for (const std::string& line : lines_of(outcome.out))
      EXPECT_TRUE(line.size() <= 80 || line.starts_with("  tribotrack")) << line;
  }
  EXPECT_THAT(run("simulate --help").out, AllOf(HasSubstr("(default 0.28)"), HasSubstr("(default pi/2)")));
}

TEST_F(Manual, VersionNamesTheLibraries) {
  const std::string version = run("--version").out;
  EXPECT_TRUE(version.starts_with("tribotrack 0.")) << version;
  EXPECT_THAT(version, AllOf(HasSubstr("OpenCV 4."), HasSubstr("libavformat 5"), HasSubstr("Ceres 2."),
                             HasSubstr("Eigen 3.")));
}

TEST_F(Manual, DoctorSaysWhatIsThereAndWhatIsNot) {
  const Outcome well = run("doctor");
  EXPECT_EQ(well.exit_code, 0) << well.out;
  EXPECT_THAT(lines_of(well.out), Not(Each(HasSubstr("MISSING"))));
  EXPECT_THAT(well.out, AllOf(HasSubstr("video files"), HasSubstr("to be used")));
  EXPECT_THAT(run("doctor --json").out, HasSubstr("\"findings\""));
  EXPECT_THAT(run("doctor", "TMPDIR=/nowhere ").out, HasSubstr("TMPDIR"));
}

// One quantity has one meaning under both of its names.
TEST_F(Manual, CampaignNamesOfTheDriveAreFlagsToo) {
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

TEST_F(Manual, EveryCommandPrintsJson) {
  for (const char* command : {"run", "watch", "track", "measure", "fit", "report", "probe", "calibrate",
                              "simulate", "sweep", "synth", "paper", "bench", "init", "doctor"})
    EXPECT_THAT(run(std::string(command) + " --help").out, HasSubstr("--json")) << command;
}

}  // namespace
}  // namespace tribotrack::apps
