#include "interrupt.hpp"

#include <csignal>

namespace conddp {
namespace {

volatile std::sig_atomic_t g_signal = 0;

extern "C" void remember_signal(int number) { g_signal = number; }

void install(int number) {
  struct sigaction action {};
  action.sa_handler = remember_signal;
  sigemptyset(&action.sa_mask);
  action.sa_flags = SA_RESETHAND;  // the next one has its usual effect
  sigaction(number, &action, nullptr);
}

}  // namespace

InterruptGuard::InterruptGuard() {
  g_signal = 0;
  install(SIGINT);
  install(SIGTERM);
}

InterruptGuard::~InterruptGuard() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

int InterruptGuard::signal() { return g_signal; }

}  // namespace conddp
