// The example table with what was typed wrongly: the program names it.
#include <gmock/gmock.h>

#include "apps/program.h"
#include "apps/text/json.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

class Slips : public ProgramTest {
 protected:
  /// In an instrument that is known exactly, which is the quicker fit.
  Outcome fit(const std::string& typed, const std::string& slip) {
    std::string text = content_of(source("data/example/alpha_v.toml"));
    const auto at = text.find(typed);
    EXPECT_NE(at, std::string::npos);
    text.replace(at, typed.size(), slip);
    put(in_folder("c.toml"), text.replace(text.find("[fit]"), 5, "[fit]\nexact = true"));
    put(in_folder("alpha_v.csv"), content_of(source("data/example/alpha_v.csv")));
    return run("fit c.toml -o fit.json");
  }
};

TEST_F(Slips, ThatFitNearlyAsWellAreUsedWithCare) {
  const Outcome outcome = fit("amplitude_mm = 0.28", "amplitude_mm = 0.56");
  EXPECT_EQ(outcome.exit_code, 0);
  const std::string said =
      "the data fit better to amplitude_mm = 0.28 instead of 0.56 (0.56 is 0.28 mm peak to peak); then chi2";
  EXPECT_THAT(outcome.err, HasSubstr("warning: " + said));
  const Json json = Json::parse(content_of(in_folder("fit.json")));
  EXPECT_EQ(json["verdict"], "care");
  EXPECT_THAT(json["verdict_reasons"].dump(), HasSubstr(said));
}

TEST_F(Slips, ThatExplainAFitThatFailsAreNamed) {
  const Outcome outcome = fit("angular_frequency_rad_s = 62.8", "angular_frequency_rad_s = 10.0");
  EXPECT_EQ(outcome.exit_code, 5);
  EXPECT_THAT(outcome.err,
              HasSubstr("warning: a slip would explain it: angular_frequency_rad_s = 62.83 instead "
                        "of 10 (10 is 62.83 rad/s in Hz); then chi2"));
}

}  // namespace
}  // namespace tribotrack::apps
