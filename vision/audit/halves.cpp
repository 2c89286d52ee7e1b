#include "vision/audit/halves.h"

#include <Eigen/Cholesky>
#include <cmath>

namespace tribotrack::vision {
namespace {

/// Of the position's information: a half with less is no judge of the rest.
constexpr double kLeastShare = 0.01;
constexpr double kTileSide = 8;

/// One half against the other, in the units of the position's error.
class Disagreement {
 public:
  Disagreement(std::span<const TileSums> tiles, const TileSums::Matrix& normal,
               const Eigen::Matrix2d& covariance)
      : tiles_(tiles), normal_(normal), factor_(normal), covariance_(covariance) {}

  template <class InHalf>
  std::optional<Eigen::Vector2d> of(const InHalf& in_half) const {
    TileSums::Vector score = TileSums::Vector::Zero(normal_.rows());
    TileSums::Matrix half = TileSums::Matrix::Zero(normal_.rows(), normal_.cols());
    for (const TileSums& tile : tiles_) {
      if (!in_half(tile.place)) continue;
      score += tile.score;
      half += tile.normal;
    }
    const TileSums::Matrix spread = half - half * factor_.solve(half);
    const Eigen::Matrix2d position = spread.topLeftCorner<2, 2>();
    for (Eigen::Index i = 0; i < 2; ++i)
      if (!(position(i, i) > kLeastShare * normal_(i, i))) return std::nullopt;
    const Eigen::LLT<Eigen::Matrix2d> whitening(position), colouring(covariance_);
    if (whitening.info() != Eigen::Success || colouring.info() != Eigen::Success) return std::nullopt;
    const Eigen::Vector2d white = whitening.matrixL().solve(score.head<2>());
    return colouring.matrixL() * white;
  }

 private:
  std::span<const TileSums> tiles_;
  const TileSums::Matrix& normal_;
  Eigen::LDLT<TileSums::Matrix> factor_;
  const Eigen::Matrix2d& covariance_;
};

bool is_left(const Point& place) {
  return place.x < 0;
}

bool is_above(const Point& place) {
  return place.y < 0;
}

bool is_dark(const Point& place) {
  const double parity = std::floor(place.x / kTileSide) + std::floor(place.y / kTileSide);
  return std::fmod(std::abs(parity), 2) == 1;
}

}  // namespace

std::optional<HalvesError> halves_error(std::span<const TileSums> tiles, const TileSums::Matrix& normal,
                                        const Eigen::Matrix2d& covariance) {
  const Disagreement disagreement(tiles, normal, covariance);
  const auto left_right = disagreement.of(is_left);
  const auto top_bottom = disagreement.of(is_above);
  const auto checkerboard = disagreement.of(is_dark);
  if (!left_right || !top_bottom || !checkerboard) return std::nullopt;
  return HalvesError{*left_right, *top_bottom, *checkerboard};
}

std::optional<HalvesError> halves_error(std::span<const TileSums> tiles, const TileSums::Matrix& normal) {
  const Eigen::LDLT<TileSums::Matrix> factor(normal);
  if (factor.info() != Eigen::Success || !factor.isPositive()) return std::nullopt;
  const TileSums::Matrix inverse = factor.solve(TileSums::Matrix::Identity(normal.rows(), normal.cols()));
  return halves_error(tiles, normal, inverse.topLeftCorner<2, 2>());
}

}  // namespace tribotrack::vision
