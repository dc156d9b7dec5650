// Corrected steps, compared with the dense inverse of the BFGS formula.
#include "solvers/globalization/lbfgs_correction.hpp"

#include <deque>

#include <gtest/gtest.h>

#include "solvers/riccati/linear_rollout.hpp"
#include "support/dense_horizon.hpp"

namespace conddp::testing {
namespace {

/// The BFGS inverse Hessian from M⁻¹ and pairs (s, y), oldest first (Nocedal, Wright, 6.17).
Eigen::MatrixXd inverse_hessian(
    const Eigen::MatrixXd& M, const std::deque<std::pair<Eigen::VectorXd, Eigen::VectorXd>>& all) {
  Eigen::MatrixXd H = M.inverse();
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(H.rows(), H.cols());
  for (const auto& [s, y] : all) {
    const Eigen::MatrixXd V = one - y * s.transpose() / y.dot(s);
    H = (V.transpose() * H * V + s * s.transpose() / y.dot(s)).eval();
  }
  return H;
}

/// Steps through a quadratic function whose Hessian differs from the model's, and the dense
/// formula.
class SteppedModel {
 public:
  SteppedModel(unsigned seed, std::vector<std::pair<int, int>> held)
      : lq_(1, 3, {1, 2}, 2, -kFree, kFree),
        bounds_(*lq_.problem),
        linearization_(*lq_.problem),
        gaps_(*lq_.problem),
        sweep_(*lq_.problem, bounds_),
        stages_(unconstrained_stage(*lq_.problem)),
        held_(std::move(held)),
        random_(seed),
        feedback(*lq_.problem),
        memory(bounds_),
        active_set(*lq_.problem) {
    randomize(*lq_.problem, random_, linearization_);
    for (const auto& [k, i] : held_) hold(k, i, 1);
    sweep();
    M = Eigen::MatrixXd::Zero(bounds_.size(), bounds_.size());
    for (int k = 0; k < 4; ++k) {
      const int at = bounds_.offset(k), nu = lq_.problem->nu(k);
      M.block(at, at, nu, nu) = sweep_.Quu(k);
    }
    for (int i = 0; i < bounds_.size(); ++i)
      if (!is_free(i)) {
        M.row(i).setZero();
        M.col(i).setZero();
        M(i, i) = 1;
      }
  }
  bool is_free(int at) const {
    for (const auto& [k, i] : held_)
      if (at == bounds_.offset(k) + i) return false;
    return true;
  }
  Eigen::VectorXd stacked() const {
    Eigen::VectorXd all(bounds_.size());
    for (int k = 0; k < 4; ++k)
      all.segment(bounds_.offset(k), feedback.k[k].size()) = feedback.k[k];
    return all;
  }
  /// Holds one control of a knot; on side 0, releases all.
  void hold(int k, int i, double side) {
    active_set.assume_sides(k, side * Eigen::VectorXd::Unit(lq_.problem->nu(k), i));
  }
  void observe() { memory.observe(feedback, sweep_, active_set); }
  /// Takes the step of `feedback`: gradients change by a different curvature.
  void step() {
    LinearRollout rollout(*lq_.problem, bounds_);
    rollout.run(linearization_, Trajectory(3, {1, 1, 2, 2}), gaps_, feedback, false);
    memory.step_taken(feedback);
    for (int k = 0; k <= 4; ++k) {
      KnotLinearization& knot = linearization_.knots[k];
      knot.gradient += random_.uniform(0.5, 1.7) * knot.hessian() * rollout.z(k);
    }
    sweep();
  }

 private:
  void sweep() {
    ASSERT_EQ(
        sweep_.run(linearization_, Trajectory(3, {1, 1, 2, 2}), gaps_, {}, *stages_, feedback), -1);
    for (const auto& [k, i] : held_) feedback.k[k][i] = 0;
  }

  LinearQuadratic lq_;
  ControlBounds bounds_;
  Linearization linearization_;
  Gaps gaps_;
  BackwardSweep sweep_;
  std::unique_ptr<StageSolver> stages_;
  std::vector<std::pair<int, int>> held_;
  RandomNumbers random_;

 public:
  Feedback feedback;
  LbfgsCorrection memory;
  ActiveSet active_set;
  Eigen::MatrixXd M;  ///< model Hessian in the free entries of v, identity elsewhere
};

TEST(LbfgsCorrection, CorrectedStepMatchesDenseFormulaOfFivePairs) {
  const std::vector<std::vector<std::pair<int, int>>> cases = {{}, {{1, 0}, {3, 1}}};
  int compared = 0, with_five = 0;
  for (const auto& held : cases)
    for (unsigned seed = 1; seed <= 4; ++seed) {
      SteppedModel model(seed, held);
      std::deque<std::pair<Eigen::VectorXd, Eigen::VectorXd>> pairs;
      Eigen::VectorXd d = model.stacked();
      model.observe();
      EXPECT_FALSE(model.memory.correct(model.feedback)) << "nothing is known";
      for (int i = 0; i < 9; ++i) {
        const Eigen::VectorXd s = model.stacked(), g = -model.M * d;
        const double length = d.dot(model.M * d);
        model.step();
        d = model.stacked();
        pairs.emplace_back(s, -model.M * d - g);
        if (pairs.size() > 5) pairs.pop_front();
        model.observe();
        const bool corrected = model.memory.correct(model.feedback);
        ASSERT_EQ(corrected, std::sqrt(d.dot(model.M * d) / length) >= 0.2) << seed << ' ' << i;
        if (!corrected) {
          EXPECT_EQ(model.stacked(), d);
          continue;
        }
        const Eigen::VectorXd expected = inverse_hessian(model.M, pairs) * model.M * d;
        EXPECT_LT((model.stacked() - expected).norm(), 1e-10 * expected.norm()) << seed << ' ' << i;
        EXPECT_GT((d - expected).norm(), 1e-3 * d.norm()) << seed << ' ' << i;
        for (const auto& [k, entry] : held) EXPECT_EQ(model.feedback.k[k][entry], 0);
        ++compared;
        with_five += pairs.size() == 5;
      }
    }
  EXPECT_GT(compared, 40);
  EXPECT_GT(with_five, 20);
}

TEST(LbfgsCorrection, RestoresObservationsAndForgets) {
  SteppedModel model(1, {{3, 1}});
  model.observe();
  model.step();
  const Eigen::VectorXd d = model.stacked();
  model.observe();
  ASSERT_TRUE(model.memory.correct(model.feedback));
  ASSERT_NE(model.stacked(), d);
  model.feedback.k[3][1] = 7;  // held: excluded
  model.memory.restore(model.feedback);
  EXPECT_EQ(model.feedback.k[3][1], 7);
  model.feedback.k[3][1] = 0;
  EXPECT_EQ(model.stacked(), d);

  model.memory.clear();
  model.observe();
  EXPECT_FALSE(model.memory.correct(model.feedback));
}

TEST(LbfgsCorrection, ForgetsPairsOfAnotherActiveSet) {
  for (const bool on_its_way : {false, true}) {
    SteppedModel model(1, {{3, 1}});
    model.observe();
    model.step();
    if (on_its_way)
      model.feedback.k[3][1] = 0.1;  // to its holding bound
    else
      model.hold(3, 1, 0);
    model.observe();
    EXPECT_FALSE(model.memory.correct(model.feedback)) << on_its_way;
  }
}

/// A step of one control from k = 1 with Q_uu = 2, followed by a sweep with another k. Returns the
/// corrected k, if any. The gradient changes from −2 to −2 k.
std::optional<double> corrected_after(double k, bool taken = true) {
  const Eigen::MatrixXd one = Eigen::MatrixXd::Identity(1, 1);
  const ShootingProblem problem =
      tracking_problem(linear_system(one, 0 * one, Eigen::VectorXd::Zero(1)), Integrator::discrete,
                       1, 1, {0}, {{0}, {1}, {2}, {1}, false});
  const ControlBounds bounds(problem);
  Linearization linearization(problem);
  const Trajectory trajectory = problem.create_trajectory();
  Evaluator(problem).differentiate(trajectory, linearization);
  BackwardSweep sweep(problem, bounds);
  Feedback feedback(problem);
  const auto stages = unconstrained_stage(problem);
  EXPECT_EQ(sweep.run(linearization, trajectory, Gaps(problem), {}, *stages, feedback), -1);
  EXPECT_EQ(sweep.Quu(0)(0, 0), 2);
  LbfgsCorrection memory(bounds);
  feedback.k[0][0] = 1;
  memory.observe(feedback, sweep, stages->active_set());
  if (taken) memory.step_taken(feedback);
  feedback.k[0][0] = k;
  memory.observe(feedback, sweep, stages->active_set());
  if (!memory.correct(feedback)) return std::nullopt;
  return feedback.k[0][0];
}

// The step 1 changed the gradient by 2 − 2k, the true curvature; the model has 2.
TEST(LbfgsCorrection, OneControlGetsTheSecantStep) {
  EXPECT_DOUBLE_EQ(corrected_after(0.4).value(), 0.8 / 1.2);
  EXPECT_DOUBLE_EQ(corrected_after(-0.5).value(), -1.0 / 3);
  EXPECT_FALSE(corrected_after(0.4, false)) << "no step was taken";
}

TEST(LbfgsCorrection, SkipsPoorQuadraticFitsAndNeedlessCorrections) {
  // Curvatures 0.79 and 5.1 are outside [2/2.5, 2·2.5]; 0.81 and 4.9 are just inside.
  EXPECT_FALSE(corrected_after(0.605));
  EXPECT_FALSE(corrected_after(-1.55));
  EXPECT_TRUE(corrected_after(0.595));
  EXPECT_TRUE(corrected_after(-1.45));
  // The direction shrank to a fifth.
  EXPECT_FALSE(corrected_after(0.19));
  EXPECT_FALSE(corrected_after(-0.19));
  EXPECT_TRUE(corrected_after(0.21));
  EXPECT_TRUE(corrected_after(-0.21));
}

}  // namespace
}  // namespace conddp::testing
