// The page of paper.h, and its table for other programs.
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "apps/page/page.h"
#include "apps/page/text.h"
#include "apps/paper/paper.h"
#include "apps/text/number_text.h"

namespace tribotrack::apps {
namespace {

constexpr const char* kPaper =
    "S. Kilikevičius, K. Liutkauskienė, A. Fedaravičius: Nonprehensile Manipulation of Parts on a Horizontal "
    "Circularly Oscillating Platform with Dynamic Dry Friction Control, 2021 (CC BY)";

/// The style of a verdict (page.css).
const char* style_of(Verdict verdict) {
  constexpr const char* kStyles[] = {"good", "good", "care", "bad"};
  return kStyles[static_cast<int>(verdict)];
}

/// "<b>5.169 rad</b> dtau of the greatest v; mu1 = 0.1".
std::string deciding_html(const Claim& claim) {
  constexpr double kRounding = 1e-9;  // below it the size matters, not the digits
  return fmt::format("<b>{}{}{}</b> {}{}", number(claim.value, std::abs(claim.value) < kRounding ? 1 : 4),
                     *claim.unit ? " " : "", escape_html(claim.unit), sentence_html(claim.quantity),
                     claim.conditions.empty() ? "" : "; " + sentence_html(claim.conditions));
}

std::string anchor_of(const Claim& claim, const Paper& paper) {
  return fmt::format("claim-{}", &claim - paper.claims.data() + 1);
}

std::string claim_table(const Paper& paper) {
  std::string rows;
  for (const Claim& claim : paper.claims)
    rows += fmt::format(
        "<tr><td class=\"n\"><a href=\"#figure{0}\">{0}</a></td><td><a href=\"#{1}\">{2}</a></td><td "
        "class=\"judged {3}\">{4}</td><td data-v=\"{5}\">{6}</td></tr>\n",
        claim.figure, anchor_of(claim, paper), sentence_html(claim.name), style_of(claim.verdict),
        to_string(claim.verdict), fmt::format("{}", claim.value), deciding_html(claim));
  return table("claims", "compact claims", {">Figure", "Claim", "Verdict", "What we find"}, rows);
}

std::string first_screen(const Paper& paper) {
  return fmt::format(
             "<p>{} claims: {}. Each verdict rests on the number beside it. <i>Steady</i> is the periodic "
             "motion that the part settles into; <i>from rest</i> the first cycles, which the paper counts. "
             "Of figures 9 to 11 only the model’s side is shown, since the paper prints its measurements as "
             "pictures only.</p>\n",
             paper.claims.size(), verdicts_text(paper.claims)) +
         claim_table(paper);
}

std::string claim_box(const Claim& claim, const Paper& paper) {
  return fmt::format(
      "<div class=\"verdict {}\" id=\"{}\"><h3>{}: {}</h3>\n<p><q>{}</q> <span class=\"small\">(section "
      "{})</span></p>\n<p>{}</p>\n<p>{}</p>\n</div>\n",
      style_of(claim.verdict), anchor_of(claim, paper), sentence_html(claim.name), to_string(claim.verdict),
      sentence_html(claim.statement), sentence_html(claim.place), sentence_html(claim.finding),
      deciding_html(claim));
}

PageSection section_of(const PaperFigure& figure, const Paper& paper) {
  PageSection section{figure.id, figure.heading, "<div class=\"claim\">\n" + figure_box(figure) + "<div>\n"};
  for (const Claim& claim : paper.claims)
    if (claim.figure == figure.number) section.html += claim_box(claim, paper);
  if (*figure.agreement)
    section.html += fmt::format(
        "<p class=\"note\">The model’s side only. The paper’s measurements are printed as pictures, without "
        "numbers; <q>{}</q> is neither confirmed nor refuted here.</p>\n",
        figure.agreement);
  if (*figure.taken) section.html += fmt::format("<p class=\"note\">{}</p>\n", figure.taken);
  section.html += "</div></div>\n";
  return section;
}

PageSection sources_section() {
  return {"sources", "Where the numbers come from",
          fmt::format(
              "<p>The paper: {}. Its sentences are quoted with their symbols; [...] marks words left "
              "out.</p>\n<p>The conditions of each figure stand below it and in "
              "<code>data/figure*.toml</code>, which this program carries. The motion, equation (5) of the "
              "paper, is solved between its events: friction switches, stops and releases are hit exactly, "
              "and an end after 20 cycles is good to some 10<sup>−13</sup> of the path.</p>\n<p>The verdicts "
              "are in <code>claims.csv</code> beside this page. <code>tribotrack sweep data/figure6a.toml -o "
              "figure6a.csv</code> gives the curves of one panel.</p>\n",
              kPaper)};
}

}  // namespace

std::string page_of(const Paper& paper) {
  Page page{.name = "paper",
            .title = "What the paper claims, computed again",
            .subtitle = kPaper,
            .first = first_screen(paper),
            .figures = {paper.figures.begin(), paper.figures.end()}};
  for (const PaperFigure& figure : paper.figures) page.sections.push_back(section_of(figure, paper));
  page.sections.push_back(sources_section());
  return html_of(std::move(page));
}

std::string claims_csv(const Paper& paper) {
  std::string csv = "figure,place,claim,verdict,quantity,conditions,value,unit,statement,finding\n";
  for (const Claim& claim : paper.claims)
    csv += fmt::format("{},\"{}\",\"{}\",{},\"{}\",\"{}\",{},{},\"{}\",\"{}\"\n", claim.figure, claim.place,
                       claim.name, to_string(claim.verdict), claim.quantity, claim.conditions,
                       exact(claim.value), claim.unit, claim.statement, claim.finding);
  return csv;
}

std::string verdicts_text(const std::vector<Claim>& claims) {
  constexpr const char* kWords[] = {"exact", "hold", "hold in part", "refuted"};
  std::vector<std::string> parts;
  for (int k = 0; k < 4; ++k)
    parts.push_back(fmt::format("{} {}", std::ranges::count(claims, static_cast<Verdict>(k), &Claim::verdict),
                                kWords[k]));
  return fmt::format("{}", fmt::join(parts, ", "));
}

}  // namespace tribotrack::apps
