#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <unordered_map>
#include <vector>

#include "batch/results/result.hpp"

namespace conddp {

/// The part of the items that a process solves: those whose index modulo `count` is `index`.
struct Shard {
  int index = 0;
  int count = 1;
};

/// The results of a shard in the folder of a run, `shards/<i>of<n>.jsonl`, with the pack of its
/// solutions next to it. Only one process writes them, and both files only grow. A result line
/// begins with a checksum. An incomplete line, left when its process ended, is thus recognized and
/// dropped, with everything in the pack after the last complete line. Every few seconds both files
/// are flushed to disk, and a mark line records the size of the pack. On reading, solutions after
/// the last mark are verified by checksum; a result without its solution is dropped, and so are all
/// later ones. So a power failure loses a few seconds at most. A pack that is shorter than the mark
/// is truncated in the same way.
class ShardFile {
 public:
  /// Opens or creates the files. Throws OutputError if they cannot be written or another process
  /// uses them.
  ShardFile(const std::filesystem::path& run, const Shard& shard);
  ~ShardFile();
  ShardFile(const ShardFile&) = delete;
  ShardFile& operator=(const ShardFile&) = delete;

  /// Appends a result with its solution, which may be empty. Throws OutputError; the file may then
  /// end in an incomplete line.
  void append(ItemResult result, std::string_view solution);
  /// Waits until all data is on disk. Throws OutputError.
  void sync();

 private:
  using Clock = std::chrono::steady_clock;

  std::filesystem::path results_, pack_;
  int results_descriptor_ = -1, pack_descriptor_ = -1;
  std::size_t pack_size_ = 0;
  bool is_synced_ = true;
  Clock::time_point last_sync_ = Clock::now();
};

/// A result and the pack of its solution.
struct StoredResult {
  ItemResult result;
  std::filesystem::path pack;
};

/// The result that takes precedence, for every item with results in any shard of a run.
std::unordered_map<std::string, StoredResult> load_results(const std::filesystem::path& run);

/// The bytes of a stored solution; empty if it is no longer in the pack.
std::string load_solution(const StoredResult& stored);

/// True if a solution was stored but is no longer in the pack.
bool is_damaged(const StoredResult& stored);

/// The solution.json of a stored result; null without one.
OrderedJson load_document(const StoredResult& stored);

/// A document as it is stored: in CBOR (RFC 8949).
std::string packed_document(const OrderedJson& document);

}  // namespace conddp
