// Tracking by the pictures that a recording shows, each of them once.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <numeric>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "vision/duplicate_frames.h"
#include "vision/io/files.h"
#include "vision/io/levels.h"
#include "vision/kernels/plane.h"
#include "vision/stages/stages.h"

namespace tribotrack::vision {
namespace {

constexpr std::int64_t kStoredOften = 4;  ///< times, in coded video: a step of the motion lies so near
constexpr std::int64_t kStill = 4;        ///< equal pictures in a row that are no mere repeats
constexpr std::size_t kMostListed = 5;    ///< image numbers written out

// Levels of 8 bits.
constexpr double kMotion = 4;       ///< mean of a block: more than a coder changes in a scene at rest
constexpr double kMovingPixel = 8;  ///< above noise
constexpr float kSmall = 0.35F;     ///< of the steps before and after: a repeat's

bool equal(const Picture& a, const Picture& b) {
  return std::ranges::equal(a.levels(), b.levels());
}

/// By how much two pictures differ: the mean of the differences in that block of 16 x 16 px where it is
/// largest. An edge that moves by s px changes it by s/16 of its contrast; a coder hardly does.
float step_of(const Picture& a, const Picture& b) {
  constexpr int kBlock = 16;
  cv::Mat off, blocks;
  cv::absdiff(matrix_of(a), matrix_of(b), off);
  cv::resize(off, blocks, {std::max(1, a.width() / kBlock), std::max(1, a.height() / kBlock)}, 0, 0,
             cv::INTER_AREA);
  double largest = 0;
  cv::minMaxLoc(blocks, nullptr, &largest);
  return static_cast<float>(largest);
}

/// Where something moves, by T a frame, rows that were filmed half a frame later differ by T/2 from the rows
/// above and below, the others by -T/2; in a picture filmed at once by nothing that goes with T. The
/// projection of the differences on T, and T's square; T is of the frames before and after.
std::pair<double, double> weave_of(const Picture& before, const Picture& now, const Picture& after,
                                   double moving) {
  double projection = 0, square = 0;
  for (int y = 1; y + 1 < now.height(); y += 3) {
    const auto above = now.row(y - 1), row = now.row(y), below = now.row(y + 1);
    const auto was = before.row(y), comes = after.row(y);
    for (std::size_t x = 0; x < row.size(); ++x) {
      const double motion = 0.5 * (comes[x] - was[x]);
      if (std::abs(motion) < moving) continue;
      const double differs = row[x] - 0.5 * (above[x] + below[x]);
      projection += (y % 2 != 0 ? motion : -motion) * differs;
      square += motion * motion;
    }
  }
  return {projection, square};
}

/// Frames whose picture is all but that of the frame before, while the scene moves on before and after. A
/// motion that turns round there does as little: then, as on a parabola, what the neighbours of both frames
/// differ by is 1.5 r/(1 + r) of what the steps before and after add up to, r being this frame's step over
/// the smaller of them; where one picture was stored twice it is all of that sum.
std::vector<std::int64_t> repeats_in_motion(const std::vector<float>& step, const std::vector<float>& over,
                                            double motion, float small) {
  constexpr float kBeyondTurn = 0.2F, kHalf = 0.5F;
  const auto count = std::ssize(step);
  const auto largest = [&](std::int64_t from, std::int64_t to) {
    float most = NAN;
    for (std::int64_t k = std::max<std::int64_t>(1, from); k <= std::min(to, count - 1); ++k)
      most = std::fmax(most, step[static_cast<std::size_t>(k)]);
    return most;
  };
  const auto level = static_cast<float>(motion);
  std::vector<std::int64_t> found, at_ends, amid;
  for (std::int64_t k = 1; k < count; ++k) {
    const auto at = static_cast<std::size_t>(k);
    float before = largest(k - kStoredOften, k - 1), after = largest(k + 1, k + kStoredOften);
    if (k <= kStoredOften && !(before >= level)) before = NAN;
    if (k + kStoredOften >= count && !(after >= level)) after = NAN;
    const float near = std::fmin(before, after), r = step[at] / near;
    if (!(near >= level) || !(r < small)) continue;
    if (std::isnan(over[at] + before + after)) {
      if (r < kHalf) at_ends.push_back(k);
    } else if ((small > kSmall && r < kHalf) ||
               over[at] >= (before + after) * (1.5F * r / (1 + r) + kBeyondTurn)) {
      found.push_back(k);
    } else if (r < 0.25F) {
      amid.push_back(k);
    }
  }
  // Too near to an end to be told by themselves, or amid those of a picture stored four times.
  const std::vector<std::int64_t> known = found;
  const auto is_known = [&](std::int64_t k) { return std::ranges::binary_search(known, k); };
  if (!known.empty()) found.insert(found.end(), at_ends.begin(), at_ends.end());
  std::ranges::copy_if(amid, std::back_inserter(found),
                       [&](std::int64_t k) { return is_known(k - 1) && is_known(k + 1); });
  std::ranges::sort(found);
  // Where many are, the others may be less alike, and a frame too many left out does no harm.
  if (small == kSmall && 4 * std::ssize(found) > count)
    return repeats_in_motion(step, over, motion, 2 * kSmall);
  return found;
}

/// Stretches of equal pictures, [first, last].
std::vector<std::pair<std::int64_t, std::int64_t>> equal_pictures(const std::vector<float>& step) {
  std::vector<std::pair<std::int64_t, std::int64_t>> runs;
  for (std::int64_t k = 1; k < std::ssize(step); ++k) {
    if (step[static_cast<std::size_t>(k)] != 0) continue;
    if (runs.empty() || runs.back().second != k - 1) runs.emplace_back(k - 1, k);
    runs.back().second = k;
  }
  return runs;
}

/// Hands on what it reads, and compares each frame read after the one before it: see RepeatedFrames. Other
/// reads are not looked at. What is not decoded costs one row a frame, what is some per cent of decoding.
class PictureWatch : public FrameSource {
 public:
  explicit PictureWatch(FrameSource& source) : source_(source) { info_ = source.info(); }
  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    const bool next = first_ < 0 || index == next_;
    if (next) {
      if (first_ < 0) first_ = index;
      next_ = index + 1;
      info_.decoded ? look_at_decoded(index) : look_at_rows(index);
    }
    const bool held = info_.decoded && index < next_ && index + std::ssize(kept_) >= next_ && index >= first_;
    if (!held) return source_.read(index, window, picture);
    copy_window(kept(index), window, picture);
  }
  const CodedFrame* coded(std::int64_t index) const override { return source_.coded(index); }
  RepeatedFrames found() const {
    constexpr std::int64_t kMostPauses = 3;  // more are pictures that were stored as often each
    RepeatedFrames found;
    found.looked_at = std::ssize(step_);
    if (info_.decoded)
      found.repeated = repeats_in_motion(step_, over_, std::ldexp(kMotion, info_.bits - 8), kSmall);
    const auto runs = equal_pictures(step_);
    const auto is_long = [](const auto& run) { return run.second - run.first + 1 >= kStill; };
    const bool paused = std::ranges::count_if(runs, is_long) <= kMostPauses;
    const std::vector<std::int64_t> in_motion = found.repeated;
    for (const auto& run : runs) {
      if (paused && is_long(run) && !std::ranges::binary_search(in_motion, run.second))
        found.still.emplace_back(first_ + run.first, first_ + run.second);
      else if (!info_.coder)
        for (std::int64_t k = run.first + 1; k <= run.second; ++k) found.repeated.push_back(k);
    }
    std::ranges::sort(found.repeated);
    const auto twice = std::ranges::unique(found.repeated);
    found.repeated.erase(twice.begin(), twice.end());
    for (std::int64_t& k : found.repeated) k += first_;

    constexpr double kWeaved = 0.1, kBeyondDoubt = 5;  // of 0.5; standard errors
    constexpr std::size_t kFewest = 8;
    if (weave_.size() < kFewest) return found;
    const auto frames = static_cast<double>(weave_.size());
    const double sum = std::accumulate(weave_.begin(), weave_.end(), 0.0);
    double scatter = 0;
    for (const double projection : weave_) scatter += std::pow(projection - sum / frames, 2);
    found.weaved =
        std::abs(sum) > kWeaved * weave_square_ && std::abs(sum) > kBeyondDoubt * std::sqrt(scatter);
    return found;
  }

 private:
  void look_at_decoded(std::int64_t index) {
    constexpr std::size_t kWeaves = 24;  // frames are enough
    source_.read(index, bounds(), kept(index));
    step_.push_back(index > first_ ? step_of(kept(index), kept(index - 1)) : NAN);
    over_.push_back(NAN);
    // Asked only where the step before this one may be that of a repeat.
    const auto before = std::ssize(step_) - 2;
    if (before >= 2) {
      const auto earlier = step_.begin() + std::max<std::int64_t>(1, before - kStoredOften);
      const float most = *std::max_element(earlier, step_.begin() + before);
      const bool may_repeat =
          before <= kStoredOften || step_[static_cast<std::size_t>(before)] < 0.75F * most;
      over_[static_cast<std::size_t>(before)] = may_repeat ? step_of(kept(index), kept(index - 3)) : 0;
    }
    if (index < first_ + 2 || weave_.size() >= kWeaves) return;
    const auto [projection, square] =
        weave_of(kept(index - 2), kept(index - 1), kept(index), std::ldexp(kMovingPixel, info_.bits - 8));
    if (square > 0) weave_.push_back(projection);
    weave_square_ += square;
  }
  /// A camera's noise makes one row of two pictures differ already.
  void look_at_rows(std::int64_t index) {
    source_.read(index, {0, info_.height / 2, info_.width, 1}, kept(index));
    bool same = index > first_ && equal(kept(index), kept(index - 1));
    if (same) {
      source_.read(index - 1, bounds(), whole_before_);
      source_.read(index, bounds(), whole_);
      same = equal(whole_before_, whole_);
    }
    step_.push_back(same ? 0 : 1);
    over_.push_back(NAN);
  }
  Picture& kept(std::int64_t index) { return kept_[static_cast<std::size_t>(index) % kept_.size()]; }

  FrameSource& source_;
  std::int64_t first_ = -1, next_ = -1;  ///< indices of the first frame looked at, and of the next one
  std::array<Picture, 4> kept_;
  Picture whole_before_, whole_;  ///< not decoded: two that may be equal
  /// Of frame first_ + k: by how much it differs from the one before, and the one before from the one after
  /// next: that is, two steps on. Grey levels, see step_of.
  std::vector<float> step_, over_;
  std::vector<double> weave_;  ///< of each frame, projection of rows' differences on motion
  double weave_square_ = 0;
};

/// Frames of a source by their indices, rising; numbers and times are theirs.
class SelectedFrames : public FrameSource {
 public:
  SelectedFrames(FrameSource& source, std::vector<std::int64_t> indices)
      : source_(source), indices_(std::move(indices)) {
    const SourceInfo& all = source.info();
    info_ = all;
    info_.frame_count = std::ssize(indices_);
    info_.numbers.clear();
    info_.exposures_s.clear();
    info_.time_base.stamps_s.clear();
    for (const std::int64_t index : indices_) {
      info_.numbers.push_back(source.number(index));
      info_.time_base.stamps_s.push_back(all.time_base.time_s(index));
      if (!all.exposures_s.empty())
        info_.exposures_s.push_back(all.exposures_s[static_cast<std::size_t>(index)]);
    }
  }
  void fill(std::int64_t index, const Rect& window, Picture& picture) override {
    source_.read(indices_[static_cast<std::size_t>(index)], window, picture);
  }
  const CodedFrame* coded(std::int64_t index) const override {
    return source_.coded(indices_[static_cast<std::size_t>(index)]);
  }

 private:
  FrameSource& source_;
  std::vector<std::int64_t> indices_;
};

/// What was left out as a repeat of the frame before, in its place.
void add_repeats(const RepeatedFrames& repeats, const FrameSource& source, TrackResult& result) {
  auto& points = result.track.points;
  for (const std::int64_t index : repeats.repeated) {
    TrackPoint& point = points.emplace_back();
    point.frame = source.number(index);
    point.time_s = source.time_s(index);
    point.status = TrackStatus::repeat;
  }
  std::ranges::sort(points, {}, &TrackPoint::frame);
  result.summary.repeats = std::ssize(repeats.repeated);
  result.summary.frames += result.summary.repeats;
}

}  // namespace

RepeatedFrames find_repeated_frames(FrameSource& source, std::int64_t max_frames) {
  PictureWatch watch(source);
  Picture corner;
  for (std::int64_t k = 0; k < std::min(max_frames, source.info().frame_count); ++k)
    watch.read(k, {0, 0, 1, 1}, corner);
  return watch.found();
}

std::vector<std::string> findings(const RepeatedFrames& repeats, const FrameSource& source) {
  std::vector<std::string> out;
  if (!repeats.repeated.empty()) {
    std::string text = fmt::format("{} the one before: image",
                                   repeats.repeated.size() == 1
                                       ? "1 picture repeats"
                                       : std::to_string(repeats.repeated.size()) + " pictures repeat");
    for (std::size_t k = 0; k < std::min(kMostListed, repeats.repeated.size()); ++k)
      text += (k == 0 ? " " : ", ") + std::to_string(source.number(repeats.repeated[k]));
    if (repeats.repeated.size() > kMostListed) text += " and others";
    if (3 * repeats.repeated.size() > static_cast<std::size_t>(repeats.looked_at))
      text += "; the camera recorded at a lower rate than the pictures are stored at";
    out.push_back(text +
                  "; a repeated picture shows the scene at an earlier time than its own and is left out");
  }
  for (std::size_t k = 0; k < std::min(kMostListed, repeats.still.size()); ++k)
    out.push_back(
        fmt::format("images {} to {} are one picture: the recording was paused, or nothing moved and the "
                    "coding dropped the "
                    "noise",
                    source.number(repeats.still[k].first), source.number(repeats.still[k].second)));
  if (repeats.weaved) out.push_back(fmt::format("the recording {}", kWeavedFields));
  return out;
}

TrackResult track_each_picture_once(
    FrameSource& recording, const TrackOptions& options,
    const std::function<TrackResult(FrameSource& source, const TrackOptions& options)>& run) {
  const FrameRange range = frames_to_analyse(recording, options);
  std::vector<std::int64_t> indices;
  for (std::int64_t k = range.first; k <= range.last; k += options.frame_step) indices.push_back(k);
  std::optional<SelectedFrames> selected;
  TrackOptions inner = options;
  if (options.frame_step > 1) {
    selected.emplace(recording, indices);
    inner.first_frame = inner.last_frame = std::nullopt;
  }
  FrameSource& source = selected ? static_cast<FrameSource&>(*selected) : recording;
  const std::int64_t first = selected ? 0 : range.first;
  const std::int64_t last = selected ? std::ssize(indices) - 1 : range.last;
  RepeatedFrames found;
  TrackResult result;
  if (options.debug) {  // its pictures are drawn once
    found = find_repeated_frames(source, source.info().frame_count);
  } else {
    PictureWatch watch(source);
    result = run(watch, inner);
    found = watch.found();
  }
  if (found.weaved) refuse(recording.info().path, "{}", kWeavedFields);
  std::erase_if(found.repeated, [&](std::int64_t index) { return index <= first || index > last; });
  if (!found.repeated.empty() || options.debug) {
    std::vector<std::int64_t> once;
    for (std::int64_t k = first; k <= last; ++k)
      if (!std::ranges::binary_search(found.repeated, k)) once.push_back(k);
    SelectedFrames each_once(source, std::move(once));
    inner.first_frame = inner.last_frame = std::nullopt;
    result = run(each_once, inner);
  }
  for (std::string& finding : findings(found, source)) result.summary.warnings.push_back(std::move(finding));
  add_repeats(found, source, result);
  return result;
}

}  // namespace tribotrack::vision
