#include "batch/cluster/slurm_job.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include <fmt/format.h>

#include "base/shared_library.hpp"
#include "base/text/shell_words.hpp"
#include "base/text/strict_number.hpp"

namespace conddp {
namespace {

/// Lead time, in seconds, of the signal before an element's time limit. Slurm may send the signal a
/// minute earlier.
constexpr double kLeastLead = 10, kMostLead = 90, kLeadShare = 0.2;

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(" \t\r\n");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r\n") - first + 1);
}

/// The value of `key` from the lines "KEY = value" of a configuration.
std::string_view value_of(std::string_view text, std::string_view key) {
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    const std::string_view line = text.substr(start, end - start);
    const std::size_t equals = line.find('=');
    if (equals != std::string_view::npos && trimmed(line.substr(0, equals)) == key)
      return trimmed(line.substr(equals + 1));
    start = end + 1;
  }
  return {};
}

bool is_control(char c) { return static_cast<unsigned char>(c) < ' ' || c == '\x7f'; }

/// Replaces control characters, quotes, backslashes, blanks and '%', which job names should not
/// contain.
std::string plain_name(std::string name) {
  for (char& c : name)
    if (is_control(c) || std::string_view("\"'\\ %").find(c) != std::string_view::npos) c = '_';
  return name;
}

std::string time_text(double seconds) {
  const long long minutes = std::max(1LL, std::llround(std::ceil(seconds / 60)));
  return fmt::format("{}:{:02}:00", minutes / 60, minutes % 60);
}

double lead(const std::optional<double>& time_s) {
  return time_s ? std::clamp(kLeadShare * *time_s, kLeastLead, kMostLead) : kMostLead;
}

/// The common beginning of both scripts.
std::string head(const SlurmJob& job, const char* suffix, const char* log) {
  std::string text = fmt::format(
      "#!/bin/bash\n"
      "#SBATCH --job-name={}{}\n"
      "#SBATCH --output=slurm/{}.log\n"
      "#SBATCH --open-mode=append\n",
      plain_name(job.name), suffix, log);
  if (!job.partition.empty()) text += fmt::format("#SBATCH --partition={}\n", job.partition);
  return text;
}

/// The shell's process becomes conddp through exec, so that signals reach it.
std::string command_line(std::vector<std::string> words) {
  return "exec " + shell_line(words) + '\n';
}

}  // namespace

int SlurmLimits::most_shards() const {
  return submitted ? std::clamp(*submitted - 1, 1, array_size) : array_size;
}

SlurmLimits parse_slurm_config(std::string_view text) {
  SlurmLimits limits;
  limits.array_size = parse_count(value_of(text, "MaxArraySize")).value_or(limits.array_size);
  const std::string_view storage = value_of(text, "AccountingStorageType");
  limits.has_accounting = !storage.empty() && storage.find("none") == std::string_view::npos;
  return limits;
}

std::optional<int> parse_submit_limit(std::string_view text) {
  std::optional<int> least;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    const auto limit = parse_count(trimmed(text.substr(start, end - start)));
    if (limit) least = std::min(*limit, least.value_or(*limit));
    start = end + 1;
  }
  return least;
}

std::optional<double> parse_slurm_time(std::string_view text) {
  text = trimmed(text);
  double days = 0;
  const std::size_t dash = text.find('-');
  if (dash != std::string_view::npos) {
    const auto count = parse_count(text.substr(0, dash));
    if (!count) return std::nullopt;
    days = *count;
    text.remove_prefix(dash + 1);
  }
  std::vector<int> parts;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find(':', start), text.size());
    const auto part = parse_count(text.substr(start, end - start));
    if (!part || parts.size() == 3) return std::nullopt;
    parts.push_back(*part);
    start = end + 1;
  }
  // After days, hours come first. Without days, one or two parts are minutes and seconds.
  const double first = dash != std::string_view::npos || parts.size() == 3 ? 3600 : 60;
  double seconds = days * 86400, unit = first;
  for (const int part : parts) {
    seconds += part * unit;
    unit /= 60;
  }
  return seconds;
}

std::optional<double> parse_partition_time(std::string_view text, bool chosen) {
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = std::min(text.find('\n', start), text.size());
    const std::string_view line = trimmed(text.substr(start, end - start));
    const std::size_t space = line.find(' ');
    start = end + 1;
    if (space != std::string_view::npos && (chosen || line[space - 1] == '*'))
      return parse_slurm_time(line.substr(space));
  }
  return std::nullopt;
}

int shards_for(double seconds, int cpus, const SlurmLimits& limits) {
  const double wanted = std::ceil(seconds / (kElementSeconds * cpus));
  return static_cast<int>(std::clamp<double>(wanted, 1, limits.most_shards()));
}

std::string unfit_for_scripts(const SlurmJob& job) {
  if (std::ranges::any_of(job.partition, [](char c) { return is_control(c) || c == ' '; }))
    return "a partition's name has no spaces and no line ends";
  const std::string run = job.run.string();
  if (std::ranges::any_of(run, is_control))
    return fmt::format("the path of the run, '{}', has line ends or control characters", run);
  return {};
}

std::string slurm_array_script(const SlurmJob& job) {
  std::string text = head(job, "", "%A_%a");
  text += fmt::format(
      "#SBATCH --array=0-{}\n"
      "#SBATCH --cpus-per-task={}\n"
      "#SBATCH --signal=B:USR1@{:.0f}\n"
      "#SBATCH --requeue\n",
      job.shards - 1, job.cpus, lead(job.time_s));
  if (job.time_s) text += fmt::format("#SBATCH --time={}\n", time_text(*job.time_s));
  std::vector<std::string> words = {job.program.string(),
                                    "batch",
                                    "run",
                                    job.run.string(),
                                    "--shard",
                                    fmt::format("auto/{}", job.shards),
                                    "-j",
                                    std::to_string(job.cpus)};
  if (job.any_build) words.emplace_back("--any-build");
  if (code_is_allowed()) words.emplace_back(kAllowCode);
  return text + command_line(std::move(words));
}

std::string slurm_collect_script(const SlurmJob& job) {
  return head(job, "-collect", "%j_collect") +
         command_line({job.program.string(), "batch", "collect", job.run.string()});
}

}  // namespace conddp
