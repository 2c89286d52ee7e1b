// What `run` and `report` leave beside the page: tables, text, and figures for print.
#include <gmock/gmock.h>

#include <filesystem>
#include <sstream>

#include "apps/program.h"
#include "apps/text/json.h"

namespace tribotrack::apps {
namespace {

namespace fs = std::filesystem;
using test::output_of;
using testing::HasSubstr;

/// Runs measured elsewhere: no recordings are needed.
class ReportOutputs : public ProgramTest {
 protected:
  void SetUp() override {
    ProgramTest::SetUp();
    std::string campaign =
        "title = \"Measured by hand\"\n[platform]\namplitude_mm = 0.28\nangular_frequency_rad_s = 62.8\n"
        "phase_shift_rad = \"pi/2\"\n[fit]\nparameters = [\"mu1\", \"mu2\", \"phase_lag_rad\"]\n";
    for (int k = 0; k < 6; ++k) {
      const std::string phi = std::to_string(k) + "pi/3";
      const std::string dtau = k % 2 == 0 ? "pi/3" : "2pi/3";
      const Json moved = Json::parse(
          run("simulate --mu1 0.1 --mu2 0.0125 --amplitude-mm 0.28 --omega-rad-s 62.8 --phi-rad " + phi +
              " --dtau-rad " + dtau + " --lag-rad 0.2 --cycles 20 --json")
              .out);
      campaign += "[[run]]\nname = \"r" + std::to_string(k) + "\"\nphi_rad = \"" + phi + "\"\ndtau_rad = \"" +
                  dtau + "\"\nalpha_rad = " + moved["alpha_rad"].dump() +
                  "\nalpha_sd_rad = 0.01\nv_mm_s = " + moved["v_mm_s"].dump() + "\nv_sd_mm_s = 0.02\n";
    }
    put(in_folder("c.toml"), campaign);
    ASSERT_EQ(run("run c.toml -o out -q").exit_code, 0);
  }
};

TEST_F(ReportOutputs, FiguresForPrintComeWithNumbersScriptAndFonts) {
  // A folder may come from a stranger: what lies in it is not run.
  fs::create_directory(in_folder("figures"));
  const std::vector<std::string> modules = {"fractions.py", "csv.py", "matplotlib.py"};
  for (const std::string& module : modules)
    put(in_folder("figures") / module, "open('" + in_folder("ran").string() + "', 'w')\n");
  put(in_folder("matplotlibrc"), "text.usetex: True\n");
  ASSERT_EQ(run("report out --figures figures -q").exit_code, 0);
  EXPECT_FALSE(fs::exists(in_folder("ran")));
  for (const std::string& module : modules) fs::remove(in_folder("figures") / module);

  EXPECT_TRUE(content_of(in_folder("figures/runs.csv")) == content_of(in_folder("out/runs.csv")));
  for (const std::string name : {"alpha-phi", "v-phi", "residuals"})
    for (const char* width : {"-84mm", "-174mm"}) {
      const std::string stem = in_folder("figures").string() + "/" + name + width;
      EXPECT_EQ(output_of("xmllint --noout '" + stem + ".svg' 2>&1"), "");
      // "yes" under "emb" for every font: 5 columns from the right.
      std::istringstream fonts(output_of("pdffonts '" + stem + ".pdf'"));
      std::string line;
      int count = 0;
      for (int k = 0; std::getline(fonts, line); ++k) {
        if (k < 2) continue;  // heading
        EXPECT_THAT(line, HasSubstr(" yes yes yes "));
        ++count;
      }
      EXPECT_GE(count, 1) << stem;
      const std::string wide = output_of("pdfinfo '" + stem + ".pdf' | grep 'Page size'");
      EXPECT_THAT(wide, HasSubstr(width == std::string("-84mm") ? "238.11" : "493.228")) << "points";
    }

  // The same numbers give the same bytes, by the script alone, too.
  const std::string before = content_of(in_folder("figures/alpha-phi-84mm.pdf"));
  const std::string drawing = content_of(in_folder("figures/alpha-phi-174mm.svg"));
  ASSERT_EQ(
      output_of("/usr/bin/python3 -B '" + in_folder("figures/figures.py").string() + "' alpha-phi 2>&1"), "");
  EXPECT_TRUE(before == content_of(in_folder("figures/alpha-phi-84mm.pdf")));
  EXPECT_TRUE(drawing == content_of(in_folder("figures/alpha-phi-174mm.svg")));
}

}  // namespace
}  // namespace tribotrack::apps
