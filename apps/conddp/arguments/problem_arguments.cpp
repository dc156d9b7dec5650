#include "arguments/problem_arguments.hpp"

#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "arguments/example_problems.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/files/source_text.hpp"
#include "problem_file/read/read_problem.hpp"

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

namespace {

/// The problem read from the standard input. Its paths are relative to the current folder.
std::optional<ProblemSpec> read_standard_input(const ProblemArguments& arguments,
                                               Diagnostics& out) {
  constexpr const char* kName = "stdin";
  std::string bytes(kMaxYamlBytes + 1, '\0');
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), stdin));
  if (bytes.size() > kMaxYamlBytes) {
    out.error({}, fmt::format("the standard input is larger than {} MiB", kMaxYamlBytes >> 20));
    return std::nullopt;
  }
  const auto text = checked_text(std::move(bytes), kName, out);
  if (!text) return std::nullopt;
  return read_problem_text(*text, kName, settings_of(arguments), out);
}

std::optional<ProblemSpec> read_named(const ProblemArguments& arguments, Diagnostics& out) {
  if (arguments.file == kStandardInput) return read_standard_input(arguments, out);
  const auto file = find_problem_file(arguments.file, out);
  if (!file) return std::nullopt;
  return read_problem(*file, settings_of(arguments), out);
}

}  // namespace

std::optional<ProblemSpec> read_problem_of(const ProblemArguments& arguments, Diagnostics& out) {
  auto spec = read_named(arguments, out);
  // The file does not name this solver, so messages about it must not refer to a place in the file.
  if (spec && !arguments.solver.empty()) spec->solver.name.place = {};
  return spec;
}

}  // namespace conddp
