#include "vision/formats/libav/pixels.h"

#include <stdexcept>

#include "vision/formats/libav/library.h"
#include "vision/io/level_conversion.h"

namespace tribotrack::vision {
namespace {

/// One component of a pixel in a row, whatever its depth and byte order.
class Component {
 public:
  Component(const AVFrame& frame, const AVPixFmtDescriptor& form, int index, int y)
      : comp_(form.comp[index]),
        row_(frame.data[comp_.plane] + static_cast<std::ptrdiff_t>(y) * frame.linesize[comp_.plane] +
             comp_.offset),
        wide_(comp_.depth + comp_.shift > 8),
        big_endian_((form.flags & AV_PIX_FMT_FLAG_BE) != 0),
        mask_((1U << comp_.depth) - 1U) {}
  std::uint32_t at(int x) const {
    const std::uint8_t* stored = row_ + static_cast<std::ptrdiff_t>(x) * comp_.step;
    std::uint32_t word = stored[0];
    if (wide_) word = big_endian_ ? word << 8 | stored[1] : word | static_cast<std::uint32_t>(stored[1]) << 8;
    return word >> comp_.shift & mask_;
  }
  /// Eight bits, or a whole 16-bit word, side by side: the row can be copied straight.
  bool plain_8() const { return !wide_ && comp_.step == 1 && comp_.shift == 0 && comp_.depth == 8; }
  bool plain_16() const { return wide_ && !big_endian_ && comp_.step == 2 && comp_.shift == 0; }
  const std::uint8_t* row() const { return row_; }

 private:
  AVComponentDescriptor comp_;
  const std::uint8_t* row_;
  bool wide_, big_endian_;
  std::uint32_t mask_;
};

void copy_luma_row(const Component& grey, int x, std::span<float> levels) {
  if (grey.plain_8()) return copy_levels(grey.row() + x, levels);
  if (grey.plain_16()) return copy_levels_16(grey.row() + 2 * static_cast<std::ptrdiff_t>(x), levels);
  for (std::size_t i = 0; i < levels.size(); ++i)
    levels[i] = static_cast<float>(grey.at(x + static_cast<int>(i)));
}

void palette_row(const AVFrame& frame, int x, int y, std::span<float> levels) {
  const std::uint8_t* codes = frame.data[0] + static_cast<std::ptrdiff_t>(y) * frame.linesize[0] + x;
  for (std::size_t i = 0; i < levels.size(); ++i) {
    const std::uint8_t* argb = frame.data[1] + 4 * static_cast<std::size_t>(codes[i]);  // B G R A in memory
    levels[i] = luma(argb[2], argb[1], argb[0]);
  }
}

}  // namespace

LibavPixelForm libav_pixel_form(int format) {
  const AVPixFmtDescriptor* form = libav().av_pix_fmt_desc_get(static_cast<AVPixelFormat>(format));
  if (!form) throw std::invalid_argument("its pixels are of no known kind");
  const std::string name = form->name;
  if (form->flags & AV_PIX_FMT_FLAG_BAYER)
    throw std::invalid_argument("its pixels are a colour filter mosaic (" + name +
                                "), which is no grey picture; export it as grey");
  if (form->flags & (AV_PIX_FMT_FLAG_HWACCEL | AV_PIX_FMT_FLAG_FLOAT | AV_PIX_FMT_FLAG_BITSTREAM))
    throw std::invalid_argument("its pixels (" + name +
                                ") are of a kind that is not read; convert it to grey");
  LibavPixelForm known;
  known.name = name;
  known.rgb = (form->flags & (AV_PIX_FMT_FLAG_RGB | AV_PIX_FMT_FLAG_PAL)) != 0;
  known.colour = known.rgb || form->nb_components >= 3;
  known.bits = form->flags & AV_PIX_FMT_FLAG_PAL ? 8 : form->comp[0].depth;
  if (known.rgb && !(form->flags & AV_PIX_FMT_FLAG_PAL) &&
      (form->comp[1].depth != known.bits || form->comp[2].depth != known.bits))
    throw std::invalid_argument("its pixels (" + name +
                                ") have colours of different depth; convert it to grey");
  return known;
}

void copy_libav_window(const AVFrame& frame, const Rect& window, Picture& picture) {
  const AVPixFmtDescriptor& form = *libav().av_pix_fmt_desc_get(static_cast<AVPixelFormat>(frame.format));
  for (int y = 0; y < window.height; ++y) {
    const std::span<float> levels = picture.row(y);
    if (form.flags & AV_PIX_FMT_FLAG_PAL) {
      palette_row(frame, window.x, window.y + y, levels);
      continue;
    }
    const Component first(frame, form, 0, window.y + y);
    if (!(form.flags & AV_PIX_FMT_FLAG_RGB)) {
      copy_luma_row(first, window.x, levels);
      continue;
    }
    const Component green(frame, form, 1, window.y + y);
    const Component blue(frame, form, 2, window.y + y);
    for (int x = 0; x < window.width; ++x)
      levels[static_cast<std::size_t>(x)] =
          luma(first.at(window.x + x), green.at(window.x + x), blue.at(window.x + x));
  }
}

}  // namespace tribotrack::vision
