#include "arguments/problem_arguments.hpp"

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "arguments/example_problems.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/files/text_file.hpp"

namespace conddp {

std::vector<Argument> problem_arguments(ProblemArguments& arguments) {
  return {
      {.names = {"FILE"},
       .value = "FILE.yaml",
       .description = "Problem file, or the name of an example (conddp list problems); '-' is the "
                      "standard input",
       .required = true,
       .target = &arguments.file},
      solver_argument(arguments.solver, "Solver instead of the file's"),
      drop_argument(arguments.drop, "Leave this constraint out; its violation is reported"),
      setting_argument(arguments.settings,
                       "Replace a value of the file, as in --set solver.max_iterations=50"),
      perturbation_argument(arguments.perturbations,
                            "Take a random instance, as conddp bench does: initial_state=S or "
                            "guess=S; repeatable"),
      seed_argument(arguments.seed, "Seed of the instance")};
}

std::vector<std::string> settings_of(const ProblemArguments& arguments) {
  std::vector<std::string> settings = arguments.settings;
  for (const auto& [name, value] : named_numbers(arguments.perturbations))
    settings.push_back(fmt::format("perturbation.{}={}", name, value));
  if (!arguments.perturbations.empty())
    settings.push_back(fmt::format("perturbation.seed={}", arguments.seed));
  if (!arguments.solver.empty()) settings.push_back("solver.name=" + arguments.solver);
  for (std::string& setting : solve_settings(arguments.max_time, arguments.threads))
    settings.push_back(std::move(setting));
  return settings;
}

Verbosity verbosity_of(const ProblemArguments& arguments) {
  if (arguments.quiet) return Verbosity::kQuiet;
  return arguments.verbose ? Verbosity::kVerbose : Verbosity::kNormal;
}

std::filesystem::path output_folder(const ProblemArguments& arguments, const BuiltProblem& built) {
  if (!arguments.folder.empty()) return arguments.folder;
  return std::filesystem::path("out") / built.facts().name.value;
}

BuildOptions build_options_of(const ProblemArguments& arguments) {
  return {.drop = arguments.drop, .unplaced_solver = !arguments.solver.empty()};
}

namespace {

/// The problem read from the standard input. Its paths are relative to the current folder.
std::optional<ProblemDocument> load_standard_input(Diagnostics& out) {
  constexpr const char* kName = "stdin";
  std::string bytes(kMaxYamlBytes + 1, '\0');
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), stdin));
  if (bytes.size() > kMaxYamlBytes) {
    out.error({}, fmt::format("the standard input is larger than {} MiB", kMaxYamlBytes >> 20));
    return std::nullopt;
  }
  auto text = checked_text(std::move(bytes), kName, out);
  return text ? parse_problem(*std::move(text), kName, out) : std::nullopt;
}

}  // namespace

std::optional<ProblemDocument> load_problem_of(const ProblemArguments& arguments,
                                               Diagnostics& out) {
  if (arguments.file == kStandardInput) return load_standard_input(out);
  const auto file = find_problem_file(arguments.file, out);
  return file ? load_problem(*file, {}, out) : std::nullopt;
}

std::optional<BuiltProblem> build_problem_of(const ProblemArguments& arguments,
                                             const BuildOptions& options, Diagnostics& out) {
  return build_problem(read_problem(load_problem_of(arguments, out), settings_of(arguments), out),
                       options, out);
}

}  // namespace conddp
