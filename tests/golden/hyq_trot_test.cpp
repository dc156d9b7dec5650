// The HyQ trot solved by Crocoddyl and Pinocchio: the same discretization, costs, and contacts,
// compared at the first guess and at the optimum. Robot and reference data are not part of the
// product; without them the tests are skipped.
#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/foreign_problems.hpp"

namespace conddp {
namespace {

using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Json = nlohmann::json;

VectorXd vector_of(const Json& numbers) {
  VectorXd v(numbers.size());
  for (std::size_t i = 0; i < numbers.size(); ++i) v[i] = numbers[i];
  return v;
}
MatrixXd matrix_of(const Json& rows) {
  MatrixXd m(rows.size(), rows[0].size());
  for (std::size_t i = 0; i < rows.size(); ++i) m.row(i) = vector_of(rows[i]).transpose();
  return m;
}

class HyqTrot : public ::testing::Test {
 protected:
  void SetUp() override {
    const auto trot = hyq_trot();
    const auto reference = hyq_trot_reference();
    if (!trot || !reference)
      GTEST_SKIP() << kNoForeignRobots << " and beside it reference/hyq_trot.json";
    reference_ = *reference;
    trot_ = *trot;
    read({});
  }

  /// Reads the trot with additional settings.
  void read(const std::vector<std::string>& overrides) {
    std::vector<std::string> settings = trot_.settings;
    settings.insert(settings.end(), overrides.begin(), overrides.end());
    spec_ = read_problem(trot_.file, settings, diagnostics_);
    ASSERT_TRUE(spec_) << format_diagnostics(diagnostics_, false);
    built_ = build_problem(*spec_, {}, diagnostics_);
    ASSERT_TRUE(built_) << format_diagnostics(diagnostics_, false);
  }

  /// Steps with exact Hessians and plain Gauss-Newton steps take different paths to the same cost.
  void expect_cost(double cost) {
    SolverOptions options = spec_->solver.options;
    const SolveResult result = solve(*built_->problem, "box_fddp", options, built_->guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
    EXPECT_NEAR(result.cost, cost, 1e-9 * cost);
    options.hessian = HessianChoice::gauss_newton;
    const SolveResult plain = solve(*built_->problem, "box_fddp", options, built_->guess);
    EXPECT_EQ(plain.status, SolveStatus::converged) << plain.message;
    EXPECT_NEAR(plain.cost, cost, 1e-9 * cost);
  }

  /// Requires that the solver satisfies all constraints.
  SolveResult expect_constrained(const char* solver) {
    SolverOptions options;
    options.max_iterations = 200;
    SolveResult result = solve(*built_->problem, solver, options, built_->guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver << ": " << result.message;
    EXPECT_LE(result.residuals.constraint, 1e-6) << solver;
    EXPECT_LE(result.residuals.stationarity, 1e-6) << solver;
    EXPECT_LE(result.residuals.complementarity, 1e-6) << solver;
    return result;
  }

  /// Compares a knot of the reference data with ours.
  void expect_same_knot(const Json& knot) const {
    const int k = knot["t"];
    const ShootingProblem& problem = *built_->problem;
    const KnotView& view = problem.knot(k);
    const VectorXd x = vector_of(knot["x"]);
    const bool last = k == problem.knots();
    const VectorXd u = last ? VectorXd() : vector_of(knot["u"]);
    KnotWorkspace<double> work(*view.model);
    view.model->differentiate(
        KnotInput<double>{x.data(), u.data(), view.parameters, view.dt, view.cost_scale}, work,
        true);
    const double cost = knot["cost"];
    EXPECT_NEAR(work.cost, cost, 1e-9 * (1 + std::abs(cost))) << "knot " << k;
    if (last) return;
    EXPECT_LT((Map<const VectorXd>(work.next().data(), x.size()) - vector_of(knot["xnext"]))
                  .lpNorm<Eigen::Infinity>(),
              1e-9)
        << "knot " << k;
    const auto data = view.model->system().create_data(double{});
    view.model->system().evaluate(x.data(), u.data(), *data);
    const auto& system = static_cast<const MultibodySystem&>(view.model->system());
    const auto& d = static_cast<const MultibodySystem::Data<double>&>(*data);
    const VectorXd acceleration = vector_of(knot["ddq"]);
    EXPECT_LT((Map<const VectorXd>(d.f.data(), acceleration.size()) - acceleration)
                  .lpNorm<Eigen::Infinity>(),
              1e-9 * (1 + acceleration.lpNorm<Eigen::Infinity>()));
    for (int i = 0; i < system.contacts().count(); ++i) {
      const std::string name = system.robot().frames[system.contacts().contacts()[i].frame].name;
      const VectorXd force = vector_of(knot["contact_force"][name + "_contact"]);
      const Force<double> ours = contact_force_in_world(d.contacts.contacts[i]);
      for (int j = 0; j < 3; ++j)
        EXPECT_NEAR(ours[j], force[j], 1e-9 * (1 + force.lpNorm<Eigen::Infinity>()));
    }
  }

  ForeignProblem trot_;
  Json reference_;
  Diagnostics diagnostics_;
  std::optional<ProblemSpec> spec_;
  std::optional<BuiltProblem> built_;
};

TEST_F(HyqTrot, KnotsHaveTheSameCostDynamicsAndForces) {
  for (const char* list_name : {"check_initial_guess_knots", "check_optimum_all_knots"})
    for (const Json& knot : reference_[list_name]) expect_same_knot(knot);
}

TEST_F(HyqTrot, KnotsHaveTheSameDerivatives) {
  for (const char* list_name : {"check_initial_guess_knots", "check_optimum_derivatives"})
    for (const Json& knot : reference_[list_name]) {
      const int k = knot["t"];
      if (k == built_->problem->knots()) continue;
      Trajectory trajectory = built_->problem->create_trajectory();
      trajectory.x(k) = vector_of(knot["x"]);
      trajectory.u(k) = vector_of(knot["u"]);
      Evaluator evaluator(*built_->problem);
      Linearization lin(*built_->problem);
      evaluator.differentiate(trajectory, lin);
      const KnotLinearization& ours = lin.knots[k];
      const int n = ours.ndx, m = ours.nu();
      const auto compare = [&](const MatrixXd& found, const Json& expected, const char* what) {
        const MatrixXd figure =
            expected[0].is_array() ? matrix_of(expected) : MatrixXd(vector_of(expected));
        EXPECT_LT((found - figure).lpNorm<Eigen::Infinity>(),
                  1e-9 * (1 + figure.lpNorm<Eigen::Infinity>()))
            << what << " of knot " << k;
      };
      const MatrixXd jacobian = ours.dense_jacobian();
      compare(jacobian.leftCols(n), knot["Fx"], "Fx");
      compare(jacobian.rightCols(m), knot["Fu"], "Fu");
      compare(ours.gradient.head(n), knot["Lx"], "Lx");
      compare(ours.gradient.tail(m), knot["Lu"], "Lu");
      compare(ours.hessian().topLeftCorner(n, n), knot["Lxx"], "Lxx");
      compare(ours.hessian().topRightCorner(n, m), knot["Lxu"], "Lxu");
      compare(ours.hessian().bottomRightCorner(m, m), knot["Luu"], "Luu");
    }
}

TEST_F(HyqTrot, HasCrocoddylsOptimalCost) {
  const double optimum = reference_["optimum"]["cost"];
  for (const char* solver : {"box_fddp", "fddp", "box_ddp"}) {
    const bool bounded = std::string(solver) != "fddp";
    const auto built = build_problem(
        *spec_, {.drop = bounded ? std::vector<std::string>{} : std::vector<std::string>{"torque"}},
        diagnostics_);
    ASSERT_TRUE(built);
    double guessed = 0;
    for (const auto& [name, value] :
         cost_by_name(*built->problem, NodeValues(*built->problem, built->guess)))
      guessed += value;
    EXPECT_NEAR(guessed, reference_["initial_guess"]["cost"].get<double>(), 1e-8 * guessed);
    const SolveResult result = solve(*built->problem, solver, spec_->solver.options, built->guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver;
    EXPECT_NEAR(result.cost, optimum, 1e-9 * optimum) << solver;
  }
}

TEST_F(HyqTrot, Converges) { expect_cost(reference_["optimum"]["cost"]); }

// Crocoddyl's BoxFDDP reaches the same costs.
TEST_F(HyqTrot, ConvergesWithWeakMotors) {
  read({"constraints.torque={bounds: control, lower: -60, upper: 60}"});
  expect_cost(4.98860191029);
}

TEST_F(HyqTrot, ConvergesOnASlipperyFloor) {
  read({"contacts.defaults.friction=0.15"});
  expect_cost(3.5411302063);
}

// Zero controls are a distant guess: the robot falls, and its weak motors cannot close all gaps at
// once. Crocoddyl's BoxFDDP reaches the same costs.
TEST_F(HyqTrot, WeakMotorsBeginWithoutTorque) {
  for (const int limit : {150, 100, 75, 60}) {
    for (const char* friction : {"0.7", "0.15"}) {
      const std::string bounds = "constraints.torque={bounds: control, lower: -" +
                                 std::to_string(limit) + ", upper: " + std::to_string(limit) + "}";
      read({bounds, std::string("contacts.defaults.friction=") + friction,
            "initial_guess.controls=zero"});
      SolverOptions options = spec_->solver.options;
      options.max_iterations = 200;
      const SolveResult zero = solve(*built_->problem, "box_fddp", options, built_->guess);
      EXPECT_EQ(zero.status, SolveStatus::converged) << limit << ": " << zero.message;
      read({bounds, std::string("contacts.defaults.friction=") + friction});
      const SolveResult near = solve(*built_->problem, "box_fddp", options, built_->guess);
      EXPECT_EQ(near.status, SolveStatus::converged) << limit << ": " << near.message;
      EXPECT_NEAR(zero.cost, near.cost, 1e-6 * near.cost) << limit << ' ' << friction;
    }
  }
}

constexpr const char* kSixty = "constraints.torque={bounds: control, lower: -60, upper: 60}";
constexpr const char* kSlippery = "contacts.defaults.friction=0.15";
constexpr const char* kPyramid =
    "constraints.grip={residual: friction_cone, contacts: all, faces: 4, inner: false}";
constexpr const char* kCone =
    "constraints.grip={residual: friction_cone, contacts: all, cone: second_order}";

// Aligator's ProxDDP converges here from the quasi-static guess with no tested initial mu.
TEST_F(HyqTrot, ConvergesOnSlipperyFloorWithWeakMotors) {
  for (const char* cone : {kPyramid, kCone}) {
    read({kSixty, kSlippery, cone});
    const SolveResult altro = expect_constrained("altro");
    const SolveResult proxddp = expect_constrained("proxddp");
    EXPECT_NEAR(altro.cost, proxddp.cost, 1e-6 * altro.cost) << cone;
    // The outer pyramid admits more force than the cone.
    EXPECT_NEAR(altro.cost, cone == kPyramid ? 6.67678 : 6.91456, 1e-4) << cone;
  }
}

TEST_F(HyqTrot, ConvergesWithHardConesAndStandardMotors) {
  for (const char* cone : {kPyramid, kCone}) {
    read({cone});
    EXPECT_NEAR(expect_constrained("proxddp").cost, reference_["optimum"]["cost"], 1e-7);
    read({kSlippery, cone});
    EXPECT_GT(expect_constrained("proxddp").cost, reference_["optimum"]["cost"]);
  }
}

}  // namespace
}  // namespace conddp
