#include "vision/formats/pictures/sink.h"

#include <opencv2/core.hpp>
#include <optional>

#include "vision/formats/pictures/imgcodecs.h"
#include "vision/formats/pictures/names.h"
#include "vision/io/in_quotes.h"
#include "vision/io/png.h"
#include "vision/io/sink_levels.h"
#include "vision/io/temporary_file.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

class PictureSink : public FrameSink {
 public:
  PictureSink(const fs::path& path, const SinkOptions& options)
      : path_(path), options_(options), pattern_(NumberPattern::parse(path)) {
    if (options.bits < 8 || options.bits > 16)
      throw InputError(in_quotes(path) + " cannot hold " + std::to_string(options.bits) +
                       " bits: 8 to 16 can be written");
    files_.emplace_back(name_of(0));  // an unwritable folder shows at once
  }

  void write(const Picture& picture) override {
    require_size(options_, picture.width(), picture.height());
    const float largest = largest_level(options_.bits);
    cv::Mat image(picture.height(), picture.width(), options_.bits == 8 ? CV_8UC1 : CV_16UC1);
    for (int y = 0; y < picture.height(); ++y) {
      const std::span<const float> row = picture.row(y);
      for (int x = 0; x < picture.width(); ++x) {
        const std::uint16_t level = whole_level(row[static_cast<std::size_t>(x)], largest);
        if (options_.bits == 8)
          image.at<std::uint8_t>(y, x) = static_cast<std::uint8_t>(level);
        else
          image.at<std::uint16_t>(y, x) = level;
      }
    }
    save(image);
  }

  void write_rgb(int width, int height, const unsigned char* rgb) override {
    require_size(options_, width, height);
    cv::Mat image(height, width, CV_8UC3);
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x, rgb += 3) image.at<cv::Vec3b>(y, x) = cv::Vec3b(rgb[2], rgb[1], rgb[0]);
    save(image);
  }

  void close() override {
    if (count_ == 0) throw InputError(in_quotes(path_) + " would hold no frames; nothing was written");
    for (TemporaryFile& file : files_) file.commit();
    if (pattern_) remove_leftovers();
  }

 private:
  fs::path name_of(std::int64_t number) const { return pattern_ ? pattern_->file(number) : path_; }

  void save(const cv::Mat& image) {
    if (count_ > 0 && !pattern_)
      throw InputError(in_quotes(path_) +
                       " holds one picture only; for a sequence give a pattern such as 'frame%05d" +
                       path_.extension().string() + "'");
    if (count_ > 0) files_.emplace_back(name_of(count_));
    files_.back().write(options_.codec == Codec::tiff ? tiff_of(image) : png_of(image));
    ++count_;
  }

  void remove_leftovers() const {
    const fs::path folder = pattern_->folder().empty() ? fs::path(".") : pattern_->folder();
    std::vector<fs::path> leftovers;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
      const auto number = pattern_->number_of(entry.path().filename().string());
      if (number && *number >= count_) leftovers.push_back(entry.path());
    }
    std::error_code ignored;
    for (const fs::path& file : leftovers) fs::remove(file, ignored);
  }

  fs::path path_;
  SinkOptions options_;
  std::optional<NumberPattern> pattern_;
  std::vector<TemporaryFile> files_;
  std::int64_t count_ = 0;
};

}  // namespace

std::unique_ptr<FrameSink> create_picture_sink(const fs::path& path, const SinkOptions& options) {
  return std::make_unique<PictureSink>(path, options);
}

}  // namespace tribotrack::vision
