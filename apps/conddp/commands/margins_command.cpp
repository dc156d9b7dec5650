#include <stdexcept>

#include <fmt/format.h>

#include "arguments/problem_arguments.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/json/ordered_json.hpp"
#include "commands/commands.hpp"
#include "problem_file/assemble/homotopy.hpp"
#include "problem_file/assemble/tangent_numbers.hpp"
#include "problem_file/values/key_forms.hpp"
#include "problem_file/yaml/yaml_source.hpp"
#include "summary/summary.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct MarginArguments : ProblemArguments {
  std::string initial, process, measurement;  ///< standard deviations, as YAML
};

/// The standard deviations of an option; zero without it.
Eigen::VectorXd sigmas_of(const char* option, const std::string& text, const BuiltProblem& built,
                          Diagnostics& out) {
  std::optional<ComponentsSpec> components;
  if (!text.empty()) {
    const auto node = parse_yaml(text, out.add_source(option, text), out, 0, true);
    if (node) {
      const ComponentsForm form{kNotNegative};
      form.read(YamlReader(*node, option, out), components.emplace());
    }
  }
  const std::vector<double> sigma = tangent_numbers(components, built, out);
  return Eigen::Map<const Eigen::VectorXd>(sigma.data(), static_cast<Eigen::Index>(sigma.size()));
}

StateNoise noise_of(const MarginArguments& arguments, const BuiltProblem& built, Diagnostics& out) {
  StateNoise noise{sigmas_of("--initial", arguments.initial, built, out),
                   sigmas_of("--process", arguments.process, built, out),
                   sigmas_of("--measurement", arguments.measurement, built, out)};
  if (!out.has_errors() && noise.initial.isZero(0) && noise.process.isZero(0) &&
      noise.measurement.isZero(0))
    out.error({}, "there is no noise: every 'sigma' is 0",
              "give --initial, --process or --measurement, for example --process 0.01");
  return noise;
}

/// The answer of the file's solver. Empty with an error if it lacks gains.
std::optional<SolveResult> solve_for_gains(const BuiltProblem& built, Diagnostics& out) {
  const auto candidates = usable_solvers(built, out);
  if (candidates.empty()) return std::nullopt;
  SolverOptions options = built.facts().solver.options;
  options.multipliers = built.multipliers;
  options.homotopy = homotopy_path(built);
  const SolverInfo* used = nullptr;
  SolveResult result = solve(*built.problem, candidates, options, built.guess, used);
  if (result.feedback_regularization) return result;
  out.error({}, fmt::format("the answer of {} has no gains: {}", used->name, result.message));
  return std::nullopt;
}

/// Empty with an error if the noise causes an overflow.
std::optional<std::vector<MarginCurve>> margins_of(const ShootingProblem& problem,
                                                   const SolveResult& result,
                                                   const StateNoise& noise, Diagnostics& out) {
  try {
    return constraint_margins(problem, result.trajectory, result.feedback.K, noise);
  } catch (const std::overflow_error& error) {
    out.error({}, fmt::format("{}: the noise is too large", error.what()),
              "standard deviations are squared, and carried through the gains of the plan");
    return std::nullopt;
  }
}

int print_margins(const MarginArguments& arguments) {
  Diagnostics diagnostics;
  const auto built = build_problem_of(arguments, build_options_of(arguments), diagnostics);
  const StateNoise noise = built ? noise_of(arguments, *built, diagnostics) : StateNoise();
  const auto result = diagnostics.has_errors() ? std::optional<SolveResult>()
                                               : solve_for_gains(*built, diagnostics);
  if (result && !is_success(result->status))
    diagnostics.warning({}, fmt::format("the plan is not a solution: {}", result->message));
  const auto curves = result ? margins_of(*built->problem, *result, noise, diagnostics)
                             : std::optional<std::vector<MarginCurve>>();
  print_messages(diagnostics, Verbosity::kNormal);
  if (!curves) return kExitBadInput;
  const OrderedJson margins = margins_json(*curves, noise, *built, result->trajectory);
  print_result(arguments.json ? json_text(margins) : margins_text(margins));
  return is_success(result->status) ? kExitConverged : kExitNotConverged;
}

Argument sigma_argument(const char* name, std::string& target, std::string description) {
  return {
      .names = {name}, .value = "SIGMA", .description = std::move(description), .target = &target};
}

}  // namespace

Command margins_command() {
  const auto a = std::make_shared<MarginArguments>();
  return {
      .name = "conddp margins",
      .description = "Solve a problem and compute how much noise its plan tolerates",
      .details =
          "Propagates the state covariance through the gains of the plan, to first order. Prints "
          "the smallest distance to each control bound and constraint in standard deviations, its "
          "place, and the probability of a violation there. SIGMA is a standard deviation for all "
          "components of the state, a list, or a mapping of names: '{theta: 0.01, \"v*\": 0.1}'. "
          "Exit status 1 where the solver did not converge.",
      .arguments = joined(
          problem_arguments(*a),
          {sigma_argument("--initial", a->initial, "Noise of the initial state"),
           sigma_argument("--process", a->process,
                          "Noise added to the state by each knot that takes time"),
           sigma_argument("--measurement", a->measurement,
                          "Noise of the state measurement that the gains receive at each knot"),
           flag({"--json"}, a->json, "Print all nodes as JSON on stdout (conddp schema margins)")}),
      .run = [a] { return print_margins(*a); }};
}

}  // namespace conddp
