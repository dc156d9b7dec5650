#include "batch/run/solve_item.hpp"

#include <algorithm>
#include <chrono>
#include <limits>
#include <optional>

#include <fmt/format.h>

#include "analysis/certificate/certificate_doubt.hpp"
#include "output/mpc/loop_files.hpp"
#include "output/report/certificate_report.hpp"
#include "output/report/solution_certificate.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/assemble/homotopy.hpp"
#include "problem_file/mesh/mesh.hpp"
#include "solvers/common/status.hpp"
#include "solvers/strategies/registry.hpp"
#include "solvers/strategies/strategies.hpp"

namespace conddp {
namespace {

SolverOptions options_of(const BuiltProblem& built) {
  SolverOptions options = built.facts().solver.options;
  options.threads = 1;
  options.multipliers = built.multipliers;
  options.homotopy = homotopy_path(built);
  return options;
}

/// The figures of a solution.json for the row of results.
OrderedJson answer_of(const OrderedJson& document, const SolutionCertificate& certificate) {
  OrderedJson answer = OrderedJson::object();
  for (const char* key : {"solver", "message", "cost", "iterations", "residuals", "constraints"})
    answer[key] = document.at(key);
  answer["certificate"] = !certificate.checks.computable() ? "not_computable"
                          : certificate.checks.holds()     ? to_string(certificate.checks.verdict())
                                                           : "fails";
  return answer;
}

/// Records that a solve started from the answer of another item instead of the problem's guess.
void name_neighbour(const std::string& id, const SolverInfo& solver, OrderedJson& document) {
  OrderedJson& guess = document.at("initial_guess_used");
  guess["states"] = guess["controls"] = "the answer of item " + id;
  if (solver.constraints == ConstraintSupport::all) guess["multipliers"] = guess["states"];
  guess["seed"] = nullptr;
}

/// The problem with the plan's file as its guess. Nothing without such a file, or, with an error,
/// if the file has changed.
std::optional<BuiltProblem> build_from_file(const Manifest& manifest, const ProblemFamily& family,
                                            const std::vector<Setting>& settings,
                                            const ItemStart& start, Diagnostics& out) {
  if (!start.file) return std::nullopt;
  const Located<std::filesystem::path> file{*start.file, {{}, "warm_start"}};
  auto built = family.build(settings, out, file);
  if (!built) return std::nullopt;
  for (const InputFile& input : built->data_files)
    if (input.sha256 == manifest.start->file.sha256) return built;
  out.error(file.place,
            fmt::format("'{}' has changed since the plan was made", file.value.string()));
  return std::nullopt;
}

/// Converts an instance whose guess is a file to the input of solve_from().
NeighbourAnswer answer_of_file(const BuiltProblem& built, const ManifestStart& start) {
  return {.trajectory = built.guess,
          .multipliers = built.multipliers,
          .cold_iterations =
              start.iterations >= 0 ? start.iterations : std::numeric_limits<int>::max()};
}

bool is_kept(const ItemResult& result, KeptSolutions keep) {
  return keep == KeptSolutions::kAll || (keep == KeptSolutions::kConverged && result.success);
}

/// The answer for a file with `mesh`, on its last grid.
struct RefinedSolve {
  std::optional<BuiltProblem> built;  ///< on that grid; nothing if it is the first grid
  SolveResult result;
  std::vector<MeshRound> rounds;
  std::string setting;  ///< setting of that grid, in `--set` syntax
};

/// Continues from the answer on the first grid, as `conddp solve` does. `options.max_time_s`
/// applies to the subsequent grids. `solver` is the solver that found the answer.
RefinedSolve refine(const BuiltProblem& first, const SolveResult& result,
                    const std::vector<const SolverInfo*>& candidates, SolverOptions options,
                    const SolverInfo*& solver, Diagnostics& out) {
  constexpr double kLeastRest = 1e-3;  // s
  RefinedSolve refined{.result = result};
  const auto began = std::chrono::steady_clock::now();
  const double most = options.max_time_s;
  options = options_near(options);
  options.restarts.count = 0;
  options.homotopy = nullptr;
  options.multipliers = nullptr;
  MeshRefinement mesh(*first.facts().mesh);
  const BuiltProblem* grid = &first;
  while (const auto factor = mesh.next(*grid->problem, refined.result)) {
    auto finer = build_on_grid(*grid, {.factor = *factor, .from_answer = true}, out);
    if (!finer) break;
    finer->guess = on_grid(*grid->problem, refined.result.trajectory, *finer->problem);
    finer->guess_used = first.guess_used;
    const std::chrono::duration<double> gone = std::chrono::steady_clock::now() - began;
    options.max_time_s = std::max(kLeastRest, most - gone.count());
    refined.result = solve(*finer->problem, candidates, options, finer->guess, solver,
                           certificate_doubt(options));
    refined.built = std::move(finer);
    grid = &*refined.built;
  }
  refined.rounds = mesh.rounds();
  refined.setting = grid_setting(first, refined.rounds.back().factor);
  return refined;
}

/// A message about a grid that is too coarse; empty if it is as fine as the file requires.
std::string too_coarse(const RefinedSolve& solve, const BuiltProblem& built) {
  const double error = solve.rounds.back().error, asked = built.facts().mesh->error;
  if (error <= asked) return {};
  return fmt::format("the last grid of {} knots has an error of {:.1e}, which is more than {:.1e}",
                     solve.rounds.back().knots, error, asked);
}

/// Processes an item from its settings to its result, and records the time of each stage.
class ItemRun {
 public:
  ItemRun(const ManifestItem& item, const Manifest& manifest, const ProblemFamily& family,
          const ItemStart& start)
      : item_(item),
        manifest_(manifest),
        family_(family),
        start_(start),
        diagnostics_(family.texts()) {}

  SolvedItem run() {
    if (!build()) return {not_built(item_, diagnostics_), {}, {}};
    built_ = seconds();
    solve();
    refine_mesh();
    solved_ = seconds();
    return certify();
  }

 private:
  double seconds() const {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began_).count();
  }
  const BuiltProblem& first() const { return warm_ && from_file_ ? *from_file_ : *own_; }
  const BuiltProblem& used() const {
    return refined_ && refined_->built ? *refined_->built : first();
  }
  const SolveResult& result() const { return refined_ ? refined_->result : started_->result; }

  bool build();
  void solve();
  void refine_mesh();
  SolvedItem certify();
  void note_start(SolvedItem& out) const;

  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  const ManifestItem& item_;
  const Manifest& manifest_;
  const ProblemFamily& family_;
  const ItemStart& start_;
  Diagnostics diagnostics_;

  std::optional<BuiltProblem> own_;
  std::optional<BuiltProblem> from_file_;  ///< guess from the plan's file
  std::vector<const SolverInfo*> candidates_;

  std::optional<NeighbourAnswer> file_answer_;
  const NeighbourAnswer* from_ = nullptr;  ///< starting point of the solve, or null
  std::optional<StartedSolve> started_;
  bool warm_ = false;
  const SolverInfo* first_solver_ = nullptr;  ///< for the answer on the first grid
  const SolverInfo* solver_ = nullptr;
  std::optional<RefinedSolve> refined_;

  double built_ = 0, solved_ = 0;
};

/// Returns false if the item can no longer be built; `diagnostics_` may contain the reason.
bool ItemRun::build() {
  const std::vector<Setting> settings = parse_settings(item_.settings, diagnostics_);
  own_ = family_.build(settings, diagnostics_);
  if (!own_ || item_id(manifest_, item_.problem, settings, input_files(*own_)) != item_.id)
    return false;
  from_file_ = build_from_file(manifest_, family_, settings, start_, diagnostics_);
  if (diagnostics_.has_errors()) return false;
  candidates_ = usable_solvers(*own_, diagnostics_);
  return !candidates_.empty();
}

void ItemRun::solve() {
  if (from_file_) file_answer_ = answer_of_file(*from_file_, *manifest_.start);
  from_ = file_answer_ ? &*file_answer_ : start_.neighbour;
  started_ = solve_from(from_, *own_, candidates_, options_of(*own_), solver_);
  first_solver_ = solver_;
  warm_ = started_->start == StartKind::kWarm;
}

/// Solves on finer grids if the file requests them, in the remaining time.
void ItemRun::refine_mesh() {
  if (!first().facts().mesh) return;
  SolverOptions rest = options_of(first());
  rest.max_time_s -= seconds() - built_;
  refined_ = refine(first(), started_->result, candidates_, rest, solver_, diagnostics_);
}

SolvedItem ItemRun::certify() {
  Solution solution{used(), *solver_, result(), item_.settings};
  solution.answer.judged = started_->judged;
  if (refined_) {
    solution.overrides.push_back(refined_->setting);
    solution.mesh = refined_->rounds;
  }
  const double prepared = seconds();
  SolutionCertificate certificate = certify_answer(solution);
  const double certified = seconds();
  const std::string coarse = refined_ ? too_coarse(*refined_, used()) : "";
  SolvedItem out{{.id = item_.id,
                  .status = std::string(to_string(result().status)),
                  .success = is_success(result().status) &&
                             !is_denied(certificate.checks.verdict()) && coarse.empty()},
                 {},
                 {}};
  const bool kept = is_kept(out.result, manifest_.keep);
  OrderedJson document = kept ? solution_json(solution) : solution_head(solution);
  out.result.answer = answer_of(document, certificate);
  if (!coarse.empty()) out.result.answer["message"] = coarse + "; " + result().message;
  if (manifest_.warm_start != WarmStart::kNone) note_start(out);
  if (kept) {
    if (warm_ && !from_file_) name_neighbour(item_.parent, *solver_, document);
    note_nulls(document, certificate.checks);
    add_certificate(certificate_json(certificate), document);
    out.solution = packed_document(document);
  }
  out.result.times = {{"build", built_},
                      {"solve", solved_ - built_},
                      {"certificate", certified - prepared},
                      {"all", seconds()}};
  return out;
}

/// Records the starting point of the solve, and the answer for items that start from it.
void ItemRun::note_start(SolvedItem& out) const {
  out.result.answer["iterations"] = result().iterations + started_->dropped_iterations;
  out.result.answer["warm_start"] = to_string(started_->start);
  if (out.result.success) out.answer = answer_for_neighbours(*started_, first_solver_, from_);
}

}  // namespace

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
  return ItemRun(item, manifest, family, start).run();
}
namespace {

std::string_view status_of(LoopEnd end) {
  return end == LoopEnd::interrupted ? to_string(SolveStatus::time_limit) : to_string(end);
}

/// The fraction of ticks that satisfy a predicate.
template <class Holds>
double share_of(const std::vector<TickRecord>& ticks, Holds holds) {
  if (ticks.empty()) return 0;
  return static_cast<double>(std::count_if(ticks.begin(), ticks.end(), holds)) /
         static_cast<double>(ticks.size());
}

/// The figures of a loop for the row of results.
OrderedJson answer_of(const LoopTask& task, const ClosedLoopResult& result) {
  const auto is_planned = [](const TickRecord& t) { return t.outcome == TickOutcome::planned; };
  const auto falls_back = [](const TickRecord& t) { return t.fallback; };
  return {{"solver", task.mpc.controller.solver},
          {"time_s", tabulated_time(result.end_time)},
          {"planned", share_of(result.ticks, is_planned)},
          {"fallback", share_of(result.ticks, falls_back)},
          {"cost", finite_or_null(result.cost)},
          {"violation", finite_or_null(result.violation)},
          {"message", reason_of_end(task, result)}};
}

}  // namespace

SolvedItem simulate_item(const ManifestItem& item, const Manifest& manifest,
                         const ProblemFamily& family) {
  const auto began = std::chrono::steady_clock::now();
  const auto seconds = [began] {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count();
  };
  Diagnostics diagnostics = family.texts();
  const std::vector<Setting> settings = parse_settings(item.settings, diagnostics);
  const auto task = family.build_loop(settings, diagnostics);
  if (!task || item_id(manifest, item.problem, settings, input_files(*task)) != item.id)
    return {not_built(item, diagnostics), {}, {}};
  const double built = seconds(), limit = manifest.limits.max_time_s;
  task->mpc.controller.solver_options.threads = 1;
  if (limit > 0) task->mpc.loop.interrupted = [&] { return seconds() > built + limit; };
  const ClosedLoopResult result = run_loop(*task);
  return {{.id = item.id,
           .status = std::string(status_of(result.end)),
           .success = result.end == LoopEnd::finished,
           .answer = answer_of(*task, result),
           .times = {{"build", built}, {"solve", seconds() - built}, {"all", seconds()}}},
          {},
          {}};
}

}  // namespace conddp
