// Grey levels out of libav's pictures.
#pragma once

#include <string>

#include "vision/picture.h"

struct AVFrame;

namespace tribotrack::vision {

struct LibavPixelForm {
  std::string name;
  int bits = 0;         ///< of the levels handed out
  bool colour = false;  ///< chroma or RGB stored
  bool rgb = false;     ///< luma computed here
};

/// What a libav pixel format (AVPixelFormat as int) holds. Throws std::invalid_argument with a clause for the
/// user where no grey level is defined (colour mosaic, hardware surfaces, floating point).
LibavPixelForm libav_pixel_form(int format);

/// The window of a decoded frame: the luma plane as stored, or luma computed from RGB.
void copy_libav_window(const AVFrame& frame, const Rect& window, Picture& picture);

}  // namespace tribotrack::vision
