#include "batch/run/solve_item.hpp"

#include <chrono>
#include <limits>
#include <optional>

#include <fmt/format.h>

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

/// Converts an instance whose guess is a file to the input of solve_from().
NeighbourAnswer answer_of_file(const ProblemInstance& instance, const ManifestStart& start) {
  return {.trajectory = instance.built.guess,
          .multipliers = instance.built.multipliers,
          .cold_iterations =
              start.iterations >= 0 ? start.iterations : std::numeric_limits<int>::max()};
}

bool is_kept(const ItemResult& result, KeptSolutions keep) {
  return keep == KeptSolutions::kAll || (keep == KeptSolutions::kConverged && result.success);
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
  const ProblemInstance& first() const { return warm_ && from_file_ ? *from_file_ : *instance_; }
  const ProblemInstance& used() const {
    return refined_ && refined_->instance ? *refined_->instance : first();
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

  std::vector<Setting> settings_;
  std::optional<ProblemInstance> instance_;
  std::optional<ProblemInstance> from_file_;  ///< guess from the plan's file
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
  settings_ = settings_of(item_, diagnostics_);
  instance_ = family_.build(settings_, diagnostics_);
  if (!instance_ ||
      item_id(manifest_, item_.problem, settings_, input_files(instance_->built)) != item_.id)
    return false;
  from_file_ = build_from_file(manifest_, family_, settings_, start_, diagnostics_);
  if (diagnostics_.has_errors()) return false;
  candidates_ = usable_solvers(*instance_->spec, *instance_->built.problem, diagnostics_);
  return !candidates_.empty();
}

void ItemRun::solve() {
  if (from_file_) file_answer_ = answer_of_file(*from_file_, *manifest_.start);
  from_ = file_answer_ ? &*file_answer_ : start_.neighbour;
  started_ = solve_from(from_, *instance_, candidates_, options_of(*instance_), solver_);
  first_solver_ = solver_;
  warm_ = started_->start == StartKind::kWarm;
}

/// Solves on finer grids if the file requests them, in the remaining time.
void ItemRun::refine_mesh() {
  if (!first().spec->mesh) return;
  SolverOptions rest = options_of(first());
  rest.max_time_s -= seconds() - built_;
  const auto build = [&](const Setting& grid) {
    std::vector<Setting> finer = settings_;
    finer.push_back(grid);
    return &first() == &*instance_
               ? family_.build(finer, diagnostics_)
               : build_from_file(manifest_, family_, finer, start_, diagnostics_);
  };
  refined_ = refine(first(), started_->result, candidates_, rest, build, solver_);
}

SolvedItem ItemRun::certify() {
  Solution solution{*used().spec, used().built, *solver_, result(), item_.settings};
  solution.answer.judged = started_->judged;
  if (refined_) {
    solution.overrides.push_back(refined_->setting);
    solution.mesh = refined_->rounds;
  }
  const double prepared = seconds();
  SolutionCertificate certificate = certify_answer(solution);
  const double certified = seconds();
  const std::string coarse = refined_ ? too_coarse(*refined_, *used().spec) : "";
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
  return ItemRun(item, manifest, family, start).run();
}

}  // namespace conddp
