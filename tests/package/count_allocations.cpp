// Library for LD_PRELOAD: at program exit it prints the number of allocations on stderr.
#include <atomic>
#include <cstdio>

#include "../support/counted_malloc.hpp"

namespace {

std::atomic<long> g_allocations{0};

struct Report {
  ~Report() { std::fprintf(stderr, "allocations: %ld\n", g_allocations.load()); }
} const g_report;

}  // namespace

void conddp::testing::count_allocation() { ++g_allocations; }
