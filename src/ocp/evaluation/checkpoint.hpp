#pragma once

#include <exception>
#include <functional>

namespace conddp {

/// Maximum number of knots that a long loop processes between two checkpoints, so that horizons of
/// any length react to signals and time limits promptly. Shorter loops pass no checkpoint.
inline constexpr int kKnotsBetweenCheckpoints = 1024;

/// Thrown by a checkpoint to abandon the running computation. Results being written are then
/// unspecified; inputs are unchanged.
struct Abandoned : std::exception {
  const char* what() const noexcept override { return "abandoned at a checkpoint"; }
};

/// During its lifetime, checkpoints that this thread passes call `check`, which may throw
/// Abandoned. The innermost scope applies.
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

/// Called by loops over knots, in the thread that started them.
void pass_checkpoint();

}  // namespace conddp
