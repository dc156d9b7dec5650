#include "batch/plan/batch_plan.hpp"

#include <algorithm>
#include <span>

#include <fnmatch.h>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/files/text_file.hpp"
#include "base/text/spelling.hpp"
#include "problem_file/yaml/yaml_source.hpp"
#include "solvers/strategies/registry.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

/// Upper limit on counting items.
constexpr long long kUncounted = 1'000'000'000'000'000;
constexpr Choice<KeptSolutions> kKeptWords[] = {{"all", KeptSolutions::kAll},
                                                {"converged", KeptSolutions::kConverged},
                                                {"none", KeptSolutions::kNone}};
constexpr const char *kOwnStart = "none", *kNeighbourStart = "neighbour";
constexpr Choice<BatchCommand> kCommandWords[] = {{"solve", BatchCommand::kSolve},
                                                  {"mpc", BatchCommand::kMpc}};
constexpr std::string_view kColumnsOfItems[] = {"item", "id", "problem", "solver", "status"};
constexpr std::string_view kColumnsOfSolves[] = {"solved",          "cost",        "iterations",
                                                 "stationarity",    "gap",         "constraint",
                                                 "complementarity", "certificate", "message"};
constexpr NumberRange kTimeLimit{1e-3, 1e9, false, false, "a number from 0.001 to 1e9"};

/// The files that match a pattern with `*` in its last part, in byte order.
std::vector<fs::path> matching_files(const fs::path& pattern) {
  std::vector<fs::path> found;
  const fs::path folder = pattern.has_parent_path() ? pattern.parent_path() : fs::path(".");
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
       entry.increment(error))
    if (const std::string name = entry->path().filename().string();
        fnmatch(pattern.filename().c_str(), name.c_str(), FNM_PERIOD) == 0)
      found.push_back(pattern.parent_path() / name);
  std::sort(found.begin(), found.end());
  return found;
}

class PlanReader {
 public:
  PlanReader(const YamlReader& reader, BatchPlan& plan)
      : map_(reader), out_(reader.diagnostics()), plan_(plan) {}

  void read() {
    if (!map_.valid()) return;
    read_format();
    read_name();
    map_.choice("command", plan_.command, kCommandWords, "command");
    read_problems();
    if (const auto r = map_.find("vary")) read_axes(*r);
    if (const auto r = map_.find("solvers")) read_solvers(*r);
    if (const auto r = map_.find("limits")) read_limits(*r);
    if (const auto r = map_.find("keep")) read_keep(*r);
    if (const auto r = map_.find("warm_start")) read_warm_start(*r);
    map_.finish();
    if (!out_.has_errors()) check_columns();
    if (!out_.has_errors()) check_size();
  }

 private:
  void read_format() {
    const auto format = map_.require("conddp_batch");
    if (!format) return;
    const auto version = format->integer(1, 1'000'000);
    if (version && *version != kBatchFormat)
      format->error(fmt::format("the plan has format {}, and this version reads format {}",
                                *version, kBatchFormat));
  }

  void read_name() {
    plan_.name = {plan_.file.stem().string(), map_.reader().place()};
    const auto r = map_.find("name");
    if (!r && !names_folder(plan_.name.value))
      map_.reader().error(fmt::format("the plan has the name of its file, '{}', and {}",
                                      plan_.name.value, kFolderNameRule),
                          "write 'name: ...'");
    if (!r) return;
    plan_.name = r->name().value_or(plan_.name);
    if (!names_folder(plan_.name.value)) r->error(kFolderNameRule);
  }

  void read_problems() {
    const auto one = map_.find("problem"), several = map_.find("problems");
    if (!map_.exclusive({"problem", "problems"})) return;
    if (one) {
      if (const auto name = one->name()) add_problems(*name);
    } else if (several) {
      for (const Name& name : several->names().value_or(std::vector<Name>{})) add_problems(name);
      if (several->is_sequence() && several->node().items.empty())
        several->error("the list of problems is empty", "write '[a.yaml, trots/*.yaml]'");
    } else {
      map_.reader().error("the plan names no problem",
                          "write 'problem: FILE.yaml' or 'problems: [a.yaml, trots/*.yaml]'");
    }
  }

  /// Adds a file, or the files that match a pattern. An existing file with that name takes
  /// precedence.
  void add_problems(const Name& name) {
    const fs::path path = plan_.file.parent_path() / name.value;
    const bool names = is_pattern(path.filename());
    const bool folders = is_pattern(fs::path(name.value).parent_path());
    std::error_code error;
    if (fs::is_regular_file(path, error) || (!names && !folders))
      return add_problem(path, name.place);
    const std::vector<fs::path> found = names ? matching_files(path) : std::vector<fs::path>();
    if (found.empty())
      out_.error(name.place, fmt::format("no file matches '{}'", path.string()),
                 folders ? "'*', '?' and '[...]' match files only in the last part of a path" : "");
    for (const fs::path& file : found) add_problem(file, name.place);
  }

  static bool is_pattern(const fs::path& path) {
    return path.string().find_first_of("*?[") != std::string::npos;
  }

  void add_problem(const fs::path& file, const Place& place) {
    for (const auto& other : plan_.problems)
      if (other.value.lexically_normal() == file.lexically_normal())
        return out_.error(place, fmt::format("the plan has the problem '{}' twice", file.string()));
    plan_.problems.push_back({file, place});
  }

  void read_axes(const YamlReader& reader) {
    const auto entries = reader.named_entries("write '{x: {key: costs.effort.weight, ...}}'");
    if (!entries) return;
    for (const auto& [name, axis] : *entries)
      plan_.axes.push_back(read_axis(name, axis, plan_.file.parent_path()));
  }

  void read_keep(const YamlReader& reader) {
    YamlMap keep(reader, "write '{solutions: converged}'");
    if (const auto solutions = keep.find("solutions"))
      plan_.keep = solutions->choice(kKeptWords, "answer").value_or(plan_.keep);
    if (plan_.command == BatchCommand::kMpc && plan_.keep != KeptSolutions::kNone)
      reader.error("closed loops have no solutions that could be kept",
                   "leave it out: 'conddp batch show' simulates a loop again");
  }

  void check_size() {
    if (plan_.items() <= kMostItems) return;
    const std::string items =
        plan_.items() == kUncounted ? "more than 10^15" : std::to_string(plan_.items());
    out_.error(plan_.axes.empty() ? plan_.problems.front().place : plan_.axes.front().name.place,
               fmt::format("the plan has {} items, and a batch has at most {}", items, kMostItems),
               "every axis of 'vary' multiplies their number: vary fewer keys, or draw samples "
               "with 'sobol'");
  }

  void read_solvers(const YamlReader& reader) {
    std::vector<std::string> known{std::string(kAutoSolver)};
    for (const SolverInfo& solver : solvers()) known.emplace_back(solver.name);
    const auto names = reader.names();
    if (!names) return;
    if (names->empty())
      reader.error("the list of solvers is empty", name_hint("", known, "solvers"));
    for (const Name& name : *names) {
      if (std::find(known.begin(), known.end(), name.value) == known.end())
        out_.error(name.place, fmt::format("unknown solver '{}'", name.value),
                   name_hint(name.value, known, "solvers"), known);
      plan_.solvers.push_back(name);
    }
  }

  void read_limits(const YamlReader& reader) {
    YamlMap limits(reader, "write '{max_time_s: 20}'");
    if (const auto r = limits.find("max_time_s"))
      if (const auto seconds = r->number(kTimeLimit)) {
        plan_.limits.max_time_s = *seconds;
        plan_.max_time = {*seconds, r->place()};
      }
    limits.integer("max_memory_mb", plan_.limits.max_memory_mb, 100, 100'000'000);
    limits.integer("retries", plan_.limits.retries, 0, 10);
  }

  void read_warm_start(const YamlReader& reader) {
    const auto word = reader.text();
    if (!word || *word == kOwnStart) return;
    if (plan_.command == BatchCommand::kMpc)
      return reader.error("closed loops start from the guesses of their problems",
                          "leave out 'warm_start'");
    if (*word == kNeighbourStart) {
      plan_.warm_start = WarmStart::kNeighbour;
      return;
    }
    const fs::path file = plan_.file.parent_path() / *word;
    std::error_code error;
    if (fs::is_regular_file(file, error)) {
      plan_.warm_start = WarmStart::kFile;
      plan_.start_file = {file, reader.place()};
    } else {
      reader.error(fmt::format("'{}' is neither a warm start nor an existing file", *word),
                   fmt::format("write '{}', '{}', or a solution.json from which all items start",
                               kOwnStart, kNeighbourStart));
    }
  }

  /// Checks that the names of columns differ. Duplicate keys are only known with the problems.
  void check_columns() {
    std::vector<const AxisColumn*> columns;
    for (const Axis& axis : plan_.axes)
      for (const AxisColumn& column : axis.columns) {
        for (const AxisColumn* other : columns)
          if (column.name == other->name && column.key.value != other->key.value)
            out_.error(column.key.place,
                       fmt::format("two columns of the results have the name '{}'", column.name));
        if (is_column_of_results(column.name, plan_.command, plan_.warm_start))
          out_.error(column.name == axis.name.value ? axis.name.place : column.key.place,
                     fmt::format("'{}' is a column of results.csv already", column.name),
                     "choose another name");
        columns.push_back(&column);
      }
  }

  YamlMap map_;
  Diagnostics& out_;
  BatchPlan& plan_;
};

}  // namespace

bool is_column_of_results(std::string_view name, BatchCommand command, WarmStart warm_start) {
  const auto is_one_of = [name](std::span<const std::string_view> columns) {
    return std::find(columns.begin(), columns.end(), name) != columns.end();
  };
  if (is_one_of(kColumnsOfItems)) return true;
  if (command == BatchCommand::kMpc) return name == "survived" || is_one_of(kLoopColumns);
  return is_one_of(kColumnsOfSolves) || name.starts_with("violation/") ||
         (warm_start != WarmStart::kNone && name == "warm_start");
}

long long BatchPlan::items() const {
  long long count =
      static_cast<long long>(problems.size() * std::max<std::size_t>(1, solvers.size()));
  for (const Axis& axis : axes) {
    count *= static_cast<long long>(axis.rows.size());
    if (count >= kUncounted) return kUncounted;
  }
  return count;
}

std::optional<BatchPlan> load_batch_plan(const fs::path& file, Diagnostics& out) {
  BatchPlan plan{.file = file};
  std::string hash;
  const auto text = read_text(file, kMaxYamlBytes, {}, hash, out);
  if (!text) return std::nullopt;
  plan.text = *text;
  const auto root = parse_yaml(*text, out.add_source(file.string(), *text), out);
  if (!root) return std::nullopt;
  if (root->find("conddp") != nullptr && root->find("conddp_batch") == nullptr) {
    out.error({root->mark, {}}, "this is a problem file, not a plan of a batch",
              "'conddp solve' takes it; a plan has 'conddp_batch: 1' and names it under 'problem'");
    return std::nullopt;
  }
  PlanReader(YamlReader(*root, {}, out), plan).read();
  if (out.has_errors()) return std::nullopt;
  return plan;
}

}  // namespace conddp
