#include <gtest/gtest.h>

#include <numbers>

#include "apps/program.h"
#include "apps/text/angle.h"
#include "apps/text/csv_table.h"

namespace tribotrack::apps {

namespace {

constexpr double pi = std::numbers::pi;

TEST(Angle, ReadsNumbersFractionsOfPiAndDegrees) {
  for (const auto& [text, angle] : {std::pair{"0.5", 0.5},
                                    {"-37.5", -37.5},
                                    {"1e-3", 1e-3},
                                    {"pi", pi},
                                    {"+pi", pi},
                                    {"-pi/2", -pi / 2},
                                    {"11pi/9", 11 * pi / 9},
                                    {"5*pi/6", 5 * pi / 6},
                                    {" 2.5 pi ", 2.5 * pi},
                                    {"90deg", pi / 2},
                                    {"-45 deg", -pi / 4}})
    EXPECT_EQ(parse_angle(text), angle) << text;
  for (const char* text :
       {"",      "abc",   "pi/",  "pi/0", "pi2",   "*pi", "pi/2/3", "nan",       "inf",    "-inf",
        "nanpi", "1e400", "0x10", "1,5",  "pi pi", "deg", "pi deg", "90degrees", "90 DEG", "90de"})
    EXPECT_FALSE(parse_angle(text)) << text;
  EXPECT_EQ(angle_slip(-4 * pi), "");
  EXPECT_NE(angle_slip(-12.6), "") << "more than two turns are degrees";
}

TEST(Number, TakesTheWholeTextOrNothing) {
  EXPECT_EQ(parse_number("+2.5"), 2.5);
  for (const char* text : {"", "2.5x", " 2.5", "nan", "inf", "--1"}) EXPECT_FALSE(parse_number(text)) << text;
}

void expect(const char* text, const char* quantity, const char* unit, bool sd = false) {
  const Heading heading = heading_of(text);
  EXPECT_EQ(heading.quantity, quantity) << text;
  EXPECT_EQ(heading.unit, unit) << text;
  EXPECT_EQ(heading.sd, sd) << text;
}

TEST(Heading, QuantityUnitAndSdInEverySpelling) {
  for (const char* text :
       {"phi_deg", "phi (deg)", "phi [\xc2\xb0]", "PHI_DEG", "phi, degrees", "\xcf\x86 (\xc2\xb0)"})
    expect(text, "phi", "deg");
  for (const char* text :
       {"v_mm_s", "v (mm/s)", "V [mm/s]", "v mm s^-1", "v (mm\xc2\xb7s\xe2\x81\xbb\xc2\xb9)"})
    expect(text, "v", "mm/s");
  for (const char* text : {"alpha_sd_deg", "alpha_deg_sd", "sd_alpha_deg", "sd alpha (deg)",
                           "\xcf\x83 alpha (deg)", "alpha std [deg]"})
    expect(text, "alpha", "deg", true);
  expect("\xce\x94\xcf\x84 [rad]", "dtau", "rad");
  expect("angular_frequency_rad_s", "angular_frequency", "rad/s");
  expect("amplitude (\xc2\xb5m)", "amplitude", "um");
  for (const char* first : {"v", "t", "m", "", "alpha"}) expect(first, first, "");  // never a unit
  EXPECT_DOUBLE_EQ(*si_per("deg", Dimension::angle), pi / 180);
  EXPECT_EQ(si_per("mm", Dimension::velocity), std::nullopt);
  EXPECT_EQ(si_per("furlong", Dimension::length), std::nullopt);
}

using Cells = std::vector<std::string_view>;

TEST(CsvTable, CellsAreTrimmedAndEmptyLinesSkipped) {
  CsvTable table("t.csv", "\xef\xbb\xbf a, \"b\" ,c\r\n\n1,,3\r\n");
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.cells(), (Cells{"a", "b", "c"}));
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.cells(), (Cells{"1", "", "3"}));
  EXPECT_EQ(table.number(table.cells()[2]), 3);
  EXPECT_FALSE(table.next());
}

TEST(CsvTable, ABadCellIsNamedWithItsPlace) {
  CsvTable table("t.csv", "a,b\n\n1, 2x\n");
  table.next();
  table.next();
  EXPECT_EQ(complaint_of([&] { table.number(table.cells()[1]); }), "t.csv:3:4: `2x` is not a number");
  EXPECT_EQ(complaint_of([&] { table.fail("is short"); }), "t.csv:3: is short");
}

TEST(CsvTable, SemicolonsComeWithDecimalCommas) {
  CsvTable table("t.csv", "a;b\n1,5;-2,5e-3;\n");
  table.next();
  table.next();
  EXPECT_EQ(table.number(table.cells()[0]), 1.5);
  EXPECT_EQ(table.number(table.cells()[1]), -2.5e-3);
  EXPECT_EQ(table.filled(), 2u);
}

TEST(CsvTable, TheFirstLineWithASeparatorTells) {
  CsvTable tabs("t.txt", "mass_A\nt\tx\ty\n0,5\t1\t2\n");
  tabs.next();
  EXPECT_EQ(tabs.cells(), (Cells{"mass_A"}));
  tabs.next();
  EXPECT_EQ(tabs.cells(), (Cells{"t", "x", "y"}));
  tabs.next();
  EXPECT_EQ(tabs.number(tabs.cells()[0]), 0.5);
  CsvTable blanks("t.txt", "t x y\n 0.5  1 2 \n");
  blanks.next();
  blanks.next();
  EXPECT_EQ(blanks.cells(), (Cells{"0.5", "1", "2"}));
}

TEST(CsvTable, NoSeparatorCountsWithinQuotes) {
  CsvTable table("t.csv", "name,v\n\"a, \"\"b\"\"\",2\n\"open,3\n");
  table.next();
  table.next();
  ASSERT_EQ(table.cells().size(), 2u);
  EXPECT_EQ(table.number(table.cells()[1]), 2);
  table.next();  // a quote that never closes is a character like others
  ASSERT_EQ(table.cells().size(), 2u);
  EXPECT_EQ(table.number(table.cells()[1]), 3);
}

}  // namespace

}  // namespace tribotrack::apps
