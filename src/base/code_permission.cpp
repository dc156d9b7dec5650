#include "base/code_permission.hpp"

#include <atomic>

namespace conddp {
namespace {

std::atomic<bool> g_allowed = false;

}  // namespace

bool code_is_allowed() { return g_allowed; }
void allow_code() { g_allowed = true; }

}  // namespace conddp
