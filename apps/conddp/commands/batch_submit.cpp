#include <algorithm>
#include <filesystem>

#include <pwd.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/text/shell_words.hpp"
#include "batch/cluster/program.hpp"
#include "batch/cluster/slurm_job.hpp"
#include "batch/plan/run_folder.hpp"
#include "batch/results/collect.hpp"
#include "commands/batch_actions.hpp"
#include "terminal/exit_codes.hpp"
#include "terminal/messages.hpp"
#include "terminal/streams.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

/// Time limit of an array element relative to its expected time.
constexpr double kTimeMargin = 3;
constexpr double kLeastTime = 600;  // s

/// An error that ends the command, with a hint.
struct Misfit {
  std::string message, hint;
};

std::string first_line(const std::string& text) { return text.substr(0, text.find('\n')); }

std::string user_name() {
  const passwd* entry = ::getpwuid(::getuid());
  return entry == nullptr ? std::string() : entry->pw_name;
}

/// Maximum number of jobs that a user may submit, from the cluster's accounting.
std::optional<int> most_submitted() {
  const ProgramEnd end =
      run_program({"sacctmgr", "--noheader", "--parsable2", "list", "associations", "where",
                   "user=" + user_name(), "format=maxsubmitjobs"});
  if (end.exit_status != 0) return std::nullopt;
  return parse_submit_limit(end.out);
}

/// Limits reported by the cluster; empty without a cluster.
std::optional<SlurmLimits> cluster_limits(const std::string& partition) {
  const ProgramEnd config = run_program({"scontrol", "show", "config"});
  if (config.exit_status != 0) return std::nullopt;
  SlurmLimits limits = parse_slurm_config(config.out);
  if (limits.has_accounting) limits.submitted = most_submitted();
  std::vector<std::string> words = {"sinfo", "--noheader", "--format=%P %l"};
  if (!partition.empty()) words.push_back("--partition=" + partition);
  const ProgramEnd times = run_program(words);
  if (times.exit_status == 0)
    limits.longest_s = parse_partition_time(times.out, !partition.empty());
  return limits;
}

/// Estimated seconds for the items without a result on one processor, from the finished items.
std::optional<double> seconds_left(const BatchStatus& status) {
  const std::size_t done = status.items - status.unfinished;
  if (done == 0) return std::nullopt;
  return status.solve_s / static_cast<double>(done) * static_cast<double>(status.unfinished);
}

/// Sets the number of shards: `wanted`, or if 0, the number suited to the time of the items.
std::optional<Misfit> choose_shards(int wanted, const SlurmLimits& limits,
                                    const std::optional<double>& seconds, SlurmJob& job) {
  if (wanted > limits.most_shards())
    return Misfit{
        fmt::format("this cluster takes arrays of at most {} elements", limits.most_shards()),
        "ask for fewer with --shards"};
  if (wanted > 0) {
    job.shards = wanted;
  } else if (seconds) {
    job.shards = shards_for(*seconds, job.cpus, limits);
  } else {
    return Misfit{"the time per item is not known yet",
                  "solve a few with 'conddp batch plan PLAN.yaml -o RUN --pilot 5', or give the "
                  "number of shards: --shards N"};
  }
  return std::nullopt;
}

std::optional<Misfit> choose_time(const BatchArguments& arguments, const SlurmLimits& limits,
                                  const std::optional<double>& seconds, SlurmJob& job) {
  if (!arguments.time.empty())
    job.time_s = parse_time_limit(arguments.time);
  else if (seconds)
    job.time_s = std::max(kLeastTime, kTimeMargin * *seconds / (job.shards * job.cpus));
  if (!job.time_s || !limits.longest_s || *job.time_s <= *limits.longest_s) return std::nullopt;
  if (arguments.time.empty()) {
    job.time_s = limits.longest_s;
    return std::nullopt;
  }
  return Misfit{fmt::format("this partition ends jobs after {:.0f} min", *limits.longest_s / 60),
                "ask for less with --time; the next submit continues with the unfinished items"};
}

std::vector<std::string> sbatch_words(const SlurmJob& job) {
  return {"sbatch", "--parsable", "--chdir=" + job.run.string()};
}

/// Submits a script; returns the job number, or an empty text after printing an error.
std::string submit(const std::vector<std::string>& words, const std::string& script,
                   const std::string& hint) {
  const ProgramEnd end = run_program(words, script);
  if (end.exit_status == 0) return first_line(end.out).substr(0, first_line(end.out).find(';'));
  print_error("Slurm does not take the job: " + first_line(end.err), hint);
  return {};
}

void write_scripts(const SlurmJob& job, const std::string& array, const std::string& collect) {
  create_folder(job.run / "slurm");
  AtomicFiles files;
  files.add(job.run / "slurm" / "array.sh", array);
  files.add(job.run / "slurm" / "collect.sh", collect);
  files.commit();
}

int hand_over(const SlurmJob& job) {
  const std::string array = slurm_array_script(job), collect = slurm_collect_script(job);
  write_scripts(job, array, collect);
  const std::string number = submit(sbatch_words(job), array,
                                    "'conddp batch submit --dry-run' prints what is handed over");
  if (number.empty()) return kExitBadInput;
  std::vector<std::string> words = sbatch_words(job);
  words.push_back("--dependency=afterany:" + number);
  const std::string last =
      submit(words, collect,
             fmt::format("the shards are queued already as job {}; when they have ended, 'conddp "
                         "batch collect {}' does what this job would have done",
                         number, job.run.string()));
  if (last.empty()) return kExitBadInput;
  print_result(fmt::format("job {}: {} shard{}; job {} collects\n", number, job.shards,
                           job.shards == 1 ? "" : "s", last));
  return kExitConverged;
}

int print_scripts(const SlurmJob& job) {
  const std::string words = shell_line(sbatch_words(job));
  print_result(fmt::format("{} <<'END'\n{}END\n{} --dependency=afterany:ARRAY <<'END'\n{}END\n",
                           words, slurm_array_script(job), words, slurm_collect_script(job)));
  return kExitConverged;
}

}  // namespace

int submit_batch(const BatchArguments& arguments) {
  Diagnostics diagnostics;
  const auto manifest = load_manifest(arguments.path, true, diagnostics);
  if (!manifest || !fits_run_folder(*manifest, arguments.path, arguments.any_build, diagnostics)) {
    print_messages(diagnostics, Verbosity::kNormal);
    return kExitBadInput;
  }
  const BatchStatus status = batch_status(*manifest, load_results(arguments.path));
  if (status.unfinished == 0) {
    print_result("all items have a result: nothing is submitted\n");
    return kExitConverged;
  }
  const auto cluster = cluster_limits(arguments.partition);
  if (!cluster && !arguments.dry_run) {
    print_error("there is no Slurm cluster here: 'scontrol show config' fails",
                "docs/clusters.md says how other queue systems run shards");
    return kExitBadInput;
  }
  const SlurmLimits limits = cluster.value_or(SlurmLimits());
  const auto seconds = seconds_left(status);
  SlurmJob job{.name = manifest->name,
               .program = fs::read_symlink("/proc/self/exe"),
               .run = fs::canonical(arguments.path),
               .cpus = std::max(1, arguments.jobs),
               .partition = arguments.partition,
               .any_build = arguments.any_build};
  if (const std::string unfit = unfit_for_scripts(job); !unfit.empty()) {
    print_error(unfit);
    return kExitBadInput;
  }
  const int planned = manifest->shards > 1 ? manifest->shards : 0;
  auto misfit =
      choose_shards(arguments.shards > 0 ? arguments.shards : planned, limits, seconds, job);
  if (!misfit) misfit = choose_time(arguments, limits, seconds, job);
  if (misfit) {
    print_error(misfit->message, misfit->hint);
    return kExitBadInput;
  }
  warn_without_time_limit(*manifest, arguments.path, diagnostics);
  print_messages(diagnostics, Verbosity::kNormal);
  return arguments.dry_run ? print_scripts(job) : hand_over(job);
}

}  // namespace conddp
