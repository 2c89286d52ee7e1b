#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>
#include <span>

#include "vision/frame_sink.h"
#include "vision/io/levels.h"
#include "vision/io/picture_files.h"
#include "vision/kernels/plane.h"
#include "vision/overlay.h"
#include "vision/temporary_file.h"

namespace tribotrack::vision {
namespace {

// A frame as a colour picture to draw on.

// BGR
const cv::Scalar kPath(0, 160, 255);
const cv::Scalar kOutline(80, 255, 80);
const cv::Scalar kMarker(255, 200, 0);
const cv::Scalar kBad(60, 60, 255);
const cv::Scalar kText(255, 255, 255);

/// Grey levels to 8 bits so that the darkest and brightest half per cent of the first frame just clip.
struct Stretch {
  float low = 0, high = 255;
  explicit Stretch(const Picture& picture) {
    std::vector<float> levels(picture.levels().begin(), picture.levels().end());
    low = level_of_share(levels, 0.005);
    high = std::max(level_of_share(levels, 0.995), low + 1);
  }
  cv::Mat operator()(const Picture& picture) const {
    const double scale = 255.0 / (high - low);
    cv::Mat out;
    matrix_of(picture).convertTo(out, CV_8U, scale, -scale * low);
    return out;
  }
};

/// A colour canvas over a frame, enlarged, with drawing in the frame's pixel coordinates.
class Canvas {
 public:
  Canvas(const cv::Mat& grey, int enlargement) : scale_(enlargement) {
    cv::Mat large;
    cv::resize(grey, large, {}, scale_, scale_, scale_ > 1 ? cv::INTER_CUBIC : cv::INTER_NEAREST);
    cv::cvtColor(large, image_, cv::COLOR_GRAY2BGR);
    weight_ = std::max(1, image_.cols / 640);
  }
  cv::Mat& image() { return image_; }

  void line(const Point& a, const Point& b, const cv::Scalar& colour) {
    cv::line(image_, fixed(a), fixed(b), colour, weight_, cv::LINE_AA, kShift);
  }
  void circle(const Point& c, double radius, const cv::Scalar& colour) {
    const int r = static_cast<int>(std::lround(radius * scale_ * (1 << kShift)));
    cv::circle(image_, fixed(c), r, colour, weight_, cv::LINE_AA, kShift);
  }
  void dot(const Point& c, const cv::Scalar& colour) {
    const int r = static_cast<int>(std::lround(1.6 * weight_ * (1 << kShift)));
    cv::circle(image_, fixed(c), r, colour, cv::FILLED, cv::LINE_AA, kShift);
  }
  void cross(const Point& c, const cv::Scalar& colour) {
    const double arm = 5.0 * weight_ / scale_;
    line({c.x - arm, c.y}, {c.x + arm, c.y}, colour);
    line({c.x, c.y - arm}, {c.x, c.y + arm}, colour);
  }
  /// A name beside a circle, on the side where the picture has room.
  void label(const Circle& c, const std::string& words, const cv::Scalar& colour) {
    const double size = std::max(0.6, image_.cols / 1200.0);
    int base = 0;
    const cv::Size box = cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, size, 2, &base);
    const auto place = [&](double v) { return static_cast<int>((v + 0.5) * scale_); };
    int x = place(c.x + c.radius) + 3;
    if (x + box.width > image_.cols) x = place(c.x - c.radius) - 3 - box.width;
    const int y = std::clamp(place(c.y) + box.height / 2, box.height + 2, image_.rows - 3);
    cv::putText(image_, words, {x, y}, cv::FONT_HERSHEY_SIMPLEX, size, {0, 0, 0}, 5, cv::LINE_AA);
    cv::putText(image_, words, {x, y}, cv::FONT_HERSHEY_SIMPLEX, size, colour, 2, cv::LINE_AA);
  }
  /// Lines every so many pixels that divides the picture into five to twelve, with their coordinates at the
  /// edges.
  void grid(const cv::Scalar& colour) {
    const double size = std::max(0.4, image_.cols / 2400.0);
    const int width = image_.cols / scale_, height = image_.rows / scale_;
    int step = 10;
    for (const int next : {20, 50, 100, 200, 500, 1000, 2000})
      if (std::max(width, height) / step > 12) step = next;
    const cv::Mat plain = image_.clone();
    for (int x = step; x < width; x += step) line({double(x), -0.5}, {double(x), height - 0.5}, colour);
    for (int y = step; y < height; y += step) line({-0.5, double(y)}, {width - 0.5, double(y)}, colour);
    cv::addWeighted(image_, 0.35, plain, 0.65, 0, image_);
    const auto write = [&](const std::string& words, cv::Point at) {
      cv::putText(image_, words, at, cv::FONT_HERSHEY_SIMPLEX, size, {0, 0, 0}, 3, cv::LINE_AA);
      cv::putText(image_, words, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
    };
    for (int x = step; x < width; x += step) write(std::to_string(x), {x * scale_ + 3, image_.rows - 5});
    for (int y = step; y < height; y += step) write(std::to_string(y), {3, y * scale_ - 3});
  }
  /// One line of text in the top left corner, line 0, 1, ...; dark behind so that it reads on any ground.
  void text(int row, const std::string& words, const cv::Scalar& colour) {
    const double size = std::max(0.45, image_.cols / 1600.0);
    int base = 0;
    const cv::Size box = cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, size, 1, &base);
    const int step = box.height + base + 4;
    const cv::Point at(8, 8 + box.height + row * step);
    const cv::Rect back =
        cv::Rect(4, at.y - box.height - 3, box.width + 8, step) & cv::Rect(0, 0, image_.cols, image_.rows);
    image_(back) *= 0.4;
    cv::putText(image_, words, at, cv::FONT_HERSHEY_SIMPLEX, size, colour, 1, cv::LINE_AA);
  }

 private:
  static constexpr int kShift = 5;  ///< binary places of the sub-pixel drawing coordinates
  cv::Point fixed(const Point& p) const {
    // Pixel centres at integers before and after enlargement.
    const auto to = [&](double v) {
      return static_cast<int>(std::lround(((v + 0.5) * scale_ - 0.5) * (1 << kShift)));
    };
    return {to(p.x), to(p.y)};
  }
  cv::Mat image_;
  int scale_;
  int weight_ = 1;
};

/// The whole factor by which small pictures are enlarged, so that they are legible.
int enlargement_for(const SourceInfo& info) {
  constexpr int kLegibleWidth = 960, kMost = 4;
  return std::clamp(kLegibleWidth / std::max(1, info.width), 1, kMost);
}

constexpr std::size_t kTail = 2000;  ///< points of the path drawn in a video

void draw_path(Canvas& canvas, std::span<const TrackPoint> points) {
  for (std::size_t k = 1; k < points.size(); ++k) {
    const TrackPoint& a = points[k - 1];
    const TrackPoint& b = points[k];
    if (a.status == TrackStatus::ok && b.status == TrackStatus::ok)
      canvas.line({a.x, a.y}, {b.x, b.y}, kPath);
  }
  if (points.size() < 150)
    for (const TrackPoint& p : points)
      if (p.status == TrackStatus::ok) canvas.dot({p.x, p.y}, kPath);
}

double outline_radius(const TrackSummary& summary) {
  return summary.disc.radius > 0 ? summary.disc.radius : 6;  // a rectangle is shown by its centre
}

void write_png(FrameSource& source, const TrackResult& result, const std::filesystem::path& path) {
  const auto& points = result.track.points;
  const Picture first = source.read(result.track.first_seen() - source.info().first_number);
  Canvas canvas(Stretch(first)(first), enlargement_for(source.info()));
  draw_path(canvas, points);
  if (result.summary.marker.radius > 0)
    canvas.circle({result.summary.marker.x, result.summary.marker.y}, result.summary.marker.radius, kMarker);
  const TrackPoint* start = nullptr;
  const TrackPoint* end = nullptr;
  for (const TrackPoint& p : points) {
    if (p.status != TrackStatus::ok) continue;
    if (!start) start = &p;
    end = &p;
  }
  if (start) {
    canvas.circle({start->x, start->y}, outline_radius(result.summary), kOutline);
    canvas.cross({start->x, start->y}, kOutline);
    canvas.circle({end->x, end->y}, outline_radius(result.summary), kPath);
    canvas.text(0, "frames " + std::to_string(start->frame) + " (green) to " + std::to_string(end->frame),
                kText);
  }
  const TrackSummary& s = result.summary;
  canvas.text(
      1,
      std::to_string(s.ok) + " ok, " + std::to_string(s.lost) + " lost, " + std::to_string(s.edge) + " edge",
      kText);
  TemporaryFile file(path);
  file.write(png_of(canvas.image()));
  file.commit();
}

void write_video(FrameSource& source, const TrackResult& result, const std::filesystem::path& path) {
  const auto& points = result.track.points;
  const SourceInfo& info = source.info();
  const int enlargement = enlargement_for(info);
  // Even sizes: the colour of most codecs has half the resolution.
  const int width = (info.width * enlargement + 1) / 2 * 2;
  const int height = (info.height * enlargement + 1) / 2 * 2;
  SinkOptions options;
  options.width = width;
  options.height = height;
  options.frame_rate_hz = 30;  // for looking at, frame by frame
  if (path.extension() != ".mp4") options.codec = Codec::mjpeg;
  const auto sink = create_sink(path, options);
  std::optional<Stretch> stretch;
  Picture picture;
  cv::Mat rgb;
  for (std::size_t k = 0; k < points.size(); ++k) {
    const TrackPoint& p = points[k];
    source.read(p.frame - info.first_number, source.bounds(), picture);
    if (!stretch) stretch.emplace(picture);
    Canvas canvas((*stretch)(picture), enlargement);
    const std::size_t from = k > kTail ? k - kTail : 0;
    draw_path(canvas, std::span(points).subspan(from, k + 1 - from));
    if (p.marker && result.summary.marker.radius > 0)
      canvas.circle({p.marker->x, p.marker->y}, result.summary.marker.radius, kMarker);
    const bool ok = p.status == TrackStatus::ok;
    if (ok) {
      canvas.circle({p.x, p.y}, outline_radius(result.summary), kOutline);
      canvas.cross({p.x, p.y}, kOutline);
    }
    canvas.text(0, "frame " + std::to_string(p.frame) + "  " + to_string(p.status), ok ? kText : kBad);
    if (ok) canvas.text(1, fmt::format("x {:.2f}  y {:.2f} px  ncc {:.3f}", p.x, p.y, p.ncc), kText);
    cv::Mat even;
    cv::copyMakeBorder(canvas.image(), even, 0, height - canvas.image().rows, 0, width - canvas.image().cols,
                       cv::BORDER_REPLICATE);
    cv::cvtColor(even, rgb, cv::COLOR_BGR2RGB);
    sink->write_rgb(width, height, rgb.data);
  }
  sink->close();
}

}  // namespace

void require_overlay_name(const std::filesystem::path& path) {
  const std::string extension = path.extension().string();
  if (extension != ".png" && extension != ".mp4" && extension != ".avi" && extension != ".mkv")
    throw InputError(path.string() + ": an overlay is a .png picture or a .mp4, .avi or .mkv video, not " +
                     (extension.empty() ? "a name without ending" : extension));
}

void write_overlay(FrameSource& source, const TrackResult& result, const std::filesystem::path& path) {
  require_overlay_name(path);
  if (result.track.points.empty())
    throw InputError(path.string() + ": the track is empty, there is nothing to draw");
  if (path.extension() == ".png")
    write_png(source, result, path);
  else
    write_video(source, result, path);
}

std::vector<unsigned char> first_frame_jpeg(FrameSource& source, std::int64_t frame_number,
                                            int largest_side) {
  constexpr int kQuality = 70;  // of 100: the paths drawn over it matter
  const Picture first = source.read(frame_number - source.info().first_number);
  cv::Mat shown = Stretch(first)(first);
  if (const double factor = static_cast<double>(largest_side) / std::max(shown.cols, shown.rows); factor < 1)
    cv::resize(shown, shown, {}, factor, factor, cv::INTER_AREA);
  return jpeg_of(shown, kQuality);
}

namespace {

const cv::Scalar kGrid(255, 255, 160);
const cv::Scalar kLamp(80, 80, 255);
const cv::Scalar kOther(200, 200, 200);

const cv::Scalar& colour_of(DiscRole role) {
  if (role == DiscRole::part || role == DiscRole::like_part) return kOutline;
  return role == DiscRole::mark ? kMarker : kOther;
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
