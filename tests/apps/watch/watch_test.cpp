// `watch` on recordings that arrive as they would from a camera: the same result as `run` on all of them.
#include <gmock/gmock.h>

#include <chrono>
#include <nlohmann/json.hpp>
#include <thread>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

namespace fs = std::filesystem;
using ::testing::AllOf;
using ::testing::HasSubstr;
using Json = nlohmann::json;

class Watch : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    put(in_folder("scene.toml"),
        "[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\nphase_shift_rad = \"pi/2\"\n"
        "[friction]\nmu1 = 0.1\nmu2 = 0.0125\nlag_rad = 0.2\n[run]\ncycles = 8\n"
        "[video]\nwidth = 200\nheight = 200\nframe_rate_hz = 250\nexposure_s = 0.4e-3\n"
        "[camera]\nmm_per_px = 0.15\n[disc]\ndiameter_mm = 6\n[marker]\nposition_px = [30, 30]\nradius_px = "
        "9\n"
        "[[shot]]\nname = \"phi000_dtau060\"\nphi_rad = 0\ndtau_rad = \"60deg\"\n"
        "[[shot]]\nname = \"phi090_dtau060\"\nphi_rad = \"90deg\"\ndtau_rad = \"60deg\"\n"
        "[[shot]]\nname = \"phi000_dtau120\"\nphi_rad = 0\ndtau_rad = \"120deg\"\n"
        "[[shot]]\nname = \"phi180_dtau090\"\nphi_rad = \"180deg\"\ndtau_rad = \"90deg\"\n");
    const Outcome outcome = run("synth scene.toml -q -o filmed");
    ASSERT_EQ(outcome.exit_code, 0) << outcome.err;
    fs::create_directory(in_folder("lab"));
  }
  void arrive(const std::string& name) const {
    fs::copy_file(in_folder("filmed/" + name), in_folder("lab/" + name),
                  fs::copy_options::overwrite_existing);
  }
  void arrive_by_halves(const std::string& name) const {
    const std::string whole = content_of(in_folder("filmed/" + name));
    put(in_folder("lab/" + name), whole.substr(0, whole.size() / 2));
    std::this_thread::sleep_for(std::chrono::milliseconds(400));
    arrive(name);
  }
};

TEST_F(Watch, EndsWithTheSameFitAsRunOnAllThatArrived) {
  std::jthread camera([this] {
    for (const char* name : {"phi090_dtau060.cine", "phi000_dtau120.cine"}) {
      std::this_thread::sleep_for(std::chrono::milliseconds(300));
      arrive(name);
    }
    arrive_by_halves("phi000_dtau060.cine");
    arrive("phi180_dtau090.cine");
  });
  const Outcome watched = run("watch lab --disc-diameter-mm 6 --until-idle-s 5 -o out");
  camera.join();
  ASSERT_EQ(watched.exit_code, 0) << watched.err;
  EXPECT_THAT(watched.out, AllOf(HasSubstr("film next: phi = 0"), HasSubstr("4 runs: mu1 = 0.")));
  ASSERT_EQ(run("run lab/campaign.toml -o again -q").exit_code, 0);
  EXPECT_EQ(content_of(in_folder("out/fit.json")), content_of(in_folder("again/fit.json")));
  EXPECT_EQ(content_of(in_folder("out/runs.csv")), content_of(in_folder("again/runs.csv")));
  EXPECT_EQ(content_of(in_folder("out/tracks/phi000_dtau060.csv")),
            content_of(in_folder("again/tracks/phi000_dtau060.csv")));
}

TEST_F(Watch, KeepsTheUsersCampaignAndTakesRecordingsThatItNamesAlready) {
  put(in_folder("lab/campaign.toml"),
      "# mine\n[part]\ndiameter_mm = 6\n[camera]\nmarker_px = [30, 30, 9]\n[fit]\nparameters = [\"mu1\"]\n"
      "[fit.fixed]\nmu2 = 0.0125\nphase_lag_rad = 0.2\n"
      "[[run]]\nvideo = \"phi000_dtau060.cine\"\nphi_rad = 0\ndtau_rad = \"60deg\"\n"
      "[[run]]\nvideo = \"planned.cine\"\nphi_rad = 1\ndtau_rad = \"60deg\"\n");
  const std::string before = content_of(in_folder("lab/campaign.toml"));
  arrive("phi000_dtau060.cine");
  fs::copy_file(in_folder("filmed/phi090_dtau060.cine"), in_folder("lab/nameless.cine"));
  const Outcome watched = run("watch lab --until-idle-s 4 --json -o out");
  EXPECT_EQ(watched.exit_code, 4) << "as of `run`: " << watched.err;
  EXPECT_EQ(content_of(in_folder("lab/campaign.toml")), before) << "nothing was to be added";
  EXPECT_THAT(watched.err, AllOf(HasSubstr("nameless.cine"), HasSubstr("add a [[run]]"),
                                 HasSubstr("not there yet, or not finished: planned")));
  EXPECT_EQ(Json::parse(watched.out).at("runs").size(), 1U);
}

}  // namespace
}  // namespace tribotrack::apps
