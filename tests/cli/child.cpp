#include "child.hpp"

#include <cstdlib>
#include <stdexcept>

#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

namespace conddp {
namespace {

constexpr const char* kBinary = CONDDP_BINARY;

[[noreturn]] void become_conddp(const std::vector<std::string>& arguments,
                                const std::vector<std::string>& environment) {
  for (const std::string& entry : environment) {
    const std::size_t equals = entry.find('=');
    setenv(entry.substr(0, equals).c_str(), entry.substr(equals + 1).c_str(), 1);
  }
  std::vector<char*> argv{const_cast<char*>(kBinary)};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(kBinary, argv.data());
  _exit(121);
}

}  // namespace

std::string conddp_binary() { return kBinary; }

Channel open_pipe() {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  return {ends[0], ends[1]};
}

pid_t start_conddp(const std::vector<std::string>& arguments,
                   const std::vector<std::string>& environment, const Channel& out,
                   const Channel& err, const std::function<void()>& prepare) {
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) {
    prepare();
    dup2(out.theirs, 1);
    dup2(err.theirs, 2);
    for (int number = 3; number < 256; ++number) close(number);
    become_conddp(arguments, environment);
  }
  close(out.theirs);
  close(err.theirs);
  return child;
}

ProcessResult collect_child(pid_t child, const Channel& out, const Channel& err,
                            const std::function<void(const ProcessResult&)>& on_text) {
  ProcessResult result;
  pollfd streams[2] = {{out.ours, POLLIN, 0}, {err.ours, POLLIN, 0}};
  std::string* const texts[2] = {&result.out, &result.err};
  while (streams[0].fd >= 0 || streams[1].fd >= 0) {
    if (poll(streams, 2, 60'000) <= 0) {
      kill(child, SIGKILL);
      break;
    }
    for (int i = 0; i < 2; ++i) {
      if (streams[i].fd < 0 || streams[i].revents == 0) continue;
      char buffer[4096];
      const ssize_t n = read(streams[i].fd, buffer, sizeof buffer);
      if (n <= 0)
        streams[i].fd = -1;
      else
        texts[i]->append(buffer, static_cast<std::size_t>(n));
    }
    on_text(result);
  }
  int status = 0;
  waitpid(child, &status, 0);
  close(out.ours);
  close(err.ours);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace conddp
