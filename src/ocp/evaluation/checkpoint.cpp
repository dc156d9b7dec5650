#include "ocp/evaluation/checkpoint.hpp"

#include <utility>

namespace conddp {
namespace {

/// The initial-exec model lets objects without -fPIC be part of a shared library, the Python
/// module.
[[gnu::tls_model("initial-exec")]] thread_local CheckpointScope* innermost = nullptr;

}  // namespace

CheckpointScope::CheckpointScope(std::function<void()> check)
    : check_(std::move(check)), outer_(std::exchange(innermost, this)) {}

CheckpointScope::~CheckpointScope() { innermost = outer_; }

void pass_checkpoint() {
  if (innermost != nullptr) innermost->check_();
}

}  // namespace conddp
