// Compiled functions in problem files, compared with equivalent expressions.
#include <fstream>

#include "analysis/derivatives/derivative_check.hpp"
#include "base/files/check_sums.hpp"
#include "base/shared_library.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_text.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/temporary_folder.hpp"

// Sanitizers replace malloc.
#if !defined(__SANITIZE_ADDRESS__) && defined(__GLIBC__)
#define CONDDP_COUNTS_ALLOCATIONS_OF_LIBRARIES
#include "support/allocation_count.hpp"
#endif

namespace conddp {
namespace {

constexpr const char* kModel = CONDDP_TEST_MODEL;

/// A problem text with compiled code, loaded with permission.
Loaded load_with_code(const std::string& text, const std::vector<std::string>& settings = {}) {
  allow_code();
  return Loaded(text, settings);
}

const std::string kSwing = fmt::format(R"(conddp: 1
system:
  library: {}
  function: swing
  states: {{angle: rad, speed: rad/s}}
  controls: {{torque: Nm}}
  parameters: {{inertia: 2, weight: 5}}
initial_state: {{values: {{angle: 0.5}}}}
phases: [{{name: only, knots: 20, dt: 0.05}}]
costs: {{effort: {{residual: control, weight: 0.1}}}}
terminal: {{costs: {{goal: {{residual: state, reference: [1, 0], weight: 20}}}}}}
solver: {{name: box_fddp, tolerances: {{stationarity: 1.0e-8}}}}
)",
                                       kModel);

std::string in_words(std::string text, const std::string& equations) {
  const std::size_t from = text.find("  library:"), to = text.find("  states:");
  return text.replace(from, to - from, equations);
}

const std::string kSwingInWords = in_words(
    kSwing,
    "  rate: {angle: speed, speed: (torque - weight*sin(angle) - 0.1*speed*angle^2)/inertia}\n");

SolveResult answer_of(const Loaded& loaded, const char* solver, SolverOptions options) {
  return solve(*loaded.built->problem, solver, options, loaded.built->guess);
}

void expect_same_optimum(const std::string& library, const std::string& words) {
  const Loaded a = load_with_code(library), b{words};
  ASSERT_TRUE(a.built) << a.all();
  ASSERT_TRUE(b.built) << b.all();
  for (const char* solver : {"box_fddp", "altro", "ipopt", "box_ddp"}) {
    const SolveResult got = answer_of(a, solver, a.spec->solver.options);
    const SolveResult expected = answer_of(b, solver, b.spec->solver.options);
    EXPECT_EQ(got.status, SolveStatus::converged) << solver;
    EXPECT_EQ(expected.status, SolveStatus::converged) << solver;
    EXPECT_NEAR(got.cost, expected.cost, 1e-9 * (1 + std::abs(expected.cost))) << solver;
    for (int k = 0; k < got.trajectory.knots(); ++k)
      EXPECT_LT((got.trajectory.u(k) - expected.trajectory.u(k)).lpNorm<Eigen::Infinity>(), 1e-6)
          << solver << ' ' << k;
  }
}

TEST(LibraryFiles, ReachTheOptimumOfExpressionEquations) {
  expect_same_optimum(kSwing, kSwingInWords);
}

TEST(LibraryFiles, ReachTheOptimumOfEquationsWithAClock) {
  const std::string text =
      replaced(replaced(kSwing, "swing", "wind"), "  parameters: {inertia: 2, weight: 5}\n", "");
  const std::string of_state =
      replaced(text, "reference: [1, 0]", "columns: [angle, speed], reference: [1, 0]");
  expect_same_optimum(
      of_state,
      in_words(of_state, "  rate: {angle: speed, speed: torque - sin(angle) + 0.3*sin(2*t)}\n"));
}

TEST(LibraryFiles, ReachTheOptimumOfAccelerationsAndDifferences) {
  const std::string fall = replaced(
      replaced(replaced(kSwing, "  function: swing\n  states: {angle: rad, speed: rad/s}\n",
                        "  function: fall\n  gives: acceleration\n  positions: {y: m}\n"
                        "  velocities: {v: m/s}\n"),
               "  parameters: {inertia: 2, weight: 5}\n", ""),
      "values: {angle: 0.5}", "values: {y: 0.5}");
  std::string words = fall;
  const std::size_t from = words.find("  library:"), to = words.find("  positions:");
  words.replace(from, to - from, "  acceleration: {v: torque - 0.4*v^2}\n");
  expect_same_optimum(fall, words);

  const std::string next =
      replaced(replaced(kSwing, "function: swing", "function: swing\n  gives: next"), "knots: 20",
               "knots: 5");
  expect_same_optimum(next, in_words(next,
                                     "  next: {angle: speed, speed: (torque - weight*sin(angle) - "
                                     "0.1*speed*angle^2)/inertia}\n"));
}

const std::string kResidual = kSwingInWords + fmt::format(R"(constraints:
  reach: {{residual: library, library: {0}, function: reach, parameters: {{length: 0.5}}, upper: {{1: 0.4, 2: 0.3}}}}
)",
                                                          kModel);

TEST(LibraryFiles, ResidualsMatchExpressionsInEveryRole) {
  const std::string rows = "rows: [0.5*sin(angle), torque*speed]";
  const std::string library = fmt::format(
      "residual: library, library: {}, function: reach, parameters: {{length: 0.5}}", kModel);
  const std::string expression = "residual: expression, " + rows;
  for (const char* role :
       {"costs: {{effort: {{residual: control, weight: 0.1}}, own: {{{}, reference: [0.1, 0.2]}}}}",
        "constraints: {{own: {{{}, upper: {{1: 0.4, 2: 0.3}}}}}}",
        "constraints: {{own: {{{}, soft: l2, weight: 30, upper: {{1: 0.2, 2: 0.3}}}}}}"}) {
    const auto text = [&](const std::string& residual) {
      const std::string term = fmt::format(fmt::runtime(role), residual);
      return term.starts_with("costs")
                 ? replaced(kSwingInWords, "costs: {effort: {residual: control, weight: 0.1}}",
                            term)
                 : kSwingInWords + term + "\n";
    };
    const Loaded a = load_with_code(text(library)), b{text(expression)};
    ASSERT_TRUE(a.built) << a.all();
    ASSERT_TRUE(b.built) << b.all();
    for (const char* solver : {"altro", "ipopt"}) {
      const SolveResult got = answer_of(a, solver, a.spec->solver.options);
      const SolveResult expected = answer_of(b, solver, b.spec->solver.options);
      EXPECT_EQ(got.status, SolveStatus::converged) << role << solver;
      EXPECT_NEAR(got.cost, expected.cost, 1e-8 * (1 + std::abs(expected.cost))) << role << solver;
    }
    for (const DerivativeComparison& derivative :
         check_derivatives(*a.built->problem, a.built->guess, {.knots_per_phase = 3}))
      EXPECT_LT(derivative.error, 1e-6) << role;
  }
}

TEST(LibraryFiles, ResidualsUseKnotTimeOrClock) {
  const std::string late =
      fmt::format("own: {{residual: library, library: {}, function: late}}", kModel);
  const std::string own = "own: {residual: expression, rows: [angle - t]}";
  const std::string wind =
      replaced(replaced(kSwing, "swing", "wind"), "  parameters: {inertia: 2, weight: 5}\n", "");
  for (const std::string& base : {kSwing, wind}) {
    const std::string text =
        replaced(base, "reference: [1, 0]", "columns: [angle, speed], reference: [1, 0]");
    const Loaded a = load_with_code(replaced(text, "costs: {", "costs: {" + late + ", "));
    const Loaded b = load_with_code(replaced(text, "costs: {", "costs: {" + own + ", "));
    ASSERT_TRUE(a.built) << a.all();
    ASSERT_TRUE(b.built) << b.all();
    const double got = answer_of(a, "box_fddp", a.spec->solver.options).cost;
    EXPECT_NEAR(got, answer_of(b, "box_fddp", b.spec->solver.options).cost, 1e-9 * (1 + got));
  }
}

TEST(LibraryFiles, BelongToTheProblemIdentity) {
  const Loaded a = load_with_code(kSwing);
  ASSERT_TRUE(a.built) << a.all();
  ASSERT_EQ(a.built->data_files.size(), 1u);
  EXPECT_EQ(a.built->data_files[0].file, kModel);
  std::ifstream stream(kModel, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
  EXPECT_EQ(a.built->data_files[0].sha256, sha256(bytes));
  const Loaded b = load_with_code(kResidual);
  ASSERT_TRUE(b.built) << b.all();
  EXPECT_EQ(b.built->data_files.size(), 1u);
}

#ifdef CONDDP_COUNTS_ALLOCATIONS_OF_LIBRARIES
TEST(LibraryFiles, AllocateNothingInEvaluations) {
  const Loaded loaded = load_with_code(kResidual);
  ASSERT_TRUE(loaded.built) << loaded.all();
  const Loaded system = load_with_code(kSwing);
  ASSERT_TRUE(system.built) << system.all();
  for (const Loaded* each : {&loaded, &system}) {
    const ShootingProblem& problem = *each->built->problem;
    Evaluation evaluation(problem);
    Evaluator evaluator(problem);
    evaluator.evaluate(each->built->guess, evaluation);
    allocations = 0;
    counting = true;
    evaluator.evaluate(each->built->guess, evaluation);
    counting = false;
    EXPECT_EQ(allocations, 0);
  }
}
#endif

TEST(LibraryFiles, SettingsReachParameters) {
  const Loaded a = load_with_code(kSwing, {"system.parameters.weight=1"});
  const Loaded b(kSwingInWords, {"system.parameters.weight=1"});
  ASSERT_TRUE(a.built) << a.all();
  ASSERT_TRUE(b.built) << b.all();
  const double got = answer_of(a, "box_fddp", a.spec->solver.options).cost;
  EXPECT_NEAR(got, answer_of(b, "box_fddp", b.spec->solver.options).cost, 1e-9 * (1 + got));
}

TEST(LibraryFiles, MismatchesAreReportedAtTheirPlaces) {
  struct Case {
    std::string from, to, message;
  };
  const Case cases[] = {
      {"function: swing", "function: absent", "4:13: error: the library has no function 'absent'"},
      {"states: {angle: rad, speed: rad/s}", "states: [angle]",
       "5:11: error: the input 'x' of 'swing' is 2 x 1 with 2 numbers, and the file has 1"},
      {"controls: {torque: Nm}", "controls: [a, b]",
       "6:13: error: the input 'u' of 'swing' is 1 x 1 with 1 numbers, and the file has 2"},
      {", weight: 5", "",
       "7:15: error: the input 'p' of 'swing' is 2 x 1 with 2 numbers, and the file has 1"},
      {"function: swing\n  states: {angle: rad, speed: rad/s}\n  controls: {torque: Nm}\n  "
       "parameters: {inertia: 2, weight: 5}",
       "function: many\n  states: [angle, speed]\n  controls: [torque]",
       "5:11: error: 'many' gives 3 numbers, and the file has 2 states"},
      {"function: swing\n  states: {angle: rad, speed: rad/s}\n  controls: {torque: Nm}\n  "
       "parameters: {inertia: 2, weight: 5}",
       "function: wind\n  gives: next\n  states: [angle, speed]\n  controls: [torque]",
       "4:13: error: difference equations have no time"},
      {"speed: rad/s", "t: rad/s", "5:24: error: 't' is the name of the clock"},
      {"speed: rad/s", "angle: rad/s", "5:24: error: the key 'angle' is given twice"},
      {"states:", "positions:",
       "5:14: error: 'positions' does not go with what the function gives"},
      {"function: swing", "function: swing\n  gives: speed",
       "unknown answer of a function 'speed'"},
      {kModel, "absent.so", "3:12: error: "},
      {kModel, "test.yaml", "3:12: error: "}};
  for (const Case& c : cases) {
    const Loaded loaded = load_with_code(replaced(kSwing, c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_NE(loaded.all().find(c.message), std::string::npos) << c.message << '\n' << loaded.all();
  }
}

TEST(LibraryFiles, MismatchedResidualsHaveTheirPlace) {
  struct Case {
    std::string from, to, message;
  };
  const Case cases[] = {
      {"function: reach", "function: absent", "error: the library has no function 'absent'"},
      {", parameters: {length: 0.5}", "",
       "error: the input 'p' of 'reach' is 1 x 1 with 1 numbers, and the file has 0"},
      {"residual: library,", "residual: library, rows: [angle],",
       "error: the residual 'library' has no 'rows'"}};
  for (const Case& c : cases) {
    const Loaded loaded = load_with_code(replaced(kResidual, c.from, c.to));
    EXPECT_FALSE(loaded.built) << c.to;
    EXPECT_NE(loaded.all().find(c.message), std::string::npos) << c.message << '\n' << loaded.all();
  }
}

TEST(LibraryFiles, MissingAndInvalidLibrariesHaveTheirPlace) {
  const std::filesystem::path text =
      std::filesystem::temp_directory_path() / "conddp_no_library.so";
  std::ofstream(text) << "no library\n";
  const Loaded loaded = load_with_code(replaced(kSwing, kModel, text.string()));
  std::filesystem::remove(text);
  EXPECT_FALSE(loaded.spec);
  EXPECT_NE(loaded.all().find("cannot be loaded"), std::string::npos) << loaded.all();
  EXPECT_NE(loaded.all().find("cc -O2 -shared -fPIC"), std::string::npos) << loaded.all();
}

TEST(LibraryFiles, TruncatedLibrariesAreNotLoaded) {
  std::ifstream stream(kModel, std::ios::binary);
  const std::string whole{std::istreambuf_iterator<char>(stream), {}};
  const TemporaryFolder folder;
  const std::filesystem::path file = folder.path() / "part.so";
  for (const double share : {0.01, 0.3}) {
    std::ofstream(file, std::ios::binary)
        << whole.substr(0, static_cast<std::size_t>(share * static_cast<double>(whole.size())));
    const Loaded loaded = load_with_code(replaced(kSwing, kModel, file.string()));
    EXPECT_FALSE(loaded.spec) << share;
    EXPECT_NE(loaded.all().find("is cut off"), std::string::npos) << share << loaded.all();
  }
}

/// Worst Hessian error of a problem near its guess; −1 if none was compared.
double worst_hessian(const Loaded& loaded) {
  EXPECT_TRUE(loaded.built) << loaded.all();
  double worst = -1;
  for (const DerivativeComparison& c :
       check_derivatives(*loaded.built->problem, loaded.built->guess))
    if (c.kind == DerivativeKind::hessian) worst = std::max(worst, c.error);
  return worst;
}

TEST(LibraryFiles, HaveTheirHessiansCompared) {
  EXPECT_EQ(worst_hessian(load_with_code(kSwing)), 0) << "as differences confirm";
  EXPECT_GT(worst_hessian(load_with_code(replaced(kSwing, "swing", "bent"))), 1e-2);
  EXPECT_EQ(worst_hessian(Loaded(kSwingInWords)), -1) << "what is not claimed is not compared";
  const std::string residual =
      kSwingInWords + fmt::format(
                          "constraints: {{own: {{residual: library, library: {}, function: "
                          "bent, parameters: {{inertia: 2, weight: 5}}}}}}\n",
                          kModel);
  EXPECT_GT(worst_hessian(load_with_code(residual)), 1e-2);
}

TEST(LibraryFiles, AreNamedIfTheyReportFailure) {
  const std::string bare = replaced(kSwing, "  parameters: {inertia: 2, weight: 5}\n", "");
  for (const char* solver : {"box_fddp", "ipopt"}) {
    const Loaded torn = load_with_code(replaced(bare, "swing", "torn"));
    ASSERT_TRUE(torn.built) << torn.all();
    const SolveResult result = answer_of(torn, solver, {});
    EXPECT_EQ(result.status, SolveStatus::diverged) << solver;
    EXPECT_NE(result.message.find("; the compiled function 'torn' reported failure"),
              std::string::npos)
        << solver << ": " << result.message;
  }
  const Loaded stuck = load_with_code(replaced(bare, "swing", "stuck"));
  ASSERT_TRUE(stuck.built) << stuck.all();
  const std::string message = answer_of(stuck, "box_fddp", {}).message;
  EXPECT_NE(message.find("the compiled function 'jac_stuck' reported failure"), std::string::npos)
      << message;
  EXPECT_EQ(message.find("'stuck'"), std::string::npos) << message;
}

}  // namespace
}  // namespace conddp
