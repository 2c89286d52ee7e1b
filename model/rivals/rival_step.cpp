#include "model/rivals/rival_step.h"

#include "model/equation/lanes.h"

namespace tribotrack::model::internal {
namespace {

struct Rodas {
  static constexpr int kStages = 6;
  static constexpr double kGamma = 0.25;
  static constexpr int kTimeOf[kStages] = {0, 1, 2, 3, 4, 4};
  static constexpr double kByTime[kStages] = {0.25, -0.1043, 0.1035, -0.03620000000000023, 0, 0};
  static constexpr double kA[kStages][5] = {
      {},
      {1.544},
      {0.9466785280815826, 0.2557011698983284},
      {3.314825187068521, 2.896124015972201, 0.9986419139977817},
      {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895},
      {1.221224509226641, 6.019134481288629, 12.53708332932087, -0.687886036105895, 1}};
  static constexpr double kC[kStages][5] = {
      {},
      {-5.6688},
      {-2.430093356833875, -0.2063599157091915},
      {-0.1073529058151375, -9.594562251023355, -20.47028614809616},
      {7.496443313967647, -10.24680431464352, -33.99990352819905, 11.7089089320616},
      {8.083246795921522, -7.981132988064893, -31.52159432874371, 16.31930543123136, -6.058818238834054}};
};

using V = Lanes<kRivalLanes>;

TRIBOTRACK_KERNEL V of(const RivalRow& row) {
  return load<V>(row.lane);
}

/// exp(-z), 0 <= z, to 1e-15: 2^-n exp(-r) with |r| <= ln 2 / 2.
TRIBOTRACK_KERNEL V exp_of_minus(V z) {
  using Bits = decltype(z < z);
  constexpr double kToInteger = 0x1.8p52, kLn2High = 0x1.62e42fefa0000p-1, kLn2Low = 0x1.cf79abc9e3b3ap-40;
  constexpr int kOrder = 13;
  z = z < 700.0 ? z : V{} + 700.0;
  const V shifted = z * 1.4426950408889634 + kToInteger, n = shifted - kToInteger;
  const V r = (z - n * kLn2High) - n * kLn2Low;
  V sum = V{} + 1.0;
  for (int k = kOrder; k > 0; --k) sum = 1.0 - r * sum * (1.0 / k);
  const Bits power = (1023 - ((Bits)shifted - (Bits)(V{} + kToInteger))) << 52;
  return sum * (V)power;
}

struct Taken {
  V value, by_speed, by_time;
};
TRIBOTRACK_KERNEL Taken taken(const RivalFriction& friction, double t, const V& speed, bool fades) {
  const V by_speed = of(friction.by_speed) + t * of(friction.by_speed_time), viscous = of(friction.viscous);
  const V mu = of(friction.level) + t * of(friction.by_time) + by_speed * speed;
  const V by_time = of(friction.by_time) + of(friction.by_speed_time) * speed;
  if (!fades) return {mu + viscous * speed, by_speed + viscous, by_time};
  const V fading = of(friction.fading), z = speed / fading;
  const V more = of(friction.stribeck) * exp_of_minus(z * z);
  return {mu * (1.0 + more) + viscous * speed,
          by_speed * (1.0 + more) - mu * more * 2.0 * z / fading + viscous, by_time * (1.0 + more)};
}

struct Direction {
  V speed, x, y;
};
/// Along the motion, or where the part is about to go.
TRIBOTRACK_KERNEL Direction direction(const V& u_x, const V& u_y, const RivalDrive& drive) {
  const double pull = __builtin_sqrt(drive.x * drive.x + drive.y * drive.y);
  const double x = pull > 0 ? drive.x / pull : 0, y = pull > 0 ? drive.y / pull : 0;
  const V speed = root(u_x * u_x + u_y * u_y), any = speed > 0.0 ? speed : V{} + 1.0;
  return {speed, speed > 0.0 ? u_x / any : V{} + x, speed > 0.0 ? u_y / any : V{} + y};
}

}  // namespace

TRIBOTRACK_CLONES void take_rival_step(const RivalStepInput& in, RivalMotion& to, double& error) {
  const V x = of(in.from.x), y = of(in.from.y), u_x = of(in.from.u_x), u_y = of(in.from.u_y);
  const double h = in.h, gamma = h * Rodas::kGamma;
  bool fades = false;
  for (const double strength : in.friction.stribeck.lane) fades |= strength != 0;

  // The derivative of d - m u/|u| by u is -m' along the motion, -m/|u| across it.
  const Direction at_begin = direction(u_x, u_y, in.drive[0]);
  const Taken begin = taken(in.friction, 0, at_begin.speed, fades);
  const V turning = at_begin.speed > 0.0 ? begin.value / at_begin.speed : V{};
  const V across = 1.0 / (1.0 / gamma + turning), more_along = 1.0 / (1.0 / gamma + begin.by_speed) - across;
  const V by_time_x = in.drive[0].x_rate - begin.by_time * at_begin.x;
  const V by_time_y = in.drive[0].y_rate - begin.by_time * at_begin.y;

  V k_x[Rodas::kStages], k_y[Rodas::kStages], k_ux[Rodas::kStages], k_uy[Rodas::kStages];
  V at_x = x, at_y = y, at_ux = u_x, at_uy = u_y;
#pragma GCC unroll 6
  for (int i = 0; i < Rodas::kStages; ++i) {
    at_x = x, at_y = y, at_ux = u_x, at_uy = u_y;
    V sum_x{}, sum_y{}, sum_ux{}, sum_uy{};
#pragma GCC unroll 6
    for (int j = 0; j < i; ++j) {
      const double a = Rodas::kA[i][j], c = Rodas::kC[i][j] / h;
      at_x += a * k_x[j], at_y += a * k_y[j], at_ux += a * k_ux[j], at_uy += a * k_uy[j];
      sum_x += c * k_x[j], sum_y += c * k_y[j], sum_ux += c * k_ux[j], sum_uy += c * k_uy[j];
    }
    const RivalDrive& drive = in.drive[Rodas::kTimeOf[i]];
    const Direction along = i == 0 ? at_begin : direction(at_ux, at_uy, drive);
    const V m = i == 0 ? begin.value
                       : taken(in.friction, kRivalTimes[Rodas::kTimeOf[i]] * h, along.speed, fades).value;
    const double by_time = h * Rodas::kByTime[i];
    const V right_x = drive.x - m * along.x + sum_ux + by_time * by_time_x;
    const V right_y = drive.y - m * along.y + sum_uy + by_time * by_time_y;
    const V on_it = more_along * (right_x * at_begin.x + right_y * at_begin.y);
    k_ux[i] = across * right_x + on_it * at_begin.x;
    k_uy[i] = across * right_y + on_it * at_begin.y;
    k_x[i] = gamma * (at_ux + sum_x + k_ux[i]);
    k_y[i] = gamma * (at_uy + sum_y + k_uy[i]);
  }

  error = 0;
  constexpr int kLast = Rodas::kStages - 1;
  const V moving = of(in.moving);
  const auto end = [&](const V& before, const V& at, const V& k, double least, RivalRow& row)
      __attribute__((always_inline)) {
    const V next = at + k, size = next > 0.0 ? next : -next, off = k > 0.0 ? k : -k;
    const V share = moving > 0.0 ? off / (least + in.tolerance * size) : V{};
    for (int lane = 0; lane < kRivalLanes; ++lane)
      if (!(share[lane] <= error)) error = share[lane] == share[lane] ? share[lane] : __builtin_inf();
    store(moving > 0.0 ? next : before, row.lane);
  };
  end(x, at_x, k_x[kLast], in.least_position, to.x);
  end(y, at_y, k_y[kLast], in.least_position, to.y);
  end(u_x, at_ux, k_ux[kLast], in.least_speed, to.u_x);
  end(u_y, at_uy, k_uy[kLast], in.least_speed, to.u_y);
}

}  // namespace tribotrack::model::internal
