#include "pseudo_terminal.hpp"

#include <cstdlib>
#include <stdexcept>

#include <poll.h>
#include <pty.h>
#include <signal.h>
#include <sys/ioctl.h>
#include <sys/wait.h>
#include <termios.h>
#include <unistd.h>

namespace conddp {
namespace {

struct Ends {
  int ours = -1;
  int theirs = -1;
};

Ends open_terminal(int columns) {
  winsize size{};
  size.ws_row = 40;
  size.ws_col = static_cast<unsigned short>(columns);
  Ends ends;
  termios mode{};
  if (openpty(&ends.ours, &ends.theirs, nullptr, nullptr, &size) != 0 ||
      tcgetattr(ends.theirs, &mode) != 0)
    throw std::runtime_error("no pseudo-terminal");
  mode.c_oflag &= ~static_cast<tcflag_t>(OPOST);
  mode.c_lflag &= ~static_cast<tcflag_t>(ECHO | ECHOCTL);
  tcsetattr(ends.theirs, TCSANOW, &mode);
  return ends;
}

Ends open_pipe() {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("no pipe");
  return {ends[0], ends[1]};
}

[[noreturn]] void become_conddp(const std::vector<std::string>& arguments,
                                const TerminalOptions& options, int control, int out, int err) {
  setsid();
  ioctl(control, TIOCSCTTY, 0);
  dup2(control, 0);
  dup2(out, 1);
  dup2(err, 2);
  for (int number = 3; number < 256; ++number) close(number);
  for (const std::string& entry : options.environment) {
    const std::size_t equals = entry.find('=');
    setenv(entry.substr(0, equals).c_str(), entry.substr(equals + 1).c_str(), 1);
  }
  std::vector<char*> argv{const_cast<char*>(CONDDP_BINARY)};
  for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
  argv.push_back(nullptr);
  execv(CONDDP_BINARY, argv.data());
  _exit(121);
}

}  // namespace

ProcessResult run_in_terminal(const std::vector<std::string>& arguments,
                              const TerminalOptions& options) {
  const Ends control = open_terminal(options.columns);
  const Ends out = options.out ? open_terminal(options.columns) : open_pipe();
  const Ends err = options.err ? open_terminal(options.columns) : open_pipe();
  const pid_t child = fork();
  if (child < 0) throw std::runtime_error("no process");
  if (child == 0) become_conddp(arguments, options, control.theirs, out.theirs, err.theirs);
  for (const int end : {control.theirs, out.theirs, err.theirs}) close(end);
  ProcessResult result;
  pollfd streams[2] = {{out.ours, POLLIN, 0}, {err.ours, POLLIN, 0}};
  std::string* const texts[2] = {&result.out, &result.err};
  bool typed = options.typed.empty();
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
    if (!typed && result.err.find(options.type_after) != std::string::npos) {
      typed = true;
      if (write(control.ours, options.typed.data(), options.typed.size()) < 0)
        throw std::runtime_error("nothing can be typed");
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  for (const int end : {control.ours, out.ours, err.ours}) close(end);
  result.exit_code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  return result;
}

}  // namespace conddp
