#include "output/solution/solved_problem.hpp"

#include <algorithm>
#include <string_view>
#include <vector>

#include <fmt/format.h>

#include "base/files/text_file.hpp"
#include "base/json/json_document.hpp"
#include "problem_file/yaml/setting.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

/// Input files of a solution, as recorded in its document.
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

/// Loops record only the names of dropped constraints; solutions also record their violations.
std::string dropped_name(const OrderedJson& dropped) {
  return dropped.is_string() ? dropped.get<std::string>() : solution_text(dropped, "name");
}

Sources sources(const OrderedJson& document, RebuiltFor kind) {
  const OrderedJson& problem = solution_member(document, "problem");
  Sources s{.problem = solution_text(problem, "file"), .sha256 = solution_text(problem, "sha256")};
  s.overrides = overrides_of(document);
  // The initial guess does not affect the answer, and its file may be missing.
  if (kind == RebuiltFor::kSolution)
    std::erase_if(s.overrides, [](const auto& text) { return text.starts_with("initial_guess"); });
  for (const OrderedJson& dropped : solution_list(document, "dropped_constraints"))
    s.drop.push_back(dropped_name(dropped));
  s.robots = files(solution_list(problem, "robots"));
  s.data_files = files(solution_list(problem, "data_files"));
  return s;
}

/// The file named in the solution, relative to the working directory or to a folder above the
/// solution.
fs::path find_problem(const std::string& name, const std::string& solution) {
  std::error_code error;
  if (fs::is_regular_file(name, error)) return name;
  const fs::path file = fs::absolute(solution, error);
  for (fs::path folder = file; folder.has_relative_path();) {
    folder = folder.parent_path();
    if (fs::is_regular_file(folder / name, error)) return folder / name;
  }
  return name;
}

void warn_if_changed(const std::string& what, const std::string& then, const std::string& now,
                     Diagnostics& out) {
  if (then == now) return;
  out.add({.file = what,
           .severity = Severity::kWarning,
           .message = "this file has changed since the answer was made (its SHA-256 differs)"});
}

void compare_files(const Sources& s, const InputFiles& files, Diagnostics& out) {
  for (std::size_t i = 0; i < files.robots.size(); ++i)
    warn_if_changed(files.robots[i].file, i < s.robots.size() ? s.robots[i].sha256 : "",
                    files.robots[i].sha256, out);
  for (const InputFile& now : files.data)
    for (const InputFile& then : s.data_files)
      if (fs::path(then.file).filename() == fs::path(now.file).filename())
        warn_if_changed(now.file, then.sha256, now.sha256, out);
}

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// True if a file identifies itself as a problem or a robot, by a line "conddp: 1" or a tag.
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

/// True if messages may be shown. Messages quote files, and a solution may name any file: as its
/// problem, in a setting, or through the problem. They are therefore shown only if they concern
/// problems, robots, and data whose hash the solution contains.
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

bool build_from(const fs::path& file, const Sources& s, const BuildAgain& build, Diagnostics& out) {
  const auto document = load_problem(file, {}, out);
  if (!document) return false;
  const auto files = build(*document, parse_settings(s.overrides, out), {.drop = s.drop}, out);
  if (!files) return false;
  warn_if_changed(file.string(), s.sha256, document->sha256, out);
  compare_files(s, *files, out);
  return true;
}

}  // namespace

std::vector<std::string> overrides_of(const OrderedJson& document) {
  std::vector<std::string> list;
  for (const OrderedJson& setting :
       solution_list(solution_member(document, "problem"), "overrides")) {
    if (!setting.is_string()) throw MalformedSolution{"'overrides' has an entry that is not text"};
    list.push_back(setting.get<std::string>());
  }
  return list;
}

bool build_again(RebuiltFor kind, const OrderedJson& document, const std::string& document_file,
                 const fs::path& problem, const BuildAgain& build, Diagnostics& out) {
  const Sources s = sources(document, kind);
  const fs::path file = problem.empty() ? find_problem(s.problem, document_file) : problem;
  std::error_code error;
  if (problem.empty() && !fs::is_regular_file(file, error)) {
    out.add({.file = document_file,
             .message = fmt::format("its problem '{}' does not exist", s.problem),
             .hint = "give its new path with --problem"});
    return false;
  }
  Diagnostics attempt = out;
  const bool built = build_from(file, s, build, attempt);
  const bool named_by_caller = !problem.empty() && s.overrides.empty();
  // Errors in the plant of a loop may quote its robots.
  const bool quotable = kind == RebuiltFor::kSolution && may_be_quoted(attempt, file, s);
  if (!built && !named_by_caller && !quotable) {
    out.add({.file = document_file,
             .message = fmt::format("its problem '{}' cannot be built", file.string()),
             .hint = fmt::format("'conddp {} {}'{} shows why; --problem names another file",
                                 kind == RebuiltFor::kLoop ? "mpc" : "check", file.string(),
                                 s.overrides.empty() ? "" : " with its settings")});
    return false;
  }
  out = std::move(attempt);
  return built;
}

std::optional<BuiltProblem> rebuild_problem(const OrderedJson& document,
                                            const std::string& solution_file,
                                            const fs::path& problem, Diagnostics& out) {
  std::optional<BuiltProblem> built;
  const auto build = [&](const ProblemDocument& read, const std::vector<Setting>& settings,
                         BuildOptions options, Diagnostics& own) -> std::optional<InputFiles> {
    options.default_guess = true;
    built = build_problem(read_problem(read, settings, own), options, own);
    return built ? std::optional(input_files(*built)) : std::nullopt;
  };
  if (!build_again(RebuiltFor::kSolution, document, solution_file, problem, build, out))
    return std::nullopt;
  return built;
}

}  // namespace conddp
