#include "vision/tracking/plan_costs.h"

#include <numbers>

#include "vision/tracker.h"

namespace tribotrack::vision {

double PlanCosts::layers(double radius, double windows) const {
  constexpr double kRim = 9;        // px of rim that are visited one by one
  constexpr double kVisit = 2.2;    // three layers instead of one template
  constexpr double kMiddle = 0.05;  // of a pixel's visit, in the disc's even middle
  constexpr double kLearning = 12;  // visits of each pixel of a kept window
  const double side = 2 * radius + 2 * kRim;
  const double rim = 2 * std::numbers::pi * radius * kRim;
  return kVisit * rim + kMiddle * side * side + kLearning * windows * side * side / frames;
}

void predict_savings(std::vector<PlanStage>& plan, double base) {
  double total = base;
  for (const PlanStage& stage : plan)
    if (stage.on) total += stage.cost;
  if (!(total > 0)) return;
  for (PlanStage& stage : plan) stage.predicted_saving = stage.cost / (stage.on ? total : total + stage.cost);
}

}  // namespace tribotrack::vision
