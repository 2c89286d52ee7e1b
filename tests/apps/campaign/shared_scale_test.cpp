#include "apps/campaign/shared_scale.h"

#include <gmock/gmock.h>

namespace tribotrack::apps {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

/// Runs scaled by a part said to be 6 mm across. They hold no track: one that is measured again fails.
class SharedScales : public testing::Test {
 protected:
  SharedScales() { campaign_.part.diameter_mm = 6; }
  /// `size`: of the part that lies there, over 6 mm; `zoom`: px per mm over the others'.
  void add(double size, double zoom = 1) {
    CampaignRun run;
    run.name = "run" + std::to_string(campaign_.runs.size());
    run.place = "c.toml:1:1";
    campaign_.runs.push_back(run);
    AnalysedRun analysed;
    analysed.track.emplace();
    analysed.track->mm_per_px = 0.1 / (size * zoom);
    analysed.track->mm_per_px_sd = 1e-5;
    analysed.track->facts.scale_source = "part's diameter";
    analysed.track->table.time = {static_cast<double>(runs_.size())};  // none is another's repetition
    analysed.track->table.position = {{0, 0}};
    analysed.measurement.emplace();
    analysed.measurement->platform.emplace();
    analysed.measurement->platform->amplitude.value = 0.28e-3 / size;
    runs_.push_back(std::move(analysed));
  }
  std::string failure_of_first() {
    for (std::size_t k = 0; k < runs_.size(); ++k) runs_[k].run = &campaign_.runs[k];
    share_scale(campaign_, runs_);
    return runs_.front().failure;
  }
  Campaign campaign_;
  std::vector<AnalysedRun> runs_;
};

TEST_F(SharedScales, ARunWithAnotherPartIsNamedWithItsSize) {
  add(2.0 / 3);
  for (int k = 0; k < 3; ++k) add(1);
  EXPECT_THAT(failure_of_first(),
              AllOf(HasSubstr("run0"), HasSubstr("4 mm across, not 6 mm"), HasSubstr("mm_per_px")));
}

TEST_F(SharedScales, ACameraThatWasMovedIsNoOtherPart) {
  add(1, 1.5);
  for (int k = 0; k < 3; ++k) add(1);
  EXPECT_THAT(failure_of_first(), IsEmpty());
}

TEST_F(SharedScales, OfTwoPartsNobodyKnowsWhichIsTheOther) {
  add(2.0 / 3);
  add(1);
  EXPECT_THAT(failure_of_first(), testing::Not(HasSubstr("another part")));
}

}  // namespace
}  // namespace tribotrack::apps
