#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "arguments/shared_arguments.hpp"
#include "base/json/json_document.hpp"
#include "commands/commands.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct CompareArguments {
  std::string known;
  std::string other;
  std::vector<std::string> tolerances;
};

std::optional<nlohmann::json> load(const std::string& file, Diagnostics& out) {
  auto solution = load_document(file, kSolutionDocument, kComparedKeys, {}, out);
  if (!solution) return std::nullopt;
  const auto defect = comparison_defect(*solution);
  if (!defect) return solution;
  out.add({.file = file, .message = "the solution cannot be compared: " + *defect});
  return std::nullopt;
}

int compare(const CompareArguments& arguments) {
  Diagnostics diagnostics;
  const auto known = load(arguments.known, diagnostics);
  const auto other = load(arguments.other, diagnostics);
  print_messages(diagnostics, Verbosity::kNormal);
  if (!known || !other) return kExitBadInput;
  const auto differences =
      compare_solutions(*known, *other, comparison_tolerances(arguments.tolerances));
  if (differences.empty()) {
    print_result(fmt::format("{} agrees with {}\n", arguments.other, arguments.known));
    return kExitConverged;
  }
  print_result(fmt::format("{} differs from {}:\n", arguments.other, arguments.known));
  for (const Difference& difference : differences) print_result(difference_text(difference));
  return kExitNotConverged;
}

}  // namespace

Command compare_command() {
  const auto a = std::make_shared<CompareArguments>();
  return {.name = "conddp compare",
          .description = "Compare two solutions by meaning",
          .details =
              "Status, cost and costs by name, residuals, times, then every column of the "
              "trajectory; rotations by the angle between them. Numbers of iterations and "
              "times of computation are not compared.",
          .arguments = {{.names = {"KNOWN"},
                         .value = "KNOWN.json",
                         .description = "The solution to compare with, or a golden file",
                         .required = true,
                         .target = &a->known},
                        {.names = {"OTHER"},
                         .value = "OTHER.json",
                         .description = "The solution in question",
                         .required = true,
                         .target = &a->other},
                        comparison_tolerance_argument(a->tolerances)},
          .run = [a] { return compare(*a); }};
}

}  // namespace conddp
