#include "ocp/evaluation/checkpoint.hpp"

#include <utility>

namespace conddp {
namespace {

thread_local CheckpointScope* innermost = nullptr;

}  // namespace

CheckpointScope::CheckpointScope(std::function<void()> check)
    : check_(std::move(check)), outer_(std::exchange(innermost, this)) {}

CheckpointScope::~CheckpointScope() { innermost = outer_; }

void pass_checkpoint() {
  if (innermost != nullptr) innermost->check_();
}

}  // namespace conddp
