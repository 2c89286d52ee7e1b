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

}  // namespace
}  // namespace tribotrack::apps
