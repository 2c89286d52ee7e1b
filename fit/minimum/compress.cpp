#include "fit/minimum/compress.h"

#include <algorithm>
#include <utility>
#include <vector>

#include "fit/tools/dense.h"

namespace tribotrack::fit::internal {
namespace {

constexpr Eigen::Index kBlock = 512;  ///< rows: their used columns lie in the cache

/// Of each block, at most.
Eigen::Index kept_of(Eigen::Index columns) {
  return std::min(kBlock, columns + 1);
}

}  // namespace

Eigen::Index compressed_rows(Eigen::Index rows, Eigen::Index columns) {
  return rows <= kBlock ? rows : (rows + kBlock - 1) / kBlock * kept_of(columns);
}

Rows compress(const Eigen::MatrixXd& jacobian, const Eigen::VectorXd& residuals) {
  const Eigen::Index rows = jacobian.rows(), columns = jacobian.cols();
  if (rows <= kBlock) return {jacobian, residuals};
  const Eigen::Index all = compressed_rows(rows, columns);
  Rows result{Eigen::MatrixXd::Zero(all, columns), Eigen::VectorXd::Zero(all)};
  for (Eigen::Index first = 0, next = 0; first < rows; first += kBlock, next += kept_of(columns)) {
    const Eigen::Index n = std::min(kBlock, rows - first);
    std::vector<Eigen::Index> used;
    for (Eigen::Index j = 0; j < columns; ++j)
      if (!jacobian.col(j).segment(first, n).isZero(0)) used.push_back(j);
    const auto width = static_cast<Eigen::Index>(used.size());
    Eigen::MatrixXd block(n, width + 1);
    for (Eigen::Index k = 0; k < width; ++k)
      block.col(k) = jacobian.col(used[static_cast<std::size_t>(k)]).segment(first, n);
    block.col(width) = residuals.segment(first, n);
    const Eigen::Index kept = std::min(n, width + 1);
    const Eigen::MatrixXd triangle = triangle_of(std::move(block));
    for (Eigen::Index k = 0; k < width; ++k)
      result.jacobian.col(used[static_cast<std::size_t>(k)]).segment(next, kept) = triangle.col(k);
    result.residuals.segment(next, kept) = triangle.col(width);
  }
  return result;
}

}  // namespace tribotrack::fit::internal
