#include "vision/synthesis/disc.h"

#include <functional>
#include <numbers>

namespace tribotrack::vision {
namespace {

/// exp(-z) I_1(z), by its asymptotic series (Abramowitz and Stegun 9.7.1) where that is exact to 1e-15.
double scaled_bessel_i1(double z) {
  if (z < 40) return std::exp(-z) * std::cyl_bessel_i(1.0, z);
  double term = 1, sum = 1;
  for (int k = 1; k < 20; ++k) {
    term *= -(4.0 - (2 * k - 1) * (2 * k - 1)) / (k * 8 * z);
    sum += term;
    if (std::abs(term) < 1e-16) break;
  }
  return sum / std::sqrt(2 * std::numbers::pi * z);
}

/// Whole numbers in [low, high] and in the row; clamped first, because far-away circles do not fit an int.
PixelSpan pixels_between(double low, double high, int width) {
  PixelSpan span;
  span.first = static_cast<int>(std::ceil(std::clamp(low, 0.0, static_cast<double>(width))));
  span.last = static_cast<int>(std::floor(std::clamp(high, -1.0, width - 1.0)));
  return span;
}

/// Pixels of the row with any part within `radius` of the centre.
PixelSpan pixels_touched(Point centre, double radius, int row, int width) {
  const double dy = std::max(0.0, std::abs(row - centre.y) - 0.5);
  if (dy > radius) return {};
  const double half = std::sqrt(radius * radius - dy * dy) + 0.5;
  return pixels_between(centre.x - half, centre.x + half, width);
}

/// Pixels of the row that lie within `radius` of the centre with all their corners.
PixelSpan pixels_filled(Point centre, double radius, int row, int width) {
  const double dy = std::abs(row - centre.y) + 0.5;
  if (radius <= 0 || dy > radius) return {};
  const double half = std::sqrt(radius * radius - dy * dy) - 0.5;
  if (half < 0) return {};
  return pixels_between(centre.x - half, centre.x + half, width);
}

}  // namespace

BlurredCircle::BlurredCircle(double radius, double blur) : radius_(radius), blur_(blur) {
  if (!(radius > 0) || !(blur > 0)) return;
  constexpr int cells_per_blur = 24;
  first_ = std::max(0.0, radius - reach());
  const auto cells =
      static_cast<std::size_t>(std::ceil((radius + reach() - first_) / blur * cells_per_blur)) + 1;
  const double width = blur / cells_per_blur;
  cells_per_pixel_ = 1 / width;
  const double variance = blur * blur;
  const auto fall = [&](double rho) {
    const double apart = (radius - rho) / blur;
    return radius / variance * std::exp(-0.5 * apart * apart) * scaled_bessel_i1(rho * radius / variance);
  };
  const QuadratureRule rule = gauss_legendre(5);
  table_.resize(cells + 1);
  // From outside inwards; what lies beyond the table is its tail, less than reach() promises.
  double value = 0;
  for (std::size_t k = cells + 1; k-- > 0;) {
    const double rho = first_ + static_cast<double>(k) * width;
    if (k < cells)
      for (std::size_t i = 0; i < rule.nodes.size(); ++i)
        value += width * rule.weights[i] * fall(rho + (0.5 + rule.nodes[i]) * width);
    table_[k] = {value, -fall(rho) * width};
  }
}

RowBand row_band(const BlurredCircle& circle, std::span<const Point> centres, int row, int width) {
  RowBand band{{width, -1}, {0, width - 1}};
  for (const Point& centre : centres) {
    const PixelSpan touched = pixels_touched(centre, circle.radius() + circle.reach(), row, width);
    if (!touched.empty()) {
      band.touched.first = std::min(band.touched.first, touched.first);
      band.touched.last = std::max(band.touched.last, touched.last);
    }
    const PixelSpan filled = pixels_filled(centre, circle.radius() - circle.reach(), row, width);
    if (filled.empty()) {
      band.filled = {};
    } else {
      band.filled.first = std::max(band.filled.first, filled.first);
      band.filled.last = std::min(band.filled.last, filled.last);
    }
  }
  return band;
}

namespace {

constexpr double kReach = 4.5;       // scratch blurs beyond which nothing of a scratch is left
constexpr double kCorner = 0.75;     // and from a pixel's centre to its corner, px
constexpr double kTolerance = 2e-5;  // of the contrast
constexpr double kSqrt2 = std::numbers::sqrt2;

/// Distance of the farther end from the disc's centre.
double scratch_extent(const DiscLayer::Scratch& s) {
  const double x = s.half_length * s.cosine;
  const double y = s.half_length * s.sine;
  return std::max(std::hypot(s.u + x, s.v + y), std::hypot(s.u - x, s.v - y));
}

}  // namespace

DiscLayer::DiscLayer(const DiscAppearance& disc, std::uint64_t seed)
    : edge_{disc.radius_px, disc.edge_blur_px},
      level_(disc.level),
      highlight_(disc.highlight),
      highlight_offset_(-0.35 * disc.radius_px),
      highlight_width_(0.45 * disc.radius_px),
      scratch_blur_(std::max(disc.edge_blur_px, 0.02 * disc.radius_px)),
      point_(gauss_legendre(1)),
      pixel_(gauss_legendre(gauss_points_for_edge(scratch_blur_, kTolerance))) {
  const CounterRandom random(seed, 0xd15cu);
  for (int j = 0; j < disc.scratches; ++j) {
    const double distance = 0.75 * disc.radius_px * std::sqrt(random.uniform(4 * j));
    const double bearing = 2 * std::numbers::pi * random.uniform(4 * j + 1);
    const double direction = std::numbers::pi * random.uniform(4 * j + 2);
    Scratch scratch;
    scratch.u = distance * std::cos(bearing);
    scratch.v = distance * std::sin(bearing);
    scratch.cosine = std::cos(direction);
    scratch.sine = std::sin(direction);
    scratch.half_length = disc.radius_px * (0.1 + 0.25 * random.uniform(4 * j + 3));
    scratch.contrast = (j % 2 == 0 ? 1 : -1) * disc.scratch_contrast;
    scratch.outermost = scratch_extent(scratch) + kReach * scratch_blur_;
    scratches_.push_back(scratch);
  }
  std::ranges::sort(scratches_, std::greater{}, &Scratch::outermost);
}

double DiscLayer::scratch_profile(const Scratch& scratch, double along, double across) const {
  const double reach = kReach * scratch_blur_;
  if (std::abs(across) > reach || std::abs(along) > scratch.half_length + reach) return 0;
  const double z = across / scratch_blur_;
  double profile = std::exp(-0.5 * z * z);
  if (std::abs(along) > scratch.half_length - reach) {
    const double scale = 1 / (kSqrt2 * scratch_blur_);
    profile *= 0.5 * (std::erf((along + scratch.half_length) * scale) -
                      std::erf((along - scratch.half_length) * scale));
  }
  return profile;
}

double DiscLayer::mean_scratch(const Scratch& scratch, Point from_centre, double cosine, double sine,
                               const QuadratureRule& rule) const {
  const double du = cosine * from_centre.x - sine * from_centre.y - scratch.u;
  const double dv = -sine * from_centre.x - cosine * from_centre.y - scratch.v;
  const double along = scratch.cosine * du + scratch.sine * dv;
  const double across = scratch.cosine * dv - scratch.sine * du;
  if (std::abs(across) > kReach * scratch_blur_ + kCorner) return 0;
  // The scratch's direction in the picture.
  const double ex = scratch.cosine * cosine - scratch.sine * sine;
  const double ey = -(scratch.sine * cosine + scratch.cosine * sine);
  double mean = 0;
  for (std::size_t j = 0; j < rule.nodes.size(); ++j)
    for (std::size_t i = 0; i < rule.nodes.size(); ++i)
      mean += rule.weights[i] * rule.weights[j] *
              scratch_profile(scratch, along + ex * rule.nodes[i] + ey * rule.nodes[j],
                              across + ey * rule.nodes[i] - ex * rule.nodes[j]);
  return mean;
}

double DiscLayer::mean_scratches(Point from_centre, double cosine, double sine,
                                 const QuadratureRule& rule) const {
  const double distance = std::hypot(from_centre.x, from_centre.y);
  double sum = 0;
  for (const Scratch& scratch : scratches_) {
    if (distance > scratch.outermost + kCorner) break;  // nor do the others reach so far
    sum += scratch.contrast * mean_scratch(scratch, from_centre, cosine, sine, rule);
  }
  return sum;
}

double DiscLayer::mean_lobe(double from_centre, const QuadratureRule& rule) const {
  double mean = 0;
  for (std::size_t i = 0; i < rule.nodes.size(); ++i) {
    const double z = (from_centre + rule.nodes[i] - highlight_offset_) / highlight_width_;
    mean += rule.weights[i] * std::exp(-0.5 * z * z);
  }
  return mean;
}

double DiscLayer::colour(double dx, double dy, double cosine, double sine) const {
  const double lobe = highlight_ != 0 ? mean_lobe(dx, point_) * mean_lobe(dy, point_) : 0;
  return level_ + highlight_ * lobe + mean_scratches({dx, dy}, cosine, sine, point_);
}

void DiscLayer::render_interior(std::span<const ExposureNode> nodes, std::span<const PixelSpan> filled,
                                Picture& picture) const {
  for (int y = 0; y < picture.height(); ++y)
    for (int x = filled[y].first; x <= filled[y].last; ++x) picture.at(x, y) = 0;
  std::vector<double> lobe(static_cast<std::size_t>(picture.width()));
  for (const auto& [weight, pose] : nodes) {
    const double cosine = std::cos(pose.theta), sine = std::sin(pose.theta);
    for (int x = 0; x < picture.width(); ++x)
      lobe[static_cast<std::size_t>(x)] = highlight_ * mean_lobe(x - pose.disc.x, pixel_);
    for (int y = 0; y < picture.height(); ++y) {
      if (filled[y].empty()) continue;
      const double lobe_of_row = mean_lobe(y - pose.disc.y, pixel_);
      for (int x = filled[y].first; x <= filled[y].last; ++x)
        picture.at(x, y) += static_cast<float>(
            weight * (level_ + lobe[static_cast<std::size_t>(x)] * lobe_of_row +
                      mean_scratches({x - pose.disc.x, y - pose.disc.y}, cosine, sine, pixel_)));
    }
  }
}

}  // namespace tribotrack::vision
