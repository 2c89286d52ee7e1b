#include "vision/coding/coded_errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <opencv2/core.hpp>

#include "vision/kernels/dense.h"
#include "vision/kernels/median.h"

namespace tribotrack::vision {
namespace {

/// A place every two pixels: each cell that the rim crosses is met.
int places_on(const Circle& rim) {
  return std::max(16, static_cast<int>(std::numbers::pi * rim.radius));
}

}  // namespace

RimCoding rim_coding(const CodedFrame& frame, const Circle& rim) {
  RimCoding out;
  out.type = frame.type;
  if (frame.cells.empty()) return out;
  const int places = places_on(rim);
  double seen = 0;
  Point all;
  for (int k = 0; k < places; ++k) {
    const double phi = 2 * std::numbers::pi * k / places, x = std::cos(phi), y = std::sin(phi);
    const int column = static_cast<int>(std::floor((rim.x + rim.radius * x) / CodedFrame::kCell));
    const int row = static_cast<int>(std::floor((rim.y + rim.radius * y) / CodedFrame::kCell));
    if (column < 0 || row < 0 || column >= frame.columns || row >= frame.rows) continue;
    const CodedCell& cell = frame.cells[static_cast<std::size_t>(row * frame.columns + column)];
    ++seen;
    out.step += static_cast<double>(cell.step);
    all.x += x * x;
    all.y += y * y;
    if (cell.kind == CodedCell::Kind::intra) continue;
    Point& share = cell.kind == CodedCell::Kind::still ? out.still : out.moving;
    share.x += x * x;
    share.y += y * y;
  }
  if (seen == 0) return out;
  out.step /= seen;
  for (Point* share : {&out.still, &out.moving}) {
    share->x /= std::max(all.x, 1e-9);
    share->y /= std::max(all.y, 1e-9);
  }
  return out;
}

namespace {

/// Of all cells alike.
RimCoding picture_coding(const CodedFrame& frame) {
  RimCoding out;
  out.type = frame.type;
  out.step = frame.mean_step();
  if (frame.cells.empty()) return out;
  const double still = frame.still_share();
  const auto moving = std::ranges::count(frame.cells, CodedCell::Kind::moving, &CodedCell::kind);
  const double moves = static_cast<double>(moving) / static_cast<double>(frame.cells.size());
  out.still = {still, still};
  out.moving = {moves, moves};
  return out;
}

}  // namespace

WatchedFrame watched(const FrameSource& recording, std::int64_t index, const Circle& part,
                     const std::optional<Circle>& mark) {
  WatchedFrame frame{.index = index, .part = {}, .mark = {}};
  if (const CodedFrame* coded = recording.coded(index)) {
    frame.part = rim_coding(*coded, part);
    frame.mark = mark ? rim_coding(*coded, *mark) : picture_coding(*coded);
  }
  return frame;
}

namespace {

constexpr int kBlock = 8;
using Block = std::array<double, kBlock * kBlock>;
/// The largest coefficient of an orthonormal DCT.
double largest_coefficient(Block block) {
  cv::Mat levels(kBlock, kBlock, CV_64F, block.data());
  cv::dct(levels, levels);
  return cv::norm(levels, cv::NORM_INF);
}

struct Mean {
  double sum = 0, weight = 0;
  void add(const Block& slope) {
    double square = 0;
    for (const double s : slope) square += s * s;
    const double largest = largest_coefficient(slope);
    sum += square * largest;
    weight += square;
  }
  double unnoticed() const { return sum > 0 ? weight / sum : 0; }
};

bool counts(const Circle& rim, int left, int top, double margin) {
  const double middle = 0.5 * (kBlock - 1);
  const double off = std::hypot(left + middle - rim.x, top + middle - rim.y) - rim.radius;
  return margin < 0 ? off < middle : std::abs(off) < middle + margin;
}

}  // namespace

Point unnoticed_motion(const Picture& picture, const Circle& rim, double margin) {
  Mean along_x, along_y;
  for (int top = 0; top + kBlock <= picture.height(); top += kBlock)
    for (int left = 0; left + kBlock <= picture.width(); left += kBlock) {
      if (!counts(rim, left, top, margin)) continue;
      Block x{}, y{};
      for (int j = 0; j < kBlock; ++j)
        for (int i = 0; i < kBlock; ++i) {
          const auto level = [&](int dx, int dy) {
            return static_cast<double>(picture.at(std::clamp(left + i + dx, 0, picture.width() - 1),
                                                  std::clamp(top + j + dy, 0, picture.height() - 1)));
          };
          const auto at = static_cast<std::size_t>(j * kBlock + i);
          x[at] = 0.5 * (level(1, 0) - level(-1, 0));
          y[at] = 0.5 * (level(0, 1) - level(0, -1));
        }
      along_x.add(x);
      along_y.add(y);
    }
  return {along_x.unnoticed(), along_y.unnoticed()};
}

namespace {

constexpr double kPlay = 0.58;               ///< half width of the play over d0
constexpr double kMoving = 0.125;            ///< of its variance, where a vector follows the part
constexpr double kBlocks = 1.4, kStill = 3;  ///< of the measured law

double square(double x) {
  return x * x;
}

/// Variances, px^2, along x and y.
using Added = Eigen::Array2d;

double play_variance(double still, double moving, double unnoticed) {
  return 0.5 * square(kPlay * unnoticed) * (still + kMoving * moving);
}

/// By the measured law, of a variance that the audit has made `white` times as large.
double by_law(double sigma, double white) {
  return std::max(0.0, square(kBlocks + kStill) / white - 1) * square(sigma);
}

Added added_in(const CodedTrack& coded, const WatchedFrame& f, const TrackPoint& p, double white) {
  if (coded.coder.all_intra || f.part.type == 'I') return {0, 0};
  if (!(f.part.step > 0)) return {by_law(p.sigma_x, white), by_law(p.sigma_y, white)};
  const double zone = coded.coder.dead_zone * f.part.step;
  return {play_variance(f.part.still.x, f.part.moving.x, zone * coded.part_unnoticed.x),
          play_variance(f.part.still.y, f.part.moving.y, zone * coded.part_unnoticed.y)};
}

Point mean_position(const Track& track) {
  Point sum;
  double count = 0;
  for (const TrackPoint& p : track.points)
    if (p.status == TrackStatus::ok) sum = {sum.x + p.x, sum.y + p.y}, ++count;
  return {sum.x / std::max(1.0, count), sum.y / std::max(1.0, count)};
}

/// px rms of a coordinate.
double sd_of(const Track& track) {
  double sum = 0, count = 0;
  for (const TrackPoint& p : track.points)
    if (p.status == TrackStatus::ok) sum += 0.5 * covariance_of(p).trace(), ++count;
  return std::sqrt(sum / std::max(1.0, count));
}

/// A template's own frame fits itself, and leaves no residual for what the coder did there: it is known no
/// better than the usual frame.
void widen_first(Track& track) {
  const auto is_ok = [](const TrackPoint& p) { return p.status == TrackStatus::ok; };
  const auto first = std::ranges::find_if(track.points, is_ok);
  if (first == track.points.end()) return;
  for (double TrackPoint::*sigma : {&TrackPoint::sigma_x, &TrackPoint::sigma_y}) {
    std::vector<double> sigmas;
    for (const TrackPoint& p : track.points)
      if (is_ok(p)) sigmas.push_back(p.*sigma);
    (*first).*sigma = std::max((*first).*sigma, median(sigmas));
  }
}

/// s over which the direction of motion stays: half the integral of its autocorrelation, both ways.
double direction_time(const Track& track, double step) {
  std::vector<Point> way;
  std::vector<double> time;
  for (const TrackPoint& p : track.points) {
    if (p.status != TrackStatus::ok) continue;
    way.push_back({p.x, p.y});
    time.push_back(p.time_s);
  }
  std::vector<Point> direction;
  for (std::size_t k = 0, last = 0; k < way.size(); ++k) {
    const Point d = {way[k].x - way[last].x, way[k].y - way[last].y};
    const double length = std::hypot(d.x, d.y);
    if (length > step) last = k;
    direction.push_back(length > 0 ? Point{d.x / length, d.y / length} : Point{});
  }
  if (direction.size() < 8) return 0;
  const double interval = (time.back() - time.front()) / static_cast<double>(time.size() - 1);
  double integral = 0;
  for (std::size_t lag = 0; lag < direction.size() / 2; ++lag) {
    double sum = 0;
    for (std::size_t k = 0; k + lag < direction.size(); ++k)
      sum += direction[k].x * direction[k + lag].x + direction[k].y * direction[k + lag].y;
    const double share = sum / static_cast<double>(direction.size() - lag);
    if (share <= 0) break;
    integral += share * interval;
  }
  return integral;
}

double mean(const Point& p) {
  return 0.5 * (p.x + p.y);
}

/// Adds what one frame tells; `added_sd` is a variance until means_of().
void add_frame(const CodedTrack& coded, const WatchedFrame& f, const Added& added, CodedErrors& sums) {
  const double zone = coded.coder.dead_zone;
  const double part = zone * f.part.step * mean(coded.part_unnoticed);
  const double mark = zone * f.mark.step * mean(coded.mark_unnoticed);
  sums.step += f.part.step;
  sums.still += mean(f.part.still);
  sums.moving += mean(f.part.moving);
  sums.unnoticed += part;
  sums.part_play += kPlay * part * mean(f.part.still);
  sums.mark_play += kPlay * mark * mean(f.mark.still);
  sums.added_sd += added.mean();
}

CodedErrors means_of(CodedErrors sums, double frames) {
  for (double* sum : {&sums.step, &sums.still, &sums.moving, &sums.unnoticed, &sums.part_play,
                      &sums.mark_play, &sums.added_sd})
    *sum /= std::max(1.0, frames);
  sums.added_sd = std::sqrt(sums.added_sd);
  return sums;
}

/// What is seen of the ground through too coarse steps is the codec's.
void leave_out_unseen_ground(const std::vector<WatchedFrame>& frames, Track& track, TrackSummary& summary) {
  double step = 0;  // 0 where the codec does not tell
  for (const WatchedFrame& f : frames) step += f.mark.step / static_cast<double>(frames.size());
  if (step < *summary.ground_steps) return;
  const std::string hidden = fmt::format(
      "the codec's steps of {:.2g} grey levels hide the platform's texture, which needs steps "
      "below {:.2g}: positions are in the camera's frame",
      step, *summary.ground_steps);
  *std::ranges::find(summary.plan, "marker", &PlanStage::name) = {.name = "marker", .reason = hidden};
  summary.warnings.push_back(hidden + "; give a marker (--marker), or film uncompressed");
  summary.ground_steps.reset();
  track.has_marker = false;
  for (TrackPoint& p : track.points) p.marker.reset();
}

/// One sentence for a person.
std::string coding_warning(const CodedErrors& errors) {
  if (!(errors.added_sd > 0)) return {};
  const bool predicted = errors.still + errors.moving > 0;
  const std::string how =
      !(errors.step > 0) ? fmt::format("coded as {}, which does not tell how", errors.coder)
      : !predicted       ? fmt::format("coded by {}, every frame by itself", errors.coder)
                         : fmt::format(
                               "coded by {}: {:.0f} % of the edge is predicted from the same place of "
                                     "another frame, where the part can move by {:.3f} px unnoticed",
                               errors.coder, 100 * errors.still, errors.unnoticed);
  return fmt::format(
      "{}; {:.4f} px that change over {:.2g} s are added to the standard deviations. Film uncompressed, as "
      "FFV1, {}",
      how, errors.added_sd, errors.slow_time,
      errors.step > 0 && !predicted ? "or with less compression"
                                    : "or code every frame by itself (MJPEG, all-intra)");
}

}  // namespace

double displacement_differs(const Track& track, const Track& other) {
  const Point here = mean_position(track), there = mean_position(other);
  double squares = 0, products = 0, count = 0;
  const auto both = [&](auto&& look) {
    for (std::size_t k = 0; k < std::min(track.points.size(), other.points.size()); ++k) {
      const TrackPoint &a = track.points[k], &b = other.points[k];
      if (a.status != TrackStatus::ok || b.status != TrackStatus::ok) continue;
      look(a.x - here.x, b.x - there.x);
      look(a.y - here.y, b.y - there.y);
    }
  };
  both([&](double x, double y) {
    squares += x * x;
    products += x * (y - x);
    ++count;
  });
  if (!(squares > 0) || count < 16) return 0;
  const double share = products / squares;
  double left = 0;
  both([&](double x, double y) { left += square(y - x - share * x); });
  const double scatter = std::sqrt(left / count / squares);
  return std::abs(share) > 2 * scatter ? share : 0;
}

void widen_for_coding(const CodedTrack& coded, Track& track, TrackSummary& summary) {
  const double white = summary.audit.white_factor;
  if (!summary.layered) widen_first(track);
  const Point middle = mean_position(track);
  CodedErrors sums;
  double frames = 0;
  for (const WatchedFrame& f : coded.frames) {
    const auto place = static_cast<std::size_t>(f.index - coded.first_index);
    if (place >= track.points.size() || track.points[place].status != TrackStatus::ok) continue;
    TrackPoint& p = track.points[place];
    Added added = added_in(coded, f, p, white);
    added += (coded.passes_differ * Eigen::Array2d(p.x - middle.x, p.y - middle.y)).square();
    add_frame(coded, f, added, sums);
    ++frames;
    set_covariance(p, covariance_of(p) + Eigen::Matrix2d(added.matrix().asDiagonal()));
  }
  CodedErrors found = means_of(sums, frames);
  found.coder = coded.coder.name;
  found.settings = coded.coder.settings;
  found.known = coded.coder.known;
  found.passes_differ = coded.passes_differ;
  // Of a coder that tells nothing all errors may be its play, also those that the audit has counted.
  if (!(found.step > 0) && !coded.coder.all_intra)
    found.part_play = found.mark_play = std::numbers::sqrt2 * sd_of(track);
  if (summary.ground_steps) leave_out_unseen_ground(coded.frames, track, summary);
  found.slow_time = found.added_sd > 0 ? direction_time(track, found.unnoticed) : 0;
  if (found.added_sd > 0 && found.slow_time > 0)
    summary.slow.push_back({"coder", found.added_sd, found.slow_time});
  if (std::string warning = coding_warning(found); !warning.empty())
    summary.warnings.push_back(std::move(warning));
  summary.coded = std::move(found);
}

namespace {

constexpr double kPredicted = 0.3,
                 kByItself = 0.08;  ///< errors in steps over the contrast, see CodingForecast

std::string advice_for(const Coder& coder) {
  if (coder.all_intra) return "every frame is coded by itself, which is the best a lossy coding can do";
  return "film uncompressed or as FFV1; else MJPEG of high quality, or H.264 with every frame coded by "
         "itself "
         "(-g 1, crf 18 or less)";
}

}  // namespace

std::optional<CodingForecast> forecast(const Coder& coder, double contrast) {
  if (!(coder.step > 0) || !(contrast > 0)) return std::nullopt;
  const double step = coder.step / contrast;
  return CodingForecast{(coder.all_intra ? kByItself : kPredicted) * step,
                        coder.all_intra ? 0 : coder.dead_zone * step / std::numbers::sqrt2,
                        advice_for(coder)};
}

}  // namespace tribotrack::vision
