#pragma once

namespace conddp {

/// While it lives, SIGINT and SIGTERM are remembered instead of ending the process: what is under
/// way is ended and its answer written, also after the guard's end. Where that takes longer than
/// five seconds, the process ends without; files that were to be replaced are then as they were. A
/// second signal of the same kind ends it at once.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

  /// The signal that came, 0 if none did.
  static int signal();
};

}  // namespace conddp
