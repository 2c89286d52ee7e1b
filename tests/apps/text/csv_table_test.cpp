#include <gtest/gtest.h>

#include <algorithm>
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
  expect("x in mm", "x", "mm");
  expect("x\xe2\x82\x81 (mm)", "x_1", "mm");
  expect("t_{1} [sec]", "t_1", "s");
  expect("point A: x", "point_a_x", "");
  for (const char* first : {"v", "t", "m", "", "alpha"}) expect(first, first, "");  // never a unit
  EXPECT_DOUBLE_EQ(*si_per("deg", Dimension::angle), pi / 180);
  EXPECT_EQ(si_per("mm", Dimension::velocity), std::nullopt);
  EXPECT_EQ(si_per("furlong", Dimension::length), std::nullopt);
}

/// At its header, the line that names an a.
CsvTable table_of(const std::string& text) {
  return {"t.csv", text, [](const Cells& cells) { return static_cast<int>(std::ranges::count(cells, "a")); }};
}

TEST(CsvTable, CellsAreTrimmedAndEmptyLinesSkipped) {
  CsvTable table = table_of("\xef\xbb\xbf a, \"b\" ,c\r\n\n1,,3\r\n");
  EXPECT_EQ(table.header(), (Cells{"a", "b", "c"}));
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.cells(), (Cells{"1", "", "3"}));
  EXPECT_EQ(table.number(table.cells()[2]), 3);
  EXPECT_FALSE(table.next());
}

TEST(CsvTable, ABadCellIsNamedWithItsPlace) {
  CsvTable table = table_of("a,b\n\n1, 2x\n1,2\n");
  EXPECT_EQ(complaint_of([&] { table.fail("is short"); }), "t.csv:1: is short");
  EXPECT_EQ(complaint_of([&] { table.fail(table.header()[1], "is b"); }), "t.csv:1:3: is b");
  table.next();
  EXPECT_EQ(complaint_of([&] { table.number(table.cells()[1]); }), "t.csv:3:4: `2x` is not a number");
  EXPECT_EQ(complaint_of([&] { table.fail("is short"); }), "t.csv:3: is short");
}

TEST(CsvTable, TheRowsOfNumbersTellSeparatorAndDecimalSign) {
  // The same two rows, below names that are separated otherwise.
  for (const char* rows :
       {"0.5,-2.5e-3,7\n1.5,3,\n", "0,5;-2,5e-3;7\n1,5;3;\n", "0.5;-2.5e-3;7\n1.5;3;\n",
        "0,5\t-2,5e-3\t7\n1,5\t3\t\n", "0.5 -2.5e-3   7\n 1.5  3 NaN\n", "0,5 -2,5e-3 7\n1,5 3 -\n",
        "\"0,5\",\"-2,5e-3\",\"7\"\n\"1,5\",\"3\",\"\"\n", "0.5 , -2.5e-3 , 7\n1.5 , 3 ,\n"})
    for (const char* names :
         {"a,b,c\n", "a;b;c\n", "# a b c\n", "of Monday, in the lab\n\na\tb\tc\n# by me; again\n"}) {
      SCOPED_TRACE(std::string(names) + rows);
      CsvTable table = table_of(std::string(names) + rows);
      EXPECT_EQ(table.header(), (Cells{"a", "b", "c"}));
      ASSERT_TRUE(table.next());
      ASSERT_GE(table.cells().size(), 3u);
      EXPECT_EQ(table.number(table.cells()[0]), 0.5);
      EXPECT_EQ(table.number(table.cells()[1]), -2.5e-3);
      EXPECT_EQ(table.number(table.cells()[2]), 7);
      ASSERT_TRUE(table.next());
      EXPECT_EQ(table.number(table.cells()[0]), 1.5);
      EXPECT_TRUE(CsvTable::is_none(table.cells().back()));
      EXPECT_FALSE(table.next());
    }
}

TEST(CsvTable, NoNumberIsReadInTheOtherDecimalSign) {
  CsvTable commas = table_of("a;b\n0,5;1,5\n0,5;1.234\n");
  commas.next(), commas.next();
  EXPECT_EQ(
      complaint_of([&] { commas.number(commas.cells()[1]); }),
      "t.csv:3:5: `1.234` is not a number: this table has decimal commas; write thousands without points");
  CsvTable points = table_of("a;b\n0.5;1.5\n0.5;1,234\n");
  points.next(), points.next();
  EXPECT_EQ(
      complaint_of([&] { points.number(points.cells()[1]); }),
      "t.csv:3:5: `1,234` is not a number: this table has decimal points; write thousands without commas");
}

TEST(CsvTable, UnitsStandInTheNamesOrBelow) {
  CsvTable table = table_of("a\tv [mm/s]\tt\n[mm]\t\tms\n1\t2\t3\n");
  EXPECT_EQ(table.heading(0).unit, "mm");
  EXPECT_EQ(table.heading(1).unit, "mm/s");
  EXPECT_EQ(table.heading(2).unit, "ms");
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.number(table.cells()[2]), 3);
}

TEST(CsvTable, EveryEncodingIsRead) {
  const std::string text =
      "a,x\u2081 [\u00b5m]\n\u22121,2\n3,4\n";  // Latin-1 knows neither subscript nor minus
  std::string little = "\xff\xfe", big = "\xfe\xff";
  for (const char16_t c : std::u16string_view(u"a,x\u2081 [\u00b5m]\n\u22121,2\n3,4\n")) {
    const char low = static_cast<char>(c & 0xff), high = static_cast<char>(c >> 8);
    little += {low, high};
    big += {high, low};
  }
  for (const std::string& bytes :
       {text, "\xef\xbb\xbf" + text, little, big, std::string("a,x_1 [\xb5m]\r-1,2\r3,4\r")}) {
    CsvTable table = table_of(bytes);
    ASSERT_EQ(table.header().size(), 2u);
    EXPECT_EQ(table.heading(1).quantity, "x_1");
    EXPECT_EQ(table.heading(1).unit, "um");
    ASSERT_TRUE(table.next());
    EXPECT_EQ(table.number(table.cells()[0]), -1);
    ASSERT_TRUE(table.next());
    EXPECT_EQ(table.number(table.cells()[1]), 4);
  }
  EXPECT_EQ(complaint_of([] { table_of("PK\x03\x04 and more"); }),
            "t.csv: is a spreadsheet, not a text; save it as CSV");
  EXPECT_NE(complaint_of([] { table_of(std::string("a,b\n1,\0", 7)); }).find("binary file"),
            std::string::npos);
}

TEST(CsvTable, WhatItHoldsIsSaid) {
  EXPECT_EQ(table_of("# note\nb;c\n1,5;2\n3;4\n").holds(),
            "it holds rows of 2 columns from line 3 on, separated by semicolons, with decimal commas under "
            "`b`, `c`");
  EXPECT_EQ(table_of("\n\n").holds(), "it is empty");
  EXPECT_EQ(table_of("Dear colleague,\n").holds(),
            "it holds no rows of numbers, and begins with `Dear colleague,`");
  std::string wide;
  for (int k = 0; k < 5000; ++k) wide += "1,";
  CsvTable table = table_of(wide + "\n" + wide + "\n");
  EXPECT_EQ(complaint_of([&] { table.next(); }),
            "t.csv:1: has more than 4096 columns, which no table of measurements has; check the file");
}

TEST(CsvTable, ANameIsNoComment) {
  CsvTable table = table_of("a,v\n" + csv_cell("#1") + ",2\n#2,2\n" + csv_cell("plain") + ",3\n");
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.cells()[0], "#1");
  ASSERT_TRUE(table.next());
  EXPECT_EQ(table.cells()[0], "plain");
}

TEST(CsvTable, NoSeparatorCountsWithinQuotes) {
  CsvTable table = table_of("a,v\n\"a, \"\"b\"\"\",2\n\"open,3\n");
  table.next();
  ASSERT_EQ(table.cells().size(), 2u);
  EXPECT_EQ(table.number(table.cells()[1]), 2);
  table.next();  // a quote that never closes is a character like others
  ASSERT_EQ(table.cells().size(), 2u);
  EXPECT_EQ(table.number(table.cells()[1]), 3);
}

}  // namespace

}  // namespace tribotrack::apps
