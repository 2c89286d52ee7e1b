#include "vision/formats/cine/cine.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <fstream>
#include <vector>

#include "vision/formats/cine/layout.h"
#include "vision/io/files.h"
#include "vision/io/levels.h"
#include "vision/temporary_file.h"

namespace tribotrack::vision {
namespace {

namespace at = cine_layout;
using Buffer = std::vector<std::uint8_t>;

constexpr std::uint64_t recording_date = 1609459200;  // 2021-01-01T00:00:00Z
constexpr std::size_t annotation_bytes = 8;
constexpr std::size_t bytes_per_image_in_tables = 8 + 4 + 8;  // stamp, exposure, offset
constexpr std::size_t expected_images = 4096;

constexpr std::uint64_t tables_begin = at::file_header_bytes + at::bitmap_bytes + at::modern_setup_bytes;

/// The tables stand before the images, whose number is known only at the end.
constexpr std::uint64_t head_bytes(std::size_t images) {
  return tables_begin + 2 * at::block_head_bytes + images * bytes_per_image_in_tables;
}

class CineSink : public FrameSink {
 public:
  CineSink(const std::filesystem::path& path, const SinkOptions& options)
      : options_(options),
        temporary_(path),
        file_(temporary_.path(), std::ios::binary | std::ios::in | std::ios::out) {
    if (options.bits != 8 && options.bits != 12)
      refuse(path, "cannot hold {} bits: a .cine is written with 8 or 12; .mkv takes 10", options.bits);
    row_bytes_ = (static_cast<std::size_t>(options.width) * (options.bits == 8 ? 1 : 2) + 3) / 4 * 4;
    image_bytes_ = row_bytes_ * static_cast<std::size_t>(options.height);
    stored_.resize(annotation_bytes + image_bytes_);
    store<std::uint32_t>(stored_, 0, annotation_bytes);
    store(stored_, 4, static_cast<std::uint32_t>(image_bytes_));
    first_image_ = head_bytes(expected_images);
    file_.seekp(static_cast<std::streamoff>(first_image_));
  }

  void write(const Picture& picture) override {
    require_size(options_, picture.width(), picture.height());
    for (int y = 0; y < options_.height; ++y)
      store_levels(picture.row(options_.height - 1 - y), options_.bits,
                   stored_.data() + annotation_bytes + static_cast<std::size_t>(y) * row_bytes_);
    file_.write(reinterpret_cast<const char*>(stored_.data()), static_cast<std::streamsize>(stored_.size()));
    require_written();
    ++count_;
  }

  void close() override {
    if (count_ == 0) refuse(temporary_.target(), "would hold no frames; nothing was written");
    if (head_bytes(count_) > first_image_) move_images(head_bytes(count_));
    const Buffer head = make_head();
    file_.seekp(0);
    file_.write(reinterpret_cast<const char*>(head.data()), static_cast<std::streamsize>(head.size()));
    file_.close();
    require_written();
    temporary_.commit();
  }

 private:
  void require_written() const {
    if (!file_) temporary_.refuse(std::strerror(errno != 0 ? errno : ENOSPC));
  }

  /// Makes room for longer tables: images move towards the end, the last first.
  void move_images(std::uint64_t to) {
    Buffer image(annotation_bytes + image_bytes_);
    for (std::size_t i = count_; i-- > 0;) {
      file_.seekg(static_cast<std::streamoff>(first_image_ + i * image.size()));
      file_.read(reinterpret_cast<char*>(image.data()), static_cast<std::streamsize>(image.size()));
      file_.seekp(static_cast<std::streamoff>(to + i * image.size()));
      file_.write(reinterpret_cast<const char*>(image.data()), static_cast<std::streamsize>(image.size()));
      require_written();
    }
    first_image_ = to;
  }

  Buffer make_head() const {
    Buffer head(head_bytes(count_));
    const std::span<std::uint8_t> bytes(head);
    const std::uint64_t stamp_block = tables_begin;
    const std::uint64_t exposure_block = stamp_block + at::block_head_bytes + 8 * count_;
    const std::uint64_t table = exposure_block + at::block_head_bytes + 4 * count_;
    const auto images = static_cast<std::uint32_t>(count_);

    head[0] = 'C';
    head[1] = 'I';
    store<std::uint16_t>(bytes, at::header_size, at::file_header_bytes);
    store<std::uint16_t>(bytes, at::compression, at::grey_or_rgb);
    store<std::uint16_t>(bytes, at::version, 1);
    store<std::uint32_t>(bytes, at::total_image_count, images);
    store<std::uint32_t>(bytes, at::image_count, images);
    store<std::uint32_t>(bytes, at::bitmap_offset, at::file_header_bytes);
    store<std::uint32_t>(bytes, at::setup_offset, at::file_header_bytes + at::bitmap_bytes);
    store(bytes, at::image_table_offset, static_cast<std::uint32_t>(table));
    store<CineTime>(bytes, at::trigger_time, recording_date << 32);
    store_bitmap(bytes.subspan(at::file_header_bytes, at::bitmap_bytes));
    store_setup(bytes.subspan(at::file_header_bytes + at::bitmap_bytes, at::modern_setup_bytes));

    store_block_head(bytes, stamp_block, static_cast<std::uint32_t>(exposure_block - stamp_block),
                     at::time_block);
    store_block_head(bytes, exposure_block, static_cast<std::uint32_t>(table - exposure_block),
                     at::exposure_block);
    for (std::size_t k = 0; k < count_; ++k) {
      store(bytes, stamp_block + at::block_head_bytes + 8 * k, stamp(k));
      store(bytes, exposure_block + at::block_head_bytes + 4 * k, exposure_fraction());
      store<std::uint64_t>(bytes, table + 8 * k, first_image_ + k * (annotation_bytes + image_bytes_));
    }
    return head;
  }

  CineTime stamp(std::size_t k) const {
    const long double seconds = static_cast<long double>(k) / options_.frame_rate_hz;
    return ((recording_date << 32) + static_cast<CineTime>(std::llround(seconds * 0x1p30L)) * 4) &
           cine_time_mask;
  }
  std::uint32_t exposure_fraction() const {
    return static_cast<std::uint32_t>(std::clamp(options_.exposure_s * 0x1p32, 0.0, 0x1p32 - 1));
  }

  static void store_block_head(std::span<std::uint8_t> bytes, std::uint64_t offset, std::uint32_t size,
                               std::uint16_t type) {
    store(bytes, offset, size);
    store(bytes, offset + 4, type);
  }

  void store_bitmap(std::span<std::uint8_t> bitmap) const {
    constexpr std::int32_t pels_per_metre = 50000;  // 20 um pixels
    store<std::uint32_t>(bitmap, 0, at::bitmap_bytes);
    store<std::int32_t>(bitmap, at::bitmap_width, options_.width);
    store<std::int32_t>(bitmap, at::bitmap_height, options_.height);
    store<std::uint16_t>(bitmap, at::bitmap_planes, 1);
    store<std::uint16_t>(bitmap, at::bitmap_bits, options_.bits == 8 ? 8 : 16);
    store<std::uint32_t>(bitmap, at::bitmap_packing, at::unpacked);
    store(bitmap, at::bitmap_image_bytes, static_cast<std::uint32_t>(image_bytes_));
    store(bitmap, at::bitmap_pels_per_metre, pels_per_metre);
    store(bitmap, at::bitmap_pels_per_metre + 4, pels_per_metre);
    store<std::uint32_t>(bitmap, at::bitmap_levels, 1U << options_.bits);
  }

  void store_setup(std::span<std::uint8_t> setup) const {
    const auto rate =
        static_cast<std::uint32_t>(std::clamp(std::round(options_.frame_rate_hz), 1.0, 0x1p32 - 1));
    store(setup, at::short_rate, static_cast<std::uint16_t>(std::min<std::uint32_t>(rate, 0xFFFF)));
    store(setup, at::setup_mark, at::setup_mark_value);
    store<std::uint16_t>(setup, at::setup_length, at::modern_setup_bytes);
    store(setup, at::integer_rate, rate);
    store<std::uint32_t>(setup, at::real_bits, static_cast<std::uint32_t>(options_.bits));
    store(setup, at::exposure_ns,
          static_cast<std::uint32_t>(std::clamp(std::round(options_.exposure_s * 1e9), 0.0, 0x1p32 - 1)));
    store<std::uint32_t>(setup, at::black_level, 0);
    store<std::uint32_t>(setup, at::white_level, (1U << options_.bits) - 1);
    store(setup, at::playback_rate, 30.0F);
    store<std::uint32_t>(setup, at::recorded_bits, static_cast<std::uint32_t>(options_.bits));
  }

  SinkOptions options_;
  TemporaryFile temporary_;
  std::fstream file_;
  Buffer stored_;
  std::size_t row_bytes_ = 0, image_bytes_ = 0, count_ = 0;
  std::uint64_t first_image_ = 0;
};

}  // namespace

std::unique_ptr<FrameSink> create_cine_sink(const std::filesystem::path& path, const SinkOptions& options) {
  return std::make_unique<CineSink>(path, options);
}

}  // namespace tribotrack::vision
