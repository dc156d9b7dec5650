#include "batch/run/worker_process.hpp"

#include <algorithm>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <utility>

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/files/atomic_file.hpp"
#include "batch/run/pipe.hpp"

extern char** environ;

namespace conddp {
namespace {

void do_not_block(int descriptor) {
  ::fcntl(descriptor, F_SETFL, ::fcntl(descriptor, F_GETFL) | O_NONBLOCK);
}

/// Enlarges a pipe to hold complete answers, so that a worker need not wait for the reader. If the
/// system refuses, it waits.
void widen(int descriptor) {
  constexpr int kBytes = 1 << 20;
  ::fcntl(descriptor, F_SETPIPE_SZ, kBytes);
}

}  // namespace

WorkerProcess::WorkerProcess(const std::vector<std::string>& command) {
  Pipe requests, answers;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, requests.read_end(), 0);
  posix_spawn_file_actions_adddup2(&actions, answers.write_end(), 1);
  std::vector<char*> arguments;
  for (const std::string& word : command) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  const int error =
      ::posix_spawn(&process_, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  input_ = requests.release_write_end();
  output_ = answers.release_read_end();
  do_not_block(input_);
  do_not_block(output_);
  widen(output_);
  if (error == 0) return;
  process_ = -1;
  throw OutputError(fmt::format("no worker can be started: {}", std::strerror(error)));
}

WorkerProcess::~WorkerProcess() {
  reap(true);
  ::close(input_);
  ::close(output_);
}

void WorkerProcess::send(const Request& request, std::string line) {
  if (unanswered_.empty()) since_ = Clock::now();
  unanswered_.push_back(request);
  sent_.push_back(request.item);
  unsent_ += std::move(line) + '\n';
  write_some();
}

bool WorkerProcess::has_had(std::size_t item, std::size_t count) const {
  const auto last = sent_.end() - static_cast<std::ptrdiff_t>(std::min(count, sent_.size()));
  return std::find(last, sent_.end(), item) != sent_.end();
}

void WorkerProcess::write_some() {
  while (!unsent_.empty()) {
    const ssize_t written = ::write(input_, unsent_.data(), unsent_.size());
    if (written < 0 && errno == EINTR) continue;
    // The end of a process is detected when reading its answers.
    if (written < 0 && errno != EAGAIN) unsent_.clear();
    if (written < 0) return;
    unsent_.erase(0, static_cast<std::size_t>(written));
  }
}

bool WorkerProcess::read_some() {
  unread_.erase(0, std::exchange(taken_, 0));
  char buffer[1 << 16];
  for (;;) {
    const ssize_t length = ::read(output_, buffer, sizeof buffer);
    if (length > 0) {
      unread_.append(buffer, static_cast<std::size_t>(length));
      continue;
    }
    if (length < 0 && errno == EINTR) continue;
    return length < 0 && errno == EAGAIN;
  }
}

std::optional<WorkerProcess::Answer> WorkerProcess::take_answer() {
  const std::string_view left = std::string_view(unread_).substr(taken_);
  const std::size_t end = left.find('\n');
  if (end == left.npos || unanswered_.empty()) return std::nullopt;
  const AnswerFrame frame = parse_frame(left.substr(0, end));
  const std::size_t first = end + 1;
  if (left.size() < first + frame.result + frame.solution) return std::nullopt;
  const Answer answer{left.substr(first, frame.result),
                      left.substr(first + frame.result, frame.solution)};
  taken_ += first + frame.result + frame.solution;
  unanswered_.pop_front();
  since_ = Clock::now();
  return answer;
}

WorkerProcess::End WorkerProcess::reap(bool kill) {
  if (process_ < 0) return {};
  if (kill) ::kill(process_, SIGKILL);
  int status = 0;
  while (::waitpid(process_, &status, 0) < 0 && errno == EINTR) {
  }
  process_ = -1;
  if (WIFSIGNALED(status))
    return {fmt::format("signal {} ({})", WTERMSIG(status), ::strsignal(WTERMSIG(status)))};
  return {fmt::format("exit status {}", WEXITSTATUS(status)), WEXITSTATUS(status)};
}

}  // namespace conddp
