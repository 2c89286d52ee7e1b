#include "vision/stages/stage_clock.h"

namespace tribotrack::vision {

const char* to_string(Stage stage) {
  switch (stage) {
    case Stage::reading:
      return "reading and decoding";
    case Stage::camera:
      return "camera: noise, bad pixels";
    case Stage::finding:
      return "finding the part";
    case Stage::setup:
      return "template of the part";
    case Stage::part:
      return "first pass: part";
    case Stage::marker:
      return "first pass: marker";
    case Stage::lamp:
      return "first pass: gate lamp";
    case Stage::radius:
      return "first pass: disc radius";
    case Stage::layers_learning:
      return "layers: learning";
    case Stage::layers_measuring:
      return "layers: measuring";
    case Stage::rotation:
      return "rotation by rings";
    case Stage::audit:
      return "audit";
    case Stage::debug_pictures:
      return "debug pictures";
    case Stage::other:
      break;
  }
  return "other";
}

std::vector<StageTime> StageClock::times() {
  switch_to(now_in_);
  std::vector<StageTime> out;
  for (std::size_t k = 0; k < kStages; ++k)
    if (spent_[k] > Clock::duration::zero())
      out.push_back({to_string(static_cast<Stage>(k)), std::chrono::duration<double>(spent_[k]).count()});
  return out;
}

}  // namespace tribotrack::vision
