#include <numbers>

#include "vision/rehearsal.h"

namespace tribotrack::vision {
namespace {

constexpr double kPredicted = 0.3, kByItself = 0.08;  ///< errors in steps over the contrast, see rehearsal.h

std::string advice_for(const Coder& coder) {
  if (coder.all_intra) return "every frame is coded by itself, which is the best a lossy coding can do";
  return std::string(
             "film uncompressed or as FFV1; else MJPEG of high quality, or H.264 with every frame coded "
             "by itself (-g 1, crf 18 or less)") +
         (coder.known ? "; what is there: `track --rehearse`" : "");
}

}  // namespace

std::optional<CodingForecast> forecast(const Coder& coder, double contrast) {
  if (!(coder.step > 0) || !(contrast > 0)) return std::nullopt;
  const double step = coder.step / contrast;
  return CodingForecast{(coder.all_intra ? kByItself : kPredicted) * step,
                        coder.all_intra ? 0 : coder.dead_zone * step / std::numbers::sqrt2,
                        advice_for(coder)};
}

}  // namespace tribotrack::vision
