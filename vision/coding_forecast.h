// What to expect of a lossy recording before anything is tracked.
//
//   if (const auto expected = forecast(*source->info().coder, 100)) std::cout << expected->advice << "\n";
#pragma once

#include <optional>
#include <string>

#include "vision/frame_source.h"

namespace tribotrack::vision {

/// Of a disc of 30 px radius with a rim of this contrast, grey levels: of such recordings errors of motion
/// faster than 0.2 px a frame were 0.3 steps over the contrast where other frames predict (0.26 to 0.39;
/// x264, mpeg4), 0.08 where every frame is coded by itself (0.06 to 0.10); slow motion comes late by up to d0
/// = 0.71 dead_zone step / contrast (vision/coding/rim_coding.h).
struct CodingForecast {
  double error_px = 0;
  double late_px = 0;
  std::string advice;
};

/// Nothing where the coder does not tell its steps.
std::optional<CodingForecast> forecast(const Coder& coder, double contrast);

}  // namespace tribotrack::vision
