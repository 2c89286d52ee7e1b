// SUNDIALS' CVODE on eq. (5): variable-order Adams and BDF.
#include <cvode/cvode.h>
#include <nvector/nvector_serial.h>
#include <sunlinsol/sunlinsol_dense.h>
#include <sunmatrix/sunmatrix_dense.h>
#include <sunnonlinsol/sunnonlinsol_fixedpoint.h>

#include <stdexcept>

#include "apps/bench/equation.h"

namespace tribotrack::bench {

using namespace model;

namespace {

using Equation = PlainEquation<double>;
using State = Equation::State;

struct Slope {
  const Equation* f;
  double m = 0;
};

int right_hand_side(double t, N_Vector q, N_Vector dqdt, void* user) {
  const Slope& slope = *static_cast<const Slope*>(user);
  const double* in = N_VGetArrayPointer(q);
  const State d = slope.f->slope(t, {in[0], in[1], in[2], in[3]}, slope.m, true);
  std::copy(d.begin(), d.end(), N_VGetArrayPointer(dqdt));
  return 0;
}

void ignore_messages(int, const char*, const char*, char*, void*) {}

/// CVODE's objects, freed together.
class Cvode {
 public:
  Cvode(int method, const Scenario& scenario, double tolerance, long max_steps, Slope& slope) {
    if (SUNContext_Create(nullptr, &context_) != 0) throw std::runtime_error("SUNDIALS: no context");
    q_ = N_VNew_Serial(4, context_);
    absolute_ = N_VNew_Serial(4, context_);
    const Scales scales(scenario);
    double* a = N_VGetArrayPointer(absolute_);
    a[0] = a[1] = tolerance * scales.length;
    a[2] = a[3] = tolerance * scales.speed;
    memory_ = CVodeCreate(method, context_);
    CVodeInit(memory_, right_hand_side, 0, q_);
    CVodeSetErrHandlerFn(memory_, ignore_messages, nullptr);
    CVodeSVtolerances(memory_, tolerance, absolute_);
    CVodeSetUserData(memory_, &slope);
    CVodeSetMaxNumSteps(memory_, max_steps);
    if (method == CV_ADAMS) {
      nonlinear_ = SUNNonlinSol_FixedPoint(q_, 0, context_);
      CVodeSetNonlinearSolver(memory_, nonlinear_);
    } else {
      matrix_ = SUNDenseMatrix(4, 4, context_);
      linear_ = SUNLinSol_Dense(q_, matrix_, context_);
      CVodeSetLinearSolver(memory_, linear_, matrix_);
    }
  }
  Cvode(const Cvode&) = delete;
  Cvode& operator=(const Cvode&) = delete;
  ~Cvode() {
    CVodeFree(&memory_);
    if (nonlinear_) SUNNonlinSolFree(nonlinear_);
    if (linear_) SUNLinSolFree(linear_);
    if (matrix_) SUNMatDestroy(matrix_);
    N_VDestroy(absolute_);
    N_VDestroy(q_);
    SUNContext_Free(&context_);
  }

  void begin(const Progress<double>& p) {
    std::copy(p.q.begin(), p.q.end(), N_VGetArrayPointer(q_));
    CVodeReInit(memory_, p.t, q_);
  }
  /// Steps until `until` or until stopped() says so.
  template <class Stopped>
  void step_to(double until, Progress<double>& p, Stopped&& stopped) {
    CVodeSetStopTime(memory_, until);
    while (p.t < until && p.within_budget()) {
      const State before = p.q;
      double t = p.t;
      const int flag = CVode(memory_, until, q_, &t, CV_ONE_STEP);
      ++p.steps;
      if (flag < 0) {
        p.steps = p.max_steps;  // given up
        return;
      }
      p.t = t;
      const double* q = N_VGetArrayPointer(q_);
      std::copy(q, q + 4, p.q.begin());
      if (stopped(before)) return;
    }
  }

 private:
  SUNContext context_ = nullptr;
  N_Vector q_ = nullptr, absolute_ = nullptr;
  void* memory_ = nullptr;
  SUNNonlinearSolver nonlinear_ = nullptr;
  SUNMatrix matrix_ = nullptr;
  SUNLinearSolver linear_ = nullptr;
};

PeerResult solve(int method, const Scenario& scenario, double tolerance, long max_steps) {
  const Equation f(scenario);
  Slope slope{&f};
  Cvode cvode(method, scenario, tolerance, max_steps, slope);
  const double small = stop_speed(Scales(scenario), tolerance);
  return run_in_segments(f, Progress<double>(scenario, max_steps), [&](auto& at, double until, double m) {
    slope.m = m;
    cvode.begin(at);
    cvode.step_to(until, at, [&](const State& before) { return stops(f, before, m, small, at); });
  });
}

}  // namespace

std::vector<BenchPeer> cvode_peers() {
  const auto peer = [](int method) {
    return [method](const Scenario& s, double tolerance, long max_steps) {
      return solve(method, s, tolerance, max_steps);
    };
  };
  return {{"CVODE Adams", peer(CV_ADAMS)}, {"CVODE BDF", peer(CV_BDF)}};
}

}  // namespace tribotrack::bench
