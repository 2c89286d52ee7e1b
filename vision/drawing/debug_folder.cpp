#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "vision/io/levels.h"
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
constexpr int kFooter = kLine + 12;
const cv::Scalar kPaper(40, 40, 40);  // BGR
const cv::Scalar kInk(235, 235, 235);
const cv::Scalar kFaint(120, 120, 120);
constexpr const char* kIndexHeader = "file\tshows\tframe\tlow\thigh\tunit\tpx_per_pixel\n";

void text(cv::Mat& image, const std::string& words, int x, int y, const cv::Scalar& colour = kInk) {
  cv::putText(image, words, {x, y}, cv::FONT_HERSHEY_SIMPLEX, 0.45, colour, 1, cv::LINE_AA);
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
  Range range{level_of_share(levels, 0.005), level_of_share(levels, 0.995)};
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
  text(image,
       fmt::format("{} {:.4g}, {} {:.4g} {}{}", picture.zero_centred ? "blue" : "black", range.low,
                   picture.zero_centred ? "red" : "white", range.high, picture.unit,
                   unknown ? "; chequered: not known" : ""),
       kMargin, image.rows - 10);
  return image;
}

void write_file(const std::filesystem::path& path, const auto& bytes) {
  TemporaryFile file(path);
  file.write(bytes);
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
  write_file(folder_ / "index.txt", std::string_view(index_));
}

void DebugFolder::show(const StagePicture& picture) {
  const Picture& levels = picture.levels;
  if (levels.empty()) return;
  const int enlargement =
      std::clamp(kPictureSide / std::max(levels.width(), levels.height()), 1, kMostEnlargement);
  const Range range = range_of(picture);
  const std::string name =
      picture.frame ? fmt::format("frame{:06d}_{}.png", *picture.frame, picture.name) : picture.name + ".png";
  write_file(folder_ / name, png_of(drawn(picture, range, enlargement)));
  // It grows with the pictures: it lists what is there even if the tracking fails later.
  index_ += fmt::format("{}\t{}\t{}\t{:.6g}\t{:.6g}\t{}\t{}\n", name, picture.title,
                        picture.frame ? fmt::format("{} ({})", *picture.frame, picture.why_frame) : "",
                        range.low, range.high, picture.unit, enlargement);
  write_file(folder_ / "index.txt", std::string_view(index_));
}

}  // namespace tribotrack::vision
