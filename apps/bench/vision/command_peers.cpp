#include "apps/bench/vision/command_peers.h"

#include <cmath>
#include <memory>

#include "apps/bench/vision/circling.h"
#include "apps/bench/vision/matching.h"

namespace tribotrack::bench {

using namespace vision;

namespace {

/// Of a frame, about a place: the template's square and how far it is searched.
Rect window_about(const Circle& target, const Rect& frame) {
  const int reach = template_reach(target) + kSearch;
  return common(frame, {static_cast<int>(std::lround(target.x)) - reach,
                        static_cast<int>(std::lround(target.y)) - reach, 2 * reach + 1, 2 * reach + 1});
}

class Followed {
 public:
  Followed(FrameSource& source, const Circle& target) : last_(target) {
    const Rect window = window_about(target, source.bounds());
    source.read(0, window, picture_);
    matching_ = match_template(picture_, {target.x - window.x, target.y - window.y, target.radius});
  }
  Point locate(FrameSource& source, std::int64_t index) {
    const Rect window = window_about(last_, source.bounds());
    source.read(index, window, picture_);
    matching_->take(picture_);
    const Point found = matching_->locate();
    last_.x = found.x + window.x;
    last_.y = found.y + window.y;
    return {last_.x, last_.y};
  }

 private:
  Circle last_;
  Picture picture_;
  std::unique_ptr<PositionMethod> matching_;
};

}  // namespace

std::vector<Point> follow_by_matching(const std::filesystem::path& recording,
                                      const std::vector<Circle>& targets) {
  const auto source = open_recording(recording);
  std::vector<Followed> followed;
  for (const Circle& target : targets) followed.emplace_back(*source, target);
  std::vector<Point> positions;
  for (std::int64_t k = 0; k < source->info().frame_count; ++k)
    for (std::size_t t = 0; t < followed.size(); ++t) {
      const Point found = followed[t].locate(*source, k);
      if (t == 0) positions.push_back(found);
    }
  return positions;
}

void read_windows(const std::filesystem::path& recording, const std::vector<Circle>& targets) {
  const auto source = open_recording(recording);
  Picture picture;
  for (std::int64_t k = 0; k < source->info().frame_count; ++k)
    for (const Circle& target : targets) source->read(k, window_about(target, source->bounds()), picture);
}

}  // namespace tribotrack::bench
