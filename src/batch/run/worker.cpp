#include "batch/run/worker.hpp"

#include <cerrno>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <new>
#include <thread>
#include <vector>

#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/write_all.hpp"
#include "batch/plan/run_folder.hpp"
#include "batch/run/solve_item.hpp"

namespace conddp {
namespace {

/// The environment variable by which tests let items fail: `crash:ID`, `hang:ID` or `memory:ID`.
constexpr const char* kFaultVariable = "CONDDP_BATCH_FAULT";

constexpr int kUnreadable = 2;  ///< exit status

void provoke_fault(const std::string& id) {
  const char* fault = std::getenv(kFaultVariable);
  if (fault == nullptr) return;
  const std::string_view wanted = fault;
  if (wanted == "crash:" + id) std::abort();
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

/// Solves items of one run; families are loaded when their first item comes.
class Worker {
 public:
  Worker(std::filesystem::path run, Manifest manifest)
      : run_(std::move(run)), manifest_(std::move(manifest)) {}

  SolvedItem solve(const ManifestItem& item) {
    provoke_fault(item.id);
    const ManifestProblem& problem = manifest_.problems.at(item.problem);
    auto& family = families_[item.problem];
    Diagnostics diagnostics;
    if (!family)
      family = ProblemFamily::load(problem_of_run(manifest_, item.problem, run_), {}, diagnostics);
    if (family) return solve_item(item, problem, *family, manifest_.keep);
    return failed(item, kUnsolvable, "its problem file cannot be read any more");
  }

  static SolvedItem failed(const ManifestItem& item, std::string_view status,
                           const std::string& message) {
    return {{.id = item.id,
             .status = std::string(status),
             .answer = {{"message", message}},
             .times = OrderedJson::object()},
            {}};
  }

 private:
  const std::filesystem::path run_;
  const Manifest manifest_;
  std::map<int, std::shared_ptr<const ProblemFamily>> families_;
};

bool answer(int descriptor, const SolvedItem& solved) {
  const std::string result = result_line(solved.result);
  return write_all(descriptor, frame_line({result.size(), solved.solution.size()})) &&
         write_all(descriptor, result) && write_all(descriptor, solved.solution);
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
  std::signal(SIGINT, SIG_IGN);  // the process that started this one decides
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
    // What was being computed may have left the process short of memory.
    if (!answer(answers, solved)) return kUnreadable;
    if (exhausted) return kMemoryUsedUp;
  }
  std::free(line);
  return 0;
}

}  // namespace conddp
