#pragma once

#include <atomic>

#include "support/counted_malloc.hpp"

// For one source of a test program: `allocations` counts on any thread while `counting` is set.

namespace {
std::atomic<bool> counting{false};
std::atomic<long> allocations{0};
}  // namespace

void conddp::testing::count_allocation() {
  if (counting.load(std::memory_order_relaxed)) allocations.fetch_add(1);
}
