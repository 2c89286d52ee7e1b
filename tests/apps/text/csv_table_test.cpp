#include "apps/text/csv_table.h"

#include <gtest/gtest.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

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
