#include "pseudo_terminal.hpp"

#include <stdexcept>

#include <pty.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include "child.hpp"

namespace conddp {
namespace {

Channel open_terminal(int columns) {
  winsize size{};
  size.ws_row = 40;
  size.ws_col = static_cast<unsigned short>(columns);
  Channel ends;
  termios mode{};
  if (openpty(&ends.ours, &ends.theirs, nullptr, nullptr, &size) != 0 ||
      tcgetattr(ends.theirs, &mode) != 0)
    throw std::runtime_error("no pseudo-terminal");
  mode.c_oflag &= ~static_cast<tcflag_t>(OPOST);
  mode.c_lflag &= ~static_cast<tcflag_t>(ECHO | ECHOCTL);
  tcsetattr(ends.theirs, TCSANOW, &mode);
  return ends;
}

}  // namespace

ProcessResult run_in_terminal(const std::vector<std::string>& arguments,
                              const TerminalOptions& options) {
  const Channel control = open_terminal(options.columns);
  const Channel out = options.out ? open_terminal(options.columns) : open_pipe();
  const Channel err = options.err ? open_terminal(options.columns) : open_pipe();
  const pid_t child = start_conddp(arguments, options.environment, out, err, [&] {
    setsid();
    ioctl(control.theirs, TIOCSCTTY, 0);
    dup2(control.theirs, 0);
  });
  close(control.theirs);
  bool typed = options.typed.empty();
  const ProcessResult result = collect_child(child, out, err, [&](const ProcessResult& so_far) {
    if (typed || so_far.err.find(options.type_after) == std::string::npos) return;
    typed = true;
    if (write(control.ours, options.typed.data(), options.typed.size()) < 0)
      throw std::runtime_error("nothing can be typed");
  });
  close(control.ours);
  return result;
}

}  // namespace conddp
