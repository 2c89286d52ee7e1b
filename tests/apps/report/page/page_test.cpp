#include "apps/report/page/page.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <memory>
#include <string>

#include "apps/browser.h"
#include "apps/report/tables/tables.h"
#include "apps/report_sample.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

using test::occurrences;
using testing::HasSubstr;

/// Not a matcher: those print the whole page, megabytes of it, when they fail.
bool holds(const std::string& page, const std::string& text) {
  return page.find(text) != std::string::npos;
}

std::string page_of(const ReportData& data) {
  return page_of(data, campaign_figures(data));
}

constexpr int figures_of_the_sample = 9;  // 4 dependences, trajectories, residuals, corner, influence, slide

TEST(ReportPage, NothingItIsGivenBecomesMarkup) {
  const std::string hostile = "<script>boom()</script>{{plotly}}\"'&";
  ReportData data = sample::campaign();
  fit::FitResult& fit = data.fit;
  data.title = data.configuration = data.shared_scale = data.phase_reference = hostile;
  fit.covariance_meaning = fit.improve_first = fit.next_experiment->sentence = hostile;
  data.warnings = fit.identifiability.weak_directions = fit.left_out = fit.systematics = {hostile};
  fit.minima = {{}, {{}, 1, hostile}};
  fit.outliers = {{hostile, 5, 0.001, 1, hostile}};
  fit.verdict_reasons = {hostile};
  fit.explanations.resize(1);
  fit.explanations[0].name = fit.explanations[0].run = fit.explanations[0].unit = hostile;
  fit.slides.resize(1);
  fit.slides[0].run = fit.slides[0].sentence = hostile;
  for (fit::BudgetEntry& entry : fit.budget) entry.source = entry.quantity = entry.from = hostile;
  data.conditions[0].quantity = data.conditions[0].from = hostile;
  data.inputs = {{hostile, hostile}};
  for (ReportRun& run : data.runs) {
    run.name = run.video = run.track.time_base = run.gate_source = hostile;
    run.notes = {hostile};
    run.track.plan = {{hostile, false, hostile, 0.1}};
    if (!run.failure.empty()) run.failure = hostile;
    for (fit::Residual& residual : run.fitted.residuals) residual.observable = hostile;
  }
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
  EXPECT_TRUE(holds(page, "<td class=\"n\">500 / 3 / 0 / 0</td>"));
  EXPECT_TRUE(holds(page, "xxh3-128:0123456789abcdef0123456789abcdef"));
}

/// Every table, as wide as it gets.
ReportData with_every_table() {
  ReportData data = sample::campaign();
  for (fit::ParameterEstimate& p : data.fit.parameters) {
    p.sd = 1e-6;  // many digits
    p.bootstrap_ci95 = p.ci95;
  }
  data.fit.outliers = {{"a run with quite a long name of its own", 12.3, 3e-8, 1.234, ""}};
  fit::Explanation& wide = data.fit.explanations.emplace_back();
  wide.name = "bad_run";
  wide.run = "a run with quite a long name of its own";
  wide.chi2_fall = 531936124.9;
  wide.size = 12.3456789;
  wide.size_sd = 1e-5;
  wide.unit = "% over the campaign";
  for (const fit::ParameterEstimate& p : data.fit.parameters)
    wide.parameters[p.parameter] = {p.estimate, p.sd, p.ci95};
  data.fit.next_experiment->phi = 0.123456;
  for (const fit::ParameterEstimate& p : data.fit.parameters)
    data.fit.next_experiment->predicted_ci95[p.parameter] = p.ci95;
  return data;
}

ReportData odd() {
  ReportData data = sample::campaign();
  for (ReportRun& run : data.runs) {
    run.measured.erase("alpha_rad");  // nothing moved more than its noise
    run.measured["v_mm_s"].value = 0;
    run.name = "same name";
    for (fit::Residual& residual : run.fitted.residuals) residual.standardised = no_value;
    run.fitted.slide.modelled.clear();
  }
  for (ReportGroup& group : data.over_phi)
    group.curve_x_rad = group.curve_alpha_rad = group.curve_v_mm_s = group.curve_alpha_sd_rad =
        group.curve_v_sd_mm_s = {};
  return data;
}

std::string dark(std::string page) {
  const std::string query = "(prefers-color-scheme: dark)";
  for (std::size_t at = page.find(query); at != std::string::npos; at = page.find(query, at))
    page.replace(at, query.size(), "(min-width: 0px)");
  return page;
}

std::string with_error_and_request(std::string page) {
  page.insert(page.rfind("</body>"),
              "<img src=\"http://blocked.invalid/x.png\"><script>throw new Error('control')</script>");
  return page;
}

constexpr const char* kDrawn =
    "for (let k = 0; k < 300 && root.dataset.drawn !== root.dataset.figures; ++k) await wait(100);"
    "await wait(500);";

constexpr const char* kState =
    "for (const key of ['errors', 'errors-text', 'violations', 'figures', 'drawn'])"
    "tell(key, root.getAttribute('data-' + key));";

constexpr const char* kSampleScript = R"js(
  tell('boxes', dom().split('class="box').length - 1);
  // Ticks of angles are fractions of pi. No bar of buttons of the library, one of which would send the chart away.
  tell('ticks', ['>3π/4<', '>7π/4<', '>2π<', '>π/6<', '>7π/6<'].filter(label => !dom().includes(label)).join());
  tell('bar', ['modebar-btn', 'Share chart'].filter(label => dom().includes(label)).join());
  tell('estimates', [...document.querySelectorAll('#parameter-table td[data-v]')].map(cell => cell.dataset.v).join());
  tell('csv', TribotrackFigures.csv_of('v-phi'));
  URL.createObjectURL = blob => { blob.text().then(text => tell('table', text)); return '#'; };
  document.querySelector('[aria-label="CSV of table run-table"]').click();
  let all = null;
  URL.createObjectURL = blob => { all = blob; return '#'; };
  document.getElementById('download-all').click();
  for (let k = 0; k < 40 && !all; ++k) await wait(250);
  const zip = new DataView(await all.arrayBuffer()), end = zip.byteLength - 22;
  const more = document.querySelectorAll('table[id]').length + 2 * TribotrackFigures.ids().length;
  tell('zip', [end, zip.getUint32(end + 16, true)].map(at => zip.getUint32(at, true).toString(16)) + ' ' + (zip.getUint16(end + 10, true) - more));
  const box = document.getElementById('plot-v-phi'), range = () => box._fullLayout.xaxis.range;
  const wide = () => range()[1] - range()[0], before = wide();
  box.dispatchEvent(new KeyboardEvent('keydown', {key: '+'}));
  tell('zoom', (wide() / before).toFixed(2));
  const entry = box.parentElement.querySelector('.legend button');
  entry.click();
  tell('hidden', entry.getAttribute('aria-pressed') + ' ' + box.data.filter(t => t.visible === false).length);
  document.querySelectorAll('details').forEach(d => { d.open = true; });
  await wait(2000);
  tell('opened', root.dataset.drawn + ' ' + root.dataset.errors);
  dispatchEvent(new Event('beforeprint'));
  tell('printed', Array.from(document.querySelectorAll('.pair .box')).every(b => b._fullLayout.width === 338));
)js";

/// Pages as headless Chromium sees them.
class ReportInChromium : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    const auto program = test::chromium();
    if (!program) return;
    browser_ = std::make_unique<test::DrivenBrowser>(*program);
    sample_ = look(page_of(sample::campaign()), kState + std::string(kSampleScript));
  }
  static void TearDownTestSuite() { browser_.reset(); }

  void SetUp() override {
    if (!browser_) GTEST_SKIP() << "chromium is not installed: the page was not looked at";
  }

  /// What a script tells of a page once it is drawn: it may `await`, with `tell(key, value)`, `wait(ms)`,
  /// `root`, the page's element, and `dom()`, the page without its scripts.
  static Json look(const std::string& html, const std::string& script, int width = 1200) {
    browser_->resize(width, 6000);
    browser_->show(html);
    return browser_->value(
        "const root = document.documentElement, told = {};"
        "const tell = (key, value) => { told[key] = String(value); };"
        "const wait = ms => new Promise(done => setTimeout(done, ms));"
        "const dom = () => { const copy = root.cloneNode(true);"
        "copy.querySelectorAll('script').forEach(s => s.remove()); return copy.outerHTML; };"
        "try {" +
        std::string(kDrawn) + script + "} catch (error) { tell('failed', error); } return told;");
  }
  static std::string told(const std::string& key) {
    return sample_.contains(key) ? sample_[key].get<std::string>() : "(nothing was told)";
  }

  static inline std::unique_ptr<test::DrivenBrowser> browser_;
  static inline Json sample_;
};

TEST_F(ReportInChromium, EveryFigureIsDrawnWithoutError) {
  const std::string all = std::to_string(figures_of_the_sample),
                    with_runs =
                        std::to_string(figures_of_the_sample + 13);  // folded away until they are opened
  EXPECT_EQ(told("errors"), "0") << told("errors-text");
  EXPECT_EQ(told("violations"), "0");
  EXPECT_EQ(told("figures"), all);
  EXPECT_EQ(told("drawn"), all);
  EXPECT_EQ(told("boxes"), with_runs);
  EXPECT_EQ(told("opened"), with_runs + " 0");
  EXPECT_EQ(told("ticks"), "") << "are missing";
  EXPECT_EQ(told("bar"), "");
  EXPECT_FALSE(sample_.contains("failed")) << told("failed");
}

TEST_F(ReportInChromium, TheNumbersOnThePageAreThoseOfTheTables) {
  const ReportData data = sample::campaign();
  std::string estimates;
  for (const fit::ParameterEstimate& p : data.fit.parameters) {
    estimates += (estimates.empty() ? "" : ",") + exact(p.estimate);
    EXPECT_TRUE(holds(parameters_csv(data),
                      std::string(fit::to_string(p.parameter)) + "," + exact(p.estimate) + ","));
  }
  EXPECT_THAT(told("estimates"), testing::StartsWith(estimates));
}

TEST_F(ReportInChromium, AFigureLeavesAsTheCsvThatItsNumbersHave) {
  std::size_t points = 0;
  for (const Figure& figure : dependence_figures(sample::campaign()))
    for (const Panel& panel : figure.panels)
      for (const Json& trace : panel.traces) points += figure.id == "v-phi" ? trace["x"].size() : 0;
  EXPECT_THAT(told("csv"), HasSubstr("panel,series,mark,name,x,y,sd,y_high,note"));
  EXPECT_EQ(occurrences(told("csv"), "\n"), points + 1);
}

// Its CSV has a heading for every cell, standard deviations too.
TEST_F(ReportInChromium, ATableLeavesAsRowsOfOneLength) {
  const std::string csv = told("table");
  const std::size_t heading = csv.find('\n'), second = csv.find('\n', heading + 1);
  ASSERT_NE(second, std::string::npos) << csv;
  EXPECT_THAT(csv, HasSubstr("α, rad, sd"));
  const fit::Estimate alpha = sample::campaign().runs[0].value("alpha_rad");
  EXPECT_THAT(csv, HasSubstr("," + exact(alpha.value) + "," + exact(alpha.sd) + ","));
  // Commas in quotes stand in headings only: "α, rad", "v, mm/s", "σ, px" and the two sds.
  const auto commas = [&](std::size_t from, std::size_t to) {
    bool in_quotes = false;
    int count = 0;
    for (std::size_t i = from; i < to; ++i) {
      in_quotes = in_quotes != (csv[i] == '"');
      count += csv[i] == ',' && !in_quotes;
    }
    return count;
  };
  EXPECT_EQ(commas(0, heading), commas(heading, second)) << csv.substr(0, second);
}

// Its end, where that says the directory is, and an entry for every table, and for every figure two.
TEST_F(ReportInChromium, AllOfItLeavesAsOneArchive) {
  EXPECT_EQ(told("zip"), "6054b50,2014b50 0");
}

TEST_F(ReportInChromium, TheKeyboardZoomsTheLegendHidesAndPaperHasItsSize) {
  EXPECT_EQ(told("zoom"), "0.70");
  EXPECT_EQ(told("hidden"), "false 4");  // band, line, points and residuals of the group
  EXPECT_EQ(told("printed"), "true");
}

/// axe-core's rules of WCAG 2.1 A and AA: what a reader who cannot see or use a mouse would stumble over.
TEST_F(ReportInChromium, AxeFindsNothingSeriousOrModerate) {
  std::ifstream file(TRIBOTRACK_AXE_JS, std::ios::binary);
  const std::string axe{std::istreambuf_iterator<char>(file), {}};
  const std::string page = page_of(sample::campaign());
  for (const std::string& html : {page, dark(page)}) {
    look(html, "");
    browser_->value(axe);
    EXPECT_EQ(browser_->value("const r = await axe.run(document, {resultTypes: ['violations']});"
                              "return r.violations.filter(v => v.impact !== 'minor').map(v => v.id + ': ' + "
                              "v.nodes.map(n => n.html).slice(0, 3).join(' | ')).join('; ')"),
              "");
  }
}

TEST_F(ReportInChromium, TablesKeepWithinANarrowPage) {
  const std::string page = page_of(with_every_table());
  for (const int width : {1200, 1000, 700})
    EXPECT_EQ(look(page, "tell('over', root.clientWidth + ' ' + (root.scrollWidth - root.clientWidth));",
                   width)["over"],
              std::to_string(width) + " 0");
}

TEST_F(ReportInChromium, NoDataAndOddDataDrawWithoutError) {
  const Json empty =
      look(page_of(ReportData{}), kState + std::string("tell('left', dom().includes('left out'));"));
  EXPECT_EQ(empty["errors"], "0") << empty;
  EXPECT_EQ(empty["figures"], "0");
  EXPECT_EQ(empty["left"], "true");
  const Json drawn = look(page_of(odd()), kState);
  EXPECT_EQ(drawn["errors"], "0") << drawn;
  EXPECT_EQ(drawn["drawn"], drawn["figures"]);
}

// What the tests above rest on: an error and a request, which is blocked, would be seen.
TEST_F(ReportInChromium, ErrorsAndRequestsWouldBeSeen) {
  const Json blocked = look(with_error_and_request(page_of(ReportData{})), kState);
  EXPECT_EQ(blocked["errors"], "1");
  EXPECT_THAT(blocked["errors-text"].dump(), HasSubstr("control"));
  EXPECT_EQ(blocked["violations"], "1");
}

}  // namespace
}  // namespace tribotrack::apps
