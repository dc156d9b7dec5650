// A loop of one's own around conddp::Mpc: a motor brings a pendulum upright and holds it there. The
// real pendulum is heavier than the model's. Once its windows have been used the loop allocates
// nothing any more.
//
// usage: balance [TICKS]     200 by default
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "conddp/conddp.hpp"

using namespace conddp;

namespace {

/// x = (θ, ω), θ = 0 where it hangs; u = torque of the motor, Nm.
class Pendulum : public ClosedFormSystem<Pendulum> {
 public:
  explicit Pendulum(double mass)
      : ClosedFormSystem(SystemKind::second_order, StateManifold::flat(2), 1), mass_(mass) {
    state_columns_ = {{"theta", "rad"}, {"omega", "rad/s"}};
    control_columns_ = {{"torque", "Nm"}};
  }

  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    f[0] = u[0] / S(mass_ * kLength * kLength) - S(kGravity / kLength) * sin(x[0]);
  }

  static constexpr double kLength = 0.5, kGravity = 9.81;  // m, m/s²

 private:
  double mass_;  ///< kg
};

constexpr double kTick = 0.02;  // s

std::shared_ptr<const ShootingProblem> upright_problem() {
  const auto pendulum = std::make_shared<const Pendulum>(/*mass*/ 1);
  const auto moving = std::make_shared<KnotModel>(pendulum, Integrator::rk4);
  moving->add_cost("angle", coordinate_residual(pendulum->manifold(), {0}), {});
  moving->add_cost("speed", coordinate_residual(pendulum->manifold(), {1}), {});
  moving->add_cost("torque", control_residual(moving->ndx(), moving->nu()), {});
  moving->set_control_bounds({-8}, {8});
  const auto end = std::make_shared<KnotModel>(pendulum, Integrator::none);

  // One knot is enough: the loop repeats it for ever (MpcOptions::hold). Of each cost its
  // reference, then its weight.
  const Phase upright{.name = "upright",
                      .model = moving,
                      .dt = {0.05},
                      .cost_scale = {0.05},
                      .parameters = {M_PI, 10, /**/ 0, 0.1, /**/ 0, 0.1}};
  const Phase nothing{.name = "end", .model = end, .dt = {0}, .cost_scale = {1}};
  return std::make_shared<const ShootingProblem>(
      ShootingProblem({M_PI - 1, 0}, {upright}, nothing));
}

/// What the torque does to the real pendulum during a tick: the midpoint rule in small steps.
void move(const Pendulum& pendulum, double torque, std::array<double, 2>& x) {
  constexpr int kParts = 10;
  const double h = kTick / kParts;
  for (int part = 0; part < kParts; ++part) {
    double a = 0;
    pendulum.rate(x.data(), &torque, &a);
    const std::array<double, 2> middle = {x[0] + h / 2 * x[1], x[1] + h / 2 * a};
    pendulum.rate(middle.data(), &torque, &a);
    x = {x[0] + h * middle[1], x[1] + h * a};
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int ticks = argc > 1 ? std::atoi(argv[1]) : 200;
  const Pendulum real(/*mass*/ 1.2);
  const auto problem = upright_problem();
  Mpc mpc(problem, problem->create_trajectory(),
          {.horizon = 1, .tick = kTick, .solver = "box_fddp"});
  mpc.reserve(ticks * kTick);
  std::array<double, 2> x = {problem->initial_state()[0], problem->initial_state()[1]};
  for (int tick = 0; tick < ticks; ++tick) {
    mpc.prepare();                             // all that needs no measurement
    const double torque = mpc.feedback(x)[0];  // from the measured state
    if (mpc.last_tick().outcome != TickOutcome::planned) {
      std::printf("tick %d: no plan\n", tick);
      return 1;
    }
    if (tick % 20 == 0)
      std::printf("%4.1f s: %6.3f rad, torque %6.3f Nm\n", tick * kTick, x[0], torque);
    move(real, torque, x);
  }
  std::printf("ends %.4f rad from upright\n", std::abs(x[0] - M_PI));
  return 0;
}
