#include "batch/run/solve_item.hpp"

#include <chrono>

#include <fmt/format.h>

#include "base/json/number_block.hpp"
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
                      const ProblemFamily& family, const NeighbourAnswer* from) {
  const auto began = std::chrono::steady_clock::now();
  const auto seconds = [&] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  Diagnostics diagnostics = family.texts();
  const std::vector<Setting> settings = settings_of(item, diagnostics);
  const auto instance = family.build(settings, diagnostics);
  if (!instance || item_id(manifest.problems[item.problem].identity, settings,
                           input_files(instance->built)) != item.id)
    return {not_built(item, diagnostics), {}, {}};
  const auto candidates = usable_solvers(*instance->spec, *instance->built.problem, diagnostics);
  if (candidates.empty()) return {not_built(item, diagnostics), {}, {}};
  const double built = seconds();

  const SolverInfo* solver = nullptr;
  const StartedSolve started =
      solve_from(from, *instance, candidates, options_of(*instance), solver);
  const SolveResult& result = started.result;
  const double solved = seconds();
  OrderedJson document = solution_json(
      {*instance->spec, instance->built, *solver, result, item.settings}, NumberForm::kBlocks);
  if (started.start == StartKind::kWarm) name_neighbour(item.parent, *solver, document);
  const double written = seconds();
  const SolutionCertificate certificate =
      certify_solution(document, *instance->spec, instance->built, false);
  const double certified = seconds();
  SolvedItem out{{.id = item.id,
                  .status = std::string(to_string(result.status)),
                  .success = is_success(result.status) && certificate.checks.holds(),
                  .answer = answer_of(document, certificate)},
                 {},
                 {}};
  if (manifest.warm_start == WarmStart::kNeighbour) {
    out.result.answer["iterations"] = result.iterations + started.dropped_iterations;
    out.result.answer["start"] = to_string(started.start);
    if (out.result.success) out.answer = answer_for_neighbours(started, solver, from);
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
