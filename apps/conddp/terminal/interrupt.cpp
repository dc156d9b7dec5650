#include "terminal/interrupt.hpp"

#include <csignal>
#include <string_view>

#include <sys/time.h>
#include <unistd.h>

#include "terminal/exit_codes.hpp"

namespace conddp {
namespace {

volatile std::sig_atomic_t g_signal = 0;

/// Time after a signal for the end of an iteration, the certificate and the files, s.
constexpr int kGrace = 5;

void install(int number, void (*handler)(int)) {
  struct sigaction action {};
  action.sa_handler = handler;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESETHAND;  // the next signal has its usual effect
  sigaction(number, &action, nullptr);
}

extern "C" void give_up(int) {
  constexpr std::string_view kText = "conddp: interrupted; there was no time to write an answer\n";
  [[maybe_unused]] const auto written = write(2, kText.data(), kText.size());
  _exit(kExitSignalBase + g_signal);
}

/// Calls only async-signal-safe functions.
extern "C" void remember_signal(int number) {
  g_signal = number;
  install(SIGALRM, give_up);
  itimerval grace{};
  grace.it_value.tv_sec = kGrace;
  setitimer(ITIMER_REAL, &grace, nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  g_signal = 0;
  install(SIGINT, remember_signal);
  install(SIGTERM, remember_signal);
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

int InterruptGuard::signal() { return g_signal; }

}  // namespace conddp
