// The trot of HyQ that Crocoddyl and Pinocchio solved: the same discretisation, costs and contacts,
// and figures at the first guess and at the optimum. The robot and the figures are not part of the
// product: without them the tests pass over themselves.
#include <fstream>

#include <Eigen/Dense>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "ocp/acts.hpp"
#include "problem_file/build.hpp"
#include "problem_file/read_problem.hpp"
#include "solvers/registry.hpp"
#include "support/robots.hpp"

namespace conddp {
namespace {

using Eigen::Map;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Json = nlohmann::json;

std::string list(const Json& numbers) { return numbers.dump(); }

/// Short names of the feet: LF for lf_foot.
std::string contact_name(const std::string& foot) {
  return {static_cast<char>(foot[0] - 'a' + 'A'), static_cast<char>(foot[1] - 'a' + 'A')};
}

std::string problem_text(const Json& reference) {
  const std::string x0 = list(reference["x0"]), weights = list(reference["state_weights"]);
  std::string contacts, phases, swings;
  for (const char* foot : {"lf_foot", "rf_foot", "lh_foot", "rh_foot"}) {
    contacts += fmt::format("  {}: {{frame: {}}}\n", contact_name(foot), foot);
    std::vector<int> knots;
    Json values = Json::array();
    for (const Json& knot : reference["knots"])
      if (knot["swing_ref"].contains(foot)) {
        knots.push_back(knot["k"]);
        values.push_back(knot["swing_ref"][foot]);
      }
    swings += fmt::format(
        "  swing_{0}: {{residual: frame_position, frame: {0}, weight: 1.0e+4, knots: {1}, "
        "reference: {{knots: {1}, values: {2}}}}}\n",
        foot, Json(knots).dump(), values.dump());
  }
  std::vector<std::pair<Json, int>> runs;
  for (const Json& knot : reference["knots"]) {
    if (runs.empty() || runs.back().first != knot["contacts"])
      runs.push_back({knot["contacts"], 0});
    ++runs.back().second;
  }
  for (const auto& [feet, knots] : runs) {
    std::string names;
    for (const Json& foot : feet) names += (names.empty() ? "" : ", ") + contact_name(foot);
    phases += fmt::format("  - {{knots: {}, dt: {}, contacts: [{}]}}\n", knots,
                          reference["dt"].get<double>(), names);
  }
  return fmt::format(R"(conddp: 1
name: hyq_trot
robot: {{urdf: hyq.urdf, base: floating}}
contacts:
  defaults: {{friction: 0.7, baumgarte: {{kp: 0, kd: 50}}}}
{0}initial_state: {{state: {1}}}
phases:
{2}costs:
  state: {{residual: state, reference: {1}, weight: 0.1, weights: {3}}}
  control: {{residual: control, weight: 1.0e-3}}
  com: {{residual: com_position, reference: {4}, weight: 100}}
  cone: {{residual: friction_cone, contacts: all, faces: 4, inner: false, weight: 10}}
{5}constraints:
  torque: {{bounds: control, from: urdf}}
terminal:
  costs:
    state: {{residual: state, reference: {1}, weight: 10, weights: {3}}}
    com: {{residual: com_position, reference: {4}, weight: 100}}
initial_guess: {{states: initial, controls: quasi_static}}
solver: {{name: box_fddp, tolerances: {{stationarity: 1.0e-9}}}}
)",
                     contacts, x0, phases, weights, list(reference["com_ref"]), swings);
}

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

class HyqTrot : public testing::Test {
 protected:
  void SetUp() override {
    const auto folder = foreign_robot_folder();
    const auto figures = folder.parent_path() / "reference/hyq_trot.json";
    if (!std::filesystem::exists(figures) || !std::filesystem::exists(folder / "hyq.urdf"))
      GTEST_SKIP() << kNoForeignRobots << " and beside it reference/hyq_trot.json";
    std::ifstream stream(figures);
    reference_ = Json::parse(stream);
    spec_ = read_problem_text(problem_text(reference_), folder / "hyq_trot.yaml", {}, diagnostics_);
    ASSERT_TRUE(spec_) << format_diagnostics(diagnostics_, false);
    built_ = build_problem(*spec_, {}, diagnostics_);
    ASSERT_TRUE(built_) << format_diagnostics(diagnostics_, false);
  }

  /// What a knot of the figures has, against ours.
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
      Acts acts(*built_->problem);
      Linearization lin(*built_->problem);
      acts.differentiate(trajectory, lin);
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
      compare(ours.hessian.topLeftCorner(n, n), knot["Lxx"], "Lxx");
      compare(ours.hessian.topRightCorner(n, m), knot["Lxu"], "Lxu");
      compare(ours.hessian.bottomRightCorner(m, m), knot["Luu"], "Luu");
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
    for (const auto& [name, value] : cost_by_name(*built->problem, built->guess)) guessed += value;
    EXPECT_NEAR(guessed, reference_["initial_guess"]["cost"].get<double>(), 1e-8 * guessed);
    const SolveResult result = solve(*built->problem, solver, spec_->solver.options, built->guess);
    EXPECT_EQ(result.status, SolveStatus::converged) << solver;
    EXPECT_NEAR(result.cost, optimum, 1e-9 * optimum) << solver;
  }
}

}  // namespace
}  // namespace conddp
