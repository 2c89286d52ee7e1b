// The example table with what was typed wrongly: the program names it.
#include <gmock/gmock.h>

#include "apps/program.h"
#include "apps/text/json.h"

namespace tribotrack::apps {
namespace {

using testing::HasSubstr;

class Slips : public ProgramTest {};

TEST_F(Slips, ThatFitNearlyAsWellAreUsedWithCare) {
  std::string text = content_of(source("data/example/alpha_v.toml"));
  const std::string typed = "amplitude_mm = 0.28";
  text.replace(text.find(typed), typed.size(), "amplitude_mm = 0.56");
  // In an instrument that is known exactly, which is the quicker fit.
  put(in_folder("c.toml"), text.replace(text.find("[fit]"), 5, "[fit]\nexact = true"));
  put(in_folder("alpha_v.csv"), content_of(source("data/example/alpha_v.csv")));
  const Outcome outcome = run("fit c.toml -o fit.json");
  EXPECT_EQ(outcome.exit_code, 0);
  const std::string said =
      "the data fit better to amplitude_mm = 0.28 instead of 0.56 (0.56 is 0.28 mm peak to peak); then chi2";
  EXPECT_THAT(outcome.err, HasSubstr("warning: " + said));
  const Json json = Json::parse(content_of(in_folder("fit.json")));
  EXPECT_EQ(json["verdict"], "care");
  EXPECT_THAT(json["verdict_reasons"].dump(), HasSubstr(said));
}

}  // namespace
}  // namespace tribotrack::apps
