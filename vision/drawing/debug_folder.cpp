#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <opencv2/imgproc.hpp>

#include "vision/io/picture_files.h"
#include "vision/overlay.h"
#include "vision/temporary_file.h"

namespace tribotrack::vision {
namespace {

constexpr int kWidth = 760;        ///< of the canvas, at least
constexpr int kPictureSide = 720;  ///< smaller pictures are enlarged by a whole factor up to about this
constexpr int kMostEnlargement = 16;
constexpr int kMargin = 16;
constexpr int kLine = 20;  ///< height of a line of text
constexpr int kHeader = 3 * kLine + 12;
constexpr int kFooter = 76;
const cv::Scalar kPaper(40, 40, 40);  // BGR
const cv::Scalar kInk(235, 235, 235);
const cv::Scalar kFaint(120, 120, 120);
constexpr const char* kIndexHeader = "file\tshows\tframe\tlow\thigh\tunit\tpx_per_pixel\n";

void text(cv::Mat& image, const std::string& words, int x, int y, const cv::Scalar& colour = kInk) {
  cv::putText(image, words, {x, y}, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv::LINE_AA);
}

int width_of(const std::string& words) {
  int base = 0;
  return cv::getTextSize(words, cv::FONT_HERSHEY_SIMPLEX, 0.45, 1, &base).width;
}

struct Range {
  double low = 0, high = 1;
};

/// All but the half per cent of the levels at either end, which clip; of differences at least one level.
Range range_of(const StagePicture& picture) {
  if (picture.low != picture.high) return {picture.low, picture.high};
  std::vector<float> levels;
  for (const float level : picture.levels.levels())
    if (std::isfinite(level)) levels.push_back(level);
  if (levels.empty()) return {};
  const auto at = [&](double share) {
    const auto rank = static_cast<std::ptrdiff_t>(share * static_cast<double>(levels.size() - 1));
    std::nth_element(levels.begin(), levels.begin() + rank, levels.end());
    return static_cast<double>(levels[static_cast<std::size_t>(rank)]);
  };
  Range range{at(0.005), at(0.995)};
  if (picture.zero_centred) {
    range.high = std::max({std::abs(range.low), std::abs(range.high), 1.0});
    range.low = -range.high;
  }
  if (!(range.high > range.low)) range = {range.low - 0.5, range.low + 0.5};
  return range;
}

/// Grey from low to high; of a difference blue, white and red; `where` neither is known a dark chequer.
cv::Vec3b colour_of(double level, const Range& range, bool zero_centred, int x, int y) {
  if (!std::isfinite(level)) return (x + y) % 2 == 0 ? cv::Vec3b(70, 40, 60) : cv::Vec3b(50, 30, 45);
  const double share = std::clamp((level - range.low) / (range.high - range.low), 0.0, 1.0);
  if (!zero_centred) {
    const auto grey = static_cast<unsigned char>(std::lround(255 * share));
    return {grey, grey, grey};
  }
  const auto faded = static_cast<unsigned char>(std::lround(255 * (1 - std::abs(2 * share - 1))));
  return share < 0.5 ? cv::Vec3b(255, faded, faded) : cv::Vec3b(faded, faded, 255);
}

/// The longest of 1, 2, 5, 10, ... px that is not longer than a quarter of the picture.
int ruler_px(int width) {
  int length = 1;
  for (int decade = 1; decade <= 10000; decade *= 10)
    for (const int step : {1, 2, 5})
      if (step * decade <= std::max(1, width / 4)) length = step * decade;
  return length;
}

void draw_footer(cv::Mat& image, const StagePicture& picture, const Range& range, int enlargement) {
  const int top = image.rows - kFooter + 12;
  constexpr int kBar = 300;
  for (int x = 0; x < kBar; ++x)
    for (int y = 0; y < 12; ++y)
      image.at<cv::Vec3b>(top + y, kMargin + x) =
          colour_of(range.low + (range.high - range.low) * x / (kBar - 1), range, picture.zero_centred, x, y);
  text(image, fmt::format("{:.4g}", range.low), kMargin, top + 30);
  const std::string high = fmt::format("{:.4g} {}", range.high, picture.unit);
  text(image, high, kMargin + kBar - width_of(fmt::format("{:.4g}", range.high)), top + 30);
  const int ruler = ruler_px(picture.levels.width());
  const int right = image.cols - kMargin, left = right - ruler * enlargement;
  cv::line(image, {left, top + 6}, {right, top + 6}, kInk, 2);
  cv::line(image, {left, top + 1}, {left, top + 11}, kInk, 1);
  cv::line(image, {right, top + 1}, {right, top + 11}, kInk, 1);
  const std::string length = fmt::format("{} px", ruler);
  text(image, length, right - width_of(length), top + 30);
}

std::string frame_text(const StagePicture& picture) {
  if (!picture.frame) return picture.why_frame.empty() ? "learnt from the recording" : picture.why_frame;
  return fmt::format("frame {} ({})", *picture.frame, picture.why_frame);
}

cv::Mat drawn(const StagePicture& picture, const Range& range, int enlargement) {
  const Picture& levels = picture.levels;
  const int width = levels.width() * enlargement, height = levels.height() * enlargement;
  cv::Mat image(kHeader + height + kFooter, std::max(kWidth, width + 2 * kMargin), CV_8UC3, kPaper);
  text(image, picture.title, kMargin, kLine);
  text(image, frame_text(picture), kMargin, 2 * kLine);
  text(image,
       fmt::format("{} x {} px, enlarged {} times; first pixel at ({:g}, {:g}) {}", levels.width(),
                   levels.height(), enlargement, picture.first.x, picture.first.y, picture.place),
       kMargin, 3 * kLine, kFaint);
  bool unknown = false;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const float level = levels.at(x / enlargement, y / enlargement);
      unknown |= !std::isfinite(level);
      image.at<cv::Vec3b>(kHeader + y, kMargin + x) =
          colour_of(level, range, picture.zero_centred, x / 4, y / 4);
    }
  draw_footer(image, picture, range, enlargement);
  if (unknown) text(image, "chequered: not known", kMargin, image.rows - 10, kFaint);
  return image;
}

void write_file(const std::filesystem::path& path, const char* bytes, std::size_t size) {
  TemporaryFile file(path);
  std::ofstream out(file.path(), std::ios::binary);
  out.write(bytes, static_cast<std::streamsize>(size));
  out.close();
  if (!out)
    throw InputError(path.string() +
                     " cannot be written; make room, or choose another folder for the debug "
                     "pictures");
  file.commit();
}

}  // namespace

DebugFolder::DebugFolder(std::filesystem::path folder) : folder_(std::move(folder)), index_(kIndexHeader) {
  std::error_code error;
  std::filesystem::create_directories(folder_, error);
  if (!std::filesystem::is_directory(folder_))
    throw InputError(
        fmt::format("{}: the folder for the debug pictures cannot be created ({}); choose another",
                    folder_.string(), error ? error.message() : "a file of that name exists"));
  write_file(folder_ / "index.txt", index_.data(), index_.size());
}

void DebugFolder::show(const StagePicture& picture) {
  const Picture& levels = picture.levels;
  if (levels.empty()) return;
  const int enlargement =
      std::clamp(kPictureSide / std::max(levels.width(), levels.height()), 1, kMostEnlargement);
  const Range range = range_of(picture);
  const std::string name =
      picture.frame ? fmt::format("frame{:06d}_{}.png", *picture.frame, picture.name) : picture.name + ".png";
  write(name, png_of(drawn(picture, range, enlargement)),
        fmt::format("{}\t{}\t{}\t{:.6g}\t{:.6g}\t{}\t{}\n", name, picture.title,
                    picture.frame ? fmt::format("{} ({})", *picture.frame, picture.why_frame) : "", range.low,
                    range.high, picture.unit, enlargement));
}

/// The index grows with the pictures: it lists what is there even if the tracking fails later.
void DebugFolder::write(const std::string& name, const std::vector<unsigned char>& png,
                        const std::string& index_line) {
  write_file(folder_ / name, reinterpret_cast<const char*>(png.data()), png.size());
  index_ += index_line;
  write_file(folder_ / "index.txt", index_.data(), index_.size());
}

}  // namespace tribotrack::vision
