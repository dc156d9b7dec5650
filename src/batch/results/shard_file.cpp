#include "batch/results/shard_file.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/files/check_sums.hpp"
#include "base/files/descriptor.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "shards";

/// Maximum delay before results are flushed to disk.
constexpr std::chrono::seconds kSyncInterval{5};

/// Start of a line that records how many bytes of the pack are on disk.
constexpr std::string_view kMark = R"({"synced":)";
std::string mark_line(std::size_t bytes) { return fmt::format("{}{}}}", kMark, bytes); }
std::size_t marked_bytes(std::string_view line) {
  std::size_t bytes = 0;
  std::from_chars(line.data() + kMark.size(), line.data() + line.size(), bytes);
  return bytes;
}

std::string read_whole(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

fs::path pack_of(const fs::path& results) {
  return results.parent_path() / (results.stem().string() + ".solutions");
}

/// All complete results of a file in order, and the end of the last one.
struct Lines {
  std::vector<ItemResult> results;
  std::vector<std::size_t> starts;  ///< of result lines
  std::size_t end = 0;
  std::size_t synced = 0;  ///< bytes of the pack known to be on disk
};

void take_line(const std::string& line, std::size_t start, std::size_t end, Lines& lines) {
  if (line.starts_with(kMark)) {
    lines.synced = std::max(lines.synced, marked_bytes(line));
    lines.end = end;
    return;
  }
  try {
    lines.results.push_back(parse_result(line));
    lines.starts.push_back(start);
    lines.end = end;
  } catch (const OrderedJson::exception&) {
  }
}

/// Drops the first result whose solution is missing from the pack, and all results after it. This
/// also handles a pack that is shorter than the last mark says.
void drop_torn(const fs::path& pack, Lines& lines) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(pack, error);
  const std::size_t kept = error ? 0 : std::min<std::uintmax_t>(lines.synced, size);
  for (std::size_t i = 0; i < lines.results.size(); ++i) {
    const ItemResult& result = lines.results[i];
    if (result.solution_offset + result.solution_bytes <= kept) continue;
    if (result.solution_bytes == 0 || !load_solution({result, pack}).empty()) continue;
    lines.end = lines.starts[i];
    lines.results.resize(i);
  }
}

Lines read_lines(const fs::path& file) {
  const std::string text = read_whole(file);
  Lines lines;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = text.find('\n', start);
    if (end == std::string::npos) break;
    const std::string line = without_sum(std::string_view(text).substr(start, end - start));
    if (!line.empty()) take_line(line, start, end + 1, lines);
    start = end + 1;
  }
  drop_torn(pack_of(file), lines);
  return lines;
}

[[noreturn]] void fail(const fs::path& file, const char* what) {
  throw OutputError(
      fmt::format("'{}' cannot be {}: {}", file.string(), what, std::strerror(errno)));
}

int open_file(const fs::path& file) {
  const int descriptor = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666);
  if (descriptor < 0) fail(file, "opened");
  return descriptor;
}

void truncate(int descriptor, std::size_t size, const fs::path& file) {
  if (::ftruncate(descriptor, static_cast<off_t>(size)) != 0 ||
      ::lseek(descriptor, 0, SEEK_END) < 0)
    fail(file, "written");
}

}  // namespace

ShardFile::ShardFile(const fs::path& run, const Shard& shard)
    : results_(run / kFolder / fmt::format("{}of{}.jsonl", shard.index + 1, shard.count)),
      pack_(pack_of(results_)) {
  create_folder(run / kFolder);
  results_descriptor_ = open_file(results_);
  if (::flock(results_descriptor_, LOCK_EX | LOCK_NB) != 0) {
    const std::string message =
        errno == EWOULDBLOCK
            ? fmt::format("another process solves this shard: it has '{}'", results_.string())
            : fmt::format("'{}' cannot be locked: {}", results_.string(), std::strerror(errno));
    ::close(results_descriptor_);
    throw OutputError(message);
  }
  pack_descriptor_ = open_file(pack_);
  const Lines lines = read_lines(results_);
  for (const ItemResult& result : lines.results)
    pack_size_ = std::max(pack_size_, result.solution_offset + result.solution_bytes);
  truncate(results_descriptor_, lines.end, results_);
  truncate(pack_descriptor_, pack_size_, pack_);
  sync_to_disk(run / kFolder);  // the names of the files
}

ShardFile::~ShardFile() {
  ::close(pack_descriptor_);
  ::close(results_descriptor_);
}

void ShardFile::append(ItemResult result, std::string_view solution) {
  result.solution_offset = solution.empty() ? 0 : pack_size_;
  result.solution_bytes = solution.size();
  result.solution_sum = check_sum(solution);
  if (!write_all(pack_descriptor_, solution)) fail(pack_, "written");
  pack_size_ += solution.size();
  if (!write_all(results_descriptor_, with_sum(result_line(result)) + '\n'))
    fail(results_, "written");
  is_synced_ = false;
  if (Clock::now() - last_sync_ >= kSyncInterval) sync();
}

void ShardFile::sync() {
  if (is_synced_) return;
  if (::fdatasync(pack_descriptor_) != 0) fail(pack_, "written");
  if (::fdatasync(results_descriptor_) != 0) fail(results_, "written");
  if (!write_all(results_descriptor_, with_sum(mark_line(pack_size_)) + '\n'))
    fail(results_, "written");
  is_synced_ = true;
  last_sync_ = Clock::now();
}

std::unordered_map<std::string, StoredResult> load_results(const fs::path& run) {
  std::vector<fs::path> files;
  std::error_code error;
  for (fs::directory_iterator entry(run / kFolder, error), end; !error && entry != end;
       entry.increment(error))
    if (entry->path().extension() == ".jsonl") files.push_back(entry->path());
  std::sort(files.begin(), files.end());
  std::unordered_map<std::string, StoredResult> found;
  for (const fs::path& file : files)
    for (ItemResult& result : read_lines(file).results) {
      const auto [known, fresh] = found.try_emplace(result.id);
      if (fresh || result.counts_before(known->second.result))
        known->second = {std::move(result), pack_of(file)};
    }
  return found;
}

std::string load_solution(const StoredResult& stored) {
  std::ifstream stream(stored.pack, std::ios::binary);
  std::string bytes(stored.result.solution_bytes, '\0');
  stream.seekg(static_cast<std::streamoff>(stored.result.solution_offset));
  if (!stream.read(bytes.data(), static_cast<std::streamsize>(bytes.size()))) return {};
  return check_sum(bytes) == stored.result.solution_sum ? bytes : std::string();
}

bool is_damaged(const StoredResult& stored) {
  return stored.result.solution_bytes > 0 && load_solution(stored).empty();
}

OrderedJson load_document(const StoredResult& stored) {
  OrderedJson document = OrderedJson::from_cbor(load_solution(stored), true, false);
  return document.is_discarded() ? OrderedJson() : document;
}

std::string packed_document(const OrderedJson& document) {
  std::string bytes;
  OrderedJson::to_cbor(document, bytes);
  return bytes;
}

}  // namespace conddp
