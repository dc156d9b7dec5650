#pragma once

namespace conddp {

/// During its lifetime, SIGINT and SIGTERM are recorded instead of ending the process. The running
/// work then ends and its answer is written, also after the guard's end. If that takes longer than
/// five seconds, the process ends without it, and files that were to be replaced are unchanged. A
/// second signal of the same kind ends the process at once.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// The received signal, 0 without one.
  static int signal();
};

}  // namespace conddp
