#include "arguments/batch_arguments.hpp"

#include <fmt/format.h>

#include "base/text/strict_number.hpp"
#include "batch/cluster/slurm_job.hpp"

namespace conddp {
namespace {

std::string shard_defect(const std::string& text) {
  if (parse_shard(text)) return {};
  return fmt::format("'{}' is not a share such as 2/7, auto/7 or auto", text);
}

constexpr const char* kAutoShard = "auto";
constexpr double kLongestTime = 1e9;  // s

/// Bare numbers are rejected: they would be seconds here and minutes in Slurm.
ArgumentCheck time_check(std::optional<double> (*parse)(std::string_view), std::string examples) {
  return [=](const std::string& text) -> std::string {
    if (parse(text)) return {};
    const auto number = parse_number(text).value;
    if (number && *number > 0 && *number <= kLongestTime)
      return fmt::format("'{0}' has no unit: write {0}m or {0}s for minutes or seconds", text);
    return fmt::format("'{}' is not a time above 0 and of at most 1e9 seconds, such as {}", text,
                       examples);
  };
}

}  // namespace

std::optional<ShardWords> parse_shard(const std::string& text) {
  if (text == kAutoShard) return ShardWords();
  const std::size_t slash = text.find('/');
  if (slash == std::string::npos) return std::nullopt;
  const std::string first = text.substr(0, slash);
  const auto index = parse_count(first), count = parse_count(text.substr(slash + 1));
  if (!count || *count < 1) return std::nullopt;
  if (first == kAutoShard) return ShardWords{.count = count};
  if (!index || *index < 1 || *index > *count) return std::nullopt;
  return ShardWords{*index - 1, count};
}

std::optional<double> parse_duration(std::string_view text) {
  static constexpr std::pair<char, double> kUnits[] = {{'h', 3600}, {'m', 60}, {'s', 1}};
  double seconds = 0;
  const auto add = [&](std::string_view words, double unit) {
    const auto number = parse_number(words).value;
    if (number && *number >= 0) seconds += *number * unit;
    return number && *number >= 0;
  };
  for (const auto& [letter, unit] : kUnits) {
    const std::size_t at = text.find(letter);
    if (at == std::string_view::npos) continue;
    if (!add(text.substr(0, at), unit)) return std::nullopt;
    text.remove_prefix(at + 1);
  }
  if (!text.empty() || seconds <= 0 || seconds > kLongestTime) return std::nullopt;
  return seconds;
}

std::optional<double> parse_time_limit(std::string_view text) {
  if (text.find_first_of(":-") == std::string_view::npos) return parse_duration(text);
  const auto seconds = parse_slurm_time(text);
  return seconds && *seconds > 0 && *seconds <= kLongestTime ? seconds : std::nullopt;
}

namespace {

/// An option that does not apply to this action.
std::string misplaced_option(const BatchArguments& arguments) {
  const auto is = [&](const char* action) { return arguments.action == action; };
  const bool submits = is("submit");
  const bool solves = is("run") || is("retry") || (is("plan") && arguments.pilot > 0);
  const struct {
    const char* name;
    bool given, belongs;
  } options[] = {
      {"--dry-run", arguments.dry_run, submits},
      {"--partition", !arguments.partition.empty(), submits},
      {"--time", !arguments.time.empty(), submits},
      {"--shards", arguments.shards > 0, submits || is("plan") || is("run")},
      {"--pilot", arguments.pilot > 0, is("plan")},
      {"-o", !arguments.folder.empty(), is("plan") || is("run") || is("show") || is("report")},
      {"--any-build", arguments.any_build, submits || is("run") || is("retry")},
      {"-j", arguments.jobs > 0, submits || solves},
      {"--group", arguments.group != BatchArguments().group, solves},
      {"--shard", !arguments.shard.empty(), solves},
      {"--budget", !arguments.budget.empty(), solves},
  };
  for (const auto& option : options)
    if (option.given && !option.belongs)
      return fmt::format("'{}' has no {}", arguments.action, option.name);
  return {};
}

}  // namespace

std::string misuse(const BatchArguments& arguments) {
  if (arguments.path == "-")
    return "a plan cannot be read from stdin, because its paths are relative to its folder";
  const bool retries = arguments.action == "retry", shows = arguments.action == "show";
  if (retries && arguments.word != kRetryFailed && arguments.word != kRetryTimeout)
    return "say what to solve again: 'failed' or 'timeout'";
  if (shows && arguments.word.empty()) return "say which item to show: its id";
  if (!retries && !shows && !arguments.word.empty())
    return fmt::format("unexpected argument '{}': '{}' takes one path", arguments.word,
                       arguments.action);
  return misplaced_option(arguments);
}

const char* const kBatchDetails =
    "plan PLAN.yaml   checks every item of a plan and writes the folder of a run\n"
    "run RUN          solves the items that have no result yet; run PLAN.yaml does all at once\n"
    "status RUN       counts results\n"
    "collect RUN      writes results.csv, times.csv and dataset.h5\n"
    "retry RUN failed|timeout   solves items again that failed or timed out\n"
    "show RUN ID      writes the problem and the solution of one item, or simulates its loop\n"
    "report RUN       writes report.html: counts, maps over the varied keys, outliers\n"
    "submit RUN       submits the run to a Slurm cluster as a job array, one element per shard\n"
    "Every worker is a separate process; ending one or all of them loses only the items in "
    "progress. Exit status 0: all items are solved, or all loops lasted; 1: some failed or have no "
    "result yet.";

std::vector<Argument> batch_arguments(BatchArguments& arguments) {
  return {{.names = {"ACTION"},
           .value = "ACTION",
           .description = "What to do",
           .choices = {"plan", "run", "status", "collect", "retry", "show", "report", "submit"},
           .required = true,
           .target = &arguments.action},
          {.names = {"PATH"},
           .value = "PATH.yaml",
           .description = "Plan, or the folder of a run",
           .required = true,
           .target = &arguments.path},
          {.names = {"WORD"},
           .value = "WORD",
           .description = "retry: failed or timeout; show: the id of an item, or its first digits",
           .target = &arguments.word},
          {.names = {"-o", "--output"},
           .value = "FOLDER",
           .description = "plan, run: folder of the run (default: out/<name of the plan>); show: "
                          "folder for its files; report: the page",
           .target = &arguments.folder},
          {.names = {"-j", "--jobs"},
           .value = "N",
           .description = "Worker processes (default: one per processor)",
           .numbers = WholeNumbers{1, 1024},
           .target = &arguments.jobs},
          {.names = {"--group"},
           .value = "N",
           .description = "Items that are sent to a worker ahead",
           .numbers = WholeNumbers{1, 1000},
           .fallback = std::to_string(arguments.group),
           .target = &arguments.group},
          {.names = {"--pilot"},
           .value = "N",
           .description = "plan: solve this many items, and estimate the rest",
           .numbers = WholeNumbers{1, 100000},
           .target = &arguments.pilot},
          {.names = {"--shard"},
           .value = "I/N",
           .description = "run, retry: solve one share of the items, such as 2/7; auto/7 or auto "
                          "takes I from the job array of this process",
           .check = shard_defect,
           .target = &arguments.shard},
          {.names = {"--budget"},
           .value = "TIME",
           .description = "run, retry: begin no item after this time: 90s, 55m, 1h30m",
           .check = time_check(parse_duration, "90s, 55m or 1h30m"),
           .target = &arguments.budget},
          {.names = {"--shards"},
           .value = "N",
           .description = "plan: the N of --shard auto; submit: elements of the array",
           .numbers = WholeNumbers{1, 1000000},
           .target = &arguments.shards},
          {.names = {"--partition"},
           .value = "NAME",
           .description = "submit: partition of the cluster",
           .target = &arguments.partition},
          {.names = {"--time"},
           .value = "TIME",
           .description =
               "submit: time limit of an element: 10m, 1h30m, or as Slurm writes it, 1:30:00",
           .check = time_check(parse_time_limit, "10m, 1h30m or 1:30:00"),
           .target = &arguments.time},
          flag({"--dry-run"}, arguments.dry_run, "submit: print what would be submitted"),
          flag({"--any-build"}, arguments.any_build,
               "run, retry, submit: accept a plan made by another build of conddp")};
}

}  // namespace conddp
