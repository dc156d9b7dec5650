#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "batch/results/result.hpp"

namespace conddp {

/// Which share of the items a process solves: those whose number leaves `index` when divided by
/// `count`.
struct Shard {
  int index = 0;
  int count = 1;
};

/// The results of a shard in the folder of a run, `shards/<i>of<n>.jsonl`, and beside it the pack
/// of its solutions. Only one process writes them; both grow at their end. A line of results begins
/// with a check sum, so that one that was cut off by the end of its process is recognized: it is
/// dropped, with whatever is in the pack behind the last whole line. Every few seconds both go to
/// the disk, and a mark among the lines says how much of the pack is there. What the pack should
/// hold behind the last mark is compared with its sum, and a result without its solution is
/// dropped, with those behind it: so a power cut loses seconds at most. A pack that has become
/// shorter than the mark is cut off in the same way.
class ShardFile {
 public:
  /// Opens or makes the files. Throws OutputError where they cannot be written, or where another
  /// process has them.
  ShardFile(const std::filesystem::path& run, const Shard& shard);
  ~ShardFile();
  ShardFile(const ShardFile&) = delete;
  ShardFile& operator=(const ShardFile&) = delete;

  /// Appends a result with its solution, which may be empty. Throws OutputError; then a part of a
  /// line may stand at the end.
  void append(ItemResult result, std::string_view solution);
  /// Waits until everything is on the disk. Throws OutputError.
  void sync();

 private:
  using Clock = std::chrono::steady_clock;

  std::filesystem::path results_, pack_;
  int results_descriptor_ = -1, pack_descriptor_ = -1;
  std::size_t pack_size_ = 0;
  bool is_synced_ = true;
  Clock::time_point last_sync_ = Clock::now();
};

/// A result and the pack that holds its solution.
struct StoredResult {
  ItemResult result;
  std::filesystem::path pack;
};

/// Of every item that has results in any shard of a run, the one that counts.
std::unordered_map<std::string, StoredResult> load_results(const std::filesystem::path& run);

/// The bytes of a kept solution; empty where the pack does not hold it any more.
std::string load_solution(const StoredResult& stored);

/// Whether a solution was kept and the pack does not hold it any more.
bool is_damaged(const StoredResult& stored);

/// The solution.json that they stand for; null where there is none.
OrderedJson load_document(const StoredResult& stored);

}  // namespace conddp
