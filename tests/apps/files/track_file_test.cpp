#include "apps/files/track_file.h"

#include <gmock/gmock.h>

#include <Eigen/Geometry>
#include <bit>
#include <cmath>
#include <random>

#include "apps/files/run_folder.h"
#include "apps/program.h"

namespace tribotrack::apps {
namespace {

using ::testing::HasSubstr;

class TrackFiles : public ProgramTest {
 protected:
  Track read(const std::string& csv, const std::string& meta = "") {
    put(in_folder("t.csv"), csv);
    if (!meta.empty()) put(in_folder("t.csv.meta.json"), meta);
    return read_track_file(in_folder("t.csv"));
  }
  std::string complaint(const std::string& csv, const std::string& meta = "") {
    return complaint_of([&] { read(csv, meta); });
  }
};

const std::string kHeader =
    "frame,time_s,x_px,y_px,sigma_x_px,sigma_y_px,rho_xy,ncc,status,x_mm,y_mm,sigma_x_mm,sigma_y_mm\n";

vision::Track noisy_track(bool marker) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  vision::Track track;
  track.has_marker = marker;
  track.has_gate = true;
  track.has_rotation = marker;
  for (int k = 0; k < 200; ++k) {
    vision::TrackPoint p;
    p.frame = k - 17;
    p.time_s = k / 997.0;
    p.status = k % 19 == 0 ? vision::TrackStatus::lost : vision::TrackStatus::ok;
    p.x = 300 + 20 * normal(random);
    p.y = 200 + 20 * normal(random);
    p.sigma_x = 0.01 * std::abs(normal(random)) + 1e-3;
    p.sigma_y = 0.01 * std::abs(normal(random)) + 1e-3;
    p.rho_xy = 0.1 * normal(random);
    p.ncc = 0.99;
    if (marker) p.marker = vision::MarkerPoint{normal(random), normal(random), 0.003, 0.98};
    if (marker && k % 7) p.rotation = vision::Rotation{0.01 * k + 0.001 * normal(random), 0.002};
    p.gate = 100 + normal(random);
    track.points.push_back(p);
  }
  return track;
}

// What is fitted from memory and what is fitted from the files must be the same, bit for bit.
TEST_F(TrackFiles, RowsInMemoryAreTheRowsReadBack) {
  const auto bits = [](double x) { return std::isnan(x) ? 0 : std::bit_cast<std::uint64_t>(x); };
  for (const bool marker : {false, true})
    for (const bool parallax : {false, true}) {
      const vision::PlaneGeometry geometry(
          vision::given_scale(0.0213, 1e-5), vision::ScalePlane::platform,
          parallax ? std::optional<vision::Parallax>({0.8, 100}) : std::nullopt);
      const TrackRows rows = track_rows(noisy_track(marker), geometry, 0.123);
      const TrackRows back = read_track_rows("t.csv", track_csv(rows));
      EXPECT_EQ(back.has_planes, parallax);
      EXPECT_EQ(back.has_rotation, marker);
      const Columns written = columns_of(rows), read = columns_of(back);
      ASSERT_EQ(read.size(), written.size());
      for (std::size_t k = 0; k < written.size(); ++k) {
        EXPECT_EQ(read[k].first, written[k].first);
        if (const auto* numbers = std::get_if<std::vector<double>>(&written[k].second))
          EXPECT_TRUE(
              std::ranges::equal(std::get<std::vector<double>>(read[k].second), *numbers, {}, bits, bits))
              << written[k].first;
        else
          EXPECT_EQ(read[k].second, written[k].second);
      }
    }
}

// mm = s R(-xi) diag(1, -1) px, so C_mm = s^2 R F C_px F R^T; a marker's own noise is added along both axes.
TEST_F(TrackFiles, CovariancesAreThoseOfThePixelsTurned) {
  const double s = 0.02, xi = 0.3;
  const Track file = read(
      "frame,time_s,x_px,y_px,sigma_x_px,sigma_y_px,rho_xy,ncc,status,x_mm,y_mm,sigma_x_mm,sigma_y_mm,"
      "marker_x_px,marker_y_px,marker_sigma_px,marker_ncc\n"
      "0,0,10,20,0.3,0.4,0.5,1,ok,1,2,0.1,0.1,3,4,0.2,1\n",
      "{\"scale\": {\"mm_per_px\": 0.02, \"mm_per_px_sd\": 0}, \"configuration\": {\"xi_axis_rad\": 0.3}}");
  Eigen::Matrix2d px;
  px << 0.09, 0.06, 0.06, 0.16;
  const Eigen::Matrix2d turn =
      Eigen::Rotation2Dd(-xi).toRotationMatrix() * Eigen::Vector2d(1, -1).asDiagonal();
  const Eigen::Matrix2d expected =
      1e-6 * s * s * (turn * px * turn.transpose() + 0.04 * Eigen::Matrix2d::Identity());
  ASSERT_EQ(file.table.covariance.size(), 1u);
  EXPECT_TRUE(file.table.covariance[0].isApprox(expected, 1e-12)) << file.table.covariance[0];
  EXPECT_TRUE(file.table.marker[0].isApprox(1e-3 * s * turn * Eigen::Vector2d(3, 4), 1e-12));
}

// Slow errors are part of a point's standard deviations: in the fit's table they stand in metres beside them.
TEST_F(TrackFiles, SlowErrorsComeBackFromTheMetaFile) {
  const std::vector<vision::SlowPart> slow{{"pictures", 0.003, 0.04}, {"coder", 0.01 / 3, 0.2}};
  Json meta = {{"slow_errors", json_of(slow)}, {"summary", {{"slow_sd_px", 5}, {"slow_time_s", 6}}}};
  const Track track = track_described_by(meta, "t.csv.meta.json");
  ASSERT_EQ(track.slow.size(), 2u);
  EXPECT_EQ(json_of(track.slow), meta.at("slow_errors"));
  EXPECT_EQ(track.slow[1].sd, slow[1].sd);

  const std::string row = "0,0,1,2,0.1,0.1,0,1,ok,1,2,0.1,0.1\n";
  meta["scale"] = {{"mm_per_px", 0.02}};
  const fit::TrackTable table = read(kHeader + row, meta.dump()).table;
  ASSERT_EQ(table.slow.size(), 2u);
  EXPECT_NEAR(table.slow[0].sd, 0.003 * 0.02e-3, 1e-20);
  EXPECT_EQ(table.slow[0].time, 0.04);
  EXPECT_NEAR(table.covariance[0](0, 0), std::pow(0.1 * 0.02e-3, 2), 1e-24);

  meta["slow_errors"] = {{{"from", "halves"}, {"sd_px", "much"}}};
  EXPECT_THROW(track_described_by(meta, "t.csv.meta.json"), InvalidInput);
}

TEST_F(TrackFiles, AnglesAreReadWhereTheyAre) {
  const std::string with = "frame,time_s,status,x_mm,y_mm,sigma_x_mm,sigma_y_mm,theta_rad,sigma_theta_rad\n";
  const Track track = read(with + "0,0,ok,1,2,0.1,0.1,0.5,0.01\n1,0.1,ok,1,2,0.1,0.1,,\n2,0.2,lost,,,,,,\n",
                           R"({"scale": {"mm_per_px": 0.5}, "summary": {"disc_px": [10, 10, 8]}})");
  ASSERT_EQ(track.table.angle.size(), 2u);
  EXPECT_EQ(track.table.angle[0], 0.5);
  EXPECT_EQ(track.table.angle_sigma[0], 0.01);
  EXPECT_TRUE(std::isnan(track.table.angle[1]));
  EXPECT_DOUBLE_EQ(track.table.radius, 4e-3);
  EXPECT_TRUE(
      read("frame,time_s,status,x_mm,y_mm,sigma_x_mm,sigma_y_mm\n0,0,ok,1,2,0.1,0.1\n").table.angle.empty());
  EXPECT_THAT(
      complaint("frame,time_s,status,x_mm,y_mm,sigma_x_mm,sigma_y_mm,theta_rad\n0,0,ok,1,2,0.1,0.1,1\n"),
      HasSubstr("sigma_theta_rad"));
  EXPECT_THAT(complaint(with + "7,0,ok,1,2,0.1,0.1,0.5,\n"), HasSubstr("frame 7 has theta_rad"));
}

}  // namespace
}  // namespace tribotrack::apps
