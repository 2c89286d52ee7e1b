#include <fmt/core.h>

#include "vision/drawing/canvas.h"
#include "vision/io/png.h"
#include "vision/overlay.h"

namespace tribotrack::vision {
namespace {

const cv::Scalar kGrid(255, 255, 160);
const cv::Scalar kLamp(80, 80, 255);
const cv::Scalar kOther(200, 200, 200);

const cv::Scalar& colour_of(DiscRole role) {
  switch (role) {
    case DiscRole::part:
    case DiscRole::like_part:
      return kOutline;
    case DiscRole::mark:
      return kMarker;
    case DiscRole::resting:
      break;
  }
  return kOther;
}

}  // namespace

std::vector<unsigned char> survey_png(FrameSource& source, const Survey& seen) {
  const Picture frame = source.read(seen.frame - source.info().first_number);
  Canvas canvas(Stretch(frame)(frame), enlargement_for(source.info()));
  canvas.grid(kGrid);
  for (std::size_t k = 0; k < seen.discs.size(); ++k) {
    const SurveyedDisc& disc = seen.discs[k];
    canvas.circle({disc.circle.x, disc.circle.y}, disc.circle.radius, colour_of(disc.role));
    canvas.label(disc.circle, std::to_string(k + 1), colour_of(disc.role));
  }
  for (std::size_t k = 0; k < seen.lamps.size(); ++k) {
    const Circle& lamp = seen.lamps[k].circle;
    canvas.circle({lamp.x, lamp.y}, lamp.radius, kLamp);
    canvas.label(lamp, fmt::format("L{}", k + 1), kLamp);
  }
  return png_of(canvas.image());
}

}  // namespace tribotrack::vision
