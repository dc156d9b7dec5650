// A library to be loaded before a program (LD_PRELOAD): when the program ends it says on stderr how
// often memory was allocated.
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
