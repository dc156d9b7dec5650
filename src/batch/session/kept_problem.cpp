#include "batch/session/kept_problem.hpp"

#include <utility>

#include "batch/run/warm_solve.hpp"
#include "output/report/certificate_report.hpp"
#include "output/solution/solution_json.hpp"
#include "problem_file/yaml/canonical_definition.hpp"
#include "problem_file/yaml/key_path.hpp"

namespace conddp {

ProblemFailure::ProblemFailure(const Diagnostics& found)
    : std::runtime_error("the problem has errors"),
      text(format_diagnostics(found, false, Severity::kError)) {
  for (const Diagnostic& d : found.list())
    if (d.severity == Severity::kError) errors.push_back(d);
}

Solution KeptAnswer::solution() const { return {task.built, *solver, result, settings, mesh}; }

OrderedJson KeptAnswer::document() const {
  OrderedJson document = solution_json(solution());
  if (certificate) {
    SolutionCertificate told = *certificate;
    note_nulls(document, told.checks);
    add_certificate(certificate_json(told), document);
  }
  return document;
}

KeptAnswer solve_task(SolveTask task, const GridSolve::Options& options,
                      std::vector<std::string> settings) {
  GridSolve solve(task, options);
  Diagnostics of_grids;
  auto result = solve.run(of_grids);
  if (!result) throw ProblemFailure(of_grids);
  settings = solve.with_grid(std::move(settings));
  KeptAnswer answer{std::move(task),     solve.solver(), *std::move(result),
                    std::move(settings), solve.rounds(), std::nullopt};
  if (options.verify) {
    Solution solution = answer.solution();
    solution.answer.judged = answer.task.judged;
    answer.certificate = certify_answer(solution);
  }
  return answer;
}

void start_from(const KeptAnswer& former, SolveTask& task) {
  const ShootingProblem& from = *former.task.built.problem;
  const ShootingProblem& to = *task.built.problem;
  BuiltProblem& built = task.built;
  const Eigen::VectorXd initial = built.guess.x(0);
  if (shape_of(from) == shape_of(to)) {
    built.guess = former.result.trajectory;
    built.multipliers = multipliers_of(former.result);
  } else if (from.nx() == to.nx() && from.phases().size() == to.phases().size()) {
    built.guess = on_grid(from, former.result.trajectory, to);
  } else {
    throw std::invalid_argument(
        "the answer to start from has other states or phases than this problem");
  }
  built.guess.x(0) = initial;
  built.guess_used.states = built.guess_used.controls = "a former answer";
  built.guess_used.multipliers = built.multipliers ? "those of the former answer" : "none";
}

KeptProblem KeptProblem::load(const std::filesystem::path& file) {
  Diagnostics out;
  auto family = ProblemFamily::load(file, {}, out);
  if (!family) throw ProblemFailure(out);
  return KeptProblem(std::move(family));
}

KeptProblem KeptProblem::parse(const std::string& text, const std::filesystem::path& folder) {
  Diagnostics out;
  auto family = ProblemFamily::parse(text, folder / "problem.yaml", out);
  if (!family) throw ProblemFailure(out);
  return KeptProblem(std::move(family));
}

void KeptProblem::set(const std::string& key, const std::string& value) {
  Diagnostics out;
  if (!parse_setting(key + "=" + value, out)) throw ProblemFailure(out);
  settings_[key] = value;
}

std::optional<OrderedJson> KeptProblem::get(const std::string& key) const {
  YamlNode root = family_->document().root;
  Diagnostics out = texts();
  for (const Setting& setting : parse_settings(settings(), out)) apply_setting(root, setting, out);
  const YamlNode* node = find_present(root, key);
  if (out.has_errors()) throw ProblemFailure(out);
  return node != nullptr ? std::optional<OrderedJson>(json_of(*node)) : std::nullopt;
}

std::vector<std::string> KeptProblem::settings(const Settings& more) const {
  Settings all = settings_;
  for (const auto& [key, value] : more) all[key] = value;
  std::vector<std::string> list;
  for (const auto& [key, value] : all) list.push_back(key + "=" + value);
  return list;
}

SolveTask KeptProblem::build(const std::vector<std::string>& settings, Diagnostics& out) const {
  const std::vector<Setting> parsed = parse_settings(settings, out);
  auto built = family_->build(parsed, out);
  if (!built || out.has_errors()) throw ProblemFailure(out);
  SolveTask task{.built = *std::move(built)};
  task.candidates = usable_solvers(task.built, out);
  if (task.candidates.empty()) throw ProblemFailure(out);
  return task;
}

std::unique_ptr<LoopTask> KeptProblem::build_loop() const {
  Diagnostics out = texts();
  const std::vector<Setting> parsed = parse_settings(settings(), out);
  auto task = family_->build_loop(parsed, out);
  if (!task || out.has_errors()) throw ProblemFailure(out);
  return task;
}

OrderedJson problem_outline(const BuiltProblem& built) {
  OrderedJson json = motion_names(built);
  json["name"] = built.facts().name.value;
  json["knots"] = built.problem->knots();
  return json;
}

}  // namespace conddp
