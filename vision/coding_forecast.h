// Expected errors of a recording with lossy compression, before anything is tracked.
//
//   if (const auto expected = forecast(*source->info().coder, 100)) std::cout << expected->advice << "\n";
#pragma once

#include <optional>
#include <string>

#include "vision/frame_source.h"

namespace tribotrack::vision {

/// For a disc of 30 px radius whose edge has this contrast, grey levels. In such recordings the errors of
/// motion faster than 0.2 px a frame were 0.3 steps over the contrast with prediction between frames (0.26
/// to 0.39; x264, mpeg4), 0.08 with every frame coded by itself (0.06 to 0.10); slow motion is delayed by
/// up to d0
/// = 0.71 dead_zone step / contrast (vision/coding/coded_errors.h).
struct CodingForecast {
  double error_px = 0;
  double late_px = 0;
  std::string advice;
};

/// Empty if the codec's quantiser steps are unknown.
std::optional<CodingForecast> forecast(const Coder& coder, double contrast);

}  // namespace tribotrack::vision
