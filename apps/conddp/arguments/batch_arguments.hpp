#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "arguments/command.hpp"

namespace conddp {

/// Arguments of 'conddp batch'.
struct BatchArguments {
  std::string action, path;
  std::string word;  ///< retry: the kind of items; show: the id of an item
  std::string folder;
  int jobs = 0;
  int group = 8;
  int pilot = 0;
  std::string shard, budget;
  int shards = 0;  ///< plan, submit: number of shards of a run; 0: not given
  std::string partition, time;
  bool any_build = false, dry_run = false;
};

/// Items that 'retry' accepts.
inline constexpr std::string_view kRetryFailed = "failed", kRetryTimeout = "timeout";

/// Description of the actions.
extern const char* const kBatchDetails;
/// ACTION, PATH, WORD and all options.
std::vector<Argument> batch_arguments(BatchArguments& arguments);

/// Error in the arguments for this action: missing or excess words; empty if none.
std::string misuse(const BatchArguments& arguments);

/// A shard as given on the command line: "2/7"; or "auto/7" and "auto" with the index from the
/// environment of a job array.
struct ShardWords {
  std::optional<int> index;  ///< from 0; absent: from the environment
  std::optional<int> count;  ///< absent: as planned
};
/// Parses a shard; empty if invalid.
std::optional<ShardWords> parse_shard(const std::string& text);

/// Parses "90s", "55m", "1h30m" into seconds; empty if not positive or without a unit.
std::optional<double> parse_duration(std::string_view text);

/// Parses a duration, or a time in Slurm's format with colons or days: "1:30:00", "90:00", "1-12".
std::optional<double> parse_time_limit(std::string_view text);

}  // namespace conddp
