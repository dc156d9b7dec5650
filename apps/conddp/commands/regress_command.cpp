#include <fmt/format.h>

#include "arguments/input_files.hpp"
#include "arguments/shared_arguments.hpp"
#include "base/files/atomic_file.hpp"
#include "commands/commands.hpp"
#include "output/bench/junit.hpp"
#include "output/solution/golden_case.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/interrupt.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

struct RegressArguments {
  std::vector<std::string> inputs;
  std::vector<std::string> settings;
  std::vector<std::string> tolerances;
  std::vector<std::string> added;
  std::string junit;
  double max_time = 0;
  bool bless = false;
};

/// All cases in sequence, and their results.
class Regression {
 public:
  explicit Regression(const RegressArguments& arguments) : arguments_(arguments) {
    options_ = {.settings = arguments.settings,
                .interrupted = [] { return InterruptGuard::signal() != 0; }};
    for (std::string& setting : solve_settings(arguments.max_time, 0))
      options_.settings.push_back(std::move(setting));
  }

  void run(const GoldenCase& golden) {
    Diagnostics diagnostics;
    const auto outcome = solve_golden(golden, options_, diagnostics);
    if (InterruptGuard::signal() != 0) return;
    print_messages(diagnostics, Verbosity::kQuiet);
    if (!outcome) {
      print_result(fmt::format("{}: cannot be solved\n", golden.name));
      return fail(golden.name, diagnostics);
    }
    const int iterations = outcome->answer.at("iterations");
    if (golden.answer.is_null()) {
      print_result(fmt::format("{}: new, {}, {} iterations\n", golden.name,
                               outcome->answer.at("status").get<std::string>(), iterations));
      return bless(golden, *outcome);
    }
    const auto differences =
        compare_solutions(golden.answer, outcome->answer,
                          comparison_tolerances(arguments_.tolerances, golden.tolerances));
    const int known = golden.answer.at("iterations");
    print_result(fmt::format("{}: {} ({} iterations{}, {:.3f} s)\n", golden.name,
                             differences.empty() ? "agrees" : "DIFFERS", iterations,
                             iterations == known ? "" : fmt::format(" instead of {}", known),
                             outcome->time_s));
    for (const Difference& difference : differences) print_result(difference_text(difference));
    JunitCase test{.name = golden.name, .time_s = outcome->time_s};
    if (!arguments_.bless)
      test.failures = failures_of(differences);
    else if (!differences.empty() || iterations != known)
      bless(golden, *outcome);
    cases_.push_back(std::move(test));
  }

  /// Records a case that cannot be solved.
  void fail(const std::string& name, const Diagnostics& diagnostics) {
    cases_.push_back({.name = name, .error = "it cannot be solved"});
    for (const Diagnostic& d : diagnostics.list())
      if (d.severity == Severity::kError) {
        cases_.back().error = d.message;
        break;
      }
  }

  int finish() {
    int bad = 0, errors = 0;
    for (const JunitCase& test : cases_) {
      errors += !test.error.empty();
      bad += !test.failures.empty();
    }
    print_result(fmt::format("{} agree, {} differ", cases_.size() - bad - errors, bad));
    if (errors > 0) print_result(fmt::format(", {} cannot be solved", errors));
    if (blessed_ > 0) print_result(fmt::format(", {} written", blessed_));
    print_result("\n");
    if (!arguments_.junit.empty())
      files_.add(arguments_.junit, junit_xml("conddp regress", cases_));
    files_.commit();
    return errors > 0 ? kExitBadInput : bad > 0 ? kExitNotConverged : kExitConverged;
  }

 private:
  static std::vector<std::string> failures_of(const std::vector<Difference>& differences) {
    std::vector<std::string> failures;
    for (const Difference& difference : differences)
      failures.push_back(difference.quantity + ": " + difference.message);
    return failures;
  }

  void bless(const GoldenCase& golden, const GoldenOutcome& outcome) {
    files_.add(golden.file, golden_text(golden, outcome.answer));
    ++blessed_;
  }

  const RegressArguments& arguments_;
  GoldenOptions options_;
  std::vector<JunitCase> cases_;
  AtomicFiles files_;
  int blessed_ = 0;
};

/// Cases to be added; an existing golden file is an error.
std::vector<GoldenCase> new_cases(const RegressArguments& arguments, Diagnostics& out) {
  namespace fs = std::filesystem;
  std::vector<GoldenCase> cases;
  if (arguments.added.empty()) return cases;
  if (arguments.inputs.size() != 1) {
    out.error({}, "with --add there is one argument, the folder of the golden files");
    return cases;
  }
  std::error_code error;
  if (!fs::is_directory(arguments.inputs.front(), error)) {
    out.error({}, fmt::format("'{}' is not a folder", arguments.inputs.front()),
              "golden files are added to an existing folder");
    return cases;
  }
  for (const std::string& problem : arguments.added) {
    cases.push_back(new_golden(problem, arguments.inputs.front()));
    if (fs::exists(cases.back().file, error))
      out.error({}, fmt::format("'{}' exists", cases.back().file.string()),
                "--bless rewrites what differs");
  }
  return cases;
}

int regress(const RegressArguments& arguments) {
  Diagnostics diagnostics;
  std::vector<GoldenCase> cases = new_cases(arguments, diagnostics);
  const bool adding = !arguments.added.empty();
  const auto files = adding ? std::vector<std::filesystem::path>()
                            : input_files(arguments.inputs, ".json", diagnostics);
  print_messages(diagnostics, Verbosity::kNormal);
  if (diagnostics.has_errors()) return kExitBadInput;
  const InterruptGuard guard;
  Regression regression(arguments);
  for (const auto& file : files) {
    Diagnostics of_file;
    auto golden = load_golden(file, of_file);
    print_messages(of_file, Verbosity::kNormal);
    if (golden)
      cases.push_back(*std::move(golden));
    else
      regression.fail(file.stem().string(), of_file);
  }
  if (cases.empty()) return kExitBadInput;
  for (const GoldenCase& golden : cases) {
    regression.run(golden);
    finish_results();  // prints each problem immediately, also to a pipe; the last call reports
                       // errors
    if (InterruptGuard::signal() != 0) return kExitSignalBase + InterruptGuard::signal();
  }
  return regression.finish();
}

}  // namespace

Command regress_command() {
  const auto a = std::make_shared<RegressArguments>();
  return {.name = "conddp regress",
          .description = "Solve the problems of golden files and compare by meaning",
          .details =
              "A golden file is a solution.json cut down to what is compared, and names its "
              "problem. Exit status: 0 all agree, 1 some differ, 2 some cannot be solved.",
          .arguments =
              {{.names = {"GOLDEN"},
                .value = "GOLDEN.json",
                .description = "Golden files, or folders of them",
                .required = true,
                .target = &a->inputs},
               setting_argument(a->settings,
                                "Replace a value in every problem, as in --set solver.threads=2"),
               comparison_tolerance_argument(a->tolerances),
               {.names = {"--junit"},
                .value = "FILE.xml",
                .description = "Write a report in JUnit's XML for a CI server",
                .target = &a->junit},
               max_time_argument(a->max_time, "Stop each solve after this many seconds"),
               flag({"--bless"}, a->bless,
                    "Show what differs, and write the new answers into the golden files", "--set"),
               {.names = {"--add"},
                .value = "FILE.yaml",
                .description =
                    "Make a golden file of this problem, in the folder given, instead of comparing",
                .excludes = "--set",
                .target = &a->added}},
          .run = [a] { return regress(*a); }};
}

}  // namespace conddp
