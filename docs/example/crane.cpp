// Repeated solves of a crane: a cart moves a load that hangs from it over a point. System
// and residual are of this program. After the first solve nothing is allocated any more.
//
// usage: crane [SOLVES]     10 by default
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <memory>
#include <vector>

#include "conddp/conddp.hpp"

using namespace conddp;

namespace {

/// x = (s, φ, ṡ, φ̇): position of the cart, angle of the cable (0: hanging). u = force on the cart.
class Crane : public ClosedFormSystem<Crane> {
 public:
  explicit Crane(double load_mass)
      : ClosedFormSystem(SystemKind::second_order, StateManifold::flat(4), 1),
        load_mass_(load_mass) {
    state_columns_ = {{"s", "m"}, {"phi", "rad"}, {"s_rate", "m/s"}, {"phi_rate", "rad/s"}};
    control_columns_ = {{"force", "N"}};
  }

  /// Accelerations (s̈, φ̈), from the equations of motion of a point mass on a cable.
  template <class S>
  void rate(const S* x, const S* u, S* f) const {
    const S sine = sin(x[1]), cosine = cos(x[1]), m = S(load_mass_), l = S(kCable);
    f[0] = (u[0] + m * sine * (l * x[3] * x[3] + S(kGravity) * cosine)) /
           (S(kCartMass) + m * sine * sine);
    f[1] = -(f[0] * cosine + S(kGravity) * sine) / l;
  }

  static constexpr double kCable = 1, kCartMass = 2, kGravity = 9.81;  // m, kg, m/s²

 private:
  double load_mass_;  ///< kg
};

/// Where the load is, minus a reference: horizontally, and in height above the cart, m.
class LoadPosition : public ResidualBase<LoadPosition> {
 public:
  LoadPosition() : ResidualBase({{.rows = 2, .columns = {0, 1}}}, /*parameters*/ 2, false) {}

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    r[0] = in.x[0] + S(Crane::kCable) * sin(in.x[1]) - in.parameters[0];
    r[1] = -S(Crane::kCable) * cos(in.x[1]) - in.parameters[1];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    jacobian[0] = S(1.0);  // by s
    jacobian[1] = S(0.0);
    jacobian[2] = S(Crane::kCable) * cos(in.x[1]);  // by φ
    jacobian[3] = S(Crane::kCable) * sin(in.x[1]);
  }
};

constexpr int kKnots = 30;
constexpr double kStep = 0.1;  // s
constexpr double kGoal = 1;    // m

ShootingProblem crane_problem() {
  const auto crane = std::make_shared<const Crane>(/*load_mass*/ 1);
  const auto moving = std::make_shared<KnotModel>(crane, Integrator::rk4);
  moving->add_cost("load", std::make_shared<const LoadPosition>(), {});
  moving->add_cost("force", control_residual(moving->ndx(), moving->nu()), {});
  moving->set_control_bounds({-8}, {8});
  const auto end = std::make_shared<KnotModel>(crane, Integrator::none);
  end->add_cost("load", std::make_shared<const LoadPosition>(), {});
  end->add_cost("rest", coordinate_residual(crane->manifold(), {2, 3}), {});

  Phase horizon{.name = "horizon", .model = moving};
  for (int k = 0; k < kKnots; ++k) {
    horizon.dt.push_back(kStep);
    horizon.cost_scale.push_back(kStep);
    // Of each cost its reference, then its weight.
    for (const double number : {kGoal, -Crane::kCable, 1.0, /**/ 0.0, 1e-3})
      horizon.parameters.push_back(number);
  }
  Phase goal{.name = "goal", .model = end, .dt = {0}, .cost_scale = {1}};
  goal.parameters = {kGoal, -Crane::kCable, 10, /**/ 0, 0, 10};
  return ShootingProblem({0, 0, 0, 0}, {horizon}, goal);
}

/// What the force does to the real crane during a step: the midpoint rule in small steps.
void move(const Crane& crane, double force, std::vector<double>& x) {
  constexpr int kParts = 20;
  const double h = kStep / kParts;
  std::array<double, 2> a{};
  for (int part = 0; part < kParts; ++part) {
    crane.rate(x.data(), &force, a.data());
    const std::array<double, 4> middle = {x[0] + h / 2 * x[2], x[1] + h / 2 * x[3],
                                          x[2] + h / 2 * a[0], x[3] + h / 2 * a[1]};
    crane.rate(middle.data(), &force, a.data());
    for (int i = 0; i < 2; ++i) {
      x[i] += h * middle[i + 2];
      x[i + 2] += h * a[i];
    }
  }
}

}  // namespace

int main(int argc, char** argv) {
  const int solves = argc > 1 ? std::atoi(argv[1]) : 10;
  const Crane real(/*load_mass*/ 1.2);  // heavier than the model's
  ShootingProblem problem = crane_problem();
  ReusableSolver solver(problem, "box_fddp", {.max_iterations = 50});
  Trajectory guess = problem.create_trajectory();
  std::vector<double> x = problem.initial_state();
  for (int i = 0; i < solves; ++i) {
    problem.set_initial_state(x);
    const SolveResult& plan = solver.solve(guess);
    if (plan.status != SolveStatus::converged) {
      std::printf("solve %d: %s\n", i, plan.message.c_str());
      return 1;
    }
    const double force = plan.trajectory.u(0)[0];
    move(real, force, x);
    std::printf("solve %d: %2d iterations, force %6.3f N, load at %.3f m\n", i, plan.iterations,
                force, x[0] + Crane::kCable * std::sin(x[1]));
    // The plan from the next knot on, with its end twice.
    for (int k = 0; k < kKnots; ++k) {
      guess.x(k) = plan.trajectory.x(k + 1);
      guess.u(k) = plan.trajectory.u(std::min(k + 1, kKnots - 1));
    }
    guess.x(kKnots) = plan.trajectory.x(kKnots);
  }
  return 0;
}
