#include "apps/simulating/swept_model.h"

#include <fmt/format.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "apps/program/errors.h"
#include "apps/program/progress.h"
#include "model/trajectory.h"

namespace tribotrack::apps {

namespace {

void require_valid(const Sweep& sweep, const Context& context) {
  constexpr std::size_t now_and_then = 4096;
  try {
    for (std::size_t index = 0; index < sweep.count(); ++index) {
      if (index % now_and_then == 0) context.tell("sweep", 0, 2 * static_cast<std::int64_t>(sweep.count()));
      sweep.scenario(index).validate();
    }
  } catch (const model::InvalidParameter& error) {
    std::string axes;
    for (const SweepAxis& axis : sweep.axes())
      axes += fmt::format("{}--over {}", axes.empty() ? "" : " ", axis.text());
    throw InvalidInput(fmt::format("{}: {}", axes, error.what()));
  }
}

template <class Solution>
void put(const std::vector<Solution>& solutions, std::vector<double>& alpha, std::vector<double>& v) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  for (const Solution& solution : solutions) {
    const bool done = solution.status == model::BatchStatus::done;
    alpha.push_back(done ? solution.alpha : none);
    v.push_back(done ? solution.v * 1e3 : none);
  }
}

}  // namespace

SweptModel solve(const Sweep& sweep, const Context& context) {
  require_valid(sweep, context);
  Progress progress("sweep", context.quiet);
  model::BatchOptions options;
  options.steady = true;
  options.threads = threads_to_use(context);
  options.progress = [&](std::size_t done, std::size_t total) {
    progress.update(static_cast<std::int64_t>(done), static_cast<std::int64_t>(total));
    context.tell("sweep", static_cast<std::int64_t>(done), static_cast<std::int64_t>(total));
  };
  const model::BatchOutcome outcome = model::solve_batch(
      sweep.count(), [&sweep](std::size_t index) { return sweep.scenario(index); }, options);
  for (std::size_t k = 0; k < outcome.ends.size(); ++k) {
    const model::BatchStatus status = outcome.ends[k].status;
    if (status == model::BatchStatus::done) continue;
    const std::string& reason = outcome.reasons.at(k);
    if (status == model::BatchStatus::failed) throw std::runtime_error(reason);
    if (status == model::BatchStatus::too_long) throw model::StepLimitExceeded(reason);
    throw model::InvalidParameter(reason);
  }
  SweptModel solved;
  put(outcome.ends, solved.alpha_rad, solved.v_mm_s);
  put(outcome.steady, solved.steady_alpha_rad, solved.steady_v_mm_s);
  solved.summary = outcome.summary;
  return solved;
}

}  // namespace tribotrack::apps
