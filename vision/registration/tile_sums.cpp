// TemplateRegistration, audit: the sums of each tile at the pose found.
#include "vision/registration/registration.h"

namespace tribotrack::vision {

std::vector<TileSums> TemplateRegistration::tile_sums() {
  const std::size_t tiles = places_.size();
  scores_.resize(tiles);
  normals_.resize(tiles);
  tile_kernels().scores(arrays_, static_cast<float>(found_.gain), static_cast<float>(found_.offset), scores_);
  tile_kernels().normals(arrays_, normals_);
  const int n = columns();
  double weight = 0;
  for (const NormalSums& sums : normals_) weight += filled(sums)(3, 3);

  // The kernels' slopes are those of the template, the picture's are gain times as steep.
  Vector slope = Vector::Ones(n);
  slope.head<2>().setConstant(found_.gain);
  if (options_.rotation) slope(4) = found_.gain;
  std::vector<TileSums> out(tiles);
  for (std::size_t t = 0; t < tiles; ++t) {
    const Matrix normal = filled(normals_[t]);
    Vector score = Eigen::Map<const Eigen::Matrix<double, 5, 1>>(scores_[t].data()).head(n);
    // The known force of the template's noise: at the optimum it is what the scores add up to.
    score.head<2>() -= normal(3, 3) / weight * found_.noise_force;
    constexpr double kMiddle = 0.5 * (kTile - 1);
    out[t].place = {pattern_.window.x + places_[t].x + kMiddle - pattern_.centre.x,
                    pattern_.window.y + places_[t].y + kMiddle - pattern_.centre.y};
    out[t].score = slope.cwiseProduct(score) / found_.noise;
    out[t].normal = slope.asDiagonal() * normal * slope.asDiagonal() / found_.noise;
  }
  return out;
}

}  // namespace tribotrack::vision
