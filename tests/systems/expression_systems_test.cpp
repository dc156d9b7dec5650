// Expression systems, compared with compiled ones.
#include "support/expression_systems.hpp"

#include <gtest/gtest.h>

#include "support/random_numbers.hpp"
#include "system_comparison.hpp"
#include "systems/collocation_system.hpp"
#include "systems/expressions/system.hpp"

namespace conddp {
namespace {

TEST(ExpressionSystems, EveryClosedFormSystemMatchesTheCompiledOne) {
  for (const SystemInWords& system : systems_in_words()) {
    const auto in_words = expression_system(system.text);
    ASSERT_EQ(in_words->nx(), system.compiled->nx()) << system.name;
    ASSERT_EQ(in_words->ndx(), system.compiled->ndx()) << system.name;
    ASSERT_EQ(in_words->nu(), system.compiled->nu()) << system.name;
    ASSERT_EQ(in_words->kind(), system.compiled->kind()) << system.name;
    EXPECT_EQ(static_cast<int>(in_words->state_columns().size()), in_words->nx());
    EXPECT_EQ(static_cast<int>(in_words->control_columns().size()), in_words->nu());
    expect_equal_answers<double>(system.name, *in_words, *system.compiled);
    expect_equal_answers<Lane>(system.name, *in_words, *system.compiled);
    expect_equal_answers<Dual<Lane>>(system.name, *in_words, *system.compiled);
  }
}

// As expressions, and as recorded closed forms.
TEST(ExpressionSystems, SecondDerivativesMatchDualNumbers) {
  RandomNumbers random(312);
  for (const SystemInWords& system : systems_in_words()) {
    const auto in_words = expression_system(system.text);
    const SystemPoint<Lane> point = random_point<Lane>(*in_words, random);
    AlignedVector<Lane> weights;
    for (int i = 0; i < in_words->rows(); ++i) weights.push_back(Lane(random.uniform(-1, 1)));
    const int nz = in_words->ndx() + in_words->nu();
    const AlignedVector<Lane> expected =
        symmetric_part(curvature_by_duals(*system.compiled, point, weights), nz);
    expect_equal_numbers(own_curvature(*in_words, point, weights), expected, 1e-11, system.name);
    expect_equal_numbers(own_curvature(*system.compiled, point, weights), expected, 1e-11,
                         system.name + ", recorded");
  }
}

TEST(ExpressionSystems, CollocationDerivativesMatchCompiledSystems) {
  RandomNumbers random(315);
  for (const SystemInWords& system : systems_in_words()) {
    if (system.text.kind == SystemKind::discrete || !system.compiled->manifold().curved().empty())
      continue;
    for (const CollocationRule rule :
         {CollocationRule::trapezoidal, CollocationRule::hermite_simpson, CollocationRule::radau3,
          CollocationRule::radau5}) {
      const CollocationSystem got(expression_system(system.text), rule);
      const CollocationSystem expected(system.compiled, rule);
      const SystemPoint<Lane> point = random_point<Lane>(expected, random);
      const auto a = got.create_data(Lane{}), b = expected.create_data(Lane{});
      got.differentiate(point.x.data(), point.u.data(), *a);
      expected.differentiate(point.x.data(), point.u.data(), *b);
      expect_equal_numbers(a->fx, b->fx, 1e-12, system.name + " fx");
      expect_equal_numbers(a->fu, b->fu, 1e-12, system.name + " fu");
    }
  }
}

/// A driven oscillator: time-dependent systems have a clock state.
ExpressionSystemText driven(SystemKind kind) {
  ExpressionSystemText text{
      .kind = kind, .states = {{"x", "m"}}, .controls = {{"u", "N"}}, .parameters = {{"k", 3}}};
  if (kind == SystemKind::second_order) {
    text.velocities = {{"v", "m/s"}};
    text.equations = {{"v", "u - k*x + sin(2*t)"}};
  } else {
    text.states.push_back({"v", "m/s"});
    text.equations = {{"x", "v"}, {"v", "u - k*x + sin(2*t)"}};
  }
  return text;
}

std::vector<std::string> column_names(const System& system) {
  std::vector<std::string> names;
  for (const Column& column : system.state_columns()) names.push_back(column.name);
  return names;
}

TEST(ExpressionSystems, TimeIsAStateIfExpressionsNeedIt) {
  using Names = std::vector<std::string>;
  const double u = 0.7;
  const auto first = expression_system(driven(SystemKind::first_order));
  EXPECT_EQ(column_names(*first), (Names{"x", "v", "t"}));
  const auto data = first->create_data(0.0);
  const double x[] = {0.3, -0.4, 1.2};
  first->differentiate(x, &u, *data);
  const double force = u - 3 * x[0] + std::sin(2 * x[2]);
  EXPECT_EQ(data->f[0], x[1]);
  EXPECT_NEAR(data->f[1], force, 1e-15);
  EXPECT_EQ(data->f[2], 1);
  EXPECT_NEAR(data->fx[2 * 3 + 1], 2 * std::cos(2 * x[2]), 1e-15);

  const auto second = expression_system(driven(SystemKind::second_order));
  EXPECT_EQ(column_names(*second), (Names{"x", "t", "v", "t_rate"}));
  ASSERT_EQ(second->nv(), 2);
  const auto more = second->create_data(0.0);
  const double y[] = {0.3, 1.2, -0.4, 1};
  second->differentiate(y, &u, *more);
  EXPECT_NEAR(more->f[0], force, 1e-15);
  EXPECT_EQ(more->f[1], 0);
  EXPECT_NEAR(more->fx[1 * 2 + 0], 2 * std::cos(2 * y[1]), 1e-15);
  EXPECT_EQ(more->fu[0], 1);

  // Without time there is no clock.
  ExpressionSystemText text = driven(SystemKind::first_order);
  text.equations[1].text = "u - k*x";
  EXPECT_EQ(column_names(*expression_system(text)), (Names{"x", "v"}));
}

TEST(ExpressionSystems, QuaternionTurnsWithBodyAngularVelocity) {
  const auto system = expression_system(
      {.kind = SystemKind::first_order,
       .states = {{"q", "", ExpressionState::Kind::kUnitQuaternion}, {"height", "m"}},
       .controls = expression_columns({"wx", "wy", "wz"}),
       .equations = {{"height", "rotate(q, [1, 2, 3]).z + cross([wx, wy, wz], [1, 0, 0])[2]"},
                     {"q", "[wx, wy, wz] + 0.1*rotate_inverse(q, [0, 0, 1])"}}});
  EXPECT_EQ(column_names(*system),
            (std::vector<std::string>{"q/x", "q/y", "q/z", "q/w", "height"}));
  ASSERT_EQ(system->ndx(), 4);
  RandomNumbers random(313);
  const Quaternion<double> q = random.rotation();
  const double x[] = {q.x, q.y, q.z, q.w, 0.5}, u[] = {0.1, 0.2, 0.3};
  const auto data = system->create_data(0.0);
  system->differentiate(x, u, *data);
  const Matrix3<double> R = rotation_matrix(q);
  EXPECT_NEAR(data->f[3], (R * Vector3<double>{1, 2, 3}).z - u[1], 1e-14);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(data->f[i], u[i] + 0.1 * R(2, i), 1e-14);
  // Along a rotation δ in body axes, R v moves by R (δ × v).
  for (int d = 0; d < 3; ++d) {
    Vector3<double> turn = Vector3<double>::zero();
    turn[d] = 1;
    EXPECT_NEAR(data->fx[d * 4 + 3], (R * cross(turn, Vector3<double>{1, 2, 3})).z, 1e-14);
  }
}

TEST(ExpressionSystems, TableIsAFunction) {
  const auto table = std::make_shared<SplineTable>(std::vector<double>{0, 1, 2, 4},
                                                   std::vector<double>{0, 1, 3, 2});
  const auto map =
      std::make_shared<SplineTable>(std::vector<double>{0, 1, 2}, std::vector<double>{0, 2},
                                    std::vector<double>{1, 2, 0, 3, 1, 5});
  const auto system = expression_system({.kind = SystemKind::second_order,
                                         .states = {{"x"}},
                                         .velocities = {{"v", "1"}},
                                         .controls = {{"u", "1"}},
                                         .tables = {{"drag", table}, {"ground", map}},
                                         .equations = {{"v", "u - drag(v) + u*ground(x, 2*u)"}}});
  const double x[] = {0.6, 1.3}, u = 0.4;
  const auto data = system->create_data(0.0);
  system->differentiate(x, &u, *data);
  const auto ground = [&](int i, int j) { return map->derivative(i, j, x[0], 2 * u); };
  EXPECT_NEAR(data->f[0], u - table->derivative(0, 0, x[1], 0) + u * ground(0, 0), 1e-15);
  EXPECT_NEAR(data->fx[0], u * ground(1, 0), 1e-15);
  EXPECT_NEAR(data->fx[1], -table->derivative(1, 0, x[1], 0), 1e-15);
  EXPECT_NEAR(data->fu[0], 1 + ground(0, 0) + 2 * u * ground(0, 1), 1e-15);
  RandomNumbers random(314);
  const SystemPoint<Lane> point = random_point<Lane>(*system, random);
  const AlignedVector<Lane> weights{Lane(0.7)};
  expect_equal_numbers(own_curvature(*system, point, weights),
                       curvature_by_duals(*system, point, weights), 1e-13, "curvature");
}

TEST(ExpressionSystems, UntakenBranchDoesNotSpoilDerivatives) {
  const auto system = expression_system({.kind = SystemKind::second_order,
                                         .states = {{"x"}},
                                         .velocities = {{"v", "1"}},
                                         .controls = {{"u", "1"}},
                                         .equations = {{"v", "u*if(x > 0, sqrt(x), 2*x)"}}});
  const auto data = system->create_data(0.0);
  const double u = 3;
  for (const double position : {-1.0, 4.0}) {
    const double x[] = {position, 0};
    system->differentiate(x, &u, *data);
    EXPECT_EQ(data->f[0], position > 0 ? 6 : -6);
    EXPECT_EQ(data->fx[0], position > 0 ? 0.75 : 6);
  }
  SystemPoint<Lane> point{{Lane(-1.0), Lane(0.0)}, {Lane(3.0)}};
  const AlignedVector<Lane> curvature = own_curvature(*system, point, {Lane(1.0)});
  EXPECT_EQ(curvature[0][0], 0);
  EXPECT_EQ(curvature[2][0], 2);
}

/// The only message of make_expression_system about a modified valid system.
ModelMessage message_of(void (*change)(ExpressionSystemText&)) {
  ExpressionSystemText text = driven(SystemKind::first_order);
  change(text);
  const ParsedExpressionSystem parsed = make_expression_system(text);
  EXPECT_EQ(parsed.system, nullptr);
  if (parsed.errors.size() != 1) return {.message = {-1, std::to_string(parsed.errors.size()), ""}};
  return parsed.errors[0];
}

TEST(ExpressionSystems, InvalidTextsHaveAPlace) {
  using Part = ModelMessage::Part;
  using Text = ExpressionSystemText;
  struct WrongText {
    void (*change)(Text&);
    Part part;
    int index;
    bool in_text;
    int offset;
    std::string message;
  };
  const WrongText cases[] = {
      {[](Text& t) { t.states.clear(); }, Part::kWhole, 0, false, 0, "the system has no states"},
      {[](Text& t) { t.states[1].name = "2v"; }, Part::kState, 1, false, 0,
       "'2v' is not a name of expressions: letters, digits and '_', no digit at first"},
      {[](Text& t) { t.controls[0].name = "t"; }, Part::kControl, 0, false, 0, "'t' is the time"},
      {[](Text& t) { t.parameters[0].first = "sin"; }, Part::kParameter, 0, false, 0,
       "'sin' is a function of the expression language"},
      {[](Text& t) {
         t.definitions = {{"pi", "3"}};
       },
       Part::kDefinition, 0, false, 0, "'pi' is a constant of the expression language"},
      {[](Text& t) {
         t.definitions = {{"and", "3"}};
       },
       Part::kDefinition, 0, false, 0, "'and' is a word of the expression language"},
      {[](Text& t) {
         t.definitions = {{"a", "b + 1"}, {"b", "1"}};
       },
       Part::kDefinition, 0, true, 0, "unknown name 'b'"},
      {[](Text& t) {
         t.definitions = {{"x", "1"}};
       },
       Part::kDefinition, 0, false, 0, "the name 'x' is taken"},
      {[](Text& t) { t.equations.pop_back(); }, Part::kState, 1, false, 0,
       "the rate of 'v' is missing"},
      {[](Text& t) {
         t.equations.push_back({"w", "1"});
       },
       Part::kEquation, 2, false, 0, "there is no state 'w' for this rate"},
      {[](Text& t) {
         t.equations.push_back({"x", "1"});
       },
       Part::kEquation, 2, false, 0, "the rate of 'x' is given twice"},
      {[](Text& t) { t.equations[0].text = "[v, v]"; }, Part::kEquation, 0, true, 0,
       "the rate of 'x' has to be a number, not a vector of 2"},
      {[](Text& t) { t.equations[0].text = "v > 0"; }, Part::kEquation, 0, true, 0,
       "the rate of 'x' has to be a number, not a condition"},
      {[](Text& t) { t.equations[1].text = "u - K*x"; }, Part::kEquation, 1, true, 4,
       "unknown name 'K'"},
      {[](Text& t) { t.kind = SystemKind::discrete; }, Part::kEquation, 1, true, 16,
       "unknown name 't'"},
      {[](Text& t) {
         t.kind = SystemKind::second_order;
         t.velocities = {{"w", "1"}};
       },
       Part::kWhole, 0, false, 0, "there are 2 positions and 1 velocity"}};
  for (const WrongText& c : cases) {
    const ModelMessage got = message_of(c.change);
    EXPECT_EQ(got.message.message, c.message);
    EXPECT_EQ(got.part, c.part) << c.message;
    EXPECT_EQ(got.index, c.index) << c.message;
    EXPECT_EQ(got.in_text, c.in_text) << c.message;
    EXPECT_EQ(got.message.offset, c.offset) << c.message;
  }
}

TEST(ExpressionSystems, WarnsAboutNonsmoothExpressions) {
  ExpressionSystemText text = driven(SystemKind::first_order);
  text.definitions = {{"drag", "0.1*v*abs(v)"}};
  text.equations[1].text = "if(x < 0, u - drag, u + drag)";
  const ParsedExpressionSystem parsed = make_expression_system(text);
  ASSERT_NE(parsed.system, nullptr);
  ASSERT_EQ(parsed.warnings.size(), 2u);
  EXPECT_EQ(parsed.warnings[0].part, ModelMessage::Part::kDefinition);
  EXPECT_EQ(parsed.warnings[0].message.offset, 6);
  EXPECT_EQ(parsed.warnings[0].message.message, "'abs' has a kink at 0; smooth_abs has none");
  EXPECT_EQ(parsed.warnings[1].part, ModelMessage::Part::kEquation);
  EXPECT_EQ(parsed.warnings[1].index, 1);
}

}  // namespace
}  // namespace conddp
