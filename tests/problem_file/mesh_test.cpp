// Grid refinement until a finer replay agrees.
#include "problem_file/mesh/mesh.hpp"

#include "analysis/certificate/replay.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

constexpr std::string_view kOscillator = R"(conddp: 1
system: {states: [x, v], controls: [u], rate: {x: v, v: u - x}}
initial_state: {values: {x: 1}}
integrator: rk2
mesh: {error: 1.0e-4}
phases: [{name: first, knots: 6, duration: 3}, {name: second, knots: 4, duration: 3}]
costs: {effort: {residual: control}}
terminal: {costs: {still: {residual: state, weight: 100}}}
solver: {name: box_fddp}
)";

std::string with_factor(int factor) {
  return replaced(kOscillator, "error: 1.0e-4", fmt::format("error: 1.0e-4, factor: {}", factor));
}

SolveResult answer_of(const Loaded& loaded) {
  return solve(*loaded.built->problem, "box_fddp", loaded.spec->solver.options,
               loaded.built->guess);
}

TEST(Mesh, FactorCutsEachStepOfThePhases) {
  const Loaded coarse{std::string(kOscillator)}, fine(with_factor(3));
  ASSERT_TRUE(coarse.built) << coarse.all();
  ASSERT_TRUE(fine.built) << fine.all();
  EXPECT_EQ(fine.built->problem->knots(), 3 * coarse.built->problem->knots());
  for (int k = 0; k < fine.built->problem->knots(); ++k)
    EXPECT_NEAR(3 * fine.built->problem->knot(k).dt, coarse.built->problem->knot(k / 3).dt, 1e-15);
}

TEST(Mesh, HalfTheKnotsHaveTheSameDuration) {
  Loaded loaded(replaced(kOscillator, "knots: 6", "knots: 7"));
  ASSERT_TRUE(loaded.spec) << loaded.all();
  ProblemSpec spec = *loaded.spec;
  ASSERT_TRUE(coarsen(spec, 2));
  EXPECT_EQ(spec.phases[0].knots.value, 3);
  EXPECT_EQ(spec.phases[1].knots.value, 2);
  for (const PhaseSpec& phase : spec.phases) EXPECT_NEAR(phase.knots.value * phase.dt, 3, 1e-15);
  EXPECT_FALSE(coarsen(spec, 2)) << "of the second phase one would be left";
  EXPECT_EQ(spec.phases[0].knots.value, 3);
}

TEST(Mesh, KnotsOfTheFileAreHalvedSeveralTimes) {
  const Loaded loaded(replaced(
      replaced(replaced(kOscillator, "mesh: {error: 1.0e-4}\n", ""), "knots: 6,", "knots: 48,"),
      "knots: 4,", "knots: 40,"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  Diagnostics out;
  for (const int halvings : {1, 2}) {
    const auto coarse = build_on_grid(*loaded.built, {.halvings = halvings}, out);
    ASSERT_TRUE(coarse) << format_diagnostics(out, false);
    EXPECT_EQ(coarse->problem->knots(), 88 >> halvings);
  }
  EXPECT_FALSE(build_on_grid(*loaded.built, {.halvings = 3}, out))
      << "of one phase 5 would be left";
}

TEST(Mesh, ErrorFallsByTheOrderOfTheIntegrator) {
  std::vector<double> errors;
  for (const int factor : {2, 4, 8}) {
    const Loaded loaded(with_factor(factor));
    ASSERT_TRUE(loaded.built) << loaded.all();
    errors.push_back(replay_error(*loaded.built->problem, answer_of(loaded).trajectory));
  }
  EXPECT_NEAR(errors[0] / errors[1], 4, 0.5);
  EXPECT_NEAR(errors[1] / errors[2], 4, 0.3);
}

TEST(Mesh, GrowsGridsByObservedOrderUntilAccurate) {
  MeshRefinement mesh(*Loaded(std::string(kOscillator)).spec->mesh);
  std::optional<int> factor = 1;
  while (factor) {
    const Loaded loaded(with_factor(*factor));
    ASSERT_TRUE(loaded.built) << loaded.all();
    factor = mesh.next(*loaded.built->problem, answer_of(loaded));
  }
  EXPECT_TRUE(mesh.reached());
  const auto& rounds = mesh.rounds();
  ASSERT_GE(rounds.size(), 3u);
  EXPECT_LE(rounds.size(), 6u);
  EXPECT_EQ(rounds[1].factor, 2);
  EXPECT_LE(rounds.back().error, 1e-4);
  EXPECT_GT(rounds.back().error, 2e-5) << "finer than it has to be";
  for (std::size_t i = 1; i < rounds.size(); ++i) {
    EXPECT_LT(rounds[i].error, rounds[i - 1].error);
    EXPECT_EQ(rounds[i].knots, 10 * rounds[i].factor);
  }
}

TEST(Mesh, EndsAtTenThousandKnots) {
  const std::string text = replaced(kOscillator, "error: 1.0e-4", "error: 1.0e-12");
  MeshRefinement mesh(*Loaded(text).spec->mesh);
  std::optional<int> factor = 1;
  while (factor) {
    const Loaded loaded(replaced(text, "error: ", fmt::format("factor: {}, error: ", *factor)));
    ASSERT_TRUE(loaded.built) << loaded.all();
    factor = mesh.next(*loaded.built->problem, answer_of(loaded));
  }
  EXPECT_FALSE(mesh.reached());
  EXPECT_EQ(mesh.rounds().back().knots, 10'000);
}

TEST(Mesh, EndsAfterTwoGridsWithGrowingError) {
  MeshRefinement mesh(*Loaded(std::string(kOscillator)).spec->mesh);
  std::optional<int> factor = 1;
  for (double wrong = 1; factor; wrong *= 2) {
    const Loaded loaded(with_factor(*factor));
    ASSERT_TRUE(loaded.built) << loaded.all();
    SolveResult answer = answer_of(loaded);
    answer.trajectory.x(loaded.built->problem->knots())[0] += wrong;
    factor = mesh.next(*loaded.built->problem, answer);
  }
  EXPECT_FALSE(mesh.reached());
  ASSERT_EQ(mesh.rounds().size(), 3u);
  EXPECT_EQ(mesh.rounds()[2].factor, 4) << "growth says nothing of the order";
}

TEST(Mesh, CollocationTolerancesSumBelowTheError) {
  const auto tolerance = [](const std::string& text) {
    const Loaded loaded(text);
    EXPECT_TRUE(loaded.spec) << loaded.all();
    return loaded.spec->solver.options.tolerances.constraint;
  };
  const double usual = SolverOptions().tolerances.constraint;
  EXPECT_EQ(tolerance(std::string(kOscillator)), usual);
  const std::string collocating =
      replaced(replaced(kOscillator, "rk2", "trapezoidal"), "box_fddp", "altro");
  EXPECT_DOUBLE_EQ(tolerance(replaced(collocating, "1.0e-4", "1.0e-6, factor: 2")), 1e-7 / 20);
  EXPECT_DOUBLE_EQ(tolerance(replaced(collocating, "1.0e-4", "1.0e-12")), 1e-11);
  EXPECT_EQ(tolerance(replaced(collocating, "mesh: {error: 1.0e-4}\n", "")), usual);
}

TEST(Mesh, EachAnswerIsTheNextGuess) {
  const Loaded coarse{std::string(kOscillator)}, fine(with_factor(2));
  const SolveResult answer = answer_of(coarse);
  const Trajectory guess = on_grid(*coarse.built->problem, answer.trajectory, *fine.built->problem);
  ASSERT_EQ(guess.knots(), 20);
  for (int k = 0; k < 10; ++k) {
    EXPECT_EQ(guess.x(2 * k), answer.trajectory.x(k));
    EXPECT_LT(
        (guess.x(2 * k + 1) - 0.5 * (answer.trajectory.x(k) + answer.trajectory.x(k + 1))).norm(),
        1e-14);
    EXPECT_EQ(guess.u(2 * k), answer.trajectory.u(k));
    EXPECT_EQ(guess.u(2 * k + 1), answer.trajectory.u(k));
  }
  EXPECT_EQ(guess.x(20), answer.trajectory.x(10));
}

TEST(Mesh, ProblemsWithoutTimeHaveNoFinerGrid) {
  const std::string text = R"(conddp: 1
system: {states: [x, v], controls: [u], rate: {x: v, v: u}}
initial_state: {}
mesh: {error: 1.0e-12}
phases: [{jump: {x: x + 0.001}}]
)";
  const Loaded loaded(text);
  ASSERT_TRUE(loaded.built) << loaded.all();
  MeshRefinement mesh(*loaded.spec->mesh);
  SolveResult result(*loaded.built->problem);
  result.status = SolveStatus::converged;
  result.trajectory.x(1)[0] = 1;  // far from the end of the jump
  EXPECT_FALSE(mesh.next(*loaded.built->problem, result));
  EXPECT_FALSE(mesh.reached());
}

TEST(Mesh, MovesWayPointsOfGaits) {
  const std::string text = R"(conddp: 1
robot:
  urdf: )" + source_tree().string() +
                           R"(/problems/robots/quadruped.urdf
  base: floating
  configurations:
    standing: {base: {position: [0, 0, 0.57]}, joints: {
      LF_HAA: -0.2, LF_HFE: 0.75, LF_KFE: -1.5, RF_HAA: -0.2, RF_HFE: 0.75, RF_KFE: -1.5,
      LH_HAA: -0.2, LH_HFE: -0.75, LH_KFE: 1.5, RH_HAA: -0.2, RH_HFE: -0.75, RH_KFE: 1.5}}
contacts: {LF: {frame: lf_foot}, RF: {frame: rf_foot}, LH: {frame: lh_foot}, RH: {frame: rh_foot}}
initial_state: {configuration: standing}
gait: {type: trot, cycles: 2, period: 0.48, dt: 0.02, step: {length: 0.15, height: 0.06}}
mesh: {error: 1.0e-3}
costs:
  posture: {residual: state, reference: {configuration: standing, displaced: gait}, weight: 10}
)";
  const Loaded coarse(text), fine(replaced(text, "error: 1.0e-3", "error: 1.0e-3, factor: 3"));
  ASSERT_TRUE(coarse.built) << coarse.all();
  ASSERT_TRUE(fine.built) << fine.all();
  const std::vector<WayPoint>& way = coarse.spec->gait_way;
  ASSERT_EQ(fine.spec->gait_way.size(), way.size());
  for (std::size_t i = 0; i < way.size(); ++i)
    EXPECT_EQ(fine.spec->gait_way[i].node, 3 * way[i].node);
}

// Each number of a knot names the same instant on all grids, so times say the same.
TEST(Mesh, CountsKnotsOnTheGridOfTheFile) {
  const char* by_knots =
      "{residual: control}, way: {residual: state, reference: {knots: [0, 3, 8], values: [[0, 0], "
      "[1, 0], [0, 1]]}}";
  const char* by_times =
      "{residual: control}, way: {residual: state, reference: {times: [0, 1.5, 4.5], values: [[0, "
      "0], [1, 0], [0, 1]]}}";
  const std::string fine = replaced(kOscillator, "error: 1.0e-4", "error: 1.0e-4, factor: 4");
  const Loaded counted(replaced(fine, "{residual: control}", by_knots)),
      timed(replaced(fine, "{residual: control}", by_times));
  ASSERT_TRUE(counted.built) << counted.all();
  ASSERT_TRUE(timed.built) << timed.all();
  for (std::size_t p = 0; p < 2; ++p) {
    const std::vector<double>& a = counted.built->problem->phases()[p].parameters;
    const std::vector<double>& b = timed.built->problem->phases()[p].parameters;
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_NEAR(a[i], b[i], 1e-12) << i;
  }
}

TEST(Mesh, NamesTermsThatDependOnTheGrid) {
  struct Case {
    std::string from, to, message;
  };
  const Case cases[] = {
      {"{residual: control}", "{residual: control, knots: [3]}",
       "7:9: error: a cost at single knots is multiplied by their time steps"},
      {"{residual: control}", "{residual: control_rate}",
       "7:9: error: the change of a control from knot to knot depends on the grid"},
      {"knots: 6, duration: 3", "knots: 6, duration: 3, refine: {last: 2}",
       "error: 'refine' and 'mesh' exclude each other"},
      {"integrator: rk2", "running_costs: sum",
       "error: costs that are added up as they are change with the grid"},
      {"error: 1.0e-4", "error: 0", "error: a number from 1e-12 to 1 is expected here"},
      {"error: 1.0e-4", "factor: 2", "lacks the key 'error'"},
      {"rate: {x: v, v: u - x}}\ninitial_state: {values: {x: 1}}\nintegrator: rk2",
       "next: {x: v, v: u - x}}\ninitial_state: {values: {x: 1}}",
       "error: a system that gives the next state itself has no finer grid"}};
  for (const Case& c : cases) {
    const Loaded loaded(replaced(kOscillator, c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_NE(loaded.all().find(c.message), std::string::npos) << c.message << '\n' << loaded.all();
  }
}

}  // namespace
}  // namespace conddp
