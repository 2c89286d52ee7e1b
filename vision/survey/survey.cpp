// What a recording shows: its discs, which of them move, and its lamps.
#include <algorithm>
#include <cmath>
#include <numbers>
#include <opencv2/imgproc.hpp>

#include "vision/discs/disc_detection.h"
#include "vision/kernels/plane.h"
#include "vision/survey.h"
#include "vision/tracking/target.h"

namespace tribotrack::vision {

std::vector<std::int64_t> spread_frames(std::int64_t span, int most) {
  std::vector<std::int64_t> frames;
  if (span <= most) {
    for (std::int64_t k = 0; k < span; ++k) frames.push_back(k);
    return frames;
  }
  for (int k = 0; k < most; ++k) {
    const double turns = k / std::numbers::phi;
    frames.push_back(static_cast<std::int64_t>((turns - std::floor(turns)) * static_cast<double>(span)));
  }
  std::ranges::sort(frames);
  frames.erase(std::unique(frames.begin(), frames.end()), frames.end());
  return frames;
}

namespace {

constexpr double kPixelsAtWork = 4e5;  ///< larger pictures are looked at in bins of several pixels
constexpr double kLeastStep = 0.08;    ///< of the range from black to white, between dark and lit
constexpr double kTwoLevels =
    0.1;  ///< a series' variance within its two classes over all of it; a sine has 0.19
constexpr int kLeastSwitches = 4;     ///< a part that passes switches a place twice
constexpr double kCompact = 0.5;      ///< share of its bounding box that a lamp fills
constexpr double kLongest = 2.5;      ///< sides of that box
constexpr double kAgreement = 0.95;   ///< of the frames, between a pixel and its lamp
constexpr double kNewLight = 0.6;     ///< of what the lamp gains is gained by its surroundings as a whole
constexpr double kLeastRadius = 2;    ///< px: smaller ones do not tell a gate, and dust and glints are
constexpr double kLeastShare = 0.03;  ///< of the frames that it is lit, and dark
constexpr int kMostLamps = 5;

/// Frames as bytes, 255 for white, in square bins.
struct BinnedFrames {
  int bin = 1;
  double white = 255;
  std::vector<cv::Mat_<std::uint8_t>> frames;
  cv::Size size() const { return frames.front().size(); }
};

BinnedFrames binned_frames(FrameSource& source, std::span<const std::int64_t> frames) {
  const SourceInfo& info = source.info();
  BinnedFrames binned;
  binned.bin = static_cast<int>(std::ceil(std::sqrt(info.width * double(info.height) / kPixelsAtWork)));
  binned.white = info.clipping_level();
  const cv::Size size(info.width / binned.bin, info.height / binned.bin);
  Picture picture;
  for (const std::int64_t frame : frames) {
    source.read(frame, source.bounds(), picture);
    cv::Mat bins;
    cv::resize(matrix_of(picture)({{0, 0}, size * binned.bin}), bins, size, 0, 0, cv::INTER_AREA);
    bins.convertTo(binned.frames.emplace_back(), CV_8U, 255 / binned.white);
  }
  return binned;
}

/// A series split at the middle of its range.
struct TwoLevels {
  double dark = 0, lit = 0, lit_share = 0;
  double within = 1;  ///< variance within the two classes over the whole variance
  int switches = 0;
  std::vector<bool> on;

  bool is_switched() const {
    return lit - dark >= kLeastStep * 255 && within <= kTwoLevels && switches >= kLeastSwitches;
  }
};

TwoLevels two_levels(std::span<const double> series) {
  TwoLevels result;
  const auto [low, high] = std::ranges::minmax(series);
  const double middle = 0.5 * (low + high);
  double sums[2] = {0, 0}, squares = 0;
  int counts[2] = {0, 0};
  for (const double level : series) {
    const bool on = level > middle;
    sums[on] += level;
    ++counts[on];
    squares += level * level;
    if (!result.on.empty()) result.switches += on != result.on.back();
    result.on.push_back(on);
  }
  if (counts[0] == 0 || counts[1] == 0) return result;
  const auto n = static_cast<double>(series.size());
  result.dark = sums[0] / counts[0];
  result.lit = sums[1] / counts[1];
  result.lit_share = counts[1] / n;
  const double mean = (sums[0] + sums[1]) / n;
  const double variance = squares / n - mean * mean;
  const double between = result.lit_share * (1 - result.lit_share) * std::pow(result.lit - result.dark, 2);
  if (variance > 0) result.within = std::max(0.0, 1 - between / variance);
  return result;
}

TwoLevels two_levels(const BinnedFrames& frames, int x, int y) {
  std::vector<double> series;
  for (const auto& frame : frames.frames) series.push_back(frame(y, x));
  return two_levels(series);
}

/// 255 where a bin switches.
cv::Mat switching_bins(const BinnedFrames& frames) {
  cv::Mat low = frames.frames.front().clone(), high = low.clone();
  for (const auto& frame : frames.frames) {
    cv::min(low, frame, low);
    cv::max(high, frame, high);
  }
  cv::Mat mask = high - low >= kLeastStep * 255;
  for (int y = 0; y < mask.rows; ++y)
    for (int x = 0; x < mask.cols; ++x)
      if (auto& bin = mask.at<std::uint8_t>(y, x); bin != 0 && !two_levels(frames, x, y).is_switched())
        bin = 0;
  return mask;
}

/// What switches together: its bins, and the sum over a box of bins in every frame.
class Candidate {
 public:
  Candidate(const BinnedFrames& frames, const cv::Mat& labels, int label, const cv::Rect& box)
      : frames_(frames), box_(box) {
    double most = 0;
    std::vector<cv::Point> all;
    std::vector<double> steps;
    for (int y = box.y; y < box.y + box.height; ++y)
      for (int x = box.x; x < box.x + box.width; ++x) {
        if (labels.at<int>(y, x) != label) continue;
        const TwoLevels levels = two_levels(frames, x, y);
        all.emplace_back(x, y);
        steps.push_back(levels.lit - levels.dark);
        most = std::max(most, steps.back());
      }
    // Its halo switches, too.
    for (std::size_t k = 0; k < all.size(); ++k)
      if (steps[k] >= 0.5 * most) bins_.push_back(all[k]);
    box_ = cv::boundingRect(bins_);
    std::vector<double> series;
    for (const auto& frame : frames.frames) {
      double sum = 0;
      for (const cv::Point& p : bins_) sum += frame(p);
      series.push_back(sum / static_cast<double>(bins_.size()));
    }
    levels_ = two_levels(series);
  }

  bool is_lamp() const {
    return levels_.is_switched() && lamp().circle.radius >= kLeastRadius &&
           std::min(levels_.lit_share, 1 - levels_.lit_share) >= kLeastShare && is_compact() &&
           switches_as_one() && brings_new_light();
  }

  SurveyedLamp lamp() const {
    double x = 0, y = 0;
    const auto n = static_cast<double>(bins_.size());
    for (const cv::Point& p : bins_) {
      x += p.x / n;
      y += p.y / n;
    }
    const double bin = frames_.bin, to_levels = frames_.white / 255;
    return {{(x + 0.5) * bin - 0.5, (y + 0.5) * bin - 0.5, bin * std::sqrt(n / std::numbers::pi)},
            to_levels * levels_.dark,
            to_levels * levels_.lit,
            levels_.lit_share};
  }

 private:
  bool is_compact() const {
    const double sides =
        static_cast<double>(std::max(box_.width, box_.height)) / std::min(box_.width, box_.height);
    return std::min(box_.width, box_.height) >= 2 && sides <= kLongest &&
           static_cast<double>(bins_.size()) >= kCompact * box_.area();
  }

  bool switches_as_one() const {
    return std::ranges::all_of(bins_, [&](const cv::Point& p) {
      const TwoLevels own = two_levels(frames_, p.x, p.y);
      std::size_t same = 0;
      for (std::size_t f = 0; f < own.on.size(); ++f) same += own.on[f] == levels_.on[f];
      return static_cast<double>(same) >= kAgreement * static_cast<double>(own.on.size());
    });
  }

  /// A bright speck that moves with the platform switches the places that it passes, but what one gains
  /// another loses: the sum over all its path stays.
  bool brings_new_light() const {
    const int reach = std::max({8 / frames_.bin, box_.width, box_.height, 2});
    const cv::Rect wide =
        cv::Rect(box_.x - reach, box_.y - reach, box_.width + 2 * reach, box_.height + 2 * reach) &
        cv::Rect({0, 0}, frames_.size());
    double gain[2] = {0, 0};
    int counts[2] = {0, 0};
    for (std::size_t f = 0; f < frames_.frames.size(); ++f) {
      gain[levels_.on[f]] += cv::sum(frames_.frames[f](wide))[0];
      ++counts[levels_.on[f]];
    }
    const double own = (levels_.lit - levels_.dark) * static_cast<double>(bins_.size());
    return gain[1] / counts[1] - gain[0] / counts[0] >= kNewLight * own;
  }

  const BinnedFrames& frames_;
  cv::Rect box_;
  std::vector<cv::Point> bins_;
  TwoLevels levels_;
};

/// What switches in those frames as lamps do.
std::vector<SurveyedLamp> find_lamps(FrameSource& source, std::span<const std::int64_t> frames) {
  const BinnedFrames binned = binned_frames(source, frames);
  const cv::Mat mask = switching_bins(binned);
  cv::Mat labels, stats, centres;
  const int count = cv::connectedComponentsWithStats(mask, labels, stats, centres);
  std::vector<SurveyedLamp> lamps;
  for (int label = 1; label < count; ++label) {
    const auto of = [&](int column) { return stats.at<int>(label, column); };
    const cv::Rect box(of(cv::CC_STAT_LEFT), of(cv::CC_STAT_TOP), of(cv::CC_STAT_WIDTH),
                       of(cv::CC_STAT_HEIGHT));
    if (std::min(box.width, box.height) < 2) continue;
    const Candidate candidate(binned, labels, label, box);
    if (candidate.is_lamp()) lamps.push_back(candidate.lamp());
  }
  std::ranges::sort(lamps, std::greater{}, [](const SurveyedLamp& lamp) {
    return (lamp.lit - lamp.dark) * lamp.circle.radius * lamp.circle.radius;
  });
  if (lamps.size() > kMostLamps) lamps.resize(kMostLamps);
  return lamps;
}

constexpr int kFramesForDiscs = 8;
constexpr int kFramesForLamps = 160;
/// Frames at the beginning among which those for lamps are; all up to the last must be decoded where any is.
constexpr std::int64_t kLampSpan = 3000, kLampSpanDecoded = 600;
constexpr int kMostDiscs = 30;
constexpr double kSmallestRadius = 3;
constexpr double kSameRadius = 0.1;  ///< relative
constexpr double kLeastNear = 10;    ///< px
constexpr double kSameWay = 0.05;    ///< relative
constexpr double kMoves = 0.5;       ///< px: noise and the search move a disc at rest by less

DiscSearch all_discs() {
  DiscSearch search;
  search.min_radius = kSmallestRadius;
  return search;
}

bool like(const Circle& a, const Circle& b) {
  return std::abs(a.radius - b.radius) <= kSameRadius * b.radius + 0.5;
}

/// No other disc can be so near, and platforms circle by less.
double near(const Circle& place) {
  return std::max(kLeastNear, place.radius);
}

bool touches_lamp(const Circle& disc, const std::vector<SurveyedLamp>& lamps) {
  return std::ranges::any_of(lamps, [&](const SurveyedLamp& lamp) {
    return distance(disc, lamp.circle) < std::max(disc.radius, lamp.circle.radius) &&
           disc.radius < 3 * lamp.circle.radius;
  });
}

/// Where the discs of the first frame are in another one: first each that is still near its place, then those
/// that are left take the nearest that is as large.
void follow(std::vector<SurveyedDisc>& discs, const std::vector<DiscFit>& found) {
  std::vector<bool> taken(found.size(), false);
  const auto take = [&](SurveyedDisc& disc, double reach) {
    std::size_t best = found.size();
    for (std::size_t k = 0; k < found.size(); ++k)
      if (!taken[k] && like(found[k].circle, disc.circle) && distance(found[k].circle, disc.circle) < reach) {
        best = k;
        reach = distance(found[k].circle, disc.circle);
      }
    if (best == found.size()) return false;
    taken[best] = true;
    ++disc.seen_in;
    disc.moved_px = std::max(disc.moved_px, reach);
    return true;
  };
  std::vector<SurveyedDisc*> gone;
  for (SurveyedDisc& disc : discs)
    if (!take(disc, near(disc.circle))) gone.push_back(&disc);
  for (SurveyedDisc* disc : gone) take(*disc, 1e9);
}

/// What lies within a larger disc and goes where it goes is on it: a highlight, a hole.
bool carried(const SurveyedDisc& disc, const SurveyedDisc& by) {
  return disc.circle.radius < by.circle.radius && distance(disc.circle, by.circle) < by.circle.radius &&
         by.moved_px > kMoves && std::abs(disc.moved_px - by.moved_px) < kMoves + kSameWay * by.moved_px;
}

/// Roles by how far each moved; `discs` are best first.
void assign_roles(std::vector<SurveyedDisc>& discs) {
  const std::vector<SurveyedDisc> all = discs;
  std::erase_if(discs, [&](const SurveyedDisc& d) {
    return std::ranges::any_of(all, [&](const SurveyedDisc& other) { return carried(d, other); });
  });
  const auto walks = [](const SurveyedDisc& d) { return d.moved_px > near(d.circle); };
  auto part = std::ranges::find_if(discs, walks);
  // Of several that walk, the largest: specks of dirt are small.
  for (auto other = discs.begin(); other != discs.end(); ++other)
    if (part != discs.end() && walks(*other) &&
        other->circle.radius > part->circle.radius * (1 + kSameRadius))
      part = other;
  // Nothing walks: the largest of those that are seen well.
  if (part == discs.end())
    part = std::ranges::max_element(discs, {}, [](const SurveyedDisc& d) { return d.circle.radius; });
  for (auto disc = discs.begin(); disc != discs.end(); ++disc) {
    if (disc == part)
      disc->role = DiscRole::part;
    else if (walks(*disc))
      disc->role = DiscRole::like_part;
    else
      disc->role = disc->moved_px > kMoves ? DiscRole::mark : DiscRole::resting;
  }
  // What lies within the part is on it: dots, a hole, a highlight.
  const Circle whole = part->circle;
  std::erase_if(discs, [&](const SurveyedDisc& d) {
    return d.role != DiscRole::part && distance(d.circle, whole) < whole.radius &&
           d.circle.radius < whole.radius;
  });
  std::ranges::stable_sort(discs, {}, &SurveyedDisc::role);
}

}  // namespace

const SurveyedDisc* Survey::mark() const {
  const auto mark = std::ranges::find(discs, DiscRole::mark, &SurveyedDisc::role);
  return mark == discs.end() ? nullptr : &*mark;
}

Survey survey(FrameSource& source) {
  const std::int64_t last = source.info().frame_count - 1;
  Survey seen;
  const std::int64_t span = std::min(last + 1, source.info().decoded ? kLampSpanDecoded : kLampSpan);
  seen.lamps = find_lamps(source, spread_frames(span, kFramesForLamps));
  const std::int64_t first = arrival_anywhere(source, 0, last, {}).index;
  seen.frame = source.number(first);
  std::vector<std::int64_t> frames = spread_frames(last - first + 1, kFramesForDiscs);
  seen.frames_looked_at = static_cast<int>(frames.size());
  for (const std::int64_t frame : frames) {
    auto found = find_discs(source.read(first + frame), all_discs(), kMostDiscs);
    std::erase_if(found, [&](const DiscFit& fit) { return touches_lamp(fit.circle, seen.lamps); });
    if (frame == 0)
      for (const DiscFit& fit : found) seen.discs.push_back({fit.circle, fit.coverage, 0, 1});
    else
      follow(seen.discs, found);
  }
  if (!seen.discs.empty()) assign_roles(seen.discs);
  return seen;
}

}  // namespace tribotrack::vision
