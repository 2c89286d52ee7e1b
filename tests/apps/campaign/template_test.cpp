// A part of any shape in a campaign: the same track as `track --template`.
#include <gmock/gmock.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

const std::string kSlide =
    "[platform]\namplitude_mm = 0\n[friction]\nmu1 = 0.2\n[run]\nvelocity_x_mm_s = 150\n"
    "[video]\nwidth = 200\nheight = 100\nframe_rate_hz = 500\nexposure_s = 0.2e-3\nframes = 60\n"
    "[camera]\nmm_per_px = 0.1\n[disc]\ndiameter_mm = 4\nstart_px = [40, 50]\n";

std::string campaign(const std::string& camera, const std::string& run = "") {
  return "[platform]\namplitude_mm = 0\n[camera]\n" + camera +
         "[fit]\nparameters = [\"mu1\"]\n[[run]]\nvideo = \"a.cine\"\nkind = \"free_slide\"\n" + run;
}

class TemplatePx : public ProgramTest {
 protected:
  Outcome run_campaign(const std::string& text) {
    put(in_folder("c.toml"), text);
    return run("run c.toml -q -o out");
  }
};

TEST_F(TemplatePx, IsFollowedAsByTheCommandLine) {
  put(in_folder("scene.toml"), kSlide);
  ASSERT_EQ(run("synth scene.toml -q -o a.cine").exit_code, 0);
  ASSERT_EQ(run("track a.cine --template 18,28,45,45 --mm-per-px 0.1 --marker none -q -o t.csv").exit_code,
            0);
  for (const auto& text :
       {campaign("mm_per_px = 0.1\ntemplate_px = [18, 28, 45, 45]\n"),
        campaign("mm_per_px = 0.1\ndisc_px = [40, 50, 20]\n", "template_px = [18, 28, 45, 45]\n")}) {
    const Outcome outcome = run_campaign(text);
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    EXPECT_EQ(content_of(in_folder("out/tracks/a.csv")), content_of(in_folder("t.csv")));
  }
}

}  // namespace
}  // namespace tribotrack::apps
