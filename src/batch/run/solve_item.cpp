#include "batch/run/solve_item.hpp"

#include <chrono>
#include <limits>

#include <fmt/format.h>

#include "base/json/number_block.hpp"
#include "batch/run/refined_solve.hpp"
#include "output/report/certificate_report.hpp"
#include "output/report/solution_certificate.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/build/homotopy.hpp"

namespace conddp {
namespace {

SolverOptions options_of(const ProblemInstance& instance) {
  SolverOptions options = instance.spec->solver.options;
  options.threads = 1;
  options.multipliers = instance.built.multipliers;
  options.homotopy = homotopy_path(instance.built);
  return options;
}

/// What of a solution.json goes into the row of results.
OrderedJson answer_of(const OrderedJson& document, const SolutionCertificate& certificate) {
  OrderedJson answer = OrderedJson::object();
  for (const char* key : {"solver", "message", "cost", "iterations", "residuals", "constraints"})
    answer[key] = document.at(key);
  answer["certificate"] = !certificate.checks.computable() ? "not_computable"
                          : certificate.checks.holds()     ? "holds"
                                                           : "fails";
  return answer;
}

/// That a solve started from the answer of another item, and not from the guess of its problem.
void name_neighbour(const std::string& id, const SolverInfo& solver, OrderedJson& document) {
  OrderedJson& guess = document.at("initial_guess_used");
  guess["states"] = guess["controls"] = "the answer of item " + id;
  if (solver.constraints == ConstraintSupport::all) guess["multipliers"] = guess["states"];
  guess["seed"] = nullptr;
}

/// The problem with the plan's file as its guess; nothing with an error where that is not what it
/// was, or there is none.
std::optional<ProblemInstance> build_from_file(const Manifest& manifest,
                                               const ProblemFamily& family,
                                               const std::vector<Setting>& settings,
                                               const ItemStart& start, Diagnostics& out) {
  if (!start.file) return std::nullopt;
  const Located<std::filesystem::path> file{*start.file, {{}, "warm_start"}};
  auto instance = family.build(settings, out, &file);
  if (!instance) return std::nullopt;
  for (const InputFile& input : instance->built.data_files)
    if (input.sha256 == manifest.start->file.sha256) return instance;
  out.error(file.place,
            fmt::format("'{}' has changed since the plan was made", file.value.string()));
  return std::nullopt;
}

/// What solve_from() needs to know of an instance whose guess is a file.
NeighbourAnswer answer_of_file(const ProblemInstance& instance, const ManifestStart& start) {
  return {.trajectory = instance.built.guess,
          .multipliers = instance.built.multipliers,
          .cold_iterations =
              start.iterations >= 0 ? start.iterations : std::numeric_limits<int>::max()};
}

bool is_kept(const ItemResult& result, KeptSolutions keep) {
  return keep == KeptSolutions::kAll || (keep == KeptSolutions::kConverged && result.success);
}

}  // namespace

std::vector<Setting> settings_of(const ManifestItem& item, Diagnostics& out) {
  std::vector<Setting> settings;
  for (const std::string& text : item.settings)
    if (auto setting = parse_setting(text, out)) settings.push_back(*std::move(setting));
  return settings;
}

ItemResult not_built(const ManifestItem& item, const Diagnostics& diagnostics) {
  std::string message = "its files have changed since the plan was made";
  for (const Diagnostic& d : diagnostics.list())
    if (d.severity == Severity::kError) {
      message = d.message;
      break;
    }
  return {.id = item.id,
          .status = std::string(kUnsolvable),
          .answer = {{"message", message}},
          .times = OrderedJson::object()};
}

SolvedItem solve_item(const ManifestItem& item, const Manifest& manifest,
                      const ProblemFamily& family, const ItemStart& start) {
  const auto began = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  Diagnostics diagnostics = family.texts();
  const std::vector<Setting> settings = settings_of(item, diagnostics);
  const auto instance = family.build(settings, diagnostics);
  if (!instance ||
      item_id(manifest, item.problem, settings, input_files(instance->built)) != item.id)
    return {not_built(item, diagnostics), {}, {}};
  const auto from_file = build_from_file(manifest, family, settings, start, diagnostics);
  if (diagnostics.has_errors()) return {not_built(item, diagnostics), {}, {}};
  const auto candidates = usable_solvers(*instance->spec, *instance->built.problem, diagnostics);
  if (candidates.empty()) return {not_built(item, diagnostics), {}, {}};
  const double built = seconds();

  const SolverInfo* solver = nullptr;
  const auto file_answer =
      from_file ? std::optional(answer_of_file(*from_file, *manifest.start)) : std::nullopt;
  const NeighbourAnswer* from = file_answer ? &*file_answer : start.neighbour;
  const StartedSolve started =
      solve_from(from, *instance, candidates, options_of(*instance), solver);
  const SolverInfo* const of_first = solver;
  const bool is_warm = started.start == StartKind::kWarm;
  const ProblemInstance& first = is_warm && from_file ? *from_file : *instance;
  std::optional<RefinedSolve> refined;
  if (first.spec->mesh) {
    SolverOptions rest = options_of(first);
    rest.max_time_s -= seconds() - built;
    const auto build = [&](const Setting& grid) {
      std::vector<Setting> finer = settings;
      finer.push_back(grid);
      return &first == &*instance ? family.build(finer, diagnostics)
                                  : build_from_file(manifest, family, finer, start, diagnostics);
    };
    refined = refine(first, started.result, candidates, rest, build, solver);
  }
  const ProblemInstance& used = refined && refined->instance ? *refined->instance : first;
  const SolveResult& result = refined ? refined->result : started.result;
  const double solved = seconds();
  Solution solution{*used.spec, used.built, *solver, result, item.settings};
  if (refined) {
    solution.overrides.push_back(refined->setting);
    solution.mesh = refined->rounds;
  }
  OrderedJson document = solution_json(solution, NumberForm::kBlocks);
  if (is_warm && !from_file) name_neighbour(item.parent, *solver, document);
  const double written = seconds();
  const SolutionCertificate certificate =
      certify_solution(document, *used.spec, used.built, false, &solution.answer);
  const double certified = seconds();
  SolvedItem out{{.id = item.id,
                  .status = std::string(to_string(result.status)),
                  .success = is_success(result.status) && certificate.checks.holds(),
                  .answer = answer_of(document, certificate)},
                 {},
                 {}};
  if (const std::string coarse = refined ? too_coarse(*refined, *used.spec) : ""; !coarse.empty()) {
    out.result.success = false;
    out.result.answer["message"] = coarse + "; " + result.message;
  }
  if (manifest.warm_start != WarmStart::kNone) {
    out.result.answer["iterations"] = result.iterations + started.dropped_iterations;
    out.result.answer["warm_start"] = to_string(started.start);
    if (out.result.success) out.answer = answer_for_neighbours(started, of_first, from);
  }
  if (is_kept(out.result, manifest.keep)) {
    add_certificate(certificate_json(certificate), document);
    out.solution = packed_document(document);
  }
  out.result.times = {{"build", built},
                      {"solve", solved - built},
                      {"certificate", certified - written},
                      {"all", seconds()}};
  return out;
}

}  // namespace conddp
