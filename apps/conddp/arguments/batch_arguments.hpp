#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/command.hpp"

namespace conddp {

/// What the command line of 'conddp batch' says.
struct BatchArguments {
  std::string action, path;
  std::string word;  ///< retry: what; show: the id of an item
  std::string folder;
  int jobs = 0;
  int group = 8;
  int pilot = 0;
  std::string shard, budget;
  int shards = 0;  ///< plan, submit: into how many a run is divided; 0: not said
  std::string partition, time;
  bool any_build = false, dry_run = false;
};

/// Which items 'retry' takes.
inline constexpr std::string_view kRetryFailed = "failed", kRetryTimeout = "timeout";

/// What the actions do.
extern const char* const kBatchDetails;
/// ACTION, PATH, WORD and all options.
std::vector<Argument> batch_arguments(BatchArguments& arguments);

/// What the words of the command line lack or have too much of; empty if they fit the action.
std::string misuse(const BatchArguments& arguments);

/// A share as the command line names it: "2/7", or with the index that the environment of an array
/// of jobs has, "auto/7" or "auto".
struct ShardWords {
  std::optional<int> index;  ///< from 0; absent: that of the environment
  std::optional<int> count;  ///< absent: as many as the plan says
};
/// Nothing where it is no share.
std::optional<ShardWords> parse_shard(const std::string& text);

/// "90s", "55m", "1h30m" in seconds; nothing where it is no time above zero, or lacks its unit.
std::optional<double> parse_duration(std::string_view text);

/// The same, or a time as Slurm writes it, with colons or days: "1:30:00", "90:00", "1-12".
std::optional<double> parse_time_limit(std::string_view text);

}  // namespace conddp
