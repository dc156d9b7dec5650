// Rewritings of problems: each stands for a feature that nothing after it knows.
#include "problem_file/lower/rewriting.hpp"

#include "ocp/evaluation/evaluator.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_text.hpp"

namespace conddp {
namespace {

/// A mass that moves for a free time; a cost, a constraint and a way-point count knots.
constexpr std::string_view kFree = R"(conddp: 1
system: {positions: {x: m}, velocities: {v: m/s}, controls: {u: N}, acceleration: {v: u}}
initial_state: {state: [0, 0]}
integrator: rk2
phases:
  - {name: push, knots: 6, duration: 1, free_duration: {lower: 0.1, upper: 10}}
costs:
  effort: {residual: control, knots: [0, 2]}
  way: {residual: state, reference: {knots: [0, 4], values: [[0, 0], [1, 0]]}}
constraints:
  slow: {residual: state, columns: [v], knots: [3], upper: 2}
terminal: {constraints: {there: {residual: state, reference: [1, 0]}}}
initial_guess: {states: {keyframes: [{knot: 6, state: {state: [1, 0]}}]}}
solver: {name: ipopt}
)";

void expect_equal_problems(const Loaded& a, const Loaded& b) {
  ASSERT_TRUE(a.built) << a.all();
  ASSERT_TRUE(b.built) << b.all();
  const ShootingProblem &p = *a.built->problem, &q = *b.built->problem;
  EXPECT_EQ(p.initial_state(), q.initial_state());
  ASSERT_EQ(p.phases().size(), q.phases().size());
  for (std::size_t i = 0; i < p.phases().size(); ++i) {
    EXPECT_EQ(p.phases()[i].dt, q.phases()[i].dt);
    EXPECT_EQ(p.phases()[i].parameters, q.phases()[i].parameters);
    EXPECT_EQ(p.phases()[i].model->control_lower(), q.phases()[i].model->control_lower());
    EXPECT_EQ(p.phases()[i].model->control_upper(), q.phases()[i].model->control_upper());
  }
  for (int k = 0; k <= p.knots(); ++k) EXPECT_EQ(a.built->guess.x(k), b.built->guess.x(k));
}

TEST(Rewriting, FreeDurationsGetTheirChoice) {
  std::string written = replaced(kFree, "phases:\n", "phases:\n  - {choose: none}\n");
  written = replaced(written, "knots: [0, 2]", "knots: [1, 3]");
  written = replaced(written, "knots: [0, 4]", "knots: [1, 5]");
  written = replaced(written, "knots: [3]", "knots: [4]");
  written = replaced(written, "knot: 6", "knot: 7");
  expect_equal_problems(Loaded{std::string(kFree)}, Loaded(written));
}

TEST(Rewriting, KnotsCountFromTheirPhases) {
  std::string written = replaced(kFree, "knots: 6, duration: 1,", "knots: 3, duration: 0.5,");
  written =
      replaced(written, "upper: 10}}\n", "upper: 10}}\n  - {name: brake, knots: 3, dt: 0.1}\n");
  std::string named = replaced(written, "knots: [0, 2]", "knots: [push, brake - 1]");
  named = replaced(named, "knots: [0, 4]", "knots: [push, brake + 1]");
  named = replaced(named, "knots: [3]", "knots: [brake]");
  named = replaced(named, "knot: 6", "knot: brake + 3");
  expect_equal_problems(Loaded(written), Loaded(named));
}

TEST(Rewriting, WrongKnotsOfPhasesAreErrors) {
  const std::pair<const char*, const char*> cases[] = {
      {"[pull]", "unknown phase 'pull'"},
      {"[push - 1]", "this is before the first knot"},
      {"[push + x]", "a knot is a number, a phase, or 'phase + 3'"},
      {"[push + 6]", "running knots are numbered from 0 to 5"},
      {"[push + 1, 1]", "1 stands twice in the list"}};
  for (const auto& [knots, says] : cases) {
    const Loaded loaded(replaced(kFree, "[3]", knots));
    EXPECT_FALSE(loaded.built) << knots;
    EXPECT_NE(loaded.all().find(says), std::string::npos) << loaded.all();
  }
}

/// Messages count knots as the file does, before a start or a finer grid moves them.
TEST(Rewriting, MissingKnotsHaveTheNumbersOfTheFile) {
  const std::string fine = std::string(kFree) + "mesh: {error: 1.0e-3, factor: 2}\n";
  const std::pair<std::string, const char*> cases[] = {
      {replaced(fine, "knots: [3]", "knots: [6]"), "running knots are numbered from 0 to 5"},
      {replaced(fine, "knots: [0, 4]", "knots: [0, 7]"), "knot 7 lies behind the last one, 6"},
      {replaced(fine, "knot: 6", "knot: 7"), "nodes are numbered from 0 to 6"}};
  for (const auto& [text, says] : cases) {
    const Loaded loaded(text);
    EXPECT_FALSE(loaded.spec);
    EXPECT_NE(loaded.all().find(says), std::string::npos) << says << '\n' << loaded.all();
  }
}

TEST(Rewriting, LinearControlsGetTheirChoice) {
  const std::string linear =
      replaced(replaced(kFree, ", free_duration: {lower: 0.1, upper: 10}", ""), "integrator: rk2",
               "integrator: rk4\ncontrols: linear");
  const std::string given =
      replaced(linear, "{state: [0, 0]}\ni", "{state: [0, 0], previous_control: 1}\ni");
  const Loaded chosen(linear), fixed(given);
  ASSERT_TRUE(chosen.built) << chosen.all();
  ASSERT_TRUE(fixed.built) << fixed.all();
  EXPECT_EQ(chosen.built->problem->knots(), fixed.built->problem->knots() + 1);
}

TEST(Rewriting, ParametersBoundAChoiceOfAllComponents) {
  const std::string text = R"(conddp: 1
parameters: {p: {free: true, lower: 1, upper: 3, start: 1.5}}
system: {states: [x], controls: [u], rate: {x: p*u}}
initial_state: {}
integrator: rk4
phases: [{choose: all, lower: -1, upper: 2}, {knots: 5, dt: 0.1}]
costs: {effort: {residual: control}}
)";
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const KnotModel& choice = *loaded.built->problem->phases()[0].model;
  EXPECT_EQ(choice.control_lower(), (std::vector<double>{-1, -0.5}));
  EXPECT_EQ(choice.control_upper(), (std::vector<double>{2, 1.5}));
}

/// Each rewriting prints a problem that the remaining ones make the same of.
TEST(Rewriting, AnyStageBuildsTheSameProblem) {
  const std::string moved =
      replaced(replaced(kFree, "conddp: 1\n", "conddp: 1\nparameters: {far: 10}\n"), "upper: 10",
               "upper: =far") +
      "mesh: {error: 1.0e-3, factor: 2}\n";
  const Loaded whole(replaced(moved, "knots: [0, 2]", "phases: push"));
  ASSERT_TRUE(whole.built) << whole.all();
  const std::string expanded = expanded_text(*whole.built);
  for (const std::string& name : names_of_rewritings()) {
    if (name == "core") continue;
    const Loaded again(expanded_text(*whole.built, name));
    ASSERT_TRUE(again.built) << name << '\n' << again.all();
    EXPECT_EQ(expanded_text(*again.built), expanded) << name;
  }
}

TEST(Rewriting, CoreHoldsWhatStepsAndCostsDo) {
  const Loaded loaded(replaced(replaced(kFree, "costs:\n", "integrals: {work: u*v}\ncosts:\n"),
                               ", knots: [0, 2]", ""));
  ASSERT_TRUE(loaded.built) << loaded.all();
  const OrderedJson core = expand_after("core", *loaded.built);
  ASSERT_EQ(core["phases"].size(), 2u);
  EXPECT_EQ(core["phases"][0]["step"]["becomes"]["start/duration/push"], "duration/push");
  const OrderedJson& push = core["phases"][1];
  EXPECT_EQ(push["step"]["lasts"], "start/duration/push");
  EXPECT_EQ(push["step"]["integrates"], OrderedJson({"work"}));
  EXPECT_EQ(push["costs"][0]["grows_with"], "start/duration/push");
  EXPECT_EQ(core["initial_state"].size(), 4u);
}

/// A periodic trot: the start is free, and the gait makes the phases behind its choice.
TEST(Rewriting, GaitsFollowAChoiceOfTheStart) {
  std::ifstream file(kProblems / "quadruped_trot.yaml");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  ASSERT_NE(text.find("\ngait:"), std::string::npos);
  const Loaded given(text), free(replaced(text, "\ngait:", "\nphases: [{choose: all}]\ngait:"));
  ASSERT_TRUE(given.built) << given.all();
  ASSERT_TRUE(free.built) << free.all();
  EXPECT_EQ(free.built->problem->knots(), given.built->problem->knots() + 1);
  const auto &a = given.spec->phases, &b = free.spec->phases;
  ASSERT_EQ(b.size(), a.size() + 1);
  for (std::size_t p = 0; p < a.size(); ++p) EXPECT_EQ(a[p].name.value, b[p + 1].name.value);
  for (std::size_t i = 0; i < given.spec->gait_way.size(); ++i)
    EXPECT_EQ(free.spec->gait_way[i].node, given.spec->gait_way[i].node + 1);
  const Loaded again(expanded_text(*free.built));
  EXPECT_EQ(again.first_error(), "");
}

}  // namespace
}  // namespace conddp
