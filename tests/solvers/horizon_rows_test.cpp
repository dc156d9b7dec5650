#include "solvers/constraints/horizon_rows.hpp"

#include <gtest/gtest.h>

#include "ocp/evaluation/evaluator.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/conic_problems.hpp"
#include "support/dense_horizon.hpp"

namespace conddp::testing {
namespace {

/// A conic problem linearized at zero, and steps from there.
struct Horizon {
  Horizon()
      : conic(1, middle_size()),
        augmentation(*conic.problem),
        linearization(*conic.problem),
        bounds(*conic.problem),
        rows(*conic.problem, bounds) {
    const ShootingProblem& problem = *conic.problem;
    augmentation.penalty.setOnes();
    Evaluator(problem).differentiate(problem.create_trajectory(), linearization, &augmentation);
    for (int k = 0; k <= problem.knots(); ++k)
      z.push_back(Eigen::VectorXd::Zero(problem.knot(k).model->nz()));
    rows.start(linearization, &augmentation);
  }

  ConicLinearQuadratic conic;
  Augmentation augmentation;
  Linearization linearization;
  ControlBounds bounds;
  HorizonRows rows;
  std::vector<Eigen::VectorXd> z;
  std::optional<int> last;
};

// Sweeps restart at the last node whose rows changed, so that node must be reported.
TEST(HorizonRows, ReportTheLastNodeWithCrossedRows) {
  Horizon horizon;
  auto& [conic, augmentation, linearization, bounds, rows, z, last] = horizon;

  EXPECT_EQ(rows.revise(z, 0, linearization, last), 0);
  EXPECT_FALSE(last.has_value());
  z[3].setConstant(100);
  z[7].setConstant(-100);
  EXPECT_GE(rows.revise(z, 0, linearization, last), 2);
  EXPECT_EQ(last, 7);
  last.reset();
  EXPECT_EQ(rows.revise(z, 0, linearization, last), 0);
  EXPECT_FALSE(last.has_value());
  z[7].setZero();
  EXPECT_GE(rows.revise(z, 0, linearization, last), 1);
  EXPECT_EQ(last, 7);
}

TEST(HorizonRows, KeepsModelsWithinTheAllowedError) {
  Horizon horizon;
  auto& [conic, augmentation, linearization, bounds, rows, z, last] = horizon;
  z[3].setConstant(100);
  const Eigen::VectorXd gradient = linearization.knots[3].gradient;
  EXPECT_EQ(rows.revise(z, 1e12, linearization, last), 0);
  EXPECT_EQ(linearization.knots[3].gradient, gradient);
  EXPECT_GE(rows.revise(z, 1e-12, linearization, last), 1);
  EXPECT_NE(linearization.knots[3].gradient, gradient);
}

// The next iterate's model starts once from the settled rows and multipliers of the last step.
TEST(HorizonRows, PredictRowsFromThePreviousStep) {
  Horizon horizon;
  auto& [conic, augmentation, linearization, bounds, rows, z, last] = horizon;
  z[3].setConstant(100);
  ASSERT_GE(rows.revise(z, 0, linearization, last), 1);
  const Eigen::VectorXd settled = linearization.knots[3].gradient;
  ASSERT_EQ(rows.revise(z, 0, linearization, last), 0);
  rows.settle();
  ASSERT_TRUE(rows.restore(linearization));
  const Eigen::VectorXd own = linearization.knots[3].gradient;

  rows.start(linearization, &augmentation);
  rows.expect(linearization);
  EXPECT_LT((linearization.knots[3].gradient - settled).norm(), 1e-9 * settled.norm());
  EXPECT_EQ(rows.revise(z, 0, linearization, last), 0);
  rows.restore(linearization);
  EXPECT_EQ(linearization.knots[3].gradient, own);
  rows.start(linearization, &augmentation);
  rows.expect(linearization);
  EXPECT_EQ(linearization.knots[3].gradient, own) << "what was expected once is past";
}

/// A mass sent to 1 and back, with quadratic costs beyond walls and a speed.
ShootingProblem beyond_walls(double weight) {
  Eigen::MatrixXd A(2, 2), B(2, 1);
  A << 1, 0.1, 0, 1;
  B << 0.005, 0.1;
  const std::shared_ptr<const System> system = linear_system(A, B, Eigen::VectorXd::Zero(2));
  const TrackingCost cost{{1, 0}, {1, 0.01}, {1e-3}, {10, 10}, false};
  constexpr int kKnots = 40;
  Phase phase = tracking_phase(system, Integrator::discrete, kKnots, 1, cost, -3, 3);
  auto model = std::make_shared<KnotModel>(*phase.model);
  constexpr double kNone = kFree;
  model->add_cost("walls", state_residual(model->manifold()),
                  {.kind = ActivationKind::quadratic_barrier,
                   .weights = {1, 0.5},
                   .lower = {-kNone, -0.4},
                   .upper = {0.7, 0.4}});
  std::vector<double> parameters;
  const int before = phase.model->parameter_count();
  for (int k = 0; k < kKnots; ++k) {
    const auto first = phase.parameters.begin() + k * before;
    parameters.insert(parameters.end(), first, first + before);
    parameters.insert(parameters.end(), {0, 0, weight});
  }
  phase.model = std::move(model);
  phase.parameters = std::move(parameters);
  return ShootingProblem({0, 0}, {std::move(phase)}, terminal_phase(system, cost));
}

// The model finds the minimum of a piecewise quadratic problem with sweeps but without iterations.
TEST(HorizonRows, IncludesBarriersThatAStepCrosses) {
  for (const double weight : {1.0, 100.0, 1e4}) {
    const ShootingProblem problem = beyond_walls(weight);
    const Trajectory guess = problem.create_trajectory();
    const SolveResult other = solve(problem, "ipopt", {}, guess);
    EXPECT_EQ(other.status, SolveStatus::converged) << other.message;
    for (const char* solver : {"box_ddp", "box_fddp"}) {
      const SolveResult result = solve(problem, solver, {}, guess);
      EXPECT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
      EXPECT_LE(result.iterations, 2) << solver << ' ' << weight;
      EXPECT_NEAR(result.cost, other.cost, 1e-6 * other.cost) << solver;
      double furthest = 0;
      for (int k = 0; k <= problem.knots(); ++k)
        furthest = std::max(furthest, result.trajectory.x(k)[0]);
      EXPECT_GT(furthest, 0.7) << "the wall is met";
    }
  }
}

// Reported gains belong to the iterate's own costs, even if the solve stops early.
TEST(HorizonRows, GainsMatchTheirSideOfEachWall) {
  const ShootingProblem problem = beyond_walls(100);
  SolverOptions options;
  options.max_iterations = 0;
  const SolveResult start = solve(problem, "box_ddp", options, problem.create_trajectory());
  const SolveResult without =
      solve(beyond_walls(0), "box_ddp", options, problem.create_trajectory());
  for (int k = 0; k < problem.knots(); ++k)
    EXPECT_EQ(start.feedback.K[k], without.feedback.K[k]) << "at rest no wall is crossed";
}

/// A random linear problem with rows of every kind that a horizon models: bounds and cones (hard,
/// soft, and quadratic soft) and a barrier. It has two nodes for each number of controls, and an
/// end.
ShootingProblem with_every_kind(unsigned seed) {
  const LinearQuadratic lq(seed, 3, {2, 1}, 2, -kFree, kFree);
  std::vector<Phase> phases = lq.problem->phases();
  for (Phase& phase : phases) {
    auto model = std::make_shared<KnotModel>(*phase.model);
    const int before = model->parameter_count();
    model->add_cost("barrier", state_residual(model->manifold()),
                    {.kind = ActivationKind::quadratic_barrier,
                     .weights = {0.5, 2, 3},
                     .lower = {-0.3, -kFree, -0.2},
                     .upper = {0.4, 0.1, kFree}});
    std::vector<double> parameters;
    for (int k = 0; k < phase.knots(); ++k) {
      const auto first = phase.parameters.begin() + k * before;
      parameters.insert(parameters.end(), first, first + before);
      parameters.insert(parameters.end(), {0.1, -0.2, 0.3, 1.5 + k});  // reference and weight
    }
    phase.model = std::move(model);
    phase.parameters = std::move(parameters);
  }
  const ShootingProblem free(lq.problem->initial_state(), std::move(phases),
                             lq.problem->terminal());
  RandomNumbers random(seed);
  std::vector<Added> list;
  const auto add = [&](int rows, int first, int last, bool cone, Softness softness) {
    Eigen::MatrixXd C(rows, free.nx() + (first < free.knots() ? free.nu(first) : 0));
    for (double& value : C.reshaped()) value = random.uniform(-1, 1);
    Added one = affine_rows(C, free, first, last, -0.2, 0.3);
    if (cone) {
      one.kind = ConstraintKind::second_order_cone;
      one.lower.clear();
      one.upper.clear();
    }
    one.softness = softness;
    one.weight = random.uniform(0.5, 2);
    list.push_back(std::move(one));
  };
  for (const Softness softness : {Softness::hard, Softness::l1, Softness::l2})
    for (const auto& [first, last] : {std::pair{0, 1}, {3, 3}, {4, 4}})
      for (const bool cone : {false, true}) add(cone ? 3 : 2, first, last, cone, softness);
  // One full lane of rows, and partial lanes.
  for (const Softness softness : {Softness::hard, Softness::l1})
    add(kLaneWidth + 3, 0, 1, false, softness);
  return with_constraints(free, list);
}

/// A horizon model, compared with the exact functions evaluated at the step.
class ModelOfEveryKind : public ::testing::TestWithParam<unsigned> {
 protected:
  ModelOfEveryKind()
      : problem_(with_every_kind(GetParam())),
        random_(GetParam()),
        augmentation_(problem_),
        linearization_(problem_),
        bounds_(problem_),
        rows_(problem_, bounds_),
        evaluator_(problem_),
        from_(random_guess(problem_, GetParam())) {
    for (const NodeConstraint& c : problem_.constraints()) {
      augmentation_.penalty.segment(c.row, c.term->rows).setConstant(random_.uniform(1, 20));
      for (int i = 0; i < c.term->rows; ++i)
        augmentation_.shift[c.row + i] = random_.uniform(-0.3, 0.3);
    }
    evaluator_.differentiate(from_, linearization_, &augmentation_);
  }

  using Step = std::vector<Eigen::VectorXd>;
  /// A step across the kinks of most rows.
  Step random_step() {
    Step z;
    for (int k = 0; k <= problem_.knots(); ++k) {
      z.emplace_back(problem_.knot(k).model->nz());
      for (double& value : z.back()) value = random_.uniform(-3, 3);
    }
    return z;
  }
  Linearization at(const Step& z) {
    Trajectory moved = from_;
    for (int k = 0; k <= problem_.knots(); ++k) {
      moved.x(k) += z[k].head(problem_.ndx());
      if (k < problem_.knots()) moved.u(k) += z[k].tail(problem_.nu(k));
    }
    Linearization there(problem_);
    evaluator_.differentiate(moved, there, &augmentation_);
    return there;
  }
  /// Expects that gradients and Hessians of the model at a step match the exact ones, up to 2 % for
  /// cones.
  void expect_model_of(const Step& z) {
    const Linearization there = at(z);
    for (int k = 0; k <= problem_.knots(); ++k) {
      const KnotLinearization& knot = linearization_.knots[k];
      const Eigen::VectorXd slope = knot.gradient + knot.hessian() * z[k];
      const double off = (slope - there.knots[k].gradient).lpNorm<Eigen::Infinity>();
      ++nodes_;
      if (off > 1e-11) {
        EXPECT_LT(off, 0.02 * cone_slopes(k, there)) << k;
        continue;
      }
      ++exact_;
      EXPECT_LT((knot.hessian() - there.knots[k].hessian()).lpNorm<Eigen::Infinity>(), 1e-11) << k;
    }
  }
  /// Upper bound of the cones' contribution to a node's gradient.
  double cone_slopes(int k, const Linearization& there) const {
    double sum = 0;
    for (const auto* list : {&problem_.constraints(), &problem_.soft_constraints()})
      for (const NodeConstraint& c : *list) {
        const int n = c.term->rows;
        if (c.node != k || c.term->has_bounds()) continue;
        const Eigen::VectorXd s =
            there.constraint.segment(c.row, n) + augmentation_.shift.segment(c.row, n);
        const KnotView& knot = problem_.knot(k);
        const double rho = c.term->softness == Softness::l2
                               ? knot.cost_scale * knot.parameters[c.term->weight()]
                               : augmentation_.penalty[c.row];
        sum += rho * distance_to_set(*c.term, s.data(), nullptr, nullptr) *
               there.knots[k].C.middleRows(c.row - problem_.constraint_offset(k), n).norm();
      }
    return sum;
  }

  ShootingProblem problem_;
  RandomNumbers random_;
  Augmentation augmentation_;
  Linearization linearization_;
  ControlBounds bounds_;
  HorizonRows rows_;
  Evaluator evaluator_;
  Trajectory from_;
  int nodes_ = 0, exact_ = 0;
};

TEST_P(ModelOfEveryKind, MatchesThePenaltiesAtTheStep) {
  const Linearization own = linearization_;
  rows_.start(linearization_, &augmentation_);
  std::optional<int> last;
  for (int i = 0; i < 4; ++i) {
    const Step z = random_step();
    EXPECT_GT(rows_.revise(z, 0, linearization_, last), 5);
    expect_model_of(z);
    EXPECT_EQ(rows_.revise(z, 0, linearization_, last), 0);
  }
  EXPECT_TRUE(rows_.restore(linearization_));
  EXPECT_FALSE(rows_.restore(linearization_));
  for (int k = 0; k <= problem_.knots(); ++k) {
    EXPECT_EQ(linearization_.knots[k].gradient, own.knots[k].gradient) << k;
    EXPECT_EQ(linearization_.knots[k].hessian(), own.knots[k].hessian()) << k;
  }
  rows_.restart();
  const Step z = random_step();
  rows_.revise(z, 0, linearization_, last);
  expect_model_of(z);
  EXPECT_GT(exact_, 0.6 * nodes_);
}

TEST_P(ModelOfEveryKind, PathExcessMatchesThePenaltyRise) {
  rows_.start(linearization_, &augmentation_);
  std::optional<int> last;
  const Step z = random_step(), to = random_step();
  rows_.revise(z, 0, linearization_, last);
  rows_.set_path(z, to, linearization_);
  for (const double alpha : {0.0, 0.3, 0.8, 1.0, 1.7}) {
    Step on_the_way = z;
    for (int k = 0; k <= problem_.knots(); ++k) on_the_way[k] += alpha * (to[k] - z[k]);
    const Linearization there = at(on_the_way);
    double more = 0, size = 0;
    for (int k = 0; k <= problem_.knots(); ++k) {
      const KnotLinearization& knot = linearization_.knots[k];
      const Eigen::VectorXd modelled = knot.gradient + knot.hessian() * on_the_way[k];
      more += (there.knots[k].gradient - modelled).dot(to[k] - z[k]);
      size += there.knots[k].gradient.norm() * (to[k] - z[k]).norm();
    }
    EXPECT_NEAR(rows_.slope_beyond_model(alpha), more, 1e-12 * size) << alpha;
    if (alpha > 0.5) {
      EXPECT_GT(std::abs(more), 1e-4 * size) << alpha;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Seeds, ModelOfEveryKind, ::testing::Range(1u, 9u));

}  // namespace
}  // namespace conddp::testing
