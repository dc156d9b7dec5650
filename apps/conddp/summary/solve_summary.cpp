#include <fmt/format.h>

#include "base/text/utf8.hpp"
#include "ocp/problem/cost_scale.hpp"
#include "ocp/step/integrator_table.hpp"
#include "output/report/answer_settings.hpp"
#include "output/report/certificate_report.hpp"
#include "output/report/contact_report.hpp"
#include "output/solution/finding_report.hpp"
#include "output/solution/free_numbers.hpp"
#include "solvers/strategies/registry.hpp"
#include "summary/summary.hpp"

namespace conddp {
namespace {

/// Free durations and parameters, those of one kind on one line.
std::string free_number_lines(const Solution& s) {
  constexpr std::string_view kDuration = "duration/";
  std::string durations, parameters;
  for (const FreeNumber& number : free_numbers(s.built, s.result.trajectory)) {
    const bool duration = number.name.starts_with(kDuration);
    std::string& text = duration ? durations : parameters;
    const bool has_unit = !number.unit.empty() && number.unit != "1";
    text += fmt::format("{}{} {:.9g}{}{}", text.empty() ? "" : ", ",
                        duration ? number.name.substr(kDuration.size()) : number.name, number.value,
                        has_unit ? " " + number.unit : "",
                        number.limit.empty() ? "" : fmt::format(" (its {} limit)", number.limit));
  }
  if (!durations.empty()) durations = fmt::format("  durations     {}\n", durations);
  if (!parameters.empty()) parameters = fmt::format("  parameters    {}\n", parameters);
  return durations + parameters;
}

/// The solves of a homotopy: the share and iterations of each and, if it did not converge, its
/// status.
std::string homotopy_line(const std::vector<HomotopyStep>& steps) {
  std::string text;
  for (const HomotopyStep& step : steps)
    text += fmt::format(
        "{}{:.4g}: {}{}", text.empty() ? "" : ", ", step.share, step.iterations,
        step.status == SolveStatus::converged ? "" : fmt::format(" ({})", to_string(step.status)));
  return text.empty() ? text : fmt::format("  homotopy      iterations at s = {}\n", text);
}

/// Advice for a faster decrease of the error on finer grids: rules of order 1 only halve it.
std::string mesh_remedy(const Solution& s) {
  for (const Phase& phase : s.built.problem->phases())
    if (info_of(phase.model->integrator()).order == 1)
      return "; try an integrator of higher order (integrator: rk4)";
  return "";
}

/// The grids with their numbers of knots and errors.
std::string mesh_line(const Solution& s) {
  std::string text;
  for (const MeshRound& round : s.mesh)
    text += fmt::format("{}{}: {:.1e}", text.empty() ? "" : ", ", round.knots, round.error);
  if (text.empty()) return text;
  const bool reached = s.mesh.back().error <= s.built.facts().mesh->error;
  const std::size_t rounds = s.mesh.size();
  const bool grew = rounds > 1 && s.mesh[rounds - 1].error >= s.mesh[rounds - 2].error;
  return fmt::format("  mesh          error at knots {}{}{}{}\n", text,
                     reached ? "" : fmt::format("; more than {:.1e}", s.built.facts().mesh->error),
                     !reached && grew ? ", and no longer smaller on finer grids" : "",
                     reached ? "" : mesh_remedy(s));
}

/// The solvers that `auto` tries, if the file selects it.
std::string auto_line(const Solution& s) {
  if (s.built.facts().solver.name.value != kAutoSolver) return {};
  const ShootingProblem& problem = *s.built.problem;
  const auto list = auto_solvers(problem, s.built.facts().solver.options);
  if (list.empty()) return {};
  return fmt::format("  auto          {}\n", describe_auto(problem, list));
}

/// Attempts of `auto`: "altro 5.7313 (105 iterations, 0.13 s); ...".
std::string attempts_line(const std::vector<Attempt>& attempts) {
  if (attempts.size() < 2) return {};
  std::string text;
  for (const Attempt& a : attempts) {
    text += fmt::format("{}{}{} {} ({} iterations, {:.2g} s{}{})", text.empty() ? "" : "; ",
                        a.solver, a.start == 0 ? "" : fmt::format(" from restart {}", a.start),
                        is_success(a.status) ? fmt::format("{:.6g}", a.cost) : to_string(a.status),
                        a.iterations, a.time_s, a.objection.empty() ? "" : ", doubted",
                        a.chosen ? ", chosen" : "");
  }
  return fmt::format("  tried         {}\n", text);
}

std::string restart_lines(const RestartRecord& restarts) {
  std::string text = fmt::format(
      "  restarts      {} starts, {} converged, to {} optima; the answer is that of start {}\n",
      restarts.starts, restarts.converged, restarts.basins.size(), restarts.answer);
  for (const Basin& basin : restarts.basins)
    text += fmt::format("    {:<20.9g} ends of starts: {}, the first of them start {}\n",
                        basin.cost, basin.starts, basin.first);
  return text;
}

std::string violation_lines(const std::vector<ConstraintViolation>& violations, const char* words) {
  std::string text;
  for (const ConstraintViolation& v : violations)
    text += fmt::format("    {:<20} {} by {:.2e}{}\n", v.name, words, v.value,
                        v.node < 0 ? "" : fmt::format(" at node {}", v.node));
  return text;
}

/// The answer: its cost, its residuals, and how it was reached.
std::string answer_lines(const Solution& s) {
  const SolveResult& r = s.result;
  std::string text = fmt::format("  cost          {:.9g}\n", r.cost);
  for (const auto& [name, value] : s.answer.costs)
    text += fmt::format("    {:<20} {:.6g}\n", name, value);
  text += free_number_lines(s);
  text += fmt::format("  residuals     stationarity {:.2e}, gap {:.2e}, constraint {:.2e}\n",
                      r.residuals.stationarity, r.residuals.gap, r.residuals.constraint);
  text += violation_lines(s.answer.violations, "violated");
  text += violation_lines(s.answer.soft_violations, "soft, off");
  if (const double scale = cost_scale(*s.built.problem); scale != 1)
    text += fmt::format("  cost scale    solved with costs times {:.4g}\n", scale);
  text += homotopy_line(r.homotopy);
  text += mesh_line(s);
  text += attempts_line(r.attempts);
  if (r.restarts) text += restart_lines(*r.restarts);
  return text;
}

/// Diagnosis, advice and findings on the answer.
std::string finding_text(const Solution& s) {
  const Diagnosis& diagnosis = s.answer.diagnosis;
  std::string text;
  if (!is_success(s.result.status)) text += fmt::format("  diagnosis     {}\n", diagnosis.message);
  if (!diagnosis.remedy.empty()) text += fmt::format("  try           {}\n", diagnosis.remedy);
  const char* heading = "findings";
  for (const std::string& line : finding_lines(s.answer.findings)) {
    text += fmt::format("  {:<13} {}\n", heading, line);
    heading = "";
  }
  return text;
}

std::string certificate_lines(const SolutionCertificate& certificate,
                              const SolverOptions& options) {
  std::string text = fmt::format("  certificate   {}\n", certificate_line(certificate));
  if (const std::string loose = loose_tolerances_line(options); !loose.empty())
    text += fmt::format("                {}\n", loose);
  if (certificate.contacts)
    text += fmt::format("  contacts      {}\n", contact_summary(*certificate.contacts));
  return text;
}

/// The initial guess of the solve, and the dropped constraints.
std::string start_lines(const Solution& s) {
  const GuessUsed& used = s.built.guess_used;
  std::string text =
      fmt::format("  first guess   states: {}; controls: {}\n", used.states, used.controls);
  if (used.multipliers != "none")
    text += fmt::format("                multipliers: {}\n", used.multipliers);
  for (const auto& [name, value] : s.answer.dropped)
    text += fmt::format("  dropped       {}: violated by {:.3g}\n", name, value);
  return text;
}

/// Colors the status, which follows the head of a text.
std::string coloured(std::string text, const std::string& head, SolveStatus status) {
  const std::size_t at = terminal_text(head).size();
  text.insert(at + to_string(status).size(), "\033[0m");
  return text.insert(at, is_success(status) ? "\033[1;32m" : "\033[1;33m");
}

}  // namespace

std::string summary_text(const Solution& s, const SolutionCertificate* certificate,
                         const std::vector<std::string>& written, bool colour, int notes) {
  const SolveResult& r = s.result;
  const std::string head = s.built.facts().name.value + ": ";
  std::string text = fmt::format("{}{} ({}, {} iterations, {:.3f} s)\n", head, to_string(r.status),
                                 s.solver.name, r.iterations, r.times.total);
  if (!is_success(r.status) && !r.message.empty()) text += fmt::format("  {}\n", r.message);
  text += answer_lines(s) + finding_text(s);
  if (certificate != nullptr)
    text += certificate_lines(*certificate, s.built.facts().solver.options);
  text += auto_line(s) + start_lines(s);
  if (notes > 0)
    text += fmt::format(
        "  notes         {} on content of the robot's file that conddp ignores: -v\n", notes);
  for (const std::string& file : written) text += fmt::format("  written       {}\n", file);
  text = terminal_text(text);
  return colour ? coloured(std::move(text), head, r.status) : text;
}

}  // namespace conddp
