#include "fit/slides/between_slides.h"

#include <cmath>

#include "fit/tools/statistics.h"

namespace tribotrack::fit::internal {
namespace {

struct WeightedMean {
  double mean = 0, information = 0, chi2 = 0;
};

WeightedMean weighted_mean(const std::vector<Estimate>& slides, double variance_between) {
  WeightedMean result;
  for (const Estimate& slide : slides) {
    const double weight = 1 / (slide.sd * slide.sd + variance_between);
    result.information += weight;
    result.mean += weight * slide.value;
  }
  result.mean /= result.information;
  for (const Estimate& slide : slides)
    result.chi2 += std::pow(slide.value - result.mean, 2) / (slide.sd * slide.sd + variance_between);
  return result;
}

}  // namespace

BetweenSlides between_slides(const std::vector<Estimate>& slides) {
  BetweenSlides result;
  result.dof = static_cast<int>(slides.size()) - 1;
  const WeightedMean alike = weighted_mean(slides, 0);
  result.chi2 = alike.chi2;
  result.p_value = chi2_survival(alike.chi2, result.dof);
  double variance = 0;
  if (alike.chi2 > result.dof && result.dof > 0) {
    // chi^2 falls as the variance grows: bisection, from above the square of the largest deviation.
    double low = 0, high = 0;
    for (const Estimate& slide : slides) high += std::pow(slide.value - alike.mean, 2);
    while (weighted_mean(slides, high).chi2 > result.dof) high *= 2;
    for (int round = 0; round < 200 && high - low > 1e-12 * high; ++round) {
      variance = 0.5 * (low + high);
      (weighted_mean(slides, variance).chi2 > result.dof ? low : high) = variance;
    }
  }
  const WeightedMean mean = weighted_mean(slides, variance);
  result.sd = std::sqrt(variance);
  result.mean = mean.mean;
  result.information = mean.information;
  result.sd_of_mean = 1 / std::sqrt(mean.information);
  return result;
}

}  // namespace tribotrack::fit::internal
