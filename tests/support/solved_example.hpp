#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>
#include <vector>

#include "output/report/solution_certificate.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "solvers/strategies/registry.hpp"
#include "support/source_tree.hpp"

namespace conddp {

struct ProblemText {
  std::string yaml;
};

/// An example problem, or one given as text, and the document of its answer.
struct SolvedExample {
  explicit SolvedExample(const std::string& name, const std::vector<std::string>& settings = {},
                         const BuildOptions& options = {}) {
    Diagnostics out;
    const auto file = source_tree() / "problems" / (name + ".yaml");
    solve_and_write(read_problem(file, settings, out), options, out);
  }
  /// Solves a text as if from a file of problems/.
  explicit SolvedExample(const ProblemText& text) {
    Diagnostics out;
    const auto file = source_tree() / "problems/text.yaml";
    solve_and_write(read_problem_text(text.yaml, file, {}, out), {}, out);
  }
  SolvedExample(const SolvedExample&) = delete;
  SolutionCertificate judge(const OrderedJson& changed) const {
    return certify_solution(changed, built, false);
  }
  ProblemSpec spec;
  BuiltProblem built;
  OrderedJson document;
  std::optional<SolveResult> result;

 private:
  void solve_and_write(std::optional<ProblemSpec> read, const BuildOptions& options,
                       Diagnostics& out) {
    if (!read) throw std::runtime_error(format_diagnostics(out, false));
    spec = *std::move(read);
    auto made = build_problem(spec, options, out);
    if (!made) throw std::runtime_error(format_diagnostics(out, false));
    built = *std::move(made);
    const SolverInfo& solver = *find_solver(spec.solver.name.value);
    result.emplace(solve(*built.problem, solver, spec.solver.options, built.guess));
    document = OrderedJson::parse(solution_json({built, solver, *result, {}}).dump());
  }
};

/// Adds to a number in place.
inline void add_to(OrderedJson& number, double change) { number = number.get<double>() + change; }

inline std::string failures(const SolutionCertificate& certificate) {
  std::string names;
  for (const Check& check : certificate.checks.checks)
    if (!check.holds) names += "[" + check.name + "]";
  return names;
}

}  // namespace conddp
