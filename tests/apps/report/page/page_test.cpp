#include "apps/report/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <optional>
#include <set>
#include <string>

#include "apps/chromium.h"
#include "apps/report_sample.h"

namespace tribotrack::apps {
namespace {

using test::Browsed;
using test::occurrences;
using test::root_data;
using testing::HasSubstr;
using testing::IsEmpty;

/// Not a matcher: those print the whole page, megabytes of it, when they fail.
bool holds(const std::string& page, const std::string& text) {
  return page.find(text) != std::string::npos;
}

constexpr int figures_of_the_sample = 7;  // 4 dependences, trajectories, residuals, one slide

TEST(ReportPage, TheSameDataGiveTheSameBytes) {
  EXPECT_TRUE(page_of(sample::campaign(3)) == page_of(sample::campaign(3)));
  EXPECT_FALSE(page_of(sample::campaign(3)) == page_of(sample::campaign(4)));
}

TEST(ReportPage, NothingItIsGivenBecomesMarkup) {
  const std::string hostile = "<script>boom()</script>{{plotly}}\"'&";
  ReportData data = sample::campaign();
  data.title = data.next_experiment = data.configuration = data.covariance_meaning = hostile;
  data.shared_scale = hostile;
  data.warnings = data.weak_directions = data.other_minima = data.left_out = data.systematics = {hostile};
  data.outliers = {{hostile, 5, 0.001, 1}};
  data.models = {{hostile, 3, 1, 1, 1, hostile}};
  data.next_runs = {{0, 1, 0.28, 62.8, hostile, {}, hostile}};
  data.parameters[0].name = data.given[0].name = data.given[0].source = hostile;
  data.inputs = {{hostile, hostile}};
  for (ReportRun& run : data.runs) {
    run.name = run.video = run.time_base = hostile;
    run.notes = {hostile};
    run.plan = {{hostile, false, hostile, 0.1}};
    if (!run.failure.empty()) run.failure = hostile;
    for (ReportResidual& residual : run.residuals) residual.observable = hostile;
  }
  data.slides[0].name = data.slides[0].sentence = hostile;
  const std::string page = page_of(data);
  EXPECT_EQ(occurrences(page, "<script>boom"), 0u);
  EXPECT_EQ(occurrences(page, "Copyright 2012"), 1u) << "the template was filled in twice";
}

TEST(ReportPage, HoldsEverySectionOfTheSample) {
  const std::string page = page_of(sample::campaign());
  for (const char* id : {"verdict", "warnings", "parameters", "check", "next", "dependences", "trajectories",
                         "residuals", "slides", "runs", "plan", "provenance"})
    EXPECT_EQ(occurrences(page, std::string("<section id=\"") + id + "\""), 1u) << id;
  EXPECT_EQ(occurrences(page, "data:image/png;base64,"), 13u);
  EXPECT_TRUE(holds(page, "phi90_dtau90.cine ends after 212 of 500 images"));
  EXPECT_TRUE(holds(page, "<td class=\"n\">500 / 3 / 0</td>"));
  EXPECT_TRUE(holds(page, "xxh3-128:0123456789abcdef0123456789abcdef"));
}

TEST(ReportPage, ForbidsTheBrowserToFetch) {
  const std::string page = page_of(sample::campaign());
  EXPECT_TRUE(holds(page,
                    "Content-Security-Policy\" content=\"default-src 'none'; img-src data: blob:; "
                    "style-src 'unsafe-inline'; script-src 'unsafe-inline'; base-uri 'none'; "
                    "form-action 'none'\""));
}

/// The page as headless Chromium sees it.
class ReportInChromium : public testing::Test {
 protected:
  void SetUp() override {
    program_ = test::chromium();
    if (!program_) GTEST_SKIP() << "chromium is not installed: the page was not looked at";
  }

  Browsed look_at(const std::string& page) {
    const Browsed browsed = test::browse(*program_, page);
    EXPECT_TRUE(holds(browsed.dom, "</html>")) << "the browser gave no page";
    return browsed;
  }

  /// Hosts the page (not the browser for itself) asked for.
  static std::set<std::string> hosts(const std::string& net_log) {
    const std::string key = "\"url\":\"";
    std::set<std::string> found;
    for (std::size_t at = net_log.find(key); at != std::string::npos; at = net_log.find(key, at + 1)) {
      const std::size_t start = at + key.size();
      const std::string url = net_log.substr(start, net_log.find('"', start) - start);
      const std::size_t host_at = url.find("://");
      if (host_at == std::string::npos || (!url.starts_with("http") && !url.starts_with("ws"))) continue;
      const std::string host = url.substr(host_at + 3, url.find('/', host_at + 3) - host_at - 3);
      if (!host.ends_with(".google.com") && !host.ends_with(".googleapis.com")) found.insert(host);
    }
    return found;
  }

  std::optional<std::string> program_;
};

TEST_F(ReportInChromium, EveryFigureIsDrawnWithoutErrorOrRequest) {
  const Browsed browsed = look_at(page_of(sample::campaign()));
  EXPECT_EQ(root_data(browsed.dom, "errors"), "0") << root_data(browsed.dom, "errors-text");
  EXPECT_EQ(root_data(browsed.dom, "violations"), "0") << root_data(browsed.dom, "violations-text");
  EXPECT_EQ(root_data(browsed.dom, "figures"), std::to_string(figures_of_the_sample));
  EXPECT_EQ(root_data(browsed.dom, "drawn"), std::to_string(figures_of_the_sample));
  EXPECT_EQ(occurrences(browsed.dom, "js-plotly-plot\""), static_cast<std::size_t>(figures_of_the_sample));
  // Lines and points of the four dependences, 13 paths, two observables, three traces of the slide.
  EXPECT_EQ(occurrences(browsed.dom, "class=\"trace scatter"), 4u * 2 + 13 + 2 + 3);
  EXPECT_FALSE(browsed.net_log.empty());
  EXPECT_THAT(hosts(browsed.net_log), IsEmpty());

  // Ticks of angles are fractions of pi.
  for (const char* label : {">3π/4<", ">7π/4<", ">2π<", ">π/6<", ">7π/6<"})
    EXPECT_TRUE(holds(browsed.dom, label)) << label;

  // The library's own choice of buttons includes one that sends the chart to its maker.
  EXPECT_EQ(occurrences(browsed.dom, "data-title=\"Download plot\""),
            static_cast<std::size_t>(figures_of_the_sample));
  EXPECT_FALSE(holds(browsed.dom, "Share chart"));
}

/// Every table, as wide as it gets.
ReportData with_every_table() {
  ReportData data = sample::campaign();
  for (ReportParameter& p : data.parameters) {
    p.sd = 1e-6;  // many digits
    p.bootstrap_ci95 = p.ci95;
  }
  data.outliers = {{"a run with quite a long name of its own", 12.3, 3e-8, 1.234}};
  data.models = {{"Coulomb friction", 3, 531936124.9, 493.0, 498.5, ""},
                 {"Stribeck", 4, 531936124.8, 494.0, 499.5, "friction at rest higher by 0.0157 +- 0.011 %"}};
  data.next_runs = {{0.123456, 1, 0.28, 62.8, "", {{0.0999, 0.1001}, {0.0125, 0.0126}, {0.29, 0.31}}, ""}};
  return data;
}

TEST_F(ReportInChromium, TablesKeepWithinANarrowPage) {
  std::string page = page_of(with_every_table());
  page.insert(page.rfind("</body>"),
              "<script>(function (d) { d.dataset.over = String(d.scrollWidth - d.clientWidth); "
              "d.dataset.width = String(d.clientWidth); })(document.documentElement)</script>");
  for (const int width : {1200, 1000, 700}) {
    const Browsed browsed = test::browse(*program_, page, "--hide-scrollbars --dump-dom", width);
    EXPECT_EQ(root_data(browsed.dom, "width"), std::to_string(width));
    EXPECT_EQ(root_data(browsed.dom, "over"), "0") << "at " << width;
  }
}

TEST_F(ReportInChromium, AReportWithoutAnyDataIsAPageToo) {
  const Browsed browsed = look_at(page_of(ReportData{}));
  EXPECT_EQ(root_data(browsed.dom, "errors"), "0") << root_data(browsed.dom, "errors-text");
  EXPECT_EQ(root_data(browsed.dom, "figures"), "0");
  EXPECT_TRUE(holds(browsed.dom, "left out"));
}

TEST_F(ReportInChromium, OddDataDrawWithoutError) {
  ReportData data = sample::campaign();
  for (ReportRun& run : data.runs) {
    run.alpha_rad = run.alpha_sd_rad = no_value;  // nothing moved more than its noise
    run.v_mm_s = 0;
    run.name = "same name";
    for (ReportResidual& residual : run.residuals) residual.standardised = no_value;
  }
  for (ReportGroup& group : data.over_phi)
    group.curve_x_rad = group.curve_alpha_rad = group.curve_v_mm_s = {};
  data.slides[0].sigma_mm.clear();
  data.slides[0].fitted_mm.clear();
  const Browsed browsed = look_at(page_of(data));
  EXPECT_EQ(root_data(browsed.dom, "errors"), "0") << root_data(browsed.dom, "errors-text");
  EXPECT_EQ(root_data(browsed.dom, "drawn"), root_data(browsed.dom, "figures"));
}

// What the tests above rest on: an error, a blocked request and an unblocked one would each be seen.
TEST_F(ReportInChromium, ErrorsAndRequestsWouldBeSeen) {
  std::string page = page_of(ReportData{});
  const std::string fetch =
      "<img src=\"http://tribotrack-control.invalid/x.png\"><script>throw new Error('control')</script>";
  page.insert(page.rfind("</body>"), fetch);
  const Browsed blocked = look_at(page);
  EXPECT_EQ(root_data(blocked.dom, "errors"), "1");
  EXPECT_THAT(root_data(blocked.dom, "errors-text"), HasSubstr("control"));
  EXPECT_EQ(root_data(blocked.dom, "violations"), "1");
  EXPECT_THAT(hosts(blocked.net_log), IsEmpty());

  const std::size_t policy = page.find("<meta http-equiv=\"Content-Security-Policy\"");
  page.erase(policy, page.find('>', policy) + 1 - policy);
  EXPECT_THAT(hosts(look_at(page).net_log), testing::ElementsAre("tribotrack-control.invalid"));
}

}  // namespace
}  // namespace tribotrack::apps
