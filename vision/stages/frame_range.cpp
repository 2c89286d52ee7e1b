#include "vision/stages/frame_range.h"

#include <fmt/format.h>

namespace tribotrack::vision {

FrameRange frames_to_analyse(const FrameSource& source, const TrackOptions& options) {
  const SourceInfo& info = source.info();
  const std::string name = info.path.string();
  if (info.frame_count <= 0) throw InputError(name + " holds no frames");
  const std::int64_t low = info.first_number;
  const std::int64_t high = info.first_number + info.frame_count - 1;
  const std::int64_t first = options.first_frame.value_or(low);
  const std::int64_t last = options.last_frame.value_or(high);
  if (first < low || first > high || last < low || last > high)
    throw InputError(fmt::format("{}: frames {} to {} requested, but the recording holds {} to {}", name,
                                 first, last, low, high));
  if (last < first)
    throw InputError(
        fmt::format("{}: the last frame requested ({}) comes before the first ({})", name, last, first));
  return {first - low, last - low};
}

}  // namespace tribotrack::vision
