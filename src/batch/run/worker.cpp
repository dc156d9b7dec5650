#include "batch/run/worker.hpp"

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <list>
#include <map>
#include <new>
#include <thread>
#include <vector>

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/files/descriptor.hpp"
#include "batch/plan/neighbours.hpp"
#include "batch/plan/run_folder.hpp"
#include "batch/run/solve_item.hpp"

namespace conddp {
namespace {

/// Environment variable for tests that makes items fail: `crash:ID`, `hang:ID` or `memory:ID`.
/// `slow:N` adds N ms to every item.
constexpr const char* kFaultVariable = "CONDDP_BATCH_FAULT";

constexpr int kUnreadable = 2;  ///< exit status

void provoke_fault(const std::string& id) {
  const char* fault = std::getenv(kFaultVariable);
  if (fault == nullptr) return;
  const std::string_view wanted = fault;
  if (wanted == "crash:" + id) std::abort();
  constexpr std::string_view kSlow = "slow:";
  if (wanted.starts_with(kSlow))
    std::this_thread::sleep_for(std::chrono::milliseconds(std::atoi(fault + kSlow.size())));
  if (wanted == "hang:" + id) {
    std::fputs("hang\n", stderr);  // unbuffered: tests wait for it
    for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
  }
  if (wanted == "memory:" + id) {
    constexpr std::size_t kTenGigabytes = 10'000'000'000;
    const std::vector<char> filled(kTenGigabytes, 1);
    std::printf("%c", filled[kTenGigabytes / 2]);
  }
}

void limit_memory(int megabytes) {
  if (megabytes == 0) return;
  rlimit limit{};
  limit.rlim_cur = limit.rlim_max = static_cast<rlim_t>(megabytes) * 1'000'000;
  setrlimit(RLIMIT_DATA, &limit);
}

/// Solves items of one run; families are loaded with their first item.
class Worker {
 public:
  Worker(std::filesystem::path run, Manifest manifest)
      : run_(std::move(run)), manifest_(std::move(manifest)) {
    if (manifest_.start) start_file_ = file_of_run(manifest_.start->file, run_);
  }

  SolvedItem solve(const ManifestItem& item) {
    const NeighbourAnswer* from = parent_of(item);
    provoke_fault(item.id);
    auto& family = families_[item.problem];
    Diagnostics diagnostics;
    if (!family)
      family = ProblemFamily::load(problem_of_run(manifest_, item.problem, run_), {}, diagnostics);
    if (!family) return failed(item, kUnsolvable, "its problem file cannot be read any more");
    if (manifest_.command == BatchCommand::kMpc) return simulate_item(item, manifest_, *family);
    SolvedItem solved = solve_item(item, manifest_, *family, {from, start_file_});
    if (manifest_.warm_start == WarmStart::kNeighbour) remember(item.id, solved.answer);
    return solved;
  }

  static SolvedItem failed(const ManifestItem& item, std::string_view status,
                           const std::string& message) {
    return {{.id = item.id,
             .status = std::string(status),
             .answer = {{"message", message}},
             .times = OrderedJson::object()},
            {},
            {}};
  }

 private:
  /// An item's answer for its neighbors, if it is solved.
  struct Answered {
    std::string id;
    std::optional<NeighbourAnswer> answer;
  };

  /// The answer of an item's parent; null without a parent or if the parent is not solved. The
  /// parent has been processed before.
  const NeighbourAnswer* parent_of(const ManifestItem& item) const {
    const auto found = std::find_if(answered_.begin(), answered_.end(),
                                    [&](const Answered& a) { return a.id == item.parent; });
    return found != answered_.end() && found->answer ? &*found->answer : nullptr;
  }

  /// Stores an answer. Keeps those of a block's items and of the current one.
  void remember(const std::string& id, std::optional<NeighbourAnswer> answer) {
    std::erase_if(answered_, [&](const Answered& a) { return a.id == id; });
    if (answered_.size() > kNeighbourBlock) answered_.pop_front();
    answered_.push_back({id, std::move(answer)});
  }

  const std::filesystem::path run_;
  const Manifest manifest_;
  std::optional<std::filesystem::path> start_file_;  ///< the plan's file
  std::map<int, std::shared_ptr<const ProblemFamily>> families_;
  std::list<Answered> answered_;  ///< latest last
};

bool answer(int descriptor, const SolvedItem& solved) {
  const std::string result = result_line(solved.result);
  // Written in one piece, so that the reading process wakes up only once.
  return write_all(descriptor,
                   frame_line({result.size(), solved.solution.size()}) + result + solved.solution);
}

}  // namespace

std::string frame_line(const AnswerFrame& frame) {
  return fmt::format("{} {}\n", frame.result, frame.solution);
}

AnswerFrame parse_frame(std::string_view line) {
  AnswerFrame frame;
  const char* end = line.data() + line.size();
  const auto first = std::from_chars(line.data(), end, frame.result);
  if (first.ptr != end) std::from_chars(first.ptr + 1, end, frame.solution);
  return frame;
}

int serve_items(const std::filesystem::path& run, int requests, int answers) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  // The parent process handles these signals; queue systems send them to both.
  std::signal(SIGINT, SIG_IGN);
  std::signal(SIGTERM, SIG_IGN);
  std::signal(SIGUSR1, SIG_IGN);
  Diagnostics diagnostics;
  auto manifest = load_manifest(run, false, diagnostics);
  if (!manifest) return kUnreadable;
  limit_memory(manifest->limits.max_memory_mb);
  Worker worker(run, *std::move(manifest));
  std::FILE* input = ::fdopen(requests, "r");
  char* line = nullptr;
  std::size_t capacity = 0;
  for (ssize_t length; (length = ::getline(&line, &capacity, input)) > 0;) {
    const auto item = parse_manifest_line({line, static_cast<std::size_t>(length)});
    if (!item) return kUnreadable;
    SolvedItem solved;
    bool exhausted = false;
    try {
      solved = worker.solve(*item);
    } catch (const std::bad_alloc&) {
      exhausted = true;
      solved = Worker::failed(*item, kOutOfMemory, "the memory that an item may use is used up");
    } catch (const std::exception& error) {
      solved = Worker::failed(*item, kDefect, error.what());
    }
    // After std::bad_alloc the failed computation may have left the process short of memory.
    if (!answer(answers, solved)) return kUnreadable;
    if (exhausted) return kMemoryUsedUp;
  }
  std::free(line);
  return 0;
}

}  // namespace conddp
