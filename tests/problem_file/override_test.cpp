#include "problem_file/yaml/key_path.hpp"
#include "problem_file/yaml/yaml_source.hpp"
#include "problem_text.hpp"
#include "solvers/common/options.hpp"

namespace conddp {
namespace {

TEST(Override, ReplacesAndAddsValues) {
  const Loaded loaded(std::string(kPendulum),
                      {"solver.max_iterations=7", "phases.1.knots=2", "costs.effort.weight=2",
                       "solver.tolerances.gap=1e-7", "initial_state={values: {theta: 0.5}}"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.spec->solver.options.max_iterations, 7);
  EXPECT_EQ(loaded.spec->solver.options.tolerances.gap, 1e-7);
  EXPECT_EQ(loaded.built->problem->knots(), 6);
  EXPECT_EQ(loaded.spec->costs[0].weight, 2);
  EXPECT_EQ(loaded.built->problem->initial_state()[0], 0.5);
}

TEST(Override, FindsPhasesByNameAndByIndex) {
  const Loaded loaded(std::string(kPendulum), {"phases.second.knots=3", "phases.1.dt=0.03",
                                               "phases.first.weights.effort=2"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.spec->phases[0].knots.value, 4);
  EXPECT_EQ(loaded.spec->phases[0].weights.front().second, 2);
  EXPECT_EQ(loaded.spec->phases[1].knots.value, 3);
  EXPECT_EQ(loaded.spec->phases[1].dt, 0.03);
}

TEST(Override, IndexWinsOverName) {
  const Loaded loaded(replaced(kPendulum, "name: first", "name: 1"), {"phases.1.knots=3"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.spec->phases[0].knots.value, 4);
  EXPECT_EQ(loaded.spec->phases[1].knots.value, 3);
}

TEST(Override, RoundTripsValuesSetFromElsewhere) {
  Diagnostics out;
  const auto value = parse_setting("a={b: [1.0e-3, \"x: y\", null], \"v/*\": word, c: {}}", out);
  ASSERT_TRUE(value);
  const Setting made = make_setting({"costs.first", {}}, value->value);
  EXPECT_EQ(made.text, "costs.first={b: [1.0e-3, \"x: y\", null], \"v/*\": word, c: {}}");
  const auto again = parse_setting(made.text, out);
  ASSERT_TRUE(again);
  EXPECT_EQ(make_setting(again->key, again->value).text, made.text);
  EXPECT_TRUE(out.list().empty());
}

TEST(Override, ReadsNumbersLikeYaml) {
  for (const std::string text :
       {"1", "-0.5", "+2", ".5", "-.5", "1e-3", "1.5E+3", "2023-01-02", "1-2", "..1", "1.", "-e"}) {
    Diagnostics out;
    const auto setting = parse_setting("k\u00e4y=" + text, out);
    ASSERT_TRUE(setting) << text;
    const auto value = parse_yaml(text, setting->value.mark.source, out, 5, true);
    ASSERT_TRUE(value) << text;
    EXPECT_EQ(setting->value.kind, value->kind) << text;
    EXPECT_EQ(setting->value.text, value->text) << text;
    EXPECT_EQ(setting->value.quoted, value->quoted) << text;
    EXPECT_EQ(setting->value.mark.line, value->mark.line) << text;
    EXPECT_EQ(setting->value.mark.column, value->mark.column) << text;
  }
}

TEST(Override, ErrorsQuoteTheSetting) {
  const Loaded loaded(std::string(kPendulum), {"solver.max_iterations=7", "solver.nmae=3"});
  EXPECT_NE(loaded.all().find("\n  solver.nmae=3\n         ^\n"), std::string::npos)
      << loaded.all();
}

TEST(Override, NamesMayContainDots) {
  const Loaded loaded(
      replaced(replaced(kPendulum, "name: first", "name: first.half"), "  effort: {",
               "  effort.less: {residual: control}\n  effort: {"),
      {"phases.first.half.knots=2", "costs.effort.less.weight=3", "costs.effort.weight=2"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.spec->phases[0].knots.value, 2);
  EXPECT_EQ(loaded.spec->costs[0].weight, 3);
  EXPECT_EQ(loaded.spec->costs[1].weight, 2);
}

TEST(Override, LongestDottedNameWins) {
  Diagnostics out;
  auto root = parse_setting("x={a: {b: {c: 1}}, a.b: {c: 2}}", out)->value;
  const auto at = [&](const char* key) {
    return find_node(root, {key, {}}, Missing::kCreate, out);
  };
  EXPECT_EQ(at("a.b.c")->text, "2");
  EXPECT_EQ(at("a.b"), find_present(root, "a.b"));
  EXPECT_EQ(find_present(root, "a.b.c")->text, "2");
  EXPECT_EQ(find_present(root, "a.c"), nullptr);
  EXPECT_TRUE(out.list().empty());
}

TEST(Override, HomotopyReachesNamesWithDots) {
  const std::string text = replaced(kPendulum, "  effort: {residual: control, weight: 0.5}",
                                    "  effort.all: {residual: control, weight: 0.5}");
  const Loaded loaded(replaced(text, "{name: box_ddp}",
                               "{name: box_ddp, homotopy: [{key: costs.effort.all.weight, "
                               "from: 2, to: 0.5}]}"));
  EXPECT_TRUE(loaded.built) << loaded.all();
}

TEST(Override, CreatesNoUnusedDefinitions) {
  const std::string scaled = replaced(kPendulum, "name: test", "parameters: {goal: 1}");
  struct Case {
    std::string text, setting, message, hint;
  };
  const Case cases[] = {
      {scaled, "parameters.gaol=3",
       "the file has no 'parameters.gaol': there is no 'gaol' in 'parameters'",
       "did you mean 'goal'?"},
      {std::string(kPendulum), "parameters.goal=3",
       "the file has no 'parameters.goal': there is no 'goal' in 'parameters'",
       "a path changes what the file defines"},
      {scaled, "tables.f={x: [0, 1], y: [0, 1]}",
       "the file has no 'tables.f': there is no 'f' in 'tables'",
       "a path changes what the file defines"},
      {replaced(kPendulum, "{type: pendulum}",
                "{states: {theta: rad, omega: rad/s}, controls: {torque: Nm}, parameters: {m: 1}, "
                "rate: {theta: omega, omega: torque/m}}"),
       "system.parameters.b=3",
       "the file has no 'system.parameters.b': there is no 'b' in 'system.parameters'",
       "names there: m"},
      {replaced(
           replaced(kPendulum, "system: {type: pendulum}", "systems: {swing: {type: pendulum}}"),
           "{name: first,", "{name: first, system: swing,"),
       "systems.swng={type: pendulum}",
       "the file has no 'systems.swng': there is no 'swng' in 'systems'", "did you mean 'swing'?"}};
  for (const Case& c : cases) {
    const Loaded loaded(c.text, {c.setting});
    ASSERT_TRUE(loaded.error()) << c.setting;
    EXPECT_EQ(loaded.error()->message, c.message);
    EXPECT_EQ(loaded.error()->hint, c.hint);
    EXPECT_EQ(loaded.error()->file, "--set");
    EXPECT_EQ(loaded.error()->column,
              static_cast<int>(c.setting.rfind('.', c.setting.find('='))) + 2);
  }
}

TEST(Override, HomotopyCreatesNoParameter) {
  const Loaded loaded(
      replaced(replaced(kPendulum, "name: test", "parameters: {goal: 1}"), "{name: box_ddp}",
               "{name: box_ddp, homotopy: [{key: parameters.gaol, from: 2, to: 1}]}"));
  ASSERT_TRUE(loaded.error());
  EXPECT_EQ(loaded.error()->hint, "did you mean 'goal'?");
}

TEST(Override, CreatesCostsAndWholeSections) {
  const Loaded loaded(std::string(kPendulum),
                      {"costs.more={residual: control}", "parameters={goal: 2}",
                       "parameters.goal=3", "terminal.costs.goal.weight==goal"});
  ASSERT_TRUE(loaded.built) << loaded.all();
  EXPECT_EQ(loaded.spec->costs.size(), 2u);
  EXPECT_EQ(loaded.spec->names.parameters[0].second.numbers, std::vector<double>{3});
}

struct BadSetting {
  const char* setting;
  int column;
  const char* message;
};

class BadOverride : public testing::TestWithParam<BadSetting> {};

TEST_P(BadOverride, IsNamedInsideTheSetting) {
  const Loaded loaded(std::string(kPendulum), {GetParam().setting});
  EXPECT_FALSE(loaded.built);
  ASSERT_TRUE(loaded.error());
  EXPECT_EQ(loaded.error()->file, "--set");
  EXPECT_EQ(loaded.error()->column, GetParam().column);
  EXPECT_NE(loaded.error()->message.find(GetParam().message), std::string::npos)
      << loaded.error()->message;
}

INSTANTIATE_TEST_SUITE_P(
    Classes, BadOverride,
    testing::Values(BadSetting{"solver.max_iterations", 1, "is not a setting"},
                    BadSetting{"=3", 1, "is not a setting"},
                    BadSetting{"solver..name=x", 8, "a name in the key path is empty"},
                    BadSetting{"solver.max_iteration=3", 8, "unknown key 'max_iteration'"},
                    BadSetting{"solver.max_iterations=many", 23, "'many' is not a number"},
                    BadSetting{"phases.2.dt=1", 8,
                               "'2' is neither a name nor an index in a list of 2"},
                    BadSetting{"phases.frist.dt=1", 8, "'frist' is neither a name nor an index"},
                    BadSetting{"gravity.2=-1.6", 9,
                               "the file has no list 'gravity', of which '2' would be an index"},
                    BadSetting{"name.x=1", 6, "leads into a word"},
                    BadSetting{"costs.effort.weight=&a 1", 21, "anchors"},
                    BadSetting{"costs.effort.weight=", 21, "is expected here, not nothing"}));

}  // namespace
}  // namespace conddp
