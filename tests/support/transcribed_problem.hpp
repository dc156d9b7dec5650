#pragma once

#include <filesystem>
#include <fstream>
#include <random>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "nlp/transcription.hpp"
#include "output/report/solution_certificate.hpp"
#include "output/solution/golden_case.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/nlp_derivatives.hpp"
#include "support/source_tree.hpp"

/// Example problems by direct transcription.
namespace conddp::testing {

/// Folder of known answers of problems that are too slow for the default tests.
inline std::filesystem::path slow_answers() { return source_tree() / "tests/golden/slow"; }

/// Names a test by its string parameter.
inline constexpr auto name_of = [](const auto& test) { return test.param; };

/// Names of these slow problems.
inline std::vector<std::string> slow_problems() {
  std::vector<std::string> names;
  for (const auto& entry : std::filesystem::directory_iterator(slow_answers()))
    names.push_back(entry.path().stem().string());
  std::sort(names.begin(), names.end());
  return names;
}

/// Names of the example problems with legged robots, or of the others; without slow ones.
inline std::vector<std::string> ready_problems(bool legged) {
  std::vector<std::string> names;
  const auto folder = source_tree() / "problems";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    const std::string name = entry.path().stem().string();
    const bool on_legs = name.starts_with("quadruped") || name.starts_with("biped");
    if (entry.path().extension() == ".yaml" && on_legs == legged &&
        !exists(slow_answers() / (name + ".json")))
      names.push_back(name);
  }
  std::sort(names.begin(), names.end());
  return names;
}

/// The problems among these whose files do not name this solver.
inline std::vector<std::string> without(const std::string& solver, std::vector<std::string> names) {
  std::erase_if(names, [&solver](const std::string& name) {
    std::ifstream file(source_tree() / "problems" / (name + ".yaml"));
    const std::string text(std::istreambuf_iterator<char>(file), {});
    return text.find("name: " + solver) != std::string::npos;
  });
  return names;
}

struct ReadyProblem {
  explicit ReadyProblem(const std::string& name, const std::vector<std::string>& settings = {}) {
    const auto file = source_tree() / "problems" / (name + ".yaml");
    Diagnostics out;
    auto read = read_problem(file, settings, out);
    if (!read) throw std::runtime_error(format_diagnostics(out, false));
    spec = *std::move(read);
    auto made = build_problem(spec, {}, out);
    if (!made) throw std::runtime_error(format_diagnostics(out, false));
    built = *std::move(made);
  }
  ProblemSpec spec;
  BuiltProblem built;
};

inline double known_cost(const std::string& name) {
  Diagnostics out;
  const auto file = source_tree() / "tests/golden" / (name + ".json");
  return load_golden(file, out).value().answer.at("cost").get<double>();
}

/// Gradient, Jacobian and Hessian near the guess.
inline void check_transcription(const std::string& name) {
  const ReadyProblem ready(name);
  const ShootingProblem& problem = *ready.built.problem;
  Evaluator evaluator(problem);
  Transcription program(problem, evaluator, {});
  program.set_center(ready.built.guess);
  std::mt19937_64 engine(11);
  const Eigen::VectorXd y =
      program.point_of(ready.built.guess) + 0.05 * random_vector(program.variables(), engine);
  check_derivatives(program, y, engine, 1e-5);
}

/// Solves a problem with `ipopt` from its guess, or from its own solver's answer, and expects the
/// known optimum with a valid certificate.
inline void expect_known_optimum(const std::string& name, bool from_answer) {
  const ReadyProblem ready(name, {"solver.name=ipopt"});
  Trajectory start = ready.built.guess;
  SolverOptions options = ready.spec.solver.options;
  if (from_answer) {
    const ReadyProblem own(name);
    start = solve(*own.built.problem, own.spec.solver.name.value, own.spec.solver.options, start)
                .trajectory;
    options.ipopt = {{"mu_init", 1e-6}, {"bound_push", 1e-8}, {"bound_frac", 1e-8}};
  }
  const SolverInfo& solver = *find_solver("ipopt");
  const SolveResult result = solve(*ready.built.problem, solver, options, start);
  EXPECT_EQ(result.status, SolveStatus::converged) << result.message;
  const double cost = known_cost(name);
  EXPECT_NEAR(result.cost, cost, 1e-6 * std::abs(cost));
  BuiltProblem built = ready.built;
  auto spec = std::make_shared<ProblemSpec>(ready.spec);
  spec->solver.options = options;
  built.problem_spec = spec;
  const OrderedJson document =
      OrderedJson::parse(solution_json({built, solver, result, {}}).dump());
  for (const Check& check : certify_solution(document, built, false).checks.checks)
    EXPECT_TRUE(check.holds) << check.name << ": claimed " << check.claimed << ", found "
                             << check.found << ' ' << check.message;
}

}  // namespace conddp::testing
