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

/// A process that solves items (serve_items), from the view of its parent. Descriptors do not
/// block; the caller polls them.
class WorkerProcess {
 public:
  using Clock = std::chrono::steady_clock;

  /// A sent item, by the caller's index.
  struct Request {
    std::size_t item = 0;
    bool again = false;  ///< solved only for the items that start from it; its result is known
  };
  /// An answer read from the pipe, valid until the next read_some().
  struct Answer {
    std::string_view result, solution;
  };

  /// Starts a command with pipes as standard input and output. Throws OutputError if the process
  /// cannot be started.
  explicit WorkerProcess(const std::vector<std::string>& command);
  /// Kills the process if it is still running.
  ~WorkerProcess();
  WorkerProcess(const WorkerProcess&) = delete;
  WorkerProcess& operator=(const WorkerProcess&) = delete;

  int input() const { return input_; }
  int output() const { return output_; }
  bool wants_to_write() const { return !unsent_.empty(); }

  /// Sends an item with its line of the manifest.
  void send(const Request& request, std::string line);
  /// True if an item is among the last `count` sent ones.
  bool has_had(std::size_t item, std::size_t count) const;
  void write_some();
  /// Reads available data. Returns false once the process has closed its end.
  bool read_some();
  /// The next complete answer; nothing if none has arrived.
  std::optional<Answer> take_answer();

  /// Sent items without an answer; the current one is first.
  const std::deque<Request>& unanswered() const { return unanswered_; }
  /// Start time of the current item.
  Clock::time_point since() const { return since_; }
  /// The end of a process.
  struct End {
    std::string cause;     ///< "signal 6 (Aborted)"
    int exit_status = -1;  ///< −1 after a signal
  };
  /// Waits until the process ends; kills it first if requested.
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
