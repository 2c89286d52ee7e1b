// The whole sweep from its parts, byte for byte.
#include "apps/files/sweeps/joined_sweep.h"

#include <fmt/format.h>

#include "apps/program.h"

namespace tribotrack::apps {
namespace {

class JoinedSweep : public ProgramTest {
 protected:
  static constexpr const char* kSweep =
      "--over phi_rad=0:6:13 --over dtau_rad=pi/6,pi/3,pi/2";  // 39 scenarios

  void SetUp() override {
    ProgramTest::SetUp();
    put(in_folder("s.toml"), "[friction]\nmu1 = 0.12\n");
    ASSERT_EQ(run(std::string("sweep s.toml ") + kSweep + " -q -o whole.csv").exit_code, 0);
  }
  /// Their names, the last first.
  std::string make_parts(int of) const {
    std::string names;
    for (int k = 1; k <= of; ++k) {
      EXPECT_EQ(
          run(fmt::format("sweep s.toml {} -q --part {}/{} -o {}of{}.csv", kSweep, k, of, k, of)).exit_code,
          0);
      names = fmt::format("{}of{}.csv ", k, of) + names;
    }
    return names;
  }
};

TEST_F(JoinedSweep, JoinedTablesAreTheWhole) {
  for (const int of : {1, 2, 5, 39}) {
    ASSERT_EQ(run("sweep --join " + make_parts(of) + "-q -o joined.csv").exit_code, 0);
    EXPECT_EQ(content_of(in_folder("joined.csv")), content_of(in_folder("whole.csv"))) << of;
    EXPECT_EQ(content_of(in_folder("joined.csv.meta.json")), content_of(in_folder("whole.csv.meta.json")))
        << of;
  }
  EXPECT_EQ(run("sweep --join " + make_parts(2) + "-q -o -").out, content_of(in_folder("whole.csv")));
}

TEST_F(JoinedSweep, JoinedObjectsAreTheWhole) {
  const std::string whole = run(std::string("sweep s.toml ") + kSweep + " -q --json -o w.csv").out;
  std::string names;
  for (int k = 1; k <= 4; ++k) {
    put(in_folder(fmt::format("{}.json", k)),
        run(fmt::format("sweep s.toml {} -q --json --part {}/4 -o p.csv", kSweep, k)).out);
    names += fmt::format("{}.json ", k);
  }
  EXPECT_EQ(run("sweep --join " + names + "-q -o -").out, whole);
}

TEST_F(JoinedSweep, RefusesWhatIsNotTheWholeOfOneSweep) {
  make_parts(3);
  expect_refused(run("sweep --join 1of3.csv 3of3.csv -q -o j.csv"), 3, {"part 2 of 3"});
  expect_refused(run("sweep --join 1of3.csv 1of3.csv 2of3.csv 3of3.csv -q -o j.csv"), 3,
                 {"1of3.csv", "once"});
  expect_refused(run("sweep --join whole.csv -q -o j.csv"), 3, {"whole.csv.meta.json", "--part"});
  ASSERT_EQ(run("sweep --over phi_rad=0:6:13 --part 2/3 -q -o other.csv").exit_code, 0);
  expect_refused(run("sweep --join 1of3.csv other.csv 3of3.csv -q -o j.csv"), 3,
                 {"other.csv", "another sweep"});
  std::string cut = content_of(in_folder("2of3.csv"));
  cut.resize(cut.rfind('\n', cut.size() - 2) + 1);
  put(in_folder("2of3.csv"), cut);
  expect_refused(run("sweep --join 1of3.csv 2of3.csv 3of3.csv -q -o j.csv"), 3, {"2of3.csv", "13 rows"});
  for (const char* part : {"0/3", "4/3", "1", "1/0", "1/3x", "-1/3"})
    expect_refused(run(std::string("sweep ") + kSweep + " -q -o j.csv --part " + part), 2, {"K/N"});
  expect_refused(run(std::string("sweep ") + kSweep + " -q -o j.csv --part 1/40"), 2, {"39 scenarios"});
  EXPECT_FALSE(std::filesystem::exists(in_folder("j.csv")));
}

}  // namespace
}  // namespace tribotrack::apps
