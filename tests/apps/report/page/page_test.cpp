#include "apps/report/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <optional>
#include <set>
#include <string>

#include "apps/chromium.h"
#include "apps/figures/figure_csv.h"
#include "apps/report/figures/figures.h"
#include "apps/report/tables/tables.h"
#include "apps/report_sample.h"
#include "apps/text/number_text.h"

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

constexpr int figures_of_the_sample =
    10;  // 4 dependences, trajectories, residuals, corner, budget, influence, slide

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
  for (const char* id : {"dependences", "parameters", "check", "budget", "next", "slides", "runs", "citing",
                         "pictures", "details", "plan", "provenance"}) {
    EXPECT_EQ(occurrences(page, std::string("<section id=\"") + id + "\""), 1u) << id;
    EXPECT_EQ(occurrences(page, std::string("<a href=\"#") + id + "\""), 1u)
        << id << " in the list of contents";
  }
  for (const char* id : {"verdict", "warnings", "result"})
    EXPECT_EQ(occurrences(page, std::string("id=\"") + id + "\""), 1u) << id;
  EXPECT_TRUE(holds(page, "0.10012(31)"));
  EXPECT_EQ(occurrences(page, "data:image/png;base64,"), 14u) << "13 runs, and one on the first screen";
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

  const std::vector<Figure> figures_ = campaign_figures(sample::campaign());
  std::optional<std::string> program_;
};

/// What a reader who cannot see or use a mouse would stumble over (axe-core's rules of WCAG 2.1 A and AA),
/// into data-axe of the page's root; "clean" where nothing is more than minor.
std::string axe_script() {
  std::ifstream file(TRIBOTRACK_AXE_JS, std::ios::binary);
  const std::string axe{std::istreambuf_iterator<char>(file), {}};
  EXPECT_FALSE(axe.empty());
  return axe + R"js(;
setTimeout(() => axe.run(document, {resultTypes: ['violations']}).then(r => {
  document.documentElement.dataset.axe = r.violations.filter(v => v.impact !== 'minor').map(v => v.id + ' ' + v.impact +
    ': ' + v.nodes.map(n => n.html).slice(0, 3).join(' | ')).join('; ').replace(/"/g, "'") || 'clean'; }), 4000);
)js";
}

std::string with_script(std::string page, const std::string& script) {
  page.insert(page.rfind("</body>"), "<script>" + script + "</script>");
  return page;
}

// One start of the browser, which looks, reads, clicks and types.
TEST_F(ReportInChromium, EveryFigureIsDrawnAndThePageWorks) {
  const ReportData data = sample::campaign();
  const Browsed browsed = look_at(with_script(page_of(data), axe_script() + R"js(
const found = document.documentElement.dataset;
document.querySelectorAll('details').forEach(d => { d.open = true; });
found.estimates = Array.from(document.querySelectorAll('#parameter-table td[data-v]')).map(d => d.dataset.v).join(' ');
found.csv = TribotrackFigures.csv_of('v-phi').split('\n')[0];
found.csvLines = TribotrackFigures.csv_of('v-phi').trim().split('\n').length;
URL.createObjectURL = blob => { blob.text().then(text => { found.table = text.replace(/\n/g, ' | '); }); return '#'; };
document.querySelector('[aria-label="CSV of table run-table"]').click();
setTimeout(() => {
  const box = document.getElementById('plot-v-phi');
  const wide = () => box._fullLayout.xaxis.range[1] - box._fullLayout.xaxis.range[0];
  const before = wide();
  box.dispatchEvent(new KeyboardEvent('keydown', {key: '+'}));
  const entry = box.parentElement.querySelector('.legend button');
  entry.click();
  found.keyboard = (wide() / before).toFixed(2) + ' ' + entry.getAttribute('aria-pressed') + ' ' +
    box.data.filter(t => t.visible === false).length;
}, 3000);
setTimeout(() => {
  dispatchEvent(new Event('beforeprint'));
  found.paper = Array.from(document.querySelectorAll('.pair .box')).every(b => b._fullLayout.width === 338);
}, 8000);
)js"));
  const auto found = [&](const char* name) { return root_data(browsed.dom, name); };
  EXPECT_EQ(found("errors"), "0") << found("errors-text");
  EXPECT_EQ(found("violations"), "0") << found("violations-text");
  EXPECT_EQ(found("figures"), std::to_string(figures_of_the_sample));
  // Folded away until they are opened: 13 runs over time.
  EXPECT_EQ(found("drawn"), std::to_string(figures_of_the_sample + 13));
  EXPECT_FALSE(browsed.net_log.empty());
  EXPECT_THAT(hosts(browsed.net_log), IsEmpty());
  // Ticks of angles are fractions of pi.
  for (const char* label : {">3π/4<", ">7π/4<", ">2π<", ">π/6<", ">7π/6<"})
    EXPECT_TRUE(holds(browsed.dom, label)) << label;
  // No bar of buttons of the library, one of which would send the chart to its maker.
  EXPECT_FALSE(holds(browsed.dom, "modebar-btn"));
  EXPECT_FALSE(holds(browsed.dom, "Share chart"));
  EXPECT_EQ(found("axe"), "clean");
  EXPECT_EQ(found("keyboard"), "0.70 false 4") << "band, line, points and residuals of the group";
  EXPECT_EQ(found("paper"), "true") << "no controls, and every figure in its size";

  // The numbers on the page are those of the tables, and of the figures for print.
  const std::string table = parameters_csv(data);
  std::string estimates;
  for (const ReportParameter& parameter : data.parameters) {
    estimates += (estimates.empty() ? "" : " ") + exact(parameter.estimate);
    EXPECT_TRUE(holds(table, parameter.name + "," + exact(parameter.estimate) + ","));
  }
  EXPECT_TRUE(found("estimates").starts_with(estimates)) << found("estimates");
  EXPECT_EQ(found("csv"), "panel,series,mark,name,x,y,sd,y_high,note");
  EXPECT_EQ(found("csv-lines"),
            std::to_string(
                occurrences(csv_of(*std::ranges::find(figures_, std::string("v-phi"), &Figure::id)), "\n")));

  // A table's CSV has a heading for every cell, standard deviations too.
  const std::string csv = found("table");
  const std::size_t heading = csv.find(" | "), second = csv.find(" | ", heading + 3);
  ASSERT_NE(second, std::string::npos) << csv;
  EXPECT_THAT(csv, HasSubstr("α, rad, sd"));
  EXPECT_THAT(csv,
              HasSubstr("," + exact(data.runs[0].alpha_rad) + "," + exact(data.runs[0].alpha_sd_rad) + ","));
  // Commas in quotes stand in headings only: "α, rad", "v, mm/s", "σ, px" and the two sds.
  const auto commas = [&](std::size_t from, std::size_t to) {
    bool in_quotes = false;
    int count = 0;
    for (std::size_t i = from; i < to; ++i) {
      if (csv.compare(i, 6, "&quot;") == 0) in_quotes = !in_quotes;
      count += csv[i] == ',' && !in_quotes;
    }
    return count;
  };
  EXPECT_EQ(commas(0, heading), commas(heading, second)) << csv.substr(0, second);
}

using ReportInChromiumCampaign = ReportInChromium;

TEST_F(ReportInChromiumCampaign, DISABLED_AxeFindsNothingInTheDark) {
  std::string page = page_of(sample::campaign());
  const std::string query = "(prefers-color-scheme: dark)";
  for (std::size_t at = page.find(query); at != std::string::npos; at = page.find(query, at))
    page.replace(at, query.size(), "(min-width: 0px)");
  EXPECT_EQ(root_data(look_at(with_script(page, axe_script())).dom, "axe"), "clean");
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

TEST_F(ReportInChromiumCampaign, DISABLED_TablesKeepWithinANarrowPage) {
  const std::string page = with_script(page_of(with_every_table()), R"js(
const d = document.documentElement;
d.dataset.over = String(d.scrollWidth - d.clientWidth);
d.dataset.width = String(d.clientWidth);
)js");
  for (const int width : {1200, 1000, 700}) {
    const Browsed browsed = test::browse(*program_, page, "--hide-scrollbars --dump-dom", width);
    EXPECT_EQ(root_data(browsed.dom, "width"), std::to_string(width));
    EXPECT_EQ(root_data(browsed.dom, "over"), "0") << "at " << width;
  }
}

TEST_F(ReportInChromiumCampaign, DISABLED_AReportWithoutAnyDataIsAPageToo) {
  const Browsed browsed = look_at(page_of(ReportData{}));
  EXPECT_EQ(root_data(browsed.dom, "errors"), "0") << root_data(browsed.dom, "errors-text");
  EXPECT_EQ(root_data(browsed.dom, "figures"), "0");
  EXPECT_TRUE(holds(browsed.dom, "left out"));
}

TEST_F(ReportInChromiumCampaign, DISABLED_OddDataDrawWithoutError) {
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
TEST_F(ReportInChromiumCampaign, DISABLED_ErrorsAndRequestsWouldBeSeen) {
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
