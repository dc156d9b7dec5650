#include "commands/bench_problems.hpp"

#include <algorithm>

#include <fmt/format.h>

#include "arguments/example_problems.hpp"
#include "arguments/input_files.hpp"
#include "base/text/spelling.hpp"
#include "output/bench/best_known.hpp"
#include "terminal/messages.hpp"

namespace conddp {
namespace {

/// The constraints of a problem that may be dropped.
std::vector<std::string> droppable(const BuiltProblem& built,
                                   const std::vector<std::string>& drop) {
  std::vector<std::string> names;
  for (const std::string& constraint : constraint_names(built))
    if (std::any_of(drop.begin(), drop.end(),
                    [&](const std::string& name) { return name == kAll || name == constraint; }))
      names.push_back(constraint);
  return names;
}

void check_drop(const std::deque<BenchProblem>& problems, const std::vector<std::string>& drop,
                Diagnostics& out) {
  std::vector<std::string> names;
  for (const BenchProblem& problem : problems)
    for (const std::string& constraint : constraint_names(problem.whole()))
      if (std::find(names.begin(), names.end(), constraint) == names.end())
        names.push_back(constraint);
  for (const std::string& name : drop)
    if (name != kAll && std::find(names.begin(), names.end(), name) == names.end())
      out.error({}, fmt::format("--drop {}: no problem has a constraint '{}'", name, name),
                name_hint(name, names, "constraints"), names);
}

/// True if an error names its problem file; errors in a robot's file do not.
bool names_file(const Diagnostics& diagnostics, const std::string& file) {
  const auto& list = diagnostics.list();
  return std::any_of(list.begin(), list.end(), [&](const Diagnostic& d) {
    return d.severity == Severity::kError &&
           (d.file == file || d.message.find(fmt::format("'{}'", file)) != std::string::npos);
  });
}

/// Looks up the best known costs of the problems in the files next to them, if any.
bool find_best_known(std::deque<BenchProblem>& problems, Diagnostics& out) {
  std::map<std::filesystem::path, BestKnown> of_folders;
  for (BenchProblem& problem : problems) {
    const std::filesystem::path folder = problem.whole().facts().file.parent_path();
    const auto [known, fresh] = of_folders.try_emplace(folder);
    std::error_code error;
    if (fresh && std::filesystem::exists(folder / kBestKnownFile, error)) {
      auto read = load_best_known(folder / kBestKnownFile, out);
      if (!read) return false;
      known->second = *std::move(read);
    }
    if (const auto found = known->second.find(problem.sha256); found != known->second.end())
      problem.best_known = found->second;
  }
  return true;
}

}  // namespace

const BuiltProblem& BenchProblem::fitting(const SolverInfo& solver,
                                          const std::vector<std::string>& drop) {
  const auto taken = [&](const std::vector<std::string>& without) {
    const auto [found, fresh] = built_.try_emplace(without);
    Diagnostics unused;  // the problem has been built before
    if (fresh)
      found->second = build_problem(whole(), {.drop = without, .unperturbed = true}, unused);
    return found->second && !unsupported(solver, *found->second->problem);
  };
  const std::vector<std::string> all = droppable(whole(), drop);
  std::vector<std::string> without;
  if (!taken(without) && taken(all)) {
    without = all;
    for (const std::string& name : all) {
      std::vector<std::string> fewer = without;
      fewer.erase(std::find(fewer.begin(), fewer.end(), name));
      if (taken(fewer)) without = fewer;
    }
  }
  return *built_.at(without);
}

namespace {

/// Adds a problem; prints the reason and returns false if it cannot be used.
bool add_problem(const std::filesystem::path& file, const std::vector<std::string>& settings,
                 std::deque<BenchProblem>& problems, Diagnostics& out) {
  Diagnostics own;
  if (auto built = build_problem(read_problem(file, settings, own), {.unperturbed = true}, own))
    problems.emplace_back(*std::move(built));
  print_messages(own, Verbosity::kQuiet);
  if (!own.has_errors()) return true;
  if (!names_file(own, file.string()))
    out.error({}, fmt::format("'{}' cannot be used", file.string()));
  return false;
}

}  // namespace

std::optional<std::deque<BenchProblem>> read_bench_problems(
    const std::vector<std::string>& inputs, const std::vector<std::string>& settings,
    const std::vector<std::string>& drop, Diagnostics& out) {
  std::deque<BenchProblem> problems;
  std::vector<std::string> paths;
  for (const std::string& input : inputs)
    if (const auto path = find_problem_file(input, out)) paths.push_back(path->string());
  bool complete = true;
  for (const auto& file : input_files(paths, ".yaml", out))
    complete &= add_problem(file, settings, problems, out);
  // The names to drop can only be checked if all problems were read.
  if (complete) check_drop(problems, drop, out);
  complete = complete && find_best_known(problems, out);
  if (!complete || out.has_errors()) return std::nullopt;
  return problems;
}

}  // namespace conddp
