// Seeded random problems through the complete path of `conddp solve` and `conddp verify`.
#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <map>
#include <regex>

#include <gtest/gtest.h>

#include "analysis/certificate/certificate_doubt.hpp"
#include "composed_body.hpp"
#include "composed_features.hpp"
#include "composed_problem.hpp"
#include "coverage.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "output/report/certificate_report.hpp"
#include "output/report/solution_certificate.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/homotopy.hpp"
#include "problem_file/expand/expand_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "support/sizes.hpp"
#include "support/source_tree.hpp"

namespace conddp {
namespace {

/// Seeds of one run of the test.
struct SeedRange {
  std::uint64_t first = 0;
  int count = kSmallSizes ? 20 : kDefaultCount;
  static constexpr int kDefaultCount = 300;

  /// CONDDP_COMPOSED=COUNT or COUNT:FIRST overrides the default.
  static SeedRange from_environment() {
    SeedRange range;
    const char* asked = std::getenv("CONDDP_COMPOSED");
    if (asked == nullptr) return range;
    char* end = nullptr;
    range.count = static_cast<int>(std::strtol(asked, &end, 10));
    if (*end == ':') range.first = std::strtoull(end + 1, nullptr, 10);
    return range;
  }
};

struct ReadProblem {
  Diagnostics diagnostics;
  std::optional<ProblemSpec> spec;
  std::optional<BuiltProblem> built;
  std::vector<const SolverInfo*> candidates;
};

/// Reads like `conddp solve`; without candidate solvers the problem is rejected.
std::unique_ptr<ReadProblem> read_composed(const std::string& text,
                                           const std::vector<std::string>& drop) {
  auto read = std::make_unique<ReadProblem>();
  const auto file = source_tree() / "problems/composed.yaml";
  read->spec = read_problem_text(text, file, {}, read->diagnostics);
  if (read->spec) read->built = build_problem(*read->spec, {.drop = drop}, read->diagnostics);
  if (read->built) read->candidates = usable_solvers(*read->built, read->diagnostics);
  return read;
}

/// A rejection names its place and reason.
void expect_clear_refusal(const ReadProblem& read) {
  EXPECT_TRUE(read.diagnostics.has_errors()) << "refused without an error";
  for (const Diagnostic& d : read.diagnostics.list()) {
    if (d.severity != Severity::kError) continue;
    EXPECT_GT(d.line, 0) << d.message;
    EXPECT_GT(d.column, 0) << d.message;
    EXPECT_FALSE(d.path.empty()) << d.message;
    EXPECT_GT(d.message.size(), 10u);
  }
}

/// Common part of messages about different names and numbers.
std::string kind_of_refusal(const ReadProblem& read) {
  for (const Diagnostic& d : read.diagnostics.list())
    if (d.severity == Severity::kError)
      return std::regex_replace(std::regex_replace(d.message, std::regex("'[^']*'"), "'...'"),
                                std::regex("-?[0-9][0-9.e+-]*"), "#");
  return "no message";
}

/// The file with every default is the same problem.
void expect_expansion_to_be_the_same(const ReadProblem& read, const ComposedProblem& problem) {
  const std::string text = expanded_text(*read.built);
  const auto again = read_composed(text, problem.drop);
  ASSERT_TRUE(again->built) << format_diagnostics(again->diagnostics, false) << text;
  EXPECT_EQ(expanded_text(*again->built), text);
}

/// Names of the failed checks, one a line.
std::string failures_of(const SolutionCertificate& certificate) {
  std::string lines;
  for (const Check& check : certificate.checks.checks)
    if (!check.holds)
      lines += fmt::format("{}: claimed {}, found {}, tolerance {} {} {}\n", check.name,
                           check.claimed, check.found, check.tolerance, check.place, check.message);
  return lines;
}

bool all_finite(const Trajectory& trajectory) {
  for (int k = 0; k <= trajectory.knots(); ++k) {
    if (!trajectory.x(k).allFinite()) return false;
    if (k < trajectory.knots() && !trajectory.u(k).allFinite()) return false;
  }
  return true;
}

/// `scale`: factor of the costs in the solve; the tolerance applies to the scaled gradients.
void expect_to_be_stated(const SolveResult& result, const SolverOptions& options, double scale) {
  EXPECT_LE(static_cast<int>(result.status), 0);
  EXPECT_NE(result.status, SolveStatus::time_limit);
  EXPECT_NE(result.status, SolveStatus::interrupted);
  EXPECT_FALSE(result.message.empty()) << to_string(result.status);
  EXPECT_TRUE(all_finite(result.trajectory)) << "the last iterate that was finite";
  if (result.status != SolveStatus::converged) return;
  EXPECT_TRUE(std::isfinite(result.cost));
  EXPECT_LE(scale * result.residuals.stationarity, options.tolerances.stationarity);
  EXPECT_LE(result.residuals.gap, options.tolerances.gap);
  EXPECT_LE(result.residuals.constraint, options.tolerances.constraint);
}

/// Checks the document with its certificate as `verify` finds them in the files. Returns true if
/// only optimality is in doubt: without a cost on all controls, an optimum may not exist.
bool expect_to_be_certified(const ReadProblem& read, const ComposedProblem& problem,
                            const SolverInfo& used, const SolveResult& result) {
  OrderedJson document = solution_json({*read.built, used, result, {}});
  const SolutionCertificate certificate = certify_solution(document, *read.built, false);
  const bool converged = result.status == SolveStatus::converged;
  EXPECT_TRUE(!converged || certificate.checks.computable());
  if (!certificate.checks.computable()) return false;
  if (certificate.checks.doubts_optimality_alone()) return true;
  EXPECT_EQ(failures_of(certificate), "");
  add_certificate(certificate_json(certificate), document);
  const std::string text = json_text(document);
  const OrderedJson written = OrderedJson::parse(text);
  EXPECT_EQ(json_text(written), text);
  const auto again = read_composed(problem.text, problem.drop);
  EXPECT_EQ(failures_of(certify_solution(written, *again->built, true)), "");
  return false;
}

/// Outcome of a problem: a status or a rejection.
struct Ending {
  bool refused = false;
  bool doubted = false;  ///< the certificate doubts only optimality
  std::string words;
  double seconds = 0;
};

Ending run(const ComposedProblem& problem, Coverage& coverage) {
  const auto read = read_composed(problem.text, problem.drop);
  if (read->candidates.empty()) {
    expect_clear_refusal(*read);
    return {.refused = true, .words = kind_of_refusal(*read)};
  }
  expect_expansion_to_be_the_same(*read, problem);
  SolverOptions options = read->spec->solver.options;
  options.homotopy = homotopy_path(*read->built);
  options.multipliers = read->built->multipliers;
  const SolverInfo* used = nullptr;
  const SolveResult result = solve(*read->built->problem, read->candidates, options,
                                   read->built->guess, used, certificate_doubt(options));
  if (used == nullptr) throw std::logic_error("a solve names no solver");
  expect_to_be_stated(result, options, cost_scale(*read->built->problem));
  const bool doubted = expect_to_be_certified(*read, problem, *used, result);
  coverage.add(problem.body, *read->built, *used);
  return {.doubted = doubted, .words = fmt::format("{}", to_string(result.status))};
}

/// Prints outcomes with counts, and the slowest seeds for manual runs.
void print(const std::map<std::string, int>& endings, std::multimap<double, std::uint64_t>& times) {
  for (const auto& [words, count] : endings) std::cout << fmt::format("{:6} {}\n", count, words);
  while (times.size() > 5) times.erase(times.begin());
  for (const auto& [seconds, seed] : times)
    std::cout << fmt::format("{:6.1f} s: seed {}\n", seconds, seed);
}

/// How often composed problems were refused or doubted.
struct Tally {
  int refused = 0, doubted = 0;
};

/// Runs the problems of `count` seeds and prints how they ended.
template <class Compose>
Tally run_all(std::uint64_t first, int count, const Compose& compose, Coverage& coverage) {
  std::map<std::string, int> endings;
  std::multimap<double, std::uint64_t> times;
  Tally tally;
  for (int i = 0; i < count; ++i) {
    const std::uint64_t seed = first + static_cast<std::uint64_t>(i);
    const ComposedProblem problem = compose(seed);
    SCOPED_TRACE(fmt::format("seed {}{}{}:\n{}", seed, problem.drop.empty() ? "" : ", --drop ",
                             fmt::join(problem.drop, ""), problem.text));
    if (count == 1) std::cout << problem.text << std::flush;
    const auto began = std::chrono::steady_clock::now();
    try {
      const Ending ending = run(problem, coverage);
      ++endings[(ending.refused ? "refused: " : "") + ending.words];
      tally.refused += ending.refused ? 1 : 0;
      tally.doubted += ending.doubted ? 1 : 0;
    } catch (const std::exception& exception) {
      ADD_FAILURE() << "an exception: " << exception.what();
    }
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began;
    times.emplace(gone.count(), seed);
  }
  print(endings, times);
  return tally;
}

TEST(Composer, EveryProblemEndsWithCertificateOrReason) {
  std::vector<std::string> bodies;
  for (const ComposedBody& body : composed_bodies()) bodies.push_back(body.name);
  Coverage coverage(bodies);
  const SeedRange range = SeedRange::from_environment();
  const Tally tally = run_all(range.first, range.count, compose_problem, coverage);
  EXPECT_LE(tally.doubted, 1 + range.count / 100);
  if (range.count < SeedRange::kDefaultCount) return;
  EXPECT_LT(tally.refused, 0.2 * range.count) << "refused compositions test the reader alone";
  EXPECT_EQ(coverage.missing(), "");
}

/// Numbers behind the states and rewritings, with all other features of a problem.
TEST(Composer, FeaturesCombine) {
  Coverage coverage({});
  const SeedRange range = SeedRange::from_environment();
  const int count = range.count / (range.count == SeedRange::kDefaultCount ? 5 : 1);
  const auto compose = [](std::uint64_t seed) {
    return with_features(compose_problem(seed), seed);
  };
  const Tally tally = run_all(range.first, count, compose, coverage);
  // Linear controls may alternate at nodes without cost, and so may chosen ones.
  EXPECT_LE(tally.doubted, 1 + count / 50);
  EXPECT_LT(tally.refused, 0.6 * count);
}

/// Box problems in strongly coupled controls, costates changed by a failed search after exact
/// Hessians, a restoration without a finite first point, and small gradients with much cost left to
/// gain.
TEST(Composer, UnfinishedAnswersMatchTheirTrajectory) {
  Coverage coverage({});
  for (const std::uint64_t seed : {60381, 63549, 64270, 810615}) {
    const ComposedProblem problem = compose_problem(seed);
    SCOPED_TRACE(fmt::format("seed {}:\n{}", seed, problem.text));
    EXPECT_FALSE(run(problem, coverage).refused);
  }
}

/// Bodies that rotate a million times a step, wrists at thousands of radians a second, free
/// directions without cost: a certificate must distinguish rounding from errors.
TEST(Composer, AnswersMadeOfRoundingHaveACertificate) {
  Coverage coverage({});
  for (const std::uint64_t seed : {543, 20165, 20291, 30395, 31913, 32221, 33013, 34619}) {
    const ComposedProblem problem = compose_problem(seed);
    SCOPED_TRACE(fmt::format("seed {}:\n{}", seed, problem.text));
    EXPECT_FALSE(run(problem, coverage).refused);
  }
}

}  // namespace
}  // namespace conddp
