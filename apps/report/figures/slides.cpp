#include "apps/report/figures/slides.h"

#include <fmt/format.h>

#include <algorithm>

#include "apps/figures/thinning.h"
#include "apps/page/text.h"

namespace tribotrack::apps {
namespace {

constexpr std::size_t kMostPoints = 600;

/// What the slide says by itself, its blows included.
std::string own_sentence(const ReportData& data, const std::string& name) {
  for (const ReportSlideResult& slide : data.slide_results)
    if (slide.name == name && !slide.sentence.empty()) return " By itself: " + slide.sentence;
  return "";
}

}  // namespace

std::vector<Figure> slide_figures(const ReportData& data) {
  std::vector<Figure> figures;
  for (std::size_t i = 0; i < data.slides.size(); ++i) {
    const ReportSlide& slide = data.slides[i];
    std::vector<double> left_um;
    for (std::size_t k = 0; k < std::min(slide.position_mm.size(), slide.fitted_mm.size()); ++k)
      left_um.push_back(1000 * (slide.position_mm[k] - slide.fitted_mm[k]));
    const std::vector<std::size_t> places = envelope(left_um, kMostPoints);
    const std::vector<double> time = picked(slide.time_s, places);
    FigurePanel main{
        .x = {.title = "time, s", .shown = false}, .y = {.title = "distance, mm"}, .height = 2.4};
    main.series = {{.mark = Mark::points,
                    .name = "measured",
                    .x = time,
                    .y = picked(slide.position_mm, places),
                    .in_legend = true,
                    .small = true},
                   {.mark = Mark::line,
                    .name = "law of friction",
                    .x = time,
                    .y = picked(slide.fitted_mm, places),
                    .colour = 1,
                    .in_legend = true}};
    FigurePanel below{.x = {.title = "time, s"}, .y = {.title = "residual, µm"}, .zero_line = true};
    Series left{.mark = Mark::points, .x = time, .y = picked(left_um, places), .small = true};
    if (!slide.sigma_mm.empty())
      for (const double sigma : picked(slide.sigma_mm, places)) left.sd.push_back(1000 * sigma);
    below.series = {left};
    Figure figure{.id = fmt::format("slide-{}", i + 1), .title = "Free slide " + slide.name, .caption = ""};
    figure.caption =
        "Distance along the slide against time, with the law of friction at its own μ<sub>1</sub> (without "
        "spin a "
        "parabola, deceleration μ<sub>1</sub> g); below, measured minus fitted. " +
        sentence_html(slide.sentence + own_sentence(data, slide.name));
    figure.alternative =
        fmt::format("Free slide {}: distance against time and the residual below.", slide.name);
    figure.panels = {main, below};
    figure.shared_x = true;
    figure.height = 0.5;
    figures.push_back(figure);
  }
  return figures;
}

}  // namespace tribotrack::apps
