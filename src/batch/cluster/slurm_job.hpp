#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace conddp {

/// Limits of a Slurm cluster, as far as it reports them.
struct SlurmLimits {
  int array_size = 1001;            ///< MaxArraySize; the largest index is one less
  std::optional<int> submitted;     ///< limit on a user's waiting array elements
  std::optional<double> longest_s;  ///< time limit of the partition
  bool has_accounting = false;      ///< true if user limits are tracked

  /// The maximum number of shards in an array; a dependent job is submitted as well.
  int most_shards() const;
};

/// Reads the output of `scontrol show config`: MaxArraySize, and whether user limits are tracked.
SlurmLimits parse_slurm_config(std::string_view text);
/// Reads the output of `sacctmgr --noheader --parsable2 list associations format=maxsubmitjobs`. It
/// has a line for each account of the user, and the site chooses the account of a job, so the
/// result is the smallest number. Nothing without a limit.
std::optional<int> parse_submit_limit(std::string_view text);
/// Converts a time in Slurm's format to seconds: minutes, minutes:seconds, hours:minutes:seconds,
/// days-hours and so on. Nothing for UNLIMITED or an invalid time.
std::optional<double> parse_slurm_time(std::string_view text);

/// The maximum time of a job in seconds, from the output of `sinfo --noheader --format="%P %l"`. It
/// applies to the default partition, marked by a star, or to the first one listed if the partitions
/// are `chosen`. Nothing if that partition does not have a limit.
std::optional<double> parse_partition_time(std::string_view text, bool chosen);

/// A run as Slurm jobs: an array with one shard per element, and a job that collects the results.
struct SlurmJob {
  std::string name;               ///< of the batch
  std::filesystem::path program;  ///< conddp
  std::filesystem::path run;      ///< absolute
  int shards = 1;
  int cpus = 1;                  ///< for the workers of each element
  std::string partition;         ///< empty: the cluster's default
  std::optional<double> time_s;  ///< time limit of an element; absent: that of the partition
  bool any_build = false;
};

/// Target solve time of an array element in seconds. It keeps the load on the queue system low, and
/// the cost of a lost element small.
inline constexpr double kElementSeconds = 600;

/// The number of shards, within the limits, that makes each take about kElementSeconds. `seconds`
/// is the time of all remaining items on one processor.
int shards_for(double seconds, int cpus, const SlurmLimits& limits);

/// Why the names of a job cannot appear in a script: for example, a line end in a partition's name
/// would add a line. Empty if they can.
std::string unfit_for_scripts(const SlurmJob& job);

/// The script of the array for sbatch. Before its time limit Slurm sends SIGUSR1; conddp then
/// finishes the current items and starts no others. An element may be requeued at any time.
std::string slurm_array_script(const SlurmJob& job);
/// The script of the job that finally writes the tables, whether or not the elements succeeded.
std::string slurm_collect_script(const SlurmJob& job);

}  // namespace conddp
