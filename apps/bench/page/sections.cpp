#include "apps/bench/page/sections.h"

#include <fmt/format.h>

#include <algorithm>
#include <stdexcept>

#include "apps/bench/page/wins.h"
#include "apps/page/text.h"

namespace tribotrack::bench {

using apps::escape_html;
using apps::PageSection;

namespace {

const BenchTable& table_named(const std::vector<BenchTable>& tables, std::string_view name) {
  const auto found = std::ranges::find(tables, name, &BenchTable::name);
  if (found == tables.end()) throw std::logic_error("the page shows a table that was not made");
  return *found;
}

std::string paragraph(const std::string& html) {
  return "<p>" + html + "</p>\n";
}

/// Long tables open on demand.
std::string folded(const std::string& summary, const std::string& html) {
  return fmt::format("<details><summary>{}</summary>{}</details>\n", summary, html);
}

std::string figures_in(const BenchTable& table) {
  std::string html;
  for (const apps::Figure& figure : table.figures) html += figure_box(figure);
  return html;
}

PageSection model_section(const ModelResults& model, const BenchTable& table) {
  return {
      "model", "Model",
      paragraph(
          "Where is the part after so many cycles, and what does it cost to know? Ours beside the "
          "paper’s recipe and solvers an engineer would use instead, each at several tolerances or steps.") +
          figures_in(table) + wins_of_peers(model.rows) +
          folded(fmt::format("All {} rows: every method at every setting", model.rows.size()), table.html)};
}

PageSection extremes_section(const ModelResults& model, const BenchTable& table) {
  std::vector<ModelExtremeRow> broken;
  std::ranges::copy_if(model.extremes, std::back_inserter(broken),
                       [](const ModelExtremeRow& row) { return !row.held; });
  std::string html = paragraph(fmt::format(
      "{} of {} stiff and extreme cases hold the law that must hold there: a scaling, a closed solution, a "
      "bound. The "
      "figure is how far each is from holding, relative to the path unless the law says otherwise.",
      model.extremes.size() - broken.size(), model.extremes.size()));
  for (const ModelExtremeRow& row : broken)
    html += paragraph(fmt::format("<b>BROKEN</b>: {}: {}", escape_html(row.name),
                                  escape_html(row.failure.empty() ? row.invariant : row.failure)));
  return {"extremes", "Extremes",
          html + folded(fmt::format("All {} cases with their laws", model.extremes.size()), table.html)};
}

PageSection claims_section(const BenchTable& table) {
  return {
      "claims", "Claims of the paper",
      paragraph("What Kilikevicius et al. (2021) state about the motion, computed again. Figures of each: "
                "<code>tribotrack paper</code>.") +
          table.html};
}

PageSection tracking_section(const BenchResults& results, const std::vector<BenchTable>& tables) {
  std::string html;
  if (results.vision) {
    const BenchTable& methods = table_named(tables, "bench_vision");
    html += paragraph(
        "How far from the truth is a position, and what does it cost? <code>tribotrack track</code> is the "
        "whole pipeline on pictures in memory, with its learning; the others are given where the disc is.");
    html += figures_in(methods) + wins_of_peers(results.vision->rows);
    html += folded(fmt::format("All {} rows", results.vision->rows.size()), methods.html);
    html +=
        "<h3>Against the limit</h3>\n" +
        paragraph(
            "The whole tracker over the grid of what recordings are like. “x bound” is the rms error over "
            "the "
            "Cramér-Rao bound; “standardised” is the rms of the errors over their own standard deviations, "
            "1 where these are true.") +
        table_named(tables, "bench_vision_limit").html;
    html += "<h3>Beside decoding</h3>\n" +
            paragraph("A recording on disk: decoding alone, and all of <code>track</code>.") +
            table_named(tables, "bench_vision_decoding").html;
  }
  if (results.commands)
    html +=
        "<h3>Whole commands</h3>\n" +
        paragraph(
            "From the start of the process to its end: CPU time with one thread, wall time with one and two; "
            "beside "
            "it the whole command of a windowed <code>cv::matchTemplate</code> that is told where to begin "
            "(“match”) and of reading its windows alone (“read”). Shares of the wall time in %.") +
        table_named(tables, "bench_commands").html;
  return {"tracking", "Tracking", html};
}

PageSection audit_section(const BenchTable& table) {
  return {"audit", "The audit’s halves",
          paragraph(
              "What a recording says of its own standard deviations, without a truth: positions from the "
              "left and right "
              "half of the disc, from top and bottom, from alternate tiles, and the scatter from frame to "
              "frame, each "
              "over what the model of the noise predicts. 1 is right; above 1 <code>track</code> widens its "
              "standard "
              "deviations by the factor given. “true errors” are those against the rendered truth, over the "
              "standard deviations that were reported.") +
              table.html};
}

PageSection fit_section(const FitResults& fit, const BenchTable& table) {
  return {
      "fit", "Fit",
      paragraph(
          "Simulated campaigns with known truth. The whole fit searches from several starts; single descents "
          "start all at one place. One that ends farther than a thousandth of a standard deviation from the "
          "minimum, or in some campaign nowhere, does not arrive.") +
          figures_in(table) + wins_of_peers(fit.rows) + table.html};
}

PageSection coverage_section(const CoverageResults& coverage, const BenchTable& table) {
  return {
      "coverage", "Coverage",
      paragraph(fmt::format(
          "Do 95 % intervals hold the truth in 95 % of campaigns? Up to {} simulated ones of each design and "
          "noise level, from seed {}. “score” is the interval’s score over that of the "
          "best possible one: 1 is as good as can be.",
          coverage.campaigns, coverage.seed)) +
          figures_in(table) + folded(fmt::format("All {} rows", coverage.rows.size()), table.html)};
}

std::string load_text(const LoadAverage& load) {
  return load ? fmt::format("{:.2f}, {:.2f}, {:.2f}", (*load)[0], (*load)[1], (*load)[2]) : "unknown";
}

}  // namespace

std::vector<PageSection> sections_of(const BenchResults& results, const std::vector<BenchTable>& tables) {
  std::vector<PageSection> sections;
  if (const auto& model = results.model) {
    sections.push_back(model_section(*model, table_named(tables, "bench_model")));
    sections.push_back(extremes_section(*model, table_named(tables, "bench_model_extremes")));
    sections.push_back(
        {"plan", "What the plan saves",
         paragraph("The same motion with and without what the plan leaves out, the saving that it predicts, "
                   "and the error that it adds beside the bound that the plan states.") +
             table_named(tables, "bench_model_plan").html});
    sections.push_back(
        {"batch", "Many at once",
         paragraph(
             "Scenarios of a sweep side by side in the lanes of a processor, beside one after the other. "
             "No other method was run here.") +
             table_named(tables, "bench_model_batch").html});
    sections.push_back(claims_section(table_named(tables, "bench_model_claims")));
  }
  if (results.vision || results.commands) sections.push_back(tracking_section(results, tables));
  if (results.vision) sections.push_back(audit_section(table_named(tables, "bench_vision_audit")));
  if (const auto& fit = results.fit) {
    sections.push_back(fit_section(*fit, table_named(tables, "bench_fit")));
    sections.push_back(
        {"filming", "Which run to film next",
         paragraph(
             "How many runs are filmed until half the 95 % interval of μ₁ is 1 % of it: chosen one by one as "
             "<code>watch</code> suggests, against the source paper’s design (8 values of φ at one Δτ, 6 of "
             "Δτ at one "
             "φ, then again). Both film the same simulated parts.") +
             table_named(tables, "bench_fit_filming").html});
  }
  if (results.coverage)
    sections.push_back(coverage_section(*results.coverage, table_named(tables, "bench_fit_coverage")));
  if (results.scale)
    sections.push_back(
        {"scale", "As work grows",
         paragraph(
             "Whole commands on ever larger inputs, one thread, and the exponent n of cost ~ "
             "size<sup>n</sup> "
             "over the three largest sizes with its standard deviation. Nothing grows faster than its work "
             "where n is at most 1.") +
             figures_in(table_named(tables, "bench_scale")) +
             table_named(tables, "bench_scale_exponents").html +
             folded("Every size", table_named(tables, "bench_scale").html)});
  return sections;
}

PageSection section_of(const Circumstances& circumstances) {
  std::string missing;
  for (const std::string& library : circumstances.missing) missing += (missing.empty() ? "" : ", ") + library;
  const std::vector<std::pair<const char*, std::string>> lines = {
      {"program", circumstances.program},
      {"machine", circumstances.cpu},
      {"compiler", circumstances.compiler},
      {"flags", circumstances.compiler_flags},
      {"clock", circumstances.clock},
      {"load before", load_text(circumstances.load_before)},
      {"load after", load_text(circumstances.load_after)},
      {"reference of the model", circumstances.model_reference},
      {"reference of tracking", circumstances.vision_reference},
      {"reference of the fit", circumstances.fit_reference},
      {"peers", circumstances.peers},
      {"missing peers", missing.empty() ? "none" : "this build was made without " + missing},
  };
  std::string html = "<div class=\"wide\"><table id=\"bench_circumstances\" class=\"compact\"><tbody>\n";
  for (const auto& [name, value] : lines)
    html += fmt::format("<tr><th>{}</th><td>{}</td></tr>\n", name, escape_html(value));
  return {"circumstances", "Circumstances", html + "</tbody></table></div>\n"};
}

}  // namespace tribotrack::bench
