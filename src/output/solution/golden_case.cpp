#include "output/solution/golden_case.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "analysis/certificate/certificate_doubt.hpp"
#include "base/json/json_document.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/build_problem.hpp"
#include "problem_file/assemble/homotopy.hpp"

namespace conddp {
namespace {

using Json = nlohmann::json;

constexpr std::string_view kGoldenKeys[] = {"problem",   "solver",     "iterations",
                                            "status",    "cost",       "cost_by_name",
                                            "residuals", "trajectory", "tolerances"};

const NamedTolerance* find_tolerance(const std::string& name) {
  const auto found =
      std::find_if(std::begin(kNamedTolerances), std::end(kNamedTolerances),
                   [&](const NamedTolerance& tolerance) { return name == tolerance.name; });
  return found == std::end(kNamedTolerances) ? nullptr : found;
}

std::string tolerance_names() {
  std::string names;
  for (const NamedTolerance& tolerance : kNamedTolerances)
    names += (names.empty() ? "" : ", ") + std::string(tolerance.name);
  return names;
}

/// The defect in the tolerances of a golden file, if any.
std::optional<std::string> tolerances_defect(const Json& answer) {
  if (!answer.contains("tolerances")) return std::nullopt;
  if (!answer["tolerances"].is_object()) return "'tolerances' has no names";
  for (const auto& [name, value] : answer["tolerances"].items()) {
    if (find_tolerance(name) == nullptr)
      return fmt::format("unknown tolerance '{}': accepted names: {}", name, tolerance_names());
    if (!value.is_number() || !(value.get<double>() >= 0))
      return fmt::format("'tolerances.{}' is not a number of at least 0", name);
  }
  return std::nullopt;
}

bool names_problem(const Json& answer) {
  return answer.contains("problem") && answer["problem"].is_object() &&
         answer["problem"].contains("file") && answer["problem"]["file"].is_string();
}

std::optional<std::string> problem_defect(const Json& answer) {
  if (!names_problem(answer)) return "'problem.file' is missing";
  if (!answer["problem"].contains("overrides")) return std::nullopt;
  const Json& overrides = answer["problem"]["overrides"];
  const bool good =
      overrides.is_array() && std::all_of(overrides.begin(), overrides.end(),
                                          [](const Json& setting) { return setting.is_string(); });
  if (!good) return "'problem.overrides' is not a list of settings";
  return std::nullopt;
}

/// The first defect in the entries of a golden file, compared or not.
std::optional<std::string> golden_defect(const Json& answer) {
  if (auto defect = problem_defect(answer)) return defect;
  if (!answer.contains("iterations") || !answer["iterations"].is_number_integer())
    return "'iterations' is missing";
  if (auto defect = tolerances_defect(answer)) return defect;
  return comparison_defect(answer);
}

}  // namespace

std::optional<GoldenCase> load_golden(const std::filesystem::path& file, Diagnostics& out) {
  auto answer = load_document(file, kSolutionDocument, kGoldenKeys, {}, out);
  if (!answer) return std::nullopt;
  if (auto defect = golden_defect(*answer)) {
    out.add({.file = file.string(), .message = "this is not a golden file: " + *defect});
    return std::nullopt;
  }
  const Json& problem = (*answer)["problem"];
  GoldenCase golden{.name = file.stem().string(), .file = file};
  golden.problem_file =
      (file.parent_path() / problem["file"].get<std::string>()).lexically_normal();
  golden.overrides = problem.value("overrides", std::vector<std::string>());
  if (answer->contains("tolerances"))
    for (const auto& [tolerance, value] : (*answer)["tolerances"].items())
      golden.tolerances.*find_tolerance(tolerance)->member = value;
  golden.answer = *std::move(answer);
  return golden;
}

GoldenCase new_golden(const std::filesystem::path& problem, const std::filesystem::path& folder) {
  GoldenCase golden{.name = problem.stem().string(), .problem_file = problem};
  golden.file = folder / (golden.name + ".json");
  return golden;
}

std::optional<GoldenOutcome> solve_golden(const GoldenCase& golden, const GoldenOptions& options,
                                          Diagnostics& out) {
  std::vector<std::string> settings = golden.overrides;
  settings.insert(settings.end(), options.settings.begin(), options.settings.end());
  const auto built = build_problem(read_problem(golden.problem_file, settings, out), {}, out);
  if (!built) return std::nullopt;
  const auto candidates = usable_solvers(*built, out);
  if (candidates.empty()) return std::nullopt;
  const SolverInfo* solver = nullptr;
  SolverOptions own = built->facts().solver.options;
  own.interrupted = options.interrupted;
  own.homotopy = homotopy_path(*built);
  const SolveResult result =
      solve(*built->problem, candidates, own, built->guess, solver, certificate_doubt(own));
  // Conversion through text: comparison and golden files have unordered keys.
  const OrderedJson document = solution_json({*built, *solver, result, settings});
  return GoldenOutcome{Json::parse(document.dump()), result.times.total};
}

std::string golden_text(const GoldenCase& golden, const Json& answer) {
  namespace fs = std::filesystem;
  Json part = golden_part(answer);
  part["problem"] = {
      {"file", fs::absolute(golden.problem_file)
                   .lexically_normal()
                   .lexically_relative(fs::absolute(golden.file).lexically_normal().parent_path())
                   .string()},
      {"overrides", golden.overrides}};
  if (golden.answer.contains("tolerances")) part["tolerances"] = golden.answer["tolerances"];
  return part.dump() + '\n';
}

}  // namespace conddp
