// Expression systems in problem files.
#include <fstream>

#include <gtest/gtest.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/yaml/yaml_text.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/expression_systems.hpp"
#include "support/source_tree.hpp"
#include "systems/expressions/functions.hpp"

namespace conddp {
namespace {

constexpr std::string_view kDrivenMass = R"(conddp: 1
system:
  states: {x: m, v: m/s}
  controls: {u: N}
  parameters: {k: 3, m: 2}
  let: {spring: -k*x}
  rate:
    x: v
    v: (u + spring)/m
initial_state: {values: {x: 1}}
phases: [{knots: 4, dt: 0.1}]
costs: {effort: {residual: control}, rest: {residual: state}}
solver: {name: box_fddp}
)";

/// A problem of a catalogue system, given by its file text.
std::string catalogue_problem(const std::string& system) {
  return fmt::format(R"(conddp: 1
{}
initial_state: {{}}
phases: [{{knots: 20, dt: 0.03}}]
costs: {{effort: {{residual: control, reference: 0.3, weight: 0.1}}}}
terminal: {{costs: {{rest: {{residual: state, weight: 2}}}}}}
solver: {{name: box_fddp}}
)",
                     system);
}

SolveResult iterate_of(const Loaded& loaded, int iterations) {
  SolverOptions options = loaded.spec->solver.options;
  options.max_iterations = iterations;
  return solve(*loaded.built->problem, "box_fddp", options, loaded.built->guess);
}

TEST(ExpressionSystemFiles, ClosedFormSystemsInWordsIterateAlike) {
  for (const SystemInWords& system : systems_in_words()) {
    if (system.name == "linear" || system.name == "double_integrator") continue;  // other columns
    const ExpressionSystemSpec spec{.text = system.text,
                                    .own = {.parameters = system.text.parameters}};
    const OrderedJson json = {{"system", expand_map(SystemSpec{.parameters = spec})}};
    const Loaded in_words(catalogue_problem(yaml_text(json)));
    const Loaded compiled(catalogue_problem("system: {type: " + system.name + "}"));
    ASSERT_TRUE(in_words.built) << in_words.all();
    ASSERT_TRUE(compiled.built) << compiled.all();
    for (const int iterations : {1, 2, 3, 4, 5, 200}) {
      const SolveResult a = iterate_of(in_words, iterations), b = iterate_of(compiled, iterations);
      EXPECT_EQ(a.status, b.status) << system.name;
      EXPECT_NEAR(a.cost, b.cost, (iterations > 5 ? 1e-9 : 1e-12) * (1 + std::abs(b.cost)))
          << system.name << " after " << iterations;
    }
  }
}

TEST(ExpressionSystemFiles, KindFollowsFromTheEquations) {
  const Loaded first{std::string(kDrivenMass)};
  ASSERT_TRUE(first.built) << first.all();
  EXPECT_EQ(first.built->plant.system->kind(), SystemKind::first_order);
  EXPECT_EQ(first.built->problem->initial_state(), (std::vector<double>{1, 0}));

  const Loaded second(replaced(
      replaced(kDrivenMass, "states: {x: m, v: m/s}", "positions: {x: m}\n  velocities: [v]"),
      "rate:\n    x: v\n", "acceleration:\n"));
  ASSERT_TRUE(second.built) << second.all();
  EXPECT_EQ(second.built->plant.system->kind(), SystemKind::second_order);
  EXPECT_EQ(second.built->problem->knot(0).model->integrator(), Integrator::semi_implicit_euler);

  const Loaded next(replaced(replaced(kDrivenMass, "rate:", "next:"), "x: v", "x: x + 0.1*v"));
  ASSERT_TRUE(next.built) << next.all();
  EXPECT_EQ(next.built->plant.system->kind(), SystemKind::discrete);
  EXPECT_EQ(next.built->problem->knot(0).model->integrator(), Integrator::discrete);

  const Loaded lists(replaced(replaced(kDrivenMass, "{x: m, v: m/s}", "[x, v]"), "{u: N}", "[u]"));
  ASSERT_TRUE(lists.built) << lists.all();
  EXPECT_EQ(lists.built->plant.system->state_columns()[1].unit, "1");
}

TEST(ExpressionSystemFiles, SettingsReachTheParameters) {
  const auto acceleration = [](const Loaded& loaded) {
    EXPECT_TRUE(loaded.built) << loaded.all();
    const System& system = *loaded.built->plant.system;
    const auto data = system.create_data(0.0);
    const double x[] = {1, 0}, u = 0;
    system.evaluate(x, &u, *data);
    return data->f[1];
  };
  EXPECT_EQ(acceleration(Loaded{std::string(kDrivenMass)}), -1.5);
  EXPECT_EQ(acceleration(Loaded(std::string(kDrivenMass), {"system.parameters.k=8"})), -4);
  EXPECT_EQ(acceleration(Loaded(std::string(kDrivenMass), {"system.let.spring=-k*x^3 + 1"})), -1);
}

TEST(ExpressionSystemFiles, ClockStartsAtTheBeginning) {
  const Loaded first(replaced(kDrivenMass, "(u + spring)/m", "u*sin(t)"));
  ASSERT_TRUE(first.built) << first.all();
  EXPECT_EQ(first.built->problem->initial_state(), (std::vector<double>{1, 0, 0}));
  const Loaded second(replaced(
      replaced(kDrivenMass, "states: {x: m, v: m/s}", "positions: {x: m}\n  velocities: {v: m/s}"),
      "rate:\n    x: v\n    v: (u + spring)/m", "acceleration: {v: u*sin(t) - x}"));
  ASSERT_TRUE(second.built) << second.all();
  EXPECT_EQ(second.built->problem->initial_state(), (std::vector<double>{1, 0, 0, 1}));
  const SolveResult answer = iterate_of(second, 50);
  for (int k = 0; k <= 4; ++k) EXPECT_NEAR(answer.trajectory.x(k)[1], 0.1 * k, 1e-15);
}

TEST(ExpressionSystemFiles, TablesAreFunctions) {
  const Loaded loaded(replaced(replaced(kDrivenMass, "  let:",
                                        "  tables:\n"
                                        "    drag: {points: [0, 1, 2], values: [0, 1, 3]}\n"
                                        "    ground: {points: [[0, 1], [0, 2]], values: [[0, 1], "
                                        "[2, 3]]}\n  let:"),
                               "(u + spring)/m", "u - drag(v) + ground(x, u)"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const System& system = *loaded.built->plant.system;
  const auto data = system.create_data(0.0);
  const double x[] = {0.5, 1}, u = 1;
  system.evaluate(x, &u, *data);
  EXPECT_NEAR(data->f[1], 1 - 1 + 1.5, 1e-14);
}

TEST(ExpressionSystemFiles, ErrorsPointIntoTheExpression) {
  struct WrongFile {
    std::string from, to, error;
  };
  const WrongFile cases[] = {
      {"(u + spring)/m", "(u + sprng)/m", "9:13: unknown name 'sprng'"},
      {"(u + spring)/m", "\"(u + sprng)/m\"", "9:14: unknown name 'sprng'"},
      {"(u + spring)/m", "'(u + sprng)/m'", "9:14: unknown name 'sprng'"},
      {"v: (u + spring)/m", "v: |\n      (u +\n       sprng)/m", "11:8: unknown name 'sprng'"},
      {"v: (u + spring)/m", "v: >\n      (u +\n       sprng)/m", "11:8: unknown name 'sprng'"},
      {"v: (u + spring)/m", "v: (u +\n       sprng)/m", "10:8: unknown name 'sprng'"},
      {"(u + spring)/m", "(u + spring", "9:19: the '(' is not closed"},
      {"(u + spring)/m", "[u, sprng]", "9:12: unknown name 'sprng'"},
      {"(u + spring)/m", "[u, spring]",
       "9:8: the rate of 'v' has to be a number, not a vector of 2"},
      {"(u + spring)/m", "{}", "9:8: an expression is expected here, not "},
      {"(u + spring)/m", "\"\\x28u + sprng)/m\"", "9:8: unknown name 'sprng'"},
      {"-k*x", "-k*X", "6:20: unknown name 'X'"},
      {"let: {spring", "let: {x", "6:9: the name 'x' is taken"},
      {"k: 3", "2k: 3",
       "5:16: '2k' is not a name of expressions: letters, digits and '_', no digit at first"},
      {"{u: N}", "{t: N}", "4:14: 't' is the time"},
      {"x: v\n", "y: v\n", "8:5: there is no state 'y' for this rate"},
      {"    x: v\n", "", "3:12: the rate of 'x' is missing"},
      {"{x: m, v: m/s}", "{x: m, v: pose}",
       "8:8: the rate of 'x' has to be a number, not a vector of 7"},
      {"states: {x: m, v: m/s}", "positions: [x, v]", "3:3: 'system' lacks the key 'states'"},
      {"rate:", "next:\n    x: 1\n  rate:", "9:3: 'next' and 'rate' exclude each other"},
      {"  rate:", "  velocities: [a]\n  rate:", "7:15: 'velocities' does not go with 'rate'"},
      {"  let:", "  tables: {drag: {points: [1, 0], values: [1, 2]}}\n  let:",
       "6:18: the points of a table have to be finite and ascending"},
      {"  let:", "  tables: {drag: {points: [1], values: [1, 2]}}\n  let:", "6:40: "},
      {"  let:", "  tables: {drag: {points: [[0, 1]], values: [1, 2]}}\n  let:",
       "6:27: a table has the points of one argument or of two"},
      {"  let:", "  tables: {drag: {points: [[0, 1], [0, 1]], values: [[1, 2]]}}\n  let:",
       "6:53: the first argument has 2 points, and there are 1 rows"},
  };
  for (const WrongFile& c : cases) {
    const Loaded loaded(replaced(kDrivenMass, c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_TRUE(loaded.first_error().starts_with(c.error)) << c.to << "\n" << loaded.all();
  }
}

TEST(ExpressionSystemFiles, ExplainsAnEmptyUnit) {
  for (const char* states : {"{x: \"\", v: m/s}", "{x: , v: m/s}"}) {
    const Loaded loaded(replaced(kDrivenMass, "{x: m, v: m/s}", states));
    ASSERT_NE(loaded.error(), nullptr);
    EXPECT_EQ(loaded.error()->message, "'x' has no unit behind it");
    EXPECT_EQ(loaded.error()->hint, "write the unit, or 1 where there is none");
  }
}

TEST(ExpressionSystemFiles, ExplainsACommaThatYamlSplits) {
  const Loaded loaded(replaced(kDrivenMass, "rate:\n    x: v\n    v: (u + spring)/m",
                               "rate: {x: v, v: atan2(u, spring)}"));
  ASSERT_NE(loaded.error(), nullptr);
  EXPECT_NE(loaded.all().find("needs quotes"), std::string::npos) << loaded.all();
}

TEST(ExpressionSystemFiles, ReferenceNamesEveryFunctionAndConstant) {
  std::ifstream stream(source_tree().string() + "/docs/problem_file.md");
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  for (const ExpressionFunction& function : expression_functions()) {
    const std::string name = "`" + std::string(function.name);
    EXPECT_TRUE(text.find(name + "`") != std::string::npos ||
                text.find(name + "(") != std::string::npos)
        << name;
  }
  for (const ExpressionConstant& constant : expression_constants())
    EXPECT_NE(text.find(fmt::format("`{}`", constant.name)), std::string::npos) << constant.name;
}

TEST(ExpressionSystemFiles, WarnAboutNonsmoothExpressions) {
  EXPECT_EQ(warnings(replaced(kDrivenMass, "(u + spring)/m", "u - abs(v)*v")),
            "6:9: nothing uses 'spring' ()\n"
            "9:12: 'abs' has a kink at 0; smooth_abs has none ()\n");
}

}  // namespace
}  // namespace conddp
