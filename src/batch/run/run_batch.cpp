#include "batch/run/run_batch.hpp"

#include <algorithm>
#include <csignal>
#include <map>
#include <memory>
#include <set>
#include <unordered_map>

#include <poll.h>

#include <fmt/format.h>

#include "batch/plan/neighbours.hpp"
#include "batch/run/worker_process.hpp"

namespace conddp {
namespace {

using Clock = WorkerProcess::Clock;

double seconds_since(Clock::time_point begin) {
  return std::chrono::duration<double>(Clock::now() - begin).count();
}

/// Maximum time of an item whose solve may take `limit` seconds. It includes time for building and
/// checking.
double patience(double limit) { return 2 * limit + 1; }

/// A run of one shard.
class BatchRun {
 public:
  BatchRun(const std::filesystem::path& run, const Manifest& manifest, const BatchOptions& options)
      : manifest_(manifest), options_(options), file_(run, options.shard) {
    const auto known = load_results(run);
    std::set<std::size_t> only;
    if (options.only) only = {options.only->begin(), options.only->end()};
    for (const auto& [id, stored] : known)
      if (!stored.result.success) failed_.insert(id);
    if (manifest.warm_start == WarmStart::kNeighbour)
      for (std::size_t i = 0; i < manifest.items.size(); ++i) numbers_[manifest.items[i].id] = i;
    for (const std::size_t item : items_of_shard(manifest, options.shard)) {
      if (options.only && !only.contains(item)) continue;
      ++progress_.items;
      const auto found = known.find(manifest.items[item].id);
      if (found != known.end()) attempts_[item] = found->second.result.attempt;
      if (found == known.end() || options.again) {
        waiting_.push_back(item);
        failed_.erase(manifest.items[item].id);
        continue;
      }
      ++progress_.before;
      progress_.failed += !found->second.result.success;
    }
  }

  BatchProgress run() {
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);
    while (!finished()) {
      if (!stopping()) feed();
      if (std::all_of(workers_.begin(), workers_.end(),
                      [](const auto& worker) { return worker->unanswered().empty(); }))
        break;
      wait();
      for (auto& worker : workers_) collect(*worker);
      std::erase_if(workers_, [&](const auto& worker) { return is_gone(*worker); });
      report();
    }
    file_.sync();
    return progress_;
  }

 private:
  bool interrupted() const { return options_.interrupted && options_.interrupted(); }
  bool finished() const {
    return interrupted() || (waiting_.empty() && suspects_.empty() && workers_.empty());
  }
  /// True if no further items should begin.
  bool stopping() {
    stopping_ = stopping_ || (options_.stop_soon && options_.stop_soon()) ||
                (options_.budget_s > 0 && seconds_since(began_) >= options_.budget_s);
    return stopping_;
  }

  /// Sends items to workers with few pending ones; a suspect is sent alone.
  void feed() {
    while (static_cast<int>(workers_.size()) < options_.workers &&
           workers_.size() < waiting_.size() + suspects_.size())
      workers_.push_back(std::make_unique<WorkerProcess>(options_.worker_command));
    for (auto& worker : workers_) {
      if (worker->unanswered().empty() && !suspects_.empty()) {
        send(*worker, suspects_.front());
        suspects_.pop_front();
        continue;
      }
      while (!waiting_.empty() && !holds_suspect(*worker) &&
             worker->unanswered().size() < items_ahead()) {
        send_block(*worker);
      }
    }
    std::erase_if(workers_, [](const auto& worker) { return worker->unanswered().empty(); });
  }

  /// Maximum number of pending items per worker. It decreases near the end, so that all workers
  /// finish together.
  std::size_t items_ahead() const {
    const std::size_t share = waiting_.size() / (2 * static_cast<std::size_t>(options_.workers));
    return std::clamp<std::size_t>(share, 1, static_cast<std::size_t>(options_.group));
  }

  bool holds_suspect(const WorkerProcess& worker) const {
    return std::any_of(worker.unanswered().begin(), worker.unanswered().end(),
                       [&](const auto& request) { return deaths_.contains(request.item); });
  }

  /// Sends the first waiting item and the subsequent ones of its block, which may start from one
  /// another.
  void send_block(WorkerProcess& worker) {
    const std::size_t block = block_of(manifest_, waiting_.front());
    while (!waiting_.empty() && block_of(manifest_, waiting_.front()) == block) {
      send(worker, waiting_.front());
      waiting_.pop_front();
    }
  }

  /// Sends an item, preceded by the ancestors whose answers the worker does not have. These are
  /// solved again, with identical bits. Each has its own time limit and may fail on its own.
  void send(WorkerProcess& worker, std::size_t item) {
    std::vector<std::size_t> line = {item};
    for (auto parent = parent_of(item); parent && !worker.has_had(*parent, kNeighbourBlock);
         parent = parent_of(*parent))
      line.push_back(*parent);
    for (std::size_t i = line.size(); i-- > 0;) {
      ManifestItem sent = manifest_.items[line[i]];
      if (!parent_of(line[i])) sent.parent.clear();
      worker.send({line[i], i > 0}, manifest_line(sent));
    }
  }

  /// The item whose answer this one starts from, unless that item failed.
  std::optional<std::size_t> parent_of(std::size_t item) const {
    const std::string& parent = manifest_.items[item].parent;
    const auto found = numbers_.find(parent);
    if (found == numbers_.end() || failed_.contains(parent)) return std::nullopt;
    return found->second;
  }

  void wait() {
    std::vector<pollfd> polled;
    for (const auto& worker : workers_) {
      polled.push_back({worker->output(), POLLIN, 0});
      if (worker->wants_to_write()) polled.push_back({worker->input(), POLLOUT, 0});
    }
    constexpr int kLongestWait = 100;  // ms
    ::poll(polled.data(), polled.size(), kLongestWait);
  }

  /// Takes the answers of a worker, and detects its end.
  void collect(WorkerProcess& worker) {
    worker.write_some();
    const bool open = worker.read_some();
    while (!worker.unanswered().empty()) {
      const auto [item, again] = worker.unanswered().front();
      const auto answer = worker.take_answer();
      if (!answer) break;
      ItemResult result = parse_result(answer->result);
      if (!again)
        record(item, std::move(result), answer->solution);
      else if (!result.success)
        failed_.insert(result.id);
      if (stopping()) return drop(worker);
    }
    if (!open) return bury(worker, kCrashed, false);
    const double limit = manifest_.limits.max_time_s;
    if (!worker.unanswered().empty() && limit > 0 &&
        seconds_since(worker.since()) > patience(limit))
      bury(worker, kKilled, true);
  }

  /// Handles a worker's end: the current item is blamed, and the others wait again.
  void bury(WorkerProcess& worker, std::string_view status, bool kill) {
    const WorkerProcess::End end = worker.reap(kill);
    std::deque<WorkerProcess::Request> left = worker.unanswered();
    gone_.insert(&worker);
    if (left.empty()) return;
    const auto [culprit, again] = left.front();
    const bool between =
        end.exit_status == kMemoryUsedUp;  // after one answer and before the next item
    if (!between) left.pop_front();
    wait_again(left);
    if (between) return;
    if (++deaths_[culprit] <= manifest_.limits.retries) {
      if (again) return;  // resent with the items that start from it
      ++attempts_[culprit];
      suspects_.push_back(culprit);
      return;
    }
    if (again) {
      failed_.insert(manifest_.items[culprit].id);
      return;
    }
    const std::string message =
        kill ? fmt::format("it did not end within {:.3g} s, the limit of a solve being {:.3g} s",
                           patience(manifest_.limits.max_time_s), manifest_.limits.max_time_s)
             : fmt::format("the process that solved it ended by {}", end.cause);
    record(culprit,
           {.id = manifest_.items[culprit].id,
            .status = std::string(status),
            .answer = {{"message", message}},
            .times = OrderedJson::object()},
           {});
  }

  /// Puts a worker's remaining items first in the queue.
  void wait_again(const std::deque<WorkerProcess::Request>& left) {
    std::deque<std::size_t> items;
    for (const auto& [item, again] : left)
      if (!again) items.push_back(item);
    waiting_.insert(waiting_.begin(), items.begin(), items.end());
  }

  /// Ends a worker and discards its other items.
  void drop(WorkerProcess& worker) {
    worker.reap(true);
    gone_.insert(&worker);
  }

  bool is_gone(const WorkerProcess& worker) { return gone_.erase(&worker) > 0; }

  void record(std::size_t item, ItemResult result, std::string_view solution) {
    result.attempt = ++attempts_[item];
    progress_.failed += !result.success;
    if (!result.success) failed_.insert(result.id);
    ++progress_.done;
    file_.append(std::move(result), solution);
  }

  void report() {
    progress_.elapsed_s = seconds_since(began_);
    if (options_.on_progress) options_.on_progress(progress_);
  }

  const Manifest& manifest_;
  const BatchOptions& options_;
  ShardFile file_;
  const Clock::time_point began_ = Clock::now();
  std::deque<std::size_t> waiting_, suspects_;
  std::unordered_map<std::string, std::size_t> numbers_;  ///< indices of the items, by id
  std::set<std::string> failed_;         ///< ids of items whose answers are not usable by others
  std::map<std::size_t, int> deaths_;    ///< deaths of workers, by the item in progress
  std::map<std::size_t, int> attempts_;  ///< attempts by item, including former runs
  std::vector<std::unique_ptr<WorkerProcess>> workers_;
  std::set<const WorkerProcess*> gone_;
  BatchProgress progress_;
  bool stopping_ = false;
};

}  // namespace

std::vector<std::size_t> items_of_shard(const Manifest& manifest, const Shard& shard) {
  std::vector<std::pair<std::size_t, std::size_t>> blocks;  // with their items
  for (std::size_t i = 0; i < manifest.items.size(); ++i)
    if (const std::size_t block = block_of(manifest, i);
        block % static_cast<std::size_t>(shard.count) == static_cast<std::size_t>(shard.index))
      blocks.emplace_back(block, i);
  std::sort(blocks.begin(), blocks.end());
  std::vector<std::size_t> items;
  for (const auto& [block, item] : blocks) items.push_back(item);
  return items;
}

BatchProgress run_batch(const std::filesystem::path& run, const Manifest& manifest,
                        const BatchOptions& options) {
  return BatchRun(run, manifest, options).run();
}

}  // namespace conddp
