#include "terminal/streams.hpp"

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>

#include <fcntl.h>

#include "base/text/utf8.hpp"

namespace conddp {
namespace {

int g_result_error = 0;

void remember(bool failed) {
  if (failed && g_result_error == 0) g_result_error = errno;
}

}  // namespace

void prepare_streams() {
  // Writing then fails with an error that gives the reason.
  std::signal(SIGPIPE, SIG_IGN);
  std::signal(SIGXFSZ, SIG_IGN);
  // open() returns the lowest free number. Descriptors 1 and 2 are opened for reading only, so that
  // writing fails.
  for (int descriptor = 0; descriptor <= 2; ++descriptor)
    if (::fcntl(descriptor, F_GETFD) == -1 && errno == EBADF) (void)::open("/dev/null", O_RDONLY);
}

void print_result(std::string_view text) { print_as_it_is(terminal_text(text)); }

void print_as_it_is(std::string_view text) {
  remember(std::fwrite(text.data(), 1, text.size(), stdout) != text.size());
}

void print_message(std::string_view text) {
  std::fwrite(text.data(), 1, text.size(), stderr);
  std::fflush(stderr);
}

const char* finish_results() {
  remember(std::fflush(stdout) != 0);
  return g_result_error == 0 || g_result_error == EPIPE ? nullptr : std::strerror(g_result_error);
}

}  // namespace conddp
