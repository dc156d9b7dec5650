#pragma once

#include <exception>
#include <functional>

namespace conddp {

/// How many knots a long loop may do between two checkpoints, so that horizons of any length hear
/// of signals and time limits in time. Shorter ones meet no checkpoint at all.
inline constexpr int kKnotsBetweenCheckpoints = 1024;

/// Thrown by a checkpoint to give up what is under way. Results that were being written then are
/// unspecified; what was an input is as it was.
struct Abandoned : std::exception {
  const char* what() const noexcept override { return "abandoned at a checkpoint"; }
};

/// While it lives, checkpoints that this thread passes call `check`, which may throw Abandoned. The
/// innermost one counts.
class CheckpointScope {
 public:
  explicit CheckpointScope(std::function<void()> check);
  ~CheckpointScope();
  CheckpointScope(const CheckpointScope&) = delete;
  CheckpointScope& operator=(const CheckpointScope&) = delete;

 private:
  friend void pass_checkpoint();
  std::function<void()> check_;
  CheckpointScope* outer_;
};

/// Called by loops over knots, in the thread that began them.
void pass_checkpoint();

}  // namespace conddp
