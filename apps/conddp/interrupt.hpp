#pragma once

namespace conddp {

/// While it lives, SIGINT and SIGTERM are remembered instead of ending the process. A second one of
/// the same kind ends it at once.
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
