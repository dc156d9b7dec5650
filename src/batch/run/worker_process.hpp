#pragma once

#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <sys/types.h>

#include "batch/run/worker.hpp"

namespace conddp {

/// A process that solves items (serve_items), seen from the one that started it. Descriptors do not
/// block; the caller polls them.
class WorkerProcess {
 public:
  using Clock = std::chrono::steady_clock;

  /// An item that was sent, by its number for the caller.
  struct Request {
    std::size_t item = 0;
    bool again = false;  ///< solved for those that start from it alone: its result is known
  };
  /// An answer as it came through the pipe, until the next read_some().
  struct Answer {
    std::string_view result, solution;
  };

  /// Starts a command whose standard input and output become the pipes. Throws OutputError where no
  /// process can be started.
  explicit WorkerProcess(const std::vector<std::string>& command);
  /// Kills the process if it still runs.
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  int input() const { return input_; }
  int output() const { return output_; }
  bool wants_to_write() const { return !unsent_.empty(); }

  /// Sends an item with its line of the manifest.
  void send(const Request& request, std::string line);
  /// Whether an item is among the last `count` that were sent.
  bool has_had(std::size_t item, std::size_t count) const;
  void write_some();
  /// Reads what is there. False once the process has closed its end.
  bool read_some();
  /// The next whole answer; nothing if there is none yet.
  std::optional<Answer> take_answer();

  /// Items that were sent and are not answered, the one under way first.
  const std::deque<Request>& unanswered() const { return unanswered_; }
  /// Since when the first of them is under way.
  Clock::time_point since() const { return since_; }
  /// How a process ended.
  struct End {
    std::string cause;     ///< "signal 6 (Aborted)"
    int exit_status = -1;  ///< −1 after a signal
  };
  /// Waits for the end of the process, or brings it about.
  End reap(bool kill);

 private:
  pid_t process_ = -1;
  int input_ = -1, output_ = -1;
  std::string unsent_, unread_;
  std::size_t taken_ = 0;  ///< bytes at the beginning of unread_
  std::deque<Request> unanswered_;
  std::vector<std::size_t> sent_;
  Clock::time_point since_;
};

}  // namespace conddp
