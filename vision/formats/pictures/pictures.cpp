#include "vision/formats/pictures/pictures.h"

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "vision/formats/contained/contained.h"
#include "vision/formats/photron/photron.h"
#include "vision/io/files.h"
#include "vision/io/levels.h"
#include "vision/io/picture_files.h"
#include "vision/kernels/plane.h"
#include "vision/temporary_file.h"
#include "vision/timing/clock.h"

namespace tribotrack::vision {
namespace {

namespace fs = std::filesystem;

void require_supported(const cv::Mat& image, const std::string& name) {
  if (image.empty())
    throw InputError(
        "'" + name +
        "' cannot be decoded as a picture: it is damaged, cut short, of another kind or larger than " +
        std::to_string(kMostPixels) + " pixels; copy or export it again, or crop it");
  require_sensible_size(name, image.cols, image.rows);
  if (image.depth() != CV_8U && image.depth() != CV_16U)
    refuse(name, "holds floating-point or signed levels; convert it to 8 or 16 bits");
  if (image.channels() != 1 && image.channels() != 3 && image.channels() != 4)
    refuse(name, "has {} channels; convert it to grey or RGB", image.channels());
}

/// The pictures of a folder or a pattern, or the pages of one file; a frame is kept decoded.
class DecodedPictures : public DecodedSource {
 public:
  DecodedPictures(const fs::path& path, PictureList pictures, const SourceOptions& options)
      : files_(std::move(pictures.files)) {
    info_.path = path;
    info_.format = "image sequence";
    info_.frame_count = std::ssize(files_);
    info_.first_number = pictures.first_number;
    info_.notes = std::move(pictures.notes);
    describe(photron_sidecar_of_pictures(files_.front()), options);
  }
  DecodedPictures(const fs::path& file, const SourceOptions& options) : files_{file} {
    const bool tiff = has_tiff_extension(file);
    info_.path = file;
    info_.format = tiff ? "tiff stack" : "picture";
    info_.frame_count = tiff ? count_tiff_pages(file) : 1;
    if (info_.frame_count == 0) refuse(file, "holds no page; export it again");
    require_decodable_picture(file);
    describe(photron_sidecar(file), options);
  }

  StoredFrame decode(std::int64_t index) override {
    const cv::Mat& image = decoded(index);
    const auto pixel = static_cast<std::ptrdiff_t>(image.elemSize());
    const int level_bytes = static_cast<int>(image.elemSize1());
    const StoredFrame frame{image.ptr(), static_cast<std::ptrdiff_t>(image.step), pixel, level_bytes,
                            image.channels() > 1};
    if (!frame.bgr) return frame;
    luma_ = Picture(info_.width, info_.height);
    copy_stored(frame, bounds_of(luma_), luma_);
    return stored_in(luma_);
  }

 private:
  void describe(const std::optional<fs::path>& sidecar, const SourceOptions& options) {
    const cv::Mat& first = decoded(0);
    info_.decoded = true;
    info_.width = first.cols;
    info_.height = first.rows;
    info_.bits = first.depth() == CV_8U ? 8 : 16;
    info_.colour = first.channels() > 1;
    info_.codec = std::to_string(info_.bits) + " bit " + (info_.colour ? "colour" : "grey");
    if (info_.colour) info_.notes.push_back("colour turned to luma (0.299 R + 0.587 G + 0.114 B)");
    ClockEvidence evidence;
    if (sidecar) read_photron_sidecar(*sidecar).describe(info_, evidence.camera);
    info_.time_base = judge_time(evidence, options, info_.first_number, info_.notes);
  }

  const cv::Mat& decoded(std::int64_t index) {
    if (index == kept_index_) return kept_;
    kept_index_ = -1;
    try {
      kept_ = picture(index);
    } catch (const cv::Exception&) {
      kept_ = cv::Mat();
    }
    require_supported(kept_, frame_name(index));
    if (kept_.channels() == 4) cv::cvtColor(kept_, kept_, cv::COLOR_BGRA2BGR);
    const int bits = kept_.depth() == CV_8U ? 8 : 16;
    if (info_.width != 0 && (kept_.cols != info_.width || kept_.rows != info_.height || bits != info_.bits))
      refuse(frame_name(index),
             "has {} x {} pixels of {} bits, but the first frame has {} x {} of {}; all frames of a "
             "recording must be alike",
             kept_.cols, kept_.rows, bits, info_.width, info_.height, info_.bits);
    kept_index_ = index;
    return kept_;
  }

  bool has_pages() const { return std::ssize(files_) < info_.frame_count; }
  const fs::path& file(std::int64_t index) const {
    return files_[has_pages() ? 0 : static_cast<std::size_t>(index)];
  }
  std::string frame_name(std::int64_t index) const {
    return file(index).string() + (has_pages() ? "', page '" + std::to_string(index) : "");
  }
  /// Without checks of what it shows.
  cv::Mat picture(std::int64_t index) {
    if (has_pages()) return page(index);
    require_readable_file(file(index));
    require_decodable_picture(file(index));
    return read_picture(file(index).string());
  }
  /// Some at a time: finding page n walks past all before it.
  cv::Mat page(std::int64_t index) {
    constexpr std::int64_t kAtATime = 16;
    if (index < first_page_ || index >= first_page_ + std::ssize(pages_)) {
      pages_.clear();
      first_page_ = index;
      const auto count = std::min(kAtATime, info_.frame_count - index);
      pages_ = read_pages(file(index).string(), static_cast<int>(index), static_cast<int>(count));
    }
    const auto slot = static_cast<std::size_t>(index - first_page_);
    return slot < pages_.size() ? pages_[slot] : cv::Mat();
  }

  std::vector<fs::path> files_;
  std::vector<cv::Mat> pages_;
  std::int64_t first_page_ = 0;
  cv::Mat kept_;
  Picture luma_;  ///< of it, where it has colour
  std::int64_t kept_index_ = -1;
};

}  // namespace

std::unique_ptr<FrameSource> open_picture_sequence(const fs::path& path, PictureList pictures,
                                                   const SourceOptions& options) {
  load_picture_library();
  return open_contained(
      path, [&] { return std::make_unique<DecodedPictures>(path, std::move(pictures), options); });
}

std::unique_ptr<FrameSource> open_picture_stack(const fs::path& path, const SourceOptions& options) {
  require_readable_file(path);
  load_picture_library();
  return open_contained(path, [&] { return std::make_unique<DecodedPictures>(path, options); });
}

namespace {

class PictureSink : public FrameSink {
 public:
  PictureSink(const fs::path& path, const SinkOptions& options)
      : path_(path), options_(options), pattern_(NumberPattern::parse(path)) {
    if (options.bits < 8 || options.bits > 16)
      refuse(path, "cannot hold {} bits: 8 to 16 can be written", options.bits);
    files_.emplace_back(name_of(0));  // an unwritable folder shows at once
  }

  void write(const Picture& picture) override {
    require_size(options_, picture.width(), picture.height());
    if (count_ > 0 && !pattern_)
      refuse(path_, "holds one picture only; for a sequence give a pattern such as 'frame%05d{}'",
             path_.extension().string());
    cv::Mat image(picture.height(), picture.width(), options_.bits == 8 ? CV_8UC1 : CV_16UC1);
    for (int y = 0; y < picture.height(); ++y) store_levels(picture.row(y), options_.bits, image.ptr(y));
    if (count_ > 0) files_.emplace_back(name_of(count_));
    files_.back().write(options_.codec == Codec::tiff ? tiff_of(image) : png_of(image));
    ++count_;
  }

  void close() override {
    if (count_ == 0) refuse(path_, "would hold no frames; nothing was written");
    for (TemporaryFile& file : files_) file.commit();
    if (pattern_) remove_leftovers();
  }

 private:
  fs::path name_of(std::int64_t number) const { return pattern_ ? pattern_->file(number) : path_; }

  void remove_leftovers() const {
    std::error_code ignored;
    for (const fs::path& file : entries(pattern_->folder()))
      if (const auto number = pattern_->number_of(file.filename().string()); number && *number >= count_)
        fs::remove(file, ignored);
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
