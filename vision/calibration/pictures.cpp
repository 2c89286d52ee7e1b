#include "vision/calibration.h"

#include <algorithm>

#include "vision/frame_source.h"

namespace tribotrack::vision {

CalibrationPicture calibration_picture(const std::filesystem::path& input) {
  return {input.string(), open_source(input)->read(0)};
}

std::vector<CalibrationPicture> calibration_pictures(const std::vector<std::filesystem::path>& inputs,
                                                     const CalibrationPicture& plane, int most) {
  std::vector<CalibrationPicture> pictures;
  for (const std::filesystem::path& input : inputs) {
    const auto source = open_source(input);
    const std::int64_t count = source->info().frame_count;
    const std::int64_t taken = std::min<std::int64_t>(count, most);
    for (std::int64_t k = 0; k < taken; ++k) {
      const std::int64_t index = k * count / taken;
      CalibrationPicture picture{input.string(), source->read(index)};
      if (count > 1) picture.name += ", image " + std::to_string(source->number(index));
      if (!std::ranges::equal(picture.picture.levels(), plane.picture.levels()))
        pictures.push_back(std::move(picture));
    }
  }
  return pictures;
}

}  // namespace tribotrack::vision
