#include <cmath>
#include <filesystem>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include "arguments/shared_arguments.hpp"
#include "base/json/json_document.hpp"
#include "base/json/ordered_json.hpp"
#include "commands/commands.hpp"
#include "output/report/answer_settings.hpp"
#include "output/report/certificate_report.hpp"
#include "output/report/contact_report.hpp"
#include "output/report/loop_certificate.hpp"
#include "output/report/solution_certificate.hpp"
#include "output/solution/finding_report.hpp"
#include "output/solution/solved_problem.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct VerifyArguments {
  std::string solution;
  std::string problem;
  bool json = false;
  bool quiet = false;
};

void print_lines(const char* word, const std::vector<std::string>& lines) {
  for (const std::string& line : lines) print_result(fmt::format("  {}{}\n", word, line));
}

/// Prints the verdict, the settings that differ from the file, and the checks.
void print_verdict(const BuiltProblem& built, const std::string& verdict,
                   const AnswerSettings& settings, const Certificate& checks) {
  print_result(fmt::format("{}: {}{}\n", built.facts().name.value, verdict,
                           settings.changed() ? ", with settings" : ""));
  print_lines("", settings_lines(settings));
  print_result(certificate_table(checks));
}

int print(const VerifyArguments& arguments, const BuiltProblem& built,
          const AnswerSettings& settings, const SolutionCertificate& certificate) {
  if (arguments.json) {
    print_result(json_text(OrderedJson{{"format", "conddp.verify/1"},
                                       {"solution", arguments.solution},
                                       {"problem", built.facts().file.string()},
                                       {"name", built.facts().name.value},
                                       {"settings", settings_json(settings)},
                                       {"findings", findings_json(certificate.findings)},
                                       {"certificate", certificate_json(certificate)}}));
  } else if (!arguments.quiet) {
    print_verdict(built, certificate_line(certificate), settings, certificate.checks);
    if (!std::isnan(certificate.checks.optimality.stationarity))
      print_result(fmt::format("  {}\n", optimality_line(certificate)));
    if (certificate.contacts)
      print_lines("", contact_lines(*certificate.contacts, certificate.tangent_names));
    print_lines("finding ", finding_lines(certificate.findings));
    if (certificate.replay) print_result(fmt::format("  replay {}\n", replay_line(certificate)));
    print_lines("warning ", certificate_warnings(certificate));
  }
  return is_denied(certificate.checks.verdict()) ? kExitNotConverged : kExitConverged;
}

int verify_solution(const VerifyArguments& arguments, const OrderedJson& document,
                    Diagnostics& out) {
  const auto built = rebuild_problem(document, arguments.solution, arguments.problem, out);
  if (!built) return kExitBadInput;
  return print(arguments, *built, answer_settings(document, *built),
               certify_solution(document, *built, true));
}

int print(const VerifyArguments& arguments, const LoopTask& task, const AnswerSettings& settings,
          const LoopCertificate& certificate) {
  if (arguments.json) {
    print_result(json_text(OrderedJson{{"format", "conddp.verify/1"},
                                       {"solution", arguments.solution},
                                       {"problem", task.built.facts().file.string()},
                                       {"name", task.built.facts().name.value},
                                       {"settings", settings_json(settings)},
                                       {"certificate", certificate_json(certificate)}}));
  } else if (!arguments.quiet) {
    print_verdict(task.built, certificate_line(certificate), settings, certificate.checks);
    for (const std::string& file : certificate.missing)
      print_result(fmt::format("  not checked: there is no {}\n", file));
  }
  return certificate.checks.holds() ? kExitConverged : kExitNotConverged;
}

int verify_loop(const VerifyArguments& arguments, const OrderedJson& document, Diagnostics& out) {
  const auto task = rebuild_loop(document, arguments.solution, arguments.problem, out);
  if (!task) return kExitBadInput;
  const auto folder = std::filesystem::path(arguments.solution).parent_path();
  return print(arguments, *task, answer_settings(document, task->built),
               certify_loop(document, folder, *task));
}

/// Keys that are kept from a solution.
constexpr std::string_view kKeys[] = {"problem",
                                      "solver",
                                      "status",
                                      "cost",
                                      "cost_by_name",
                                      "free_numbers",
                                      "cost_scale",
                                      "iterations",
                                      "mesh",
                                      "residuals",
                                      "findings",
                                      "initial_guess_used",
                                      "constraints",
                                      "soft_constraints",
                                      "dropped_constraints",
                                      "trajectory",
                                      "gains",
                                      "multipliers",
                                      "log",
                                      "certificate",
                                      "nulls"};

/// Verifies a document, loaded as a solution; a closed loop is loaded completely.
int verify_document(const VerifyArguments& arguments, const nlohmann::json& loaded,
                    Diagnostics& out) {
  if (!is_of(kLoopDocument, loaded)) return verify_solution(arguments, OrderedJson(loaded), out);
  const auto whole = load_document(arguments.solution, kLoopDocument, kEverything, {}, out);
  return whole ? verify_loop(arguments, OrderedJson(*whole), out) : kExitBadInput;
}

int verify(const VerifyArguments& arguments) {
  constexpr DocumentKind kKinds[] = {kSolutionDocument, kLoopDocument};
  Diagnostics diagnostics;
  int code = kExitBadInput;
  try {
    if (const auto loaded = load_document(arguments.solution, kKinds, kKeys, {}, diagnostics))
      code = verify_document(arguments, *loaded, diagnostics);
  } catch (const MalformedSolution& malformed) {
    diagnostics.add({.file = arguments.solution,
                     .message = "the file cannot be used: " + std::string(malformed.what())});
  } catch (const OrderedJson::exception& error) {
    diagnostics.add({.file = arguments.solution,
                     .message = fmt::format("the file cannot be used: {}", error.what())});
  }
  print_messages(diagnostics,
                 arguments.quiet && code != kExitBadInput ? Verbosity::kQuiet : Verbosity::kNormal);
  return code;
}

}  // namespace

Command verify_command() {
  const auto a = std::make_shared<VerifyArguments>();
  return {.name = "conddp verify",
          .description =
              "Check a solution with code independent of the solvers, or replay a closed loop",
          .details =
              "Simulates every knot again and compares costs, gaps, bounds, multipliers and the "
              "gradient of the Lagrangian with the values in the solution. For an mpc.json, moves "
              "the plant along closed_loop.csv beside it, and simulates the loop again. Exit "
              "status 0 if all of it holds, 1 if not.",
          .arguments = {{.names = {"FILE"},
                         .value = "FILE.json",
                         .description = "Solution, or mpc.json of a closed loop",
                         .required = true,
                         .target = &a->solution},
                        problem_of_solution(
                            a->problem, "Problem file (default: the one named in the solution)"),
                        flag({"--quiet"}, a->quiet, "Print nothing but errors"),
                        flag({"--json"}, a->json, "Print JSON on stdout", "--quiet")},
          .run = [a] { return verify(*a); }};
}

}  // namespace conddp
