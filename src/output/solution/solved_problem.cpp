#include "output/solution/solved_problem.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "base/files/source_text.hpp"
#include "base/files/text_file.hpp"
#include "base/json/solution_members.hpp"
#include "problem_file/build/build_problem.hpp"
#include "problem_file/read/read_problem.hpp"
#include "problem_file/yaml/setting.hpp"

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
    if (!setting.is_string()) throw MalformedSolution{"'overrides' has an entry that is not text"};
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

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Whether a file says of itself that it is a problem or a robot: in a line "conddp: 1" or a tag.
bool says_what_it_is(const fs::path& file) {
  const std::string text = read_text_file(file, kMaxDataBytes).text;
  if (text.find("<robot") != text.npos) return true;
  constexpr std::string_view kKey = "conddp: ";
  for (std::size_t at = text.find(kKey); at != text.npos; at = text.find(kKey, at + 1)) {
    const std::size_t value = text.find_first_not_of(' ', at + kKey.size());
    if ((at == 0 || text[at - 1] == '\n') && value != text.npos && is_digit(text[value]))
      return true;
  }
  return false;
}

/// Messages quote what they are about, and a solution may name any file: as its problem, in a
/// setting, in the problem beside it. So they are shown only where they can be about problems,
/// robots, and data whose hash the solution knows.
bool may_be_quoted(const Diagnostics& about, const fs::path& problem, const Sources& s) {
  const auto is_of_a_problem = [&](const Diagnostic& d) {
    return d.file.empty() || d.file == kSettingSource || d.file == problem.string() ||
           says_what_it_is(d.file);
  };
  const auto is_known = [&](const InputFile& read) {
    return std::any_of(s.data_files.begin(), s.data_files.end(),
                       [&](const InputFile& known) { return known.sha256 == read.sha256; });
  };
  return says_what_it_is(problem) &&
         std::all_of(about.list().begin(), about.list().end(), is_of_a_problem) &&
         std::all_of(about.data_files().begin(), about.data_files().end(), is_known);
}

std::optional<SolvedProblem> build_from(const fs::path& file, const Sources& s, Diagnostics& out) {
  auto spec = read_problem(file, s.overrides, out);
  if (!spec) return std::nullopt;
  spec->guess = {};
  auto owned = std::make_unique<const ProblemSpec>(std::move(*spec));
  auto built = build_problem(*owned, {.drop = s.drop}, out);
  if (!built) return std::nullopt;
  compare_files(s, *owned, *built, out);
  return SolvedProblem{std::move(owned), std::move(*built)};
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
  Diagnostics attempt = out;
  auto solved = build_from(file, s, attempt);
  const bool named_by_caller = !problem.empty() && s.overrides.empty();
  if (!solved && !named_by_caller && !may_be_quoted(attempt, file, s)) {
    out.add({.file = solution_file,
             .message = fmt::format("its problem '{}' cannot be built", file.string()),
             .hint = fmt::format("'conddp check {}'{} says why; --problem takes another file",
                                 file.string(),
                                 s.overrides.empty() ? "" : " with the solution's settings")});
    return std::nullopt;
  }
  out = std::move(attempt);
  return solved;
}

}  // namespace conddp
