#include "batch/results/shard_file.hpp"

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <fstream>

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "base/files/sha256.hpp"
#include "base/files/write_all.hpp"

namespace conddp {
namespace {

namespace fs = std::filesystem;

constexpr const char* kFolder = "shards";
constexpr std::size_t kSumDigits = 8;

std::string check_sum(std::string_view text) { return sha256(text).substr(0, kSumDigits); }

/// `{"sum":"01234567",` before what stands on the line of a result behind its first brace.
std::string summed_line(const std::string& line) {
  return fmt::format(R"({{"sum":"{}",{})", check_sum(line), std::string_view(line).substr(1)) +
         '\n';
}

/// The line of a result without its sum; empty where that does not fit.
std::string checked_line(std::string_view line) {
  constexpr std::string_view kStart = R"({"sum":")", kEnd = R"(",)";
  if (!line.starts_with(kStart) || line.size() < kStart.size() + kSumDigits + kEnd.size())
    return {};
  const std::string_view sum = line.substr(kStart.size(), kSumDigits);
  std::string rest = "{";
  rest += line.substr(kStart.size() + kSumDigits + kEnd.size());
  return check_sum(rest) == sum ? rest : std::string();
}

std::string read_whole(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(stream), {}};
}

/// All whole results of a file in their order, and where the last one ends.
struct Lines {
  std::vector<ItemResult> results;
  std::size_t end = 0;
};

Lines read_lines(const fs::path& file) {
  const std::string text = read_whole(file);
  Lines lines;
  for (std::size_t start = 0; start < text.size();) {
    const std::size_t end = text.find('\n', start);
    if (end == std::string::npos) break;
    const std::string line = checked_line(std::string_view(text).substr(start, end - start));
    start = end + 1;
    if (line.empty()) continue;
    try {
      lines.results.push_back(parse_result(line));
      lines.end = start;
    } catch (const OrderedJson::exception&) {
    }
  }
  return lines;
}

fs::path pack_of(const fs::path& results) {
  return results.parent_path() / (results.stem().string() + ".solutions");
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
}

ShardFile::~ShardFile() {
  ::close(pack_descriptor_);
  ::close(results_descriptor_);
}

void ShardFile::append(ItemResult result, std::string_view solution) {
  result.solution_offset = solution.empty() ? 0 : pack_size_;
  result.solution_bytes = solution.size();
  if (!write_all(pack_descriptor_, solution)) fail(pack_, "written");
  pack_size_ += solution.size();
  if (!write_all(results_descriptor_, summed_line(result_line(result)))) fail(results_, "written");
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
  std::string text(stored.result.solution_bytes, '\0');
  stream.seekg(static_cast<std::streamoff>(stored.result.solution_offset));
  if (!stream.read(text.data(), static_cast<std::streamsize>(text.size()))) return {};
  return text;
}

}  // namespace conddp
