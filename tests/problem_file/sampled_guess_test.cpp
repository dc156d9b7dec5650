#include "problem_file/motion/sampled_guess.hpp"

#include <cmath>

#include "ocp/evaluation/evaluator.hpp"
#include "ocp/problem/by_name.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

std::string with_sampling(const std::string& text, const std::string& sampling) {
  return text + "initial_guess: {sampling: " + sampling + "}\n";
}

/// An example problem with a sampled guess around zero controls.
Loaded example(const std::string& name, const std::string& sampling,
               std::vector<std::string> settings = {}) {
  std::stringstream file;
  file << std::ifstream(kProblems / (name + ".yaml")).rdbuf();
  settings.push_back("initial_guess={sampling: " + sampling + "}");
  return Loaded(file.str(), settings);
}

Evaluation evaluated(const BuiltProblem& built) {
  Evaluation evaluation(*built.problem);
  Evaluator(*built.problem).evaluate(built.guess, evaluation);
  return evaluation;
}

/// Expects states that follow from the controls, and controls within their bounds.
void expect_rollout(const BuiltProblem& built) {
  EXPECT_LT(evaluated(built).gap.cwiseAbs().maxCoeff(), 1e-9);
  for (int k = 0; k < built.problem->knots(); ++k)
    for (int i = 0; i < built.problem->nu(k); ++i) {
      EXPECT_GE(built.guess.u(k)[i], built.problem->knot(k).model->control_lower()[i]);
      EXPECT_LE(built.guess.u(k)[i], built.problem->knot(k).model->control_upper()[i]);
    }
  EXPECT_NE(built.guess_used.controls.find("the best of"), std::string::npos)
      << built.guess_used.controls;
}

TEST(SampledGuess, SplinesReproduceTheirNodes) {
  for (const Interpolation form : {Interpolation::kLinear, Interpolation::kCubic})
    for (const int nodes : {1, 2, 3, 6}) {
      const TimeSeries units = unit_splines(nodes, form, 1, 4);
      for (int j = 0; j < nodes; ++j) {
        const std::vector<double> at = units.interpolate(
            nodes == 1 ? 1 : std::lerp(1, 4, static_cast<double>(j) / (nodes - 1)));
        for (int i = 0; i < nodes; ++i) EXPECT_NEAR(at[i], i == j ? 1 : 0, 1e-12);
      }
    }
}

TEST(SampledGuess, SplinesReproduceStraightLines) {
  for (const Interpolation form : {Interpolation::kLinear, Interpolation::kCubic}) {
    const TimeSeries units = unit_splines(5, form, 0, 4);
    for (const double time : {0.0, 0.3, 1.7, 3.9}) {
      const std::vector<double> at = units.interpolate(time);
      double one = 0, line = 0;
      for (int j = 0; j < 5; ++j) {
        one += at[j];
        line += at[j] * j;
      }
      EXPECT_NEAR(one, 1, 1e-12);
      EXPECT_NEAR(line, time, 1e-12);
    }
  }
}

TEST(SampledGuess, IsARolloutAroundTheGuess) {
  for (const char* sampling :
       {"{}", "{method: cem, spline: linear}", "{method: mppi, knots: 10}"}) {
    const Loaded loaded(with_sampling(std::string(kPendulum), sampling));
    ASSERT_TRUE(loaded.built) << loaded.all();
    expect_rollout(*loaded.built);
    EXPECT_EQ(loaded.built->guess_used.seed, 1u);
    EXPECT_GT(loaded.built->guess.u(0).norm(), 0);
  }
}

TEST(SampledGuess, CostsLessThanTheGuess) {
  const Loaded loaded(with_sampling(std::string(kPendulum), "{samples: 64, rounds: 10}"));
  const Loaded plain{std::string(kPendulum)};
  ASSERT_TRUE(loaded.built && plain.built) << loaded.all();
  Trajectory still = plain.built->guess;
  ASSERT_LT(Evaluator(*plain.built->problem).simulate(still), 0);
  Evaluation before(*plain.built->problem);
  Evaluator(*plain.built->problem).evaluate(still, before);
  EXPECT_LT(evaluated(*loaded.built).cost.sum(), 0.9 * before.cost.sum());
}

TEST(SampledGuess, ChoosesDurationsWithinBounds) {
  const Loaded loaded(with_sampling(
      replaced(kPendulum, "dt: 0.05}", "dt: 0.05, free_duration: {lower: 0.1, upper: 2}}"),
      "{samples: 32, rounds: 3}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  expect_rollout(*loaded.built);
  const double duration = loaded.built->guess.u(0)[0];
  EXPECT_NE(duration, 0.3);
  EXPECT_EQ(loaded.built->guess.x(loaded.built->problem->knots())[2], duration);
}

TEST(SampledGuess, LeavesALocalMinimum) {
  const auto cost = [](const BuiltProblem& built) {
    return solve(*built.problem, "box_fddp", {}, built.guess).cost;
  };
  const Loaded sampled = example("around_wall", "{}");
  ASSERT_TRUE(sampled.built) << sampled.all();
  Diagnostics out;
  const auto still = build_problem(*sampled.built, {.default_guess = true}, out);
  ASSERT_TRUE(still);
  EXPECT_GT(cost(*still), 1);
  EXPECT_LT(cost(*sampled.built), 0.1);
}

TEST(SampledGuess, MovesFloatingBases) {
  const Loaded loaded = example("quadrotor_flip", "{samples: 32, rounds: 5}");
  ASSERT_TRUE(loaded.built) << loaded.all();
  expect_rollout(*loaded.built);
}

TEST(SampledGuess, OfPhasesWithDifferentControls) {
  const Loaded loaded = example("rocket_stages", "{samples: 32, rounds: 3}");
  ASSERT_TRUE(loaded.built) << loaded.all();
  expect_rollout(*loaded.built);
}

TEST(SampledGuess, OfCollocationHasExplicitSteps) {
  const std::string sampling = "{samples: 64, rounds: 12}";
  const Loaded loaded = example("cartpole_collocation", sampling);
  const Loaded explicit_steps = example("cartpole_collocation", sampling, {"integrator=rk4"});
  ASSERT_TRUE(loaded.built && explicit_steps.built) << loaded.all() << explicit_steps.all();
  expect_rollout(*explicit_steps.built);
  const BuiltProblem &built = *loaded.built, &other = *explicit_steps.built;
  for (int k = 0; k < built.problem->knots(); ++k) {
    EXPECT_EQ(built.guess.x(k + 1), other.guess.x(k + 1));
    EXPECT_EQ(built.guess.u(k)[0], other.guess.u(k)[0]);
    EXPECT_GT(built.guess.nu(k), other.guess.nu(k));
  }
}

TEST(SampledGuess, OfContactsSatisfiesTheStep) {
  const Loaded loaded = example("puck_slide", "{samples: 16, rounds: 8}");
  ASSERT_TRUE(loaded.built) << loaded.all();
  const BuiltProblem& built = *loaded.built;
  expect_rollout(built);
  for (const auto& row : violations_by_name(*built.problem, evaluated(built).constraint)) {
    if (!row.name.starts_with("terminal")) {
      EXPECT_LT(row.value, 1e-6) << row.name;
    }
  }
}

TEST(SampledGuess, SurvivesExpansionAndFinerGrids) {
  const Loaded loaded(with_sampling(std::string(kPendulum), "{samples: 8, rounds: 2, knots: 3}"));
  ASSERT_TRUE(loaded.built) << loaded.all();
  Diagnostics out;
  const auto finer = build_on_grid(*loaded.built, {.factor = 2, .from_answer = true}, out);
  ASSERT_TRUE(finer);
  EXPECT_EQ(finer->guess_used.controls, "zero");
  const auto sampled = build_on_grid(*loaded.built, {.factor = 2}, out);
  ASSERT_TRUE(sampled);
  EXPECT_NE(sampled->guess_used.controls, "zero");
}

struct BadSampling {
  const char* name;
  const char* sampling;
  const char* place;
  const char* error;
};
void PrintTo(const BadSampling& bad, std::ostream* stream) { *stream << bad.name; }

class BadSamplings : public testing::TestWithParam<BadSampling> {};
TEST_P(BadSamplings, AreNamedWithTheirPlace) {
  const Loaded loaded(with_sampling(std::string(kPendulum), GetParam().sampling));
  EXPECT_FALSE(loaded.built);
  EXPECT_EQ(loaded.first_error().substr(0, 6), GetParam().place);
  EXPECT_NE(loaded.first_error().find(GetParam().error), std::string::npos) << loaded.first_error();
}
INSTANTIATE_TEST_SUITE_P(
    Keys, BadSamplings,
    testing::Values(BadSampling{"NoSamples", "{samples: 0}", "17:37:", "0"},
                    BadSampling{"NoRounds", "{rounds: 0}", "17:36:", "0"},
                    BadSampling{"TooManyKnots", "{knots: 11}", "17:35:", "10 knots"},
                    BadSampling{"UnknownMethod", "{method: annealing}", "17:36:", "annealing"},
                    BadSampling{"UnknownKey", "{nodes: 5}", "17:28:", "unknown key 'nodes'"}),
    [](const auto& test) { return test.param.name; });

}  // namespace
}  // namespace conddp
