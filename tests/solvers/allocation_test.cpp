#include <algorithm>
#include <cstdlib>

#include <gtest/gtest.h>

#include "ocp/knot/collocation_residual.hpp"
#include "ocp/residuals/residuals.hpp"
#include "ocp/residuals/weighted_residual.hpp"
#include "solvers/sampling/sampling.hpp"
#include "solvers/strategies/registry.hpp"
#include "solvers/strategies/reusable_solver.hpp"
#include "support/conic_problems.hpp"
#include "support/constrained_problems.hpp"
#include "support/random_robot.hpp"
#include "support/second_derivatives.hpp"
#include "support/small_problems.hpp"
#include "systems/closed_forms/catalogue.hpp"
#include "systems/multibody/multibody.hpp"

// Sanitizers replace malloc.
#if defined(__SANITIZE_ADDRESS__) || !defined(__GLIBC__)
#define CONDDP_COUNTS_ALLOCATIONS 0
#else
#define CONDDP_COUNTS_ALLOCATIONS 1
#endif

#if CONDDP_COUNTS_ALLOCATIONS

#include "support/allocation_count.hpp"

namespace conddp {
namespace {

struct Count {
  long allocations = 0;
  int iterations = 0;
};

/// Allocations between the end of the first iteration and the end of the last, in a reusable
/// solver; others allocate once more when they switch to exact Hessians.
Count count_allocations(const ShootingProblem& problem, const SolverInfo& solver,
                        const Trajectory& guess, SolverOptions options) {
  Count result;
  options.on_iteration = [&](const IterationRecord& row) {
    counting = false;
    result.allocations = allocations;
    result.iterations = row.iteration;
    counting = row.iteration >= 1;
  };
  ReusableSolver reusable(problem, solver.name, options);
  allocations = 0;
  reusable.solve(guess);
  counting = false;
  return result;
}

TEST(Allocation, CounterSeesNewAndMalloc) {
  allocations = 0;
  counting = true;
  delete new volatile int(1);
  void* volatile p = std::malloc(10);
  std::free(p);
  Eigen::VectorXd v(100);
  v.setZero();
  AlignedVector<double> aligned(100);
  counting = false;
  EXPECT_EQ(allocations, 4) << v.sum() + aligned[0];
}

/// A pendulum swing-up under full weight matrices.
ShootingProblem weighted_swing_up() {
  constexpr int kKnots = 60;
  const auto system = pendulum({});
  const Eigen::Matrix2d W{{1, 0.2}, {0.2, 0.1}};
  const auto state = weighted_residual(state_residual(system->manifold()), W);
  auto running = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  running->add_cost("state", state, {});
  running->add_cost("control", control_residual(system->ndx(), system->nu()), {});
  auto end = std::make_shared<KnotModel>(system, Integrator::none);
  end->add_cost("state", state, {});
  Phase phase{"knots", running, std::vector(kKnots, 0.05), std::vector(kKnots, 0.05), {}};
  for (int k = 0; k < kKnots; ++k)
    phase.parameters.insert(phase.parameters.end(), {3.14, 0, 1, 0, 0.01});
  return {{0, 0}, {phase}, Phase{"end", end, {0.0}, {1.0}, {3.14, 0, 100}}};
}

TEST(Allocation, NoneInAnIterationAfterTheFirst) {
  const struct {
    const char* name;
    ShootingProblem problem;
    double u;
  } cases[] = {{"cartpole", testing::cartpole_swing_up(), 0.01},
               {"cartpole, limited", testing::cartpole_swing_up(3), 0.01},
               {"quadrotor", testing::quadrotor_move(), 1.22625},
               {"quadrotor, limited", testing::quadrotor_move(0.5, 2), 1.22625},
               {"unicycle", testing::unicycle_parking(), 0.01},
               {"landing", testing::landing(), 0.01},
               {"landing, limited", testing::landing(60), 0.01},
               {"weighted pendulum", weighted_swing_up(), 0.01}};
  for (const auto& [name, problem, u] : cases) {
    for (const SolverInfo& solver : solvers()) {
      // The Ipopt library allocates freely.
      if (solver.name == "ipopt" || unsupported(solver, problem)) continue;
      for (HessianChoice hessian :
           {HessianChoice::automatic, HessianChoice::gauss_newton, HessianChoice::exact}) {
        if (hessian == HessianChoice::exact && !solver.exact_hessian) continue;
        if (hessian == HessianChoice::gauss_newton && !solver.gauss_newton_hessian) continue;
        SolverOptions options;
        options.max_iterations = 60;
        options.hessian = hessian;
        // Starts without gaps, since exact Hessians wait for closed gaps.
        Trajectory guess = testing::constant_controls(problem, u);
        ASSERT_EQ(Evaluator(problem).simulate(guess), -1);
        const Count count = count_allocations(problem, solver, guess, options);
        EXPECT_GE(count.iterations, 5) << name << ' ' << solver.name;
        EXPECT_EQ(count.allocations, 0) << name << ' ' << solver.name;
      }
    }
  }
}

TEST(Allocation, NoneInFurtherRoundsOfSampling) {
  const ShootingProblem problem = testing::cartpole_swing_up(3);
  const Trajectory nominal = problem.create_trajectory();
  ControlSplines splines(problem, nominal);
  const int channel = splines.add_channel(1, 3);
  constexpr double kOne[] = {1};
  for (int k = 0; k < problem.knots(); ++k) splines.add_entry(k, 0, channel, kOne);
  search_controls(splines, {.samples = 20, .rounds = 1});  // what libraries allocate once
  for (const SamplingMethod method :
       {SamplingMethod::predictive, SamplingMethod::cem, SamplingMethod::mppi}) {
    long counts[2];
    for (const int more : {0, 1}) {
      allocations = 0;
      counting = true;
      search_controls(splines, {.method = method, .samples = 20, .rounds = 20 + 20 * more});
      counting = false;
      counts[more] = allocations;
    }
    EXPECT_GT(counts[0], 0);
    EXPECT_EQ(counts[1], counts[0]);
  }
}

TEST(Allocation, NoneWithConstraintsOrInNewtonSteps) {
  for (const auto& [name, problem, control, cost] : testing::published_cases()) {
    for (const char* solver : {"altro", "proxddp", "ipddp"}) {
      const Count count = count_allocations(problem, *find_solver(solver),
                                            testing::constant_controls(problem, control), {});
      EXPECT_GE(count.iterations, 5) << name << ' ' << solver;
      EXPECT_EQ(count.allocations, 0) << name << ' ' << solver;
    }
  }
}

/// A cart-pole with implicit steps.
ShootingProblem collocated_cartpole(CollocationRule rule) {
  const auto system = std::make_shared<CollocationSystem>(cartpole({}), rule);
  const IntegratorInfo& integrator =
      *std::find_if(std::begin(kIntegrators), std::end(kIntegrators),
                    [&](const IntegratorInfo& info) { return info.collocation == rule; });
  std::vector<double> effort(system->nu(), 0.0);
  effort[0] = 0.1;
  const double dt = 0.05;
  const ShootingProblem free = testing::tracking_problem(
      system, integrator.integrator, 40, dt, {0, 0, 0, 0},
      {{0, M_PI, 0, 0}, {0.01, 0.01, 0.01, 0.01}, effort, {100, 100, 100, 100}});
  const std::vector<double> zero(system->later_stages() * system->rows(), 0.0);
  return testing::with_constraints(free, {{.name = "collocation",
                                           .residual = collocation_residual(system, free.ndx()),
                                           .reference = {dt},
                                           .lower = zero,
                                           .upper = zero,
                                           .first = 0,
                                           .last = 39}});
}

TEST(Allocation, NoneWithImplicitSteps) {
  for (const CollocationRule rule : {CollocationRule::trapezoidal, CollocationRule::hermite_simpson,
                                     CollocationRule::radau3, CollocationRule::radau5}) {
    const ShootingProblem problem = collocated_cartpole(rule);
    for (const char* solver : {"altro", "proxddp", "intro"}) {
      SolverOptions options;
      options.max_iterations = 60;
      const Count count = count_allocations(problem, *find_solver(solver),
                                            testing::constant_controls(problem, 0.01), options);
      EXPECT_GE(count.iterations, 5) << solver;
      EXPECT_EQ(count.allocations, 0) << solver;
    }
  }
}

/// An arm with its tip on a plane, with costs on the contact force and a frame position.
ShootingProblem arm_on_a_plane(bool loaded) {
  const RobotModel plain = random_robot(5, {.joints = 5, .wrenches = 0});
  const auto robot = std::make_shared<RobotModel>(loaded ? loaded_robot(plain, 6) : plain);
  int tip = 0;
  for (int i = 0; i < static_cast<int>(robot->frames.size()); ++i)
    if (robot->frames[i].joint == plain.joint_count() - 1) tip = i;
  const auto system = std::make_shared<MultibodySystem>(
      robot, Actuation::full(*robot), PassiveForces{},
      std::vector<Contact>{
          {.name = "tip", .frame = tip, .kind = ContactKind::normal, .kp = 20, .kd = 9}});
  const auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
  const int nv = system->nv(), nu = system->nu();
  model->add_cost("state", state_residual(model->manifold()),
                  {.weights = std::vector<double>(2 * nv, 0.1)});
  model->add_cost("control", control_residual(model->ndx(), nu),
                  {.weights = std::vector<double>(nu, 0.1)});
  model->add_cost("force", contact_force_residual(system, 0, model->ndx()),
                  {.weights = {0.01, 0.01, 0.01}});
  model->add_cost("reach", frame_position_residual(system, tip), {.weights = {50, 50, 50}});
  // References, each followed by its weight.
  std::vector<double> one(2 * nv, 0.0);
  one.push_back(1);
  one.insert(one.end(), nu, 0.0);
  one.push_back(1);
  one.insert(one.end(), {0, 0, 0, 1, 0.3, -0.4, 0.5, 1});
  Phase phase{.name = "all", .model = model};
  for (int k = 0; k < 20; ++k) {
    phase.dt.push_back(0.05);
    phase.cost_scale.push_back(0.05);
    phase.parameters.insert(phase.parameters.end(), one.begin(), one.end());
  }
  return ShootingProblem(std::vector<double>(2 * nv, 0.2), {phase},
                         testing::terminal_phase(system, {.goal = std::vector<double>(2 * nv, 0.0),
                                                          .qf = std::vector<double>(2 * nv, 1.0)}));
}

TEST(Allocation, NoneWithPartwiseExactHessiansOfARobot) {
  for (const bool loaded : {false, true}) {
    const ShootingProblem problem = arm_on_a_plane(loaded);
    ASSERT_TRUE(known_by_parts(*problem.knot(0).model));
    for (const char* solver : {"ddp", "fddp", "altro", "proxddp"}) {
      SolverOptions options;
      options.tolerances.stationarity = 1e-300;
      options.max_iterations = 30;
      options.hessian = HessianChoice::exact;
      Trajectory guess = testing::constant_controls(problem, 0);
      ASSERT_EQ(Evaluator(problem).simulate(guess), -1);
      const Count count = count_allocations(problem, *find_solver(solver), guess, options);
      EXPECT_GE(count.iterations, 3) << solver;
      EXPECT_EQ(count.allocations, 0) << solver;
    }
  }
}

TEST(Allocation, NoneInDescentsThroughTheHorizonModel) {
  const testing::ConicLinearQuadratic conic(1, testing::alternating_size());
  for (const char* solver : {"altro", "proxddp"}) {
    const Count count = count_allocations(*conic.problem, *find_solver(solver),
                                          conic.problem->create_trajectory(), {});
    EXPECT_GE(count.iterations, 5) << solver;
    EXPECT_EQ(count.allocations, 0) << solver;
  }
}

TEST(Allocation, NoneWithEqualitiesInTheNullSpace) {
  const ShootingProblem parking = testing::unicycle_parking();
  const ShootingProblem problem =
      testing::with_constraints(parking, {testing::goal_constraint(parking, {3, 3, 0})});
  const Count count = count_allocations(problem, *find_solver("intro"),
                                        testing::constant_controls(problem, 0.01), {});
  EXPECT_GE(count.iterations, 5);
  EXPECT_EQ(count.allocations, 0);
}

TEST(Allocation, NoneWithOpenGapsOrAtRoundingFloor) {
  const ShootingProblem problem = testing::quadrotor_move(0.5, 2);
  Trajectory guess = testing::constant_controls(problem, 1.2);
  for (int k = 1; k <= problem.knots(); ++k) guess.x(k)[0] += 0.1 * k;
  SolverOptions options;
  options.tolerances.stationarity = 1e-300;
  options.hessian = HessianChoice::gauss_newton;
  const SolverInfo& solver = *find_solver("box_fddp");
  const Count count = count_allocations(problem, solver, guess, options);
  EXPECT_GE(count.iterations, 5);
  EXPECT_EQ(count.allocations, 0);
}

/// Allocations of later solves from successive initial states.
long count_further_solves(ShootingProblem problem, const char* name, SolverOptions options) {
  ReusableSolver solver(problem, name, options);
  Trajectory guess = testing::constant_controls(problem, 0.01);
  std::vector<double> x0 = problem.initial_state();
  allocations = 0;
  for (int i = 0; i < 4; ++i) {
    counting = i > 0;
    const SolveResult& answer = solver.solve(guess);
    guess = answer.trajectory;
    x0.back() += 0.01;
    problem.set_initial_state(x0);
  }
  counting = false;
  return allocations;
}

TEST(Allocation, NoneInASolveAfterTheFirst) {
  for (const char* solver : {"ilqr", "ddp", "fddp", "box_ddp", "box_fddp", "proxddp"}) {
    SolverOptions options;
    EXPECT_EQ(count_further_solves(testing::cartpole_swing_up(), solver, options), 0) << solver;
    options.max_iterations = 2;
    EXPECT_EQ(count_further_solves(testing::cartpole_swing_up(), solver, options), 0) << solver;
  }
  EXPECT_EQ(count_further_solves(testing::cartpole_swing_up(3), "box_fddp", {}), 0);
  EXPECT_EQ(count_further_solves(testing::cartpole_swing_up(3), "altro", {}), 0);
}

}  // namespace
}  // namespace conddp

#endif  // CONDDP_COUNTS_ALLOCATIONS
