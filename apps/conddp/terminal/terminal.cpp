#include "terminal/terminal.hpp"

#include <cstdlib>
#include <string_view>

#include <sys/ioctl.h>
#include <unistd.h>

#include "terminal/environment.hpp"

namespace conddp {

Terminal terminal_of(int descriptor) {
  Terminal terminal{.is_tty = ::isatty(descriptor) != 0};
  if (!terminal.is_tty) return terminal;
  const auto variable = [](const EnvironmentInfo& info) {
    const char* value = std::getenv(info.name);
    return std::string_view(value == nullptr ? "" : value);
  };
  terminal.redraws = variable(kTerm) != "dumb" && !variable(kTerm).empty();
  terminal.colour = terminal.redraws && variable(kNoColor).empty();
  winsize size{};
  if (::ioctl(descriptor, TIOCGWINSZ, &size) == 0 && size.ws_col > 0) terminal.width = size.ws_col;
  return terminal;
}

}  // namespace conddp
