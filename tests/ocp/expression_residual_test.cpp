#include "ocp/residuals/expression_residual.hpp"

#include <gtest/gtest.h>

#include "support/expression_systems.hpp"
#include "support/knot_case.hpp"
#include "support/second_derivatives.hpp"

namespace conddp {
namespace {

std::shared_ptr<const Residual> expression_residual(const KnotModel& model,
                                                    const ExpressionResidualText& text) {
  const ParsedExpressionResidual parsed = make_expression_residual(model.manifold(), text);
  if (!parsed.residual) throw std::invalid_argument(parsed.errors.at(0).message.message);
  return parsed.residual;
}

std::shared_ptr<const MultibodySystem> small_robot(bool floating) {
  const auto robot = std::make_shared<RobotModel>(
      random_robot(51, {.joints = 3, .floating = floating, .wrenches = 0}));
  return std::make_shared<MultibodySystem>(robot, Actuation::full(*robot));
}

/// Rows of every kind for a system: on all of its columns, separately and in vectors.
std::vector<std::string> rows_of(const System& system) {
  std::vector<std::string> rows;
  std::string sum = "0.3";
  for (const KnotName& name : knot_names(system)) {
    const bool of_control = name.numbers[0].of_control;
    if (name.numbers.size() == 1 && name.parts.empty()) {
      rows.push_back(fmt::format("sin({0}) + 0.2*{0}^2", name.name));
      sum += fmt::format(" + 0.4*{}", name.name);
      continue;
    }
    for (const auto& part : name.parts) {
      const std::string text = fmt::format("{}[{}]", name.name, part.name);
      if (part.count == 1) {
        rows.push_back(fmt::format("0.5*{}", text));
        sum += fmt::format(" - 0.3*{}", text);
      } else if (part.count == 3) {
        rows.push_back(fmt::format("[norm({0} + [0.1, 0.2, 0.3]), 2*{0}]", text));
      } else {
        rows.push_back(fmt::format("rotate({}, [1, 2, 3])", text));
      }
    }
    if (of_control) rows.push_back(fmt::format("smooth_norm({}, 0.1)", name.name));
  }
  rows.push_back(fmt::format("cos({})", sum));
  rows.push_back(fmt::format("[{0}, exp(0.1*({0}))]", sum));
  return rows;
}

std::vector<std::pair<std::string, std::shared_ptr<const System>>> systems_with_names() {
  std::vector<std::pair<std::string, std::shared_ptr<const System>>> systems = {
      {"cartpole", cartpole({})},
      {"unicycle", unicycle()},
      {"arm", small_robot(false)},
      {"floating arm", small_robot(true)}};
  for (const SystemInWords& system : systems_in_words())
    if (system.name == "quadrotor" || system.name == "lander")
      systems.emplace_back(system.name, expression_system(system.text));
  return systems;
}

TEST(ExpressionResiduals, GradientsMatchDualNumbers) {
  RandomNumbers random(61);
  for (const auto& [name, system] : systems_with_names())
    for (const bool memory : {false, true}) {
      const Integrator integrator = integrators_of(*system).front();
      const auto model = std::make_shared<KnotModel>(step_with(system, integrator, memory));
      model->add_cost(
          "rows",
          expression_residual(*model, {.names = knot_names(*system), .rows = rows_of(*system)}),
          {});
      const KnotCase c = make_case(name, model, random);
      KnotWorkspace<double> work(*model);
      model->differentiate({c.x.data(), c.u.data(), c.parameters.data(), c.dt, c.dt}, work, true);
      double scale = 1;
      for (const double g : work.gradient) scale = std::max(scale, std::abs(g));
      for (int d = 0; d < model->nz(); ++d)
        EXPECT_NEAR(work.gradient[d], directional_derivative(c, d).cost, 1e-12 * scale)
            << name << " direction " << d;
    }
}

TEST(ExpressionResiduals, PartwiseExactHessiansMatchDualNumbers) {
  RandomNumbers random(62);
  for (const auto& [name, system] : systems_with_names()) {
    if (system->kind() != SystemKind::second_order || name == "cartpole") continue;
    const auto model = std::make_shared<KnotModel>(system, Integrator::semi_implicit_euler);
    model->add_cost(
        "rows",
        expression_residual(*model, {.names = knot_names(*system), .rows = rows_of(*system)}),
        {.kind = ActivationKind::smooth_l1, .epsilon = 0.3});
    EXPECT_TRUE(known_by_parts(*model)) << name;
    const KnotCase c = make_case(name, model, random);
    const ShootingProblem problem = problem_of(c, kLaneWidth + 1);
    Trajectory t = problem.create_trajectory();
    for (int k = 0; k <= problem.knots(); ++k) {
      const auto x = random_manifold_state(problem.manifold(), random, 1.0);
      std::copy(x.begin(), x.end(), t.x(k).data());
      if (k == problem.knots()) break;
      for (double& u : t.u(k)) u = random.uniform(-2, 2);
    }
    SCOPED_TRACE(name);
    expect_hessians_of_dual_numbers(problem, t, Augmentation(problem), random);
  }
}

std::vector<double> values_of(const Residual& residual, const System& system,
                              const std::vector<double>& x, const std::vector<double>& u,
                              std::vector<double> parameters = {}) {
  const auto data = system.create_data(0.0);
  std::vector<double> r(residual.size());
  if (parameters.empty()) parameters.assign(residual.size(), 0.0);
  residual.evaluate({x.data(), u.data(), parameters.data(), *data}, r.data());
  return r;
}

TEST(ExpressionResiduals, NamesAreTheColumnsOfTheSystem) {
  const auto system = small_robot(true);
  const KnotModel model(system, Integrator::semi_implicit_euler);
  const std::string base =
      system->state_columns()[0].name.substr(0, system->state_columns()[0].name.find('/'));
  const std::string joint = system->state_columns()[8].name.substr(2);
  ASSERT_EQ(system->state_columns()[8].name, "q/" + joint);
  const auto residual = expression_residual(
      model, {.names = knot_names(*system),
              .rows = {base + ".position", base + ".angular",
                       "q[" + joint + "] + u[0]*v[" + joint + "]", base + "[qw]"}});
  RandomNumbers random(63);
  const std::vector<double> x = random_manifold_state(system->manifold(), random, 1),
                            u = random.numbers(model.nu(), 1);
  const std::vector<double> r = values_of(*residual, *system, x, u);
  const int nq = system->nq();
  EXPECT_EQ(r, (std::vector<double>{x[0], x[1], x[2], x[nq + 3], x[nq + 4], x[nq + 5],
                                    std::fma(u[0], x[nq + 7], x[8]), x[6]}));
}

TEST(ExpressionResiduals, DeclareTheColumnsThatTheyRead) {
  const auto system = cartpole({});
  const KnotModel model(system, Integrator::rk4);
  const auto residual = expression_residual(
      model, {.names = knot_names(*system),
              .parameters = {{"l", 0.5}},
              .definitions = {{"tip", "x + l*sin(theta)"}},
              .rows = {"tip", "x*theta", "omega", "force - vx", "2*vx + 3*force"}});
  EXPECT_TRUE(residual->needs_control());
  const auto& blocks = residual->blocks();
  ASSERT_EQ(blocks.size(), 3u);
  EXPECT_EQ(blocks[0].columns, (std::vector<int>{0, 1}));
  EXPECT_EQ(blocks[0].rows, 2);
  EXPECT_FALSE(blocks[0].affine);
  EXPECT_EQ(blocks[1].columns, (std::vector<int>{3}));
  EXPECT_TRUE(blocks[1].affine);
  EXPECT_EQ(blocks[2].columns, (std::vector<int>{2, 4}));
  EXPECT_EQ(blocks[2].rows, 2);
  EXPECT_TRUE(blocks[2].affine);
  EXPECT_FALSE(
      expression_residual(model, {.names = knot_names(*system), .rows = {"x"}})->needs_control());
}

TEST(ExpressionResiduals, RowsAreMeasuredFromTheirReferences) {
  const auto system = unicycle();
  const KnotModel model(system, Integrator::rk4);
  const auto residual =
      expression_residual(model, {.names = knot_names(*system), .rows = {"x*y", "[theta, x]"}});
  EXPECT_EQ(residual->parameter_count(), 3);
  EXPECT_EQ(values_of(*residual, *system, {2, 3, 4}, {0, 0}, {1, 0.5, -1}),
            (std::vector<double>{5, 3.5, 3}));
}

TEST(ExpressionResiduals, AllowConstantRowsIfTimeCosts) {
  const auto system = unicycle();
  const KnotModel model(system, Integrator::rk4);
  const auto residual = expression_residual(
      model, {.names = knot_names(*system), .rows = {"2*pi"}, .constants = true});
  EXPECT_TRUE(residual->blocks()[0].columns.empty());
  EXPECT_NEAR(values_of(*residual, *system, {2, 3, 4}, {0, 0})[0], 2 * M_PI, 1e-15);
}

TEST(ExpressionResiduals, TimeIsAParameterUnlessAColumn) {
  const auto system = unicycle();
  const KnotModel model(system, Integrator::rk4);
  ExpressionResidualText text{.names = knot_names(*system),
                              .rows = {"x - sin(t) + 10*phase_time + 100*final_time"}};
  const auto residual = expression_residual(model, text);
  EXPECT_EQ(residual->parameter_count(), 4);
  EXPECT_TRUE(make_expression_residual(model.manifold(), text).reads_time);
  EXPECT_NEAR(values_of(*residual, *system, {2, 0, 0}, {0, 0}, {0.25, 0.5, 0.125, 2})[0],
              1.75 - std::sin(0.5) + 1.25 + 200, 1e-13);
  // Other names of the file do not hide them.
  text.parameters = {{"speed", 3.0}};
  text.definitions = {{"double_speed", "2*speed"}};
  EXPECT_EQ(expression_residual(model, text)->parameter_count(), 4);
  text.rows = {"x"};
  EXPECT_EQ(expression_residual(model, text)->parameter_count(), 1);
  EXPECT_FALSE(make_expression_residual(model.manifold(), text).reads_time);

  const auto timed = expression_system({.kind = SystemKind::first_order,
                                        .states = {{"x"}},
                                        .controls = {{"u", "1"}},
                                        .equations = {{"x", "u*t"}}});
  const KnotModel with_clock(timed, Integrator::rk4);
  const auto read = expression_residual(with_clock, {.names = knot_names(*timed), .rows = {"x*t"}});
  EXPECT_EQ(read->parameter_count(), 1);
  EXPECT_EQ(read->blocks()[0].columns, (std::vector<int>{0, 1}));
}

// Rows of times only: values without durations, and share s of each duration.
TEST(ExpressionResiduals, TimesGrowWithShareOfFreeDurations) {
  const auto system = unicycle();
  const KnotModel model(system, Integrator::rk4);
  const auto residual = expression_residual(model, {.names = knot_names(*system),
                                                    .rows = {"t", "phase_time", "final_time"},
                                                    .durations = {2, 0}});
  const std::vector<double> references = {0.5, 0.25, 0.125}, times = {1, 2, 4},
                            t_shares = {0.75, 3}, phase_shares = {5, 7};
  std::vector<double> parameters;
  for (const auto& part : {references, times, t_shares, phase_shares})
    parameters.insert(parameters.end(), part.begin(), part.end());
  EXPECT_EQ(residual->parameter_count(), static_cast<int>(parameters.size()));
  const double theta = 16, x = 11;
  EXPECT_EQ(values_of(*residual, *system, {x, 1000, theta}, {0, 0}, parameters),
            (std::vector<double>{1 + 0.75 * theta + 3 * x - 0.5, 2 + 5 * theta + 7 * x - 0.25,
                                 4 + theta + x - 0.125}));
}

TEST(ExpressionResiduals, ManyRowsHaveRoomOnTheStack) {
  const auto system = cartpole({});
  const KnotModel model(system, Integrator::rk4);
  ExpressionResidualText text{.names = knot_names(*system), .rows = {}};
  for (int i = 0; i < 300; ++i) text.rows.push_back(fmt::format("sin(x*{} + theta)", i + 1));
  const auto residual = expression_residual(model, text);
  const auto data = system->create_data(0.0);
  const double x[] = {0.3, -0.4, 0, 0};
  std::vector<double> r(residual->size()), jacobian(residual->jacobian_size());
  const std::vector<double> zero(residual->size());
  residual->differentiate({x, nullptr, zero.data(), *data}, r.data(), jacobian.data());
  for (int i = 0; i < 300; ++i) {
    const double angle = x[0] * (i + 1) + x[1];
    EXPECT_NEAR(r[i], std::sin(angle), 1e-13);
    EXPECT_NEAR(jacobian[i], (i + 1) * std::cos(angle), 1e-11);
    EXPECT_NEAR(jacobian[300 + i], std::cos(angle), 1e-13);
  }
  for (int i = 300; i < 2500; ++i) text.rows.push_back(fmt::format("sin(x*{} + theta)", i + 1));
  EXPECT_EQ(make_expression_residual(model.manifold(), text).errors.at(0).message.message,
            "the expressions need more than 4096 intermediate results");
}

TEST(ExpressionResiduals, InvalidTextsHaveAPlace) {
  using Part = ModelMessage::Part;
  const auto system = cartpole({});
  const ExpressionResidualText good{.names = knot_names(*system), .rows = {"x", "theta"}};
  const auto expect = [&](auto change, Part part, int index, bool in_text, int offset,
                          const std::string& message) {
    ExpressionResidualText text = good;
    change(text);
    const ParsedExpressionResidual parsed = make_expression_residual(system->manifold(), text);
    EXPECT_EQ(parsed.residual, nullptr) << message;
    ASSERT_EQ(parsed.errors.size(), 1u) << message;
    EXPECT_EQ(parsed.errors[0].message.message, message);
    EXPECT_EQ(parsed.errors[0].message.offset, offset) << message;
    EXPECT_EQ(parsed.errors[0].part, part) << message;
    EXPECT_EQ(parsed.errors[0].index, index) << message;
    EXPECT_EQ(parsed.errors[0].in_text, in_text) << message;
  };
  using Text = ExpressionResidualText;
  expect([](Text& t) { t.rows[1] = "theta + thta"; }, Part::kRow, 1, true, 8,
         "unknown name 'thta'");
  expect([](Text& t) { t.rows[0] = "2*pi"; }, Part::kRow, 0, true, 0,
         "a row of a residual depends on the state or the control, and this does not");
  expect([](Text& t) { t.rows[0] = "sin(t)"; }, Part::kRow, 0, true, 0,
         "a row of a residual depends on the state or the control, and this does not");
  expect([](Text& t) { t.rows[1] = "x > 1"; }, Part::kRow, 1, true, 0,
         "a row of a residual is a number or a vector, and this is a condition");
  expect(
      [](Text& t) {
        t.parameters = {{"x", 1}};
      },
      Part::kParameter, 0, false, 0, "the name 'x' is taken");
  expect(
      [](Text& t) {
        t.definitions = {{"a b", "1"}};
      },
      Part::kDefinition, 0, false, 0,
      "'a b' is not a name of expressions: letters, digits and '_', no digit at first");
  expect(
      [](Text& t) {
        t.definitions = {{"a", "x +"}};
      },
      Part::kDefinition, 0, true, 3,
      "the expression ends where a number, a name or '(' is expected");
  expect(
      [](Text& t) {
        t.tables = {{"sin", std::make_shared<SplineTable>(std::vector<double>{0, 1},
                                                          std::vector<double>{0, 1})}};
      },
      Part::kTable, 0, false, 0, "'sin' is a function of the expression language");
  ExpressionResidualText kinked = good;
  kinked.rows[1] = "abs(theta)";
  const auto warned = make_expression_residual(system->manifold(), kinked);
  EXPECT_NE(warned.residual, nullptr);
  ASSERT_EQ(warned.warnings.size(), 1u);
  EXPECT_EQ(warned.warnings[0].index, 1);
}

// (x − 0.5)(θ + 1) + (v − 0.1)² and y (ω + 0.2); the factors are rows of other residuals with their
// own references.
TEST(ExpressionResiduals, NameRowsOfOtherResidualsWithOwnReferences) {
  const auto system = unicycle();
  KnotModel model(system, Integrator::rk4);
  const auto residual = expression_residual(
      model,
      {.names = knot_names(*system),
       .operands =
           {{"place", coordinate_residual(model.manifold(), {0, 2}), {0.5, -1}, {"x", "turn"}},
            {"push", control_residual(3, 2), {0.1, -0.2}, {"ahead", "around"}}},
       .rows = {"place[x]*place[turn] + push[ahead]^2", "y*push[around]"}});
  EXPECT_TRUE(residual->needs_control());
  EXPECT_EQ(residual->parameter_count(), 2);
  EXPECT_FALSE(residual->has_claimed_hessian());
  EXPECT_TRUE(residual->failed_functions().empty());
  model.add_constraint(make_constraint("rows", residual, ConstraintKind::bounds));
  const std::vector<double> x = {2, 3, 0.25}, u = {0.7, -1.2};
  const std::vector<double> parameters = {10, 20, 0, 0, 0, 0, 1};
  KnotWorkspace<double> work(model);
  const KnotInput<double> in{x.data(), u.data(), parameters.data(), 0.1, 1};
  model.evaluate(in, work);
  EXPECT_NEAR(work.constraint[0], 1.5 * 1.25 + 0.36 - 10, 1e-14);
  EXPECT_NEAR(work.constraint[1], 3 * -1.0 - 20, 1e-14);
  model.differentiate(in, work, false);
  EXPECT_NEAR(work.constraint[0], 1.5 * 1.25 + 0.36 - 10, 1e-14);
  EXPECT_NEAR(work.constraint[1], 3 * -1.0 - 20, 1e-14);
  Eigen::MatrixXd C = Eigen::MatrixXd::Zero(2, 5);
  for (std::size_t e = 0; e < model.constraint_pattern().size(); ++e)
    C(model.constraint_pattern()[e].first, model.constraint_pattern()[e].second) =
        work.constraint_jacobian[e];
  const Eigen::MatrixXd expected{{1.25, 0, 1.5, 1.2, 0}, {0, -1, 0, 0, 3}};
  EXPECT_LT((C - expected).norm(), 1e-14) << C;
}

}  // namespace
}  // namespace conddp
