#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

namespace conddp {

/// What a Slurm cluster allows, as far as it says so.
struct SlurmLimits {
  int array_size = 1001;            ///< MaxArraySize: the largest index is one less
  std::optional<int> submitted;     ///< elements of arrays that a user may have waiting
  std::optional<double> longest_s;  ///< time limit of the partition
  bool has_accounting = false;      ///< whether limits of users are kept at all

  /// How many shards one array may have; a dependent job is submitted beside it.
  int most_shards() const;
};

/// Reads `scontrol show config`: MaxArraySize, and whether limits of users are kept.
SlurmLimits parse_slurm_config(std::string_view text);
/// The least number that stands alone on a line of what `sacctmgr --noheader --parsable2 list
/// associations format=maxsubmitjobs` prints, a line for each account of the user: which of them a
/// job is booked on the site decides. Nothing where none has a limit.
std::optional<int> parse_submit_limit(std::string_view text);
/// A time as Slurm prints it: minutes, minutes:seconds, hours:minutes:seconds, days-hours and so
/// on; nothing for UNLIMITED or what is no time. In seconds.
std::optional<double> parse_slurm_time(std::string_view text);

/// The longest time of a job in seconds, from what `sinfo --noheader --format="%P %l"` prints: of
/// the default partition, whose name has a star, or of the first one listed if the partitions are
/// `chosen`. Nothing where that has no limit.
std::optional<double> parse_partition_time(std::string_view text, bool chosen);

/// A run as jobs of Slurm: an array with a shard an element, and a job that collects.
struct SlurmJob {
  std::string name;               ///< of the batch
  std::filesystem::path program;  ///< conddp
  std::filesystem::path run;      ///< absolute
  int shards = 1;
  int cpus = 1;                  ///< of each element: its workers
  std::string partition;         ///< empty: the cluster's default
  std::optional<double> time_s;  ///< limit of an element; absent: that of the partition
  bool any_build = false;
};

/// How many seconds of solving an element of an array should have, so that the queue system has
/// little to do and a lost element costs little.
inline constexpr double kElementSeconds = 600;

/// So many shards that each takes about kElementSeconds, as many as are allowed at most.
/// `seconds`: of all items that are left, on one processor.
int shards_for(double seconds, int cpus, const SlurmLimits& limits);

/// Why no script can have the names of a job: a line end in a partition's name would begin another
/// line of the script. Empty where all can.
std::string unfit_for_scripts(const SlurmJob& job);

/// The script of the array for sbatch. Before its time limit Slurm sends SIGUSR1, on which conddp
/// ends the items under way and no others; an element may be requeued at any time.
std::string slurm_array_script(const SlurmJob& job);
/// The script of the job that writes the tables at the end, whatever became of the elements.
std::string slurm_collect_script(const SlurmJob& job);

}  // namespace conddp
