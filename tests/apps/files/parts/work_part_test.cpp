#include "apps/files/parts/work_part.h"

#include <gtest/gtest.h>

namespace tribotrack::apps {
namespace {

TEST(WorkPart, EachThingIsInOnePart) {
  for (const std::size_t count : {1u, 7u, 39u, 100'000'000u})
    for (const std::size_t of : {1u, 2u, 3u, 38u, 100u}) {
      std::size_t place = 0;
      for (std::size_t k = 1; k <= of; ++k) {
        const WorkPart part{k, of};
        EXPECT_EQ(part.begin(count), place);
        place = part.end(count);
        EXPECT_LE(place - part.begin(count), count / of + 1);
        EXPECT_GE(place - part.begin(count), count / of);
      }
      EXPECT_EQ(place, count);
    }
}

}  // namespace
}  // namespace tribotrack::apps
