#include "output/solved_problem.hpp"

#include <vector>

#include <fmt/format.h>

#include "analysis/solution_members.hpp"
#include "problem_file/read_problem.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

/// What a solution says about the files it was made from.
struct Sources {
  std::string problem;
  std::string sha256;
  std::vector<std::string> overrides;
  std::vector<std::string> drop;
  std::vector<InputFile> robots, data_files;
};

std::vector<InputFile> files(const OrderedJson& array) {
  std::vector<InputFile> all;
  for (const OrderedJson& file : array)
    all.push_back({solution_text(file, "file"), solution_text(file, "sha256")});
  return all;
}

Sources sources(const OrderedJson& document) {
  const OrderedJson& problem = solution_member(document, "problem");
  Sources s{.problem = solution_text(problem, "file"), .sha256 = solution_text(problem, "sha256")};
  for (const OrderedJson& setting : solution_list(problem, "overrides")) {
    if (!setting.is_string()) throw MalformedSolution{"'overrides' has an entry that is no text"};
    // Where the solve began has no part in the answer, and that file may be gone.
    if (std::string value = setting; !value.starts_with("initial_guess"))
      s.overrides.push_back(std::move(value));
  }
  for (const OrderedJson& dropped : solution_list(document, "dropped_constraints"))
    s.drop.push_back(solution_text(dropped, "name"));
  s.robots = files(solution_list(problem, "robots"));
  s.data_files = files(solution_list(problem, "data_files"));
  return s;
}

/// The file as the solution names it, seen from here or from a folder above the solution.
fs::path find_problem(const std::string& name, const std::string& solution) {
  std::error_code error;
  if (fs::exists(name, error)) return name;
  const fs::path file = fs::absolute(solution, error);
  for (fs::path folder = file; folder.has_relative_path();) {
    folder = folder.parent_path();
    if (fs::exists(folder / name, error)) return folder / name;
  }
  return name;
}

void warn_if_changed(const std::string& what, const std::string& then, const std::string& now,
                     Diagnostics& out) {
  if (then == now) return;
  out.add({.file = what,
           .severity = Severity::kWarning,
           .message = "this file has changed since the solution was made (its SHA-256 differs)"});
}

void compare_files(const Sources& s, const ProblemSpec& spec, const BuiltProblem& built,
                   Diagnostics& out) {
  warn_if_changed(spec.file.string(), s.sha256, spec.sha256, out);
  const auto& parts = built.plant.parts;
  for (std::size_t i = 0; i < parts.size(); ++i)
    warn_if_changed(parts[i].spec->path.string(), i < s.robots.size() ? s.robots[i].sha256 : "",
                    parts[i].sha256, out);
  for (const InputFile& now : built.data_files)
    for (const InputFile& then : s.data_files)
      if (fs::path(then.file).filename() == fs::path(now.file).filename())
        warn_if_changed(now.file, then.sha256, now.sha256, out);
}

}  // namespace

std::optional<SolvedProblem> rebuild_problem(const OrderedJson& document,
                                             const std::string& solution_file,
                                             const fs::path& problem, Diagnostics& out) {
  const Sources s = sources(document);
  const fs::path file = problem.empty() ? find_problem(s.problem, solution_file) : problem;
  std::error_code error;
  if (problem.empty() && !fs::exists(file, error)) {
    out.add({.file = solution_file,
             .message = fmt::format("its problem '{}' is not there", s.problem),
             .hint = "say with --problem where it is now"});
    return std::nullopt;
  }
  auto spec = read_problem(file, s.overrides, out);
  if (!spec) return std::nullopt;
  spec->guess = {};
  auto owned = std::make_unique<const ProblemSpec>(std::move(*spec));
  auto built = build_problem(*owned, {.drop = s.drop}, out);
  if (!built) return std::nullopt;
  compare_files(s, *owned, *built, out);
  return SolvedProblem{std::move(owned), std::move(*built)};
}

}  // namespace conddp
