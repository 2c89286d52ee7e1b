
#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "vision/kernels/dense.h"
#include "vision/kernels/median.h"
#include "vision/stages/stages.h"

namespace tribotrack::vision {

void StageClock::switch_to(const char* next) {
  if (!is_own()) return;
  const Clock::time_point now = Clock::now();
  auto here = std::ranges::find(spent_, now_in_, &StageTime::name);
  if (here == spent_.end()) here = spent_.insert(here, {now_in_, 0});
  here->seconds += std::chrono::duration<double>(now - since_).count();
  since_ = now;
  now_in_ = next;
}

std::vector<StageTime> StageClock::times() {
  switch_to(now_in_);
  std::vector<StageTime> out = spent_;
  std::ranges::stable_sort(out, {}, [](const StageTime& stage) { return stage.name == kOther; });
  return out;
}

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

ShownFrames frames_to_show(const Track& track, const FirstPassResult& first, const TrackOptions& options) {
  ShownFrames shown;
  std::vector<std::int64_t> seen;
  for (std::size_t k = 0; k < track.points.size(); ++k)
    if (track.points[k].status == TrackStatus::ok)
      seen.push_back(first.first_index + static_cast<std::int64_t>(k));
  if (!options.debug || seen.empty()) return shown;
  const auto add = [&](std::int64_t index, const char* why) {
    std::string& all = shown[index];
    all += (all.empty() ? "" : ", ") + std::string(why);
  };
  add(seen.front(), "first");
  add(seen[seen.size() / 2], "middle");
  add(seen.back(), "last");
  const auto worst = std::ranges::max_element(first.looks, {}, &PartLook::residual);
  if (worst->residual > 0) add(first.first_index + (worst - first.looks.begin()), "largest residual");
  return shown;
}

Remeasurement compare(const Track& track, const SeenFrames& frames,
                      const std::vector<std::optional<Remeasured>>& fixes) {
  Remeasurement out;
  std::vector<double> sds;
  double squares = 0, variances = 0;
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!fixes[k]) continue;
    const TrackPoint& p = track.points[frames[k].place];
    const double x = fixes[k]->centre.x - p.x, y = fixes[k]->centre.y - p.y;
    out.moved = {out.moved.x + x, out.moved.y + y};
    squares += x * x + y * y;
    variances += 0.5 * fixes[k]->covariance.trace();
    sds.push_back(std::sqrt(0.5 * fixes[k]->covariance.trace()));
  }
  out.count = sds.size();
  if (sds.empty()) return out;
  const auto n = static_cast<double>(sds.size());
  out.moved = {out.moved.x / n, out.moved.y / n};
  const double of_mean = out.moved.x * out.moved.x + out.moved.y * out.moved.y;
  out.differ = std::sqrt(std::max(0.0, 0.5 * (squares / n - of_mean)));
  out.sd = std::sqrt(variances / n);
  out.median_sd = median(sds);
  return out;
}

void replace(Track& track, const SeenFrames& frames, const std::vector<std::optional<Remeasured>>& fixes) {
  for (std::size_t k = 0; k < frames.size(); ++k) {
    if (!fixes[k]) continue;
    TrackPoint& p = track.points[frames[k].place];
    p.x = fixes[k]->centre.x;
    p.y = fixes[k]->centre.y;
    p.ncc = fixes[k]->ncc.value_or(p.ncc);
    set_covariance(p, fixes[k]->covariance);
  }
}

StagePicture window_of(FrameSource& source, const ShownFrames::value_type& shown, const Rect& window) {
  StagePicture seen{.name = "window",
                    .title = "the camera's picture about the part",
                    .frame = source.number(shown.first),
                    .why_frame = shown.second,
                    .levels = {},
                    .first = {static_cast<double>(window.x), static_cast<double>(window.y)},
                    .place = "of the camera"};
  source.read(shown.first, window, seen.levels);
  const auto [low, high] = std::ranges::minmax(seen.levels.levels());
  seen.low = low;
  seen.high = high;
  return seen;
}

void show_prediction(const StagePicture& seen, Picture predicted, const std::string& stage,
                     const std::string& title, const std::string& residual_title, DebugSink& sink) {
  StagePicture model = seen, residual = seen;
  model.name = stage + "_predicted";
  model.title = title;
  residual.name = stage + "_residual";
  residual.title = residual_title;
  residual.low = residual.high = 0;
  residual.zero_centred = true;
  for (std::size_t k = 0; k < predicted.levels().size(); ++k)
    residual.levels.levels()[k] -= predicted.levels()[k];
  model.levels = std::move(predicted);
  sink.show(model);
  sink.show(residual);
}

}  // namespace tribotrack::vision
