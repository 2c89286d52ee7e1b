#include <fmt/format.h>
#include <gmock/gmock.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>

#include "apps/files/tracks/any_track.h"
#include "apps/program.h"
#include "fit/measurement.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

constexpr double kRate = 250, kScale = 0.1;  // frames/s, mm/px
constexpr int kFrames = 300;

/// A part that slips on a circling platform: mm, y up, with some noise.
struct Motion {
  std::vector<Eigen::Vector2d> part, mark;
  Motion() {
    std::mt19937_64 random(3);
    std::normal_distribution<double> normal;
    for (int k = 0; k < kFrames; ++k) {
      const double t = k / kRate, turn = 62.8 * t;
      const Eigen::Vector2d platform(0.28 * std::cos(turn), 0.28 * std::cos(turn + 1.5707963));
      const Eigen::Vector2d slip(3 * t, -2 * t + 0.02 * std::sin(2 * turn));
      const auto noise = [&]() -> Eigen::Vector2d {
        return 0.001 * Eigen::Vector2d(normal(random), normal(random));
      };
      part.push_back(platform + slip + noise());
      mark.push_back(Eigen::Vector2d(5, 7) + platform + noise());
    }
  }
};

TrackReading in_unit(const std::string& unit, const std::string& point = "", const std::string& mark = "") {
  TrackReading reading;
  reading.unit = unit;
  reading.point = point;
  reading.mark = mark;
  return reading;
}

class ForeignTracks : public ProgramTest {
 protected:
  Track read(const std::string& text, TrackReading reading = {}) {
    put(in_folder("x.csv"), text);
    return read_any_track(in_folder("x.csv"), reading);
  }
  std::string complaint(const std::string& text, const TrackReading& reading = {}) {
    const std::string message = complaint_of([&] { read(text, reading); });
    const std::string folder = in_folder("").string();
    return message.substr(message.starts_with(folder) ? folder.size() : 0);
  }
  /// One line a frame.
  std::string lines(const std::function<std::string(int)>& line) const {
    std::string text;
    for (int k = 0; k < kFrames; ++k) text += line(k) + "\n";
    return text;
  }
  /// Time and place of the part, in a format.
  std::string table(const std::string& header, const std::string& format, double second = 1, double mm = 1,
                    bool decimal_comma = false) const {
    return header + lines([&](int k) {
             std::string line = fmt::format(fmt::runtime(format), second * k / kRate, mm * motion.part[k].x(),
                                            mm * motion.part[k].y());
             if (decimal_comma) std::ranges::replace(line, '.', ',');
             return line;
           });
  }
  std::string plain() const { return table("t_s,x_mm,y_mm\n", "{},{},{}"); }
  static fit::Displacement moved(const Track& file) {
    return fit::measure_displacement(file.table, {62.8, 0}, 10);
  }
  const Motion motion;
};

void expect_same(const fit::Displacement& a, const fit::Displacement& b, double tolerance) {
  EXPECT_NEAR(a.vector.x(), b.vector.x(), tolerance);
  EXPECT_NEAR(a.vector.y(), b.vector.y(), tolerance);
}

TEST_F(ForeignTracks, APlainTableInEveryUnit) {
  const Track mm = read(plain());
  EXPECT_EQ(mm.table.time.size(), static_cast<std::size_t>(kFrames));
  EXPECT_FALSE(mm.table.platform_frame);
  EXPECT_TRUE(mm.in_camera_frame);
  EXPECT_THAT(mm.imported, HasSubstr("y up"));
  const fit::Displacement moved_mm = moved(mm);
  EXPECT_NEAR(moved_mm.vector.x(), 3e-3 * moved_mm.duration, 1e-5);
  EXPECT_NEAR(moved_mm.vector.y(), -2e-3 * moved_mm.duration, 1e-5);
  const Track metres = read(table("time (ms);x [m];y [m]\n", "{};{};{}", 1e3, 1e-3, true));
  expect_same(moved(metres), moved_mm, 1e-12);
}

TEST_F(ForeignTracks, DICeTellsASubsetsDisplacementWithItsSd) {
  TrackReading in_px;
  in_px.mm_per_px = kScale;
  in_px.frame_rate_hz = kRate;
  const Track dice =
      read("FRAME,COORDINATE_X,COORDINATE_Y,DISPLACEMENT_X,DISPLACEMENT_Y,ROTATION_Z,SIGMA,GAMMA,BETA\n" +
               lines([&](int k) {
                 const Eigen::Vector2d p = motion.part[k] / kScale;
                 return fmt::format("{},3.44E+02,2.12E+02,{},{},0,{},0,0", 4870 + k, 100 + p.x(), 80 - p.y(),
                                    k == 7 ? -1 : 0.004);
               }),
           in_px);
  EXPECT_THAT(dice.imported, HasSubstr("DICe"));
  EXPECT_EQ(dice.lost, 1u);
  EXPECT_FALSE(dice.sd_from_scatter);
  EXPECT_NEAR(std::sqrt(dice.table.covariance[5](1, 1)), 0.004 * kScale * 1e-3, 1e-12);
  expect_same(moved(dice), moved(read(plain())), 1e-11);
}

TEST_F(ForeignTracks, AMarkTakesThePlatformsMotionOut) {
  const auto both = [&](const std::string& header) {
    return header + lines([&](int k) {
             return fmt::format("{},{},{},{},{}", k / kRate, motion.part[k].x(), motion.part[k].y(),
                                motion.mark[k].x(), motion.mark[k].y());
           });
  };
  const Track file = read(both("t_s,x_mm,y_mm,marker_x_mm,marker_y_mm\n"));
  EXPECT_TRUE(file.table.platform_frame);
  const auto platform = fit::measure_platform_motion(file.table);
  ASSERT_TRUE(platform);
  EXPECT_NEAR(platform->amplitude.value, 0.28e-3, 4 * platform->amplitude.sd);
  EXPECT_NEAR(platform->angular_frequency.value, 62.8, 4 * platform->angular_frequency.sd);
  EXPECT_TRUE(platform->clockwise);
  // Whole cycles of platform motion cancel in the camera's frame.
  expect_same(moved(file), moved(read(plain())), 4e-6);
  // By name, and of several particles.
  const TrackReading named = in_unit("mm", "mass A", "Mark_1");
  const Track multi = read("#multi:\n,mass A,,Mark 1,\n" + both("t,x,y,x,y\n"), named);
  EXPECT_TRUE(multi.table.platform_frame);
  expect_same(moved(multi), moved(file), 1e-11);
  TrackReading px = in_unit("", "3", "8");
  px.mm_per_px = kScale;
  px.frame_rate_hz = kRate;
  std::string particles = "frame,x,y,particle\n";
  for (int k = 0; k < kFrames; ++k) {
    const Eigen::Vector2d p = motion.part[k] / kScale, m = motion.mark[k] / kScale;
    particles += fmt::format("{0},{1},{2},3\n{0},{3},{4},8\n", k, p.x(), -p.y(), m.x(), -m.y());
  }
  const Track trackpy = read(particles, px);
  EXPECT_TRUE(trackpy.table.platform_frame);
  expect_same(moved(trackpy), moved(file), 1e-11);
  const auto in_px = fit::measure_platform_motion(trackpy.table);
  ASSERT_TRUE(in_px);
  EXPECT_NEAR(in_px->amplitude.value, platform->amplitude.value, 1e-9);
  EXPECT_NEAR(in_px->phase_at_zero.value, platform->phase_at_zero.value, 1e-6);
}

TEST_F(ForeignTracks, PartAndMarkAreTakenInOneUnit) {
  // The part in pixels and in millimetres, the mark in pixels alone.
  TrackReading reading;
  reading.mm_per_px = kScale;
  const Track file = read("t_s,x_px,y_px,marker_x_px,marker_y_px,x_mm,y_mm\n" + lines([&](int k) {
                            const Eigen::Vector2d p = motion.part[k] / kScale, m = motion.mark[k] / kScale;
                            return fmt::format("{},{},{},{},{},0,0", k / kRate, p.x(), -p.y(), m.x(), -m.y());
                          }),
                          reading);
  EXPECT_TRUE(file.table.platform_frame);
  EXPECT_EQ(*file.mm_per_px, kScale);
  expect_same(moved(file), moved(read(plain())), 4e-6);
  // Without a mark a length is taken, which needs no scale.
  expect_same(moved(read(table("t_s,x_px,y_px,x_mm,y_mm\n", "{},0,0,{},{}"))), moved(read(plain())), 1e-12);
}

TEST_F(ForeignTracks, SdsComeFromTheFileOrFromTheScatter) {
  const Track estimated = read(plain());
  EXPECT_TRUE(estimated.sd_from_scatter);
  EXPECT_NEAR(std::sqrt(estimated.table.covariance[5](0, 0)), 1e-6, 0.15e-6);
  const Track given = read(table("t_s,x_mm,y_mm,x_sd_mm,sigma_y_mm\n", "{},{},{},0.002,0.003"));
  EXPECT_FALSE(given.sd_from_scatter);
  EXPECT_NEAR(std::sqrt(given.table.covariance[5](0, 0)), 2e-6, 1e-12);
  EXPECT_NEAR(std::sqrt(given.table.covariance[5](1, 1)), 3e-6, 1e-12);
}

TEST_F(ForeignTracks, WhatIsRoundedErrsByItsRounding) {
  const Track file = read("t_s,x_mm,y_mm\n" + lines([&](int k) {
                            return fmt::format("{},{:.0f}.5,{:.0f}.5", k / kRate, 0.01 * k, -0.01 * k);
                          }));
  EXPECT_NEAR(std::sqrt(file.table.covariance[0](0, 0)), 0.1e-3 / std::sqrt(12.0), 1e-6);
}

TEST_F(ForeignTracks, FramesThatWereLostAreLeftOut) {
  std::string text = "t_s,x_mm,y_mm\n" + lines([&](int k) {
                       if (k == 10) return fmt::format("{},NaN,NaN", k / kRate);
                       if (k == 11) return fmt::format("{},,", k / kRate);
                       return fmt::format("{},{},{}", k / kRate, motion.part[k].x(), motion.part[k].y());
                     });
  const Track file = read(text);
  EXPECT_EQ(file.lost, 2u);
  EXPECT_EQ(file.table.time.size(), static_cast<std::size_t>(kFrames - 2));
}

TEST_F(ForeignTracks, TimesRoundedToMillisecondsGoBackOnTheirGrid) {
  // 240 frames a second, as Kinovea prints them: whole milliseconds.
  const Track file = read(table("Time (ms),x (mm),y (mm)\n", "{:.0f},{},{}", 1e3 * kRate / 240));
  EXPECT_NEAR(*file.frame_rate_hz, 240, 0.02);
  for (int k = 0; k < kFrames; ++k) EXPECT_NEAR(file.table.time[k], k / 240.0, 2e-4);
  EXPECT_EQ(file.table.frame.back(), kFrames - 1);
}

TEST_F(ForeignTracks, AGivenRateBeatsTheTimesOfAFilmPlayedSlowly) {
  const std::string slow = table("t,x,y\n", "{},{},{}", kRate / 30);
  TrackReading reading = in_unit("mm");
  EXPECT_THAT(read(slow, reading).warnings.back(), HasSubstr("at which films are played"));
  reading.frame_rate_hz = kRate;
  const Track file = read(slow, reading);
  EXPECT_EQ(file.warnings.size(), 1u);
  expect_same(moved(file), moved(read(plain())), 1e-11);
}

// By a step's third: as a clock that other work disturbs. Rows 80 to 94 are missing.
TEST_F(ForeignTracks, TimesThatVaryCountFramesForAGivenRate) {
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> off(-0.15, 0.15);
  std::string text = "t_s,x_mm,y_mm\n";
  for (int k = 0; k < kFrames; ++k)
    if (k < 80 || k >= 95)
      text += fmt::format("{},{},{}\n", (k + off(random)) / 30, motion.part[k].x(), motion.part[k].y());
  TrackReading reading;
  reading.frame_rate_hz = kRate;
  const Track file = read(text, reading);
  EXPECT_EQ(file.table.frame[79], 79);
  EXPECT_EQ(file.table.frame[80], 95);
  EXPECT_EQ(file.table.frame.back(), kFrames - 1);
}

TEST_F(ForeignTracks, FramesChooseAStretch) {
  TrackReading reading;
  reading.first_frame = 100;
  reading.last_frame = 250;
  const Track file = read(plain(), reading);
  EXPECT_EQ(file.table.frame.front(), 100);
  EXPECT_EQ(file.table.frame.back(), 250);
  EXPECT_EQ(file.table.position.front(), Eigen::Vector2d(0, 0));
  EXPECT_NEAR(file.table.time.front(), 100 / kRate, 1e-12);
}

TEST_F(ForeignTracks, TheAxisOfTheSensorTurnsIt) {
  TrackReading turned;
  turned.xi_axis_rad = 0.3;
  const fit::Displacement a = moved(read(plain())), b = moved(read(plain(), turned));
  EXPECT_NEAR(std::atan2(b.vector.y(), b.vector.x()), std::atan2(a.vector.y(), a.vector.x()) - 0.3, 1e-9);
}

TEST_F(ForeignTracks, AnImportedTrackIsTheSameToTheLastBit) {
  put(in_folder("x.csv"), plain());
  const Track direct = read_any_track(in_folder("x.csv"), {});
  import_track(in_folder("x.csv"), {}, in_folder("a.csv"));
  const Track back = read_track_file(in_folder("a.csv"));
  EXPECT_EQ(back.table.time, direct.table.time);
  EXPECT_EQ(back.table.position, direct.table.position);
  EXPECT_EQ(back.table.covariance, direct.table.covariance);
  EXPECT_EQ(back.warnings, direct.warnings);
  EXPECT_TRUE(back.in_camera_frame && back.sd_from_scatter);
  // Ours goes through as it is.
  import_track(in_folder("a.csv"), {}, in_folder("b.csv"));
  EXPECT_EQ(content_of(in_folder("a.csv")), content_of(in_folder("b.csv")));
  EXPECT_EQ(content_of(in_folder("a.csv.meta.json")), content_of(in_folder("b.csv.meta.json")));
}

TEST_F(ForeignTracks, WhatIsMissingIsAskedFor) {
  EXPECT_THAT(complaint("t,x,y\n0,1,2\n"), HasSubstr("x.csv:1: does not say in which unit x and y are"));
  EXPECT_THAT(complaint("t_s,x_px,y_px\n0,1,2\n"), HasSubstr("is in pixels; give mm_per_px"));
  TrackReading px;
  px.mm_per_px = 0.1;
  EXPECT_THAT(complaint("pt1_cam1_X,pt1_cam1_Y\n1,2\n", px), HasSubstr("track_y = \"up\" or \"down\""));
  px.y = "down";
  EXPECT_THAT(complaint("pt1_cam1_X,pt1_cam1_Y\n1,2\n2,3\n", px), HasSubstr("has no times; give the rate"));
  px.frame_rate_hz = 100;
  EXPECT_THAT(complaint("pt1_cam1_X,pt1_cam1_Y,pt2_cam1_X,pt2_cam1_Y\n1,2,3,4\n", px),
              HasSubstr("holds 2 points: pt1, pt2; say which is the part, track_point = \"pt1\""));
  px.point = "pt7";
  EXPECT_THAT(complaint("pt1_cam1_X,pt1_cam1_Y\n1,2\n", px),
              HasSubstr("there is no point \"pt7\" (track_point)"));
  EXPECT_THAT(complaint("a,b,c\n1,2,3\n"),
              HasSubstr("x.csv: is not a track: no line above its numbers names an x"));
  EXPECT_THAT(complaint("a,b,c\n"), HasSubstr("t_s, x_mm, y_mm"));
  EXPECT_THAT(complaint("t_s,x_mm,y_mm\n0,1,2\n1,q,2\n"), HasSubstr("x.csv:3:3: `q` is not a number"));
  EXPECT_THAT(complaint("t_s,x_mm,y_mm\n0,1,2\n0,1,2\n"), HasSubstr("x.csv:3: its time does not come after"));
  EXPECT_THAT(complaint("t_s,x_mm,y_mm\n0,1,2\n1,1,2\n"), HasSubstr("too few to estimate them"));
  EXPECT_THAT(
      complaint("t_s,x_mm,y_mm,x_sd_mm,y_sd_mm,marker_x_mm,marker_y_mm\n0,1,2,1,1,3,4\n1,1,2,1,1,3,4\n"),
      HasSubstr("add the columns marker_x_sd_mm and marker_y_sd_mm"));
  EXPECT_THAT(complaint("t_s,x_mm,y_mm\n0,1,2\n"), HasSubstr("fewer than two rows"));
  EXPECT_THAT(complaint("t_s,x_mm,y_mm,x_sd_mm,y_sd_mm\n0,1,2,0,1\n"), HasSubstr("must be greater than 0"));
  EXPECT_THAT(complaint("frame,x_mm,y_mm\n0,1,2\n1.5,1,2\n"), HasSubstr("`1.5` is no frame's number"));
  EXPECT_THAT(complaint("frame,x,y,particle\n0,1,2,1\n0,1,2,1\n", in_unit("mm")), HasSubstr("twice"));
  put(in_folder("d.npy"), std::string("\x93NUMPY\0\1", 8));
  EXPECT_THAT(complaint_of([&] { read_any_track(in_folder("d.npy"), {}); }), HasSubstr("numpy.savetxt"));
  EXPECT_THAT(complaint_of([&] { read_any_track(in_folder("none.csv"), {}); }),
              HasSubstr("there is no such track"));
}

}  // namespace
}  // namespace tribotrack::apps
