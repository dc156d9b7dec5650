#include "batch/cluster/program.hpp"

#include <cerrno>
#include <csignal>
#include <cstring>

#include <poll.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fmt/format.h>

#include "base/files/descriptor.hpp"
#include "batch/run/pipe.hpp"

extern char** environ;

namespace conddp {
namespace {

/// Reads available bytes; returns false at the end.
bool read_piece(int descriptor, std::string& text) {
  char buffer[4096];
  const ssize_t length = ::read(descriptor, buffer, sizeof buffer);
  if (length < 0) return errno == EINTR;
  text.append(buffer, static_cast<std::size_t>(length));
  return length > 0;
}

/// Reads both streams to their ends as data arrives.
void read_both(int out, int err, ProgramEnd& end) {
  pollfd polled[] = {{out, POLLIN, 0}, {err, POLLIN, 0}};
  std::string* texts[] = {&end.out, &end.err};
  while (polled[0].fd >= 0 || polled[1].fd >= 0) {
    if (::poll(polled, 2, -1) < 0 && errno != EINTR) return;
    for (int i = 0; i < 2; ++i)
      if (polled[i].revents != 0 && !read_piece(polled[i].fd, *texts[i])) polled[i].fd = -1;
  }
}

}  // namespace

ProgramEnd run_program(const std::vector<std::string>& words, std::string_view input) {
  Pipe in, out, err;
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, in.read_end(), 0);
  posix_spawn_file_actions_adddup2(&actions, out.write_end(), 1);
  posix_spawn_file_actions_adddup2(&actions, err.write_end(), 2);
  std::vector<char*> arguments;
  for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
  arguments.push_back(nullptr);
  pid_t process = -1;
  const int error =
      ::posix_spawnp(&process, arguments[0], &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  ProgramEnd end;
  if (error != 0) {
    end.err = fmt::format("'{}' cannot be started: {}", words.front(), std::strerror(error));
    return end;
  }
  in.close_read_end();
  out.close_write_end();
  err.close_write_end();
  // A program that does not read its input may already have ended.
  const auto former = std::signal(SIGPIPE, SIG_IGN);
  write_all(in.write_end(), input);
  std::signal(SIGPIPE, former);
  in.close_write_end();
  read_both(out.read_end(), err.read_end(), end);
  int status = 0;
  while (::waitpid(process, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFEXITED(status)) end.exit_status = WEXITSTATUS(status);
  return end;
}

}  // namespace conddp
