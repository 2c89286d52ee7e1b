#include "apps/bench/vision/decoding.h"

#include <gtest/gtest.h>

namespace tribotrack::bench {

namespace {

TEST(BenchDecoding, EveryCodingIsWrittenDecodedAndTracked) {
  const auto rows = bench_decoding(quick_decoding_options());
  ASSERT_EQ(rows.size(), 8U);
  for (const VisionDecodingRow& row : rows) {
    SCOPED_TRACE(row.coding + (row.brushed ? ", brushed" : ""));
    EXPECT_EQ(row.lost, 0);
    EXPECT_GT(row.decoding, 0);
    EXPECT_GT(row.tracking, 0);
    EXPECT_LT(row.rms, 0.2) << "a tenth of the pixels that a coder moves";
  }
  for (const std::size_t scene : {0U, 4U})
    EXPECT_EQ(rows[scene].rms, rows[scene + 1].rms) << "FFV1 loses nothing: the very same track";
}

}  // namespace
}  // namespace tribotrack::bench
