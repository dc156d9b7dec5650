#include "terminal/heap.hpp"

#include <cstdint>
#include <cstdlib>

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

namespace conddp {
namespace {

constexpr std::size_t kFirstPart = 64 << 20;  // bytes
constexpr std::size_t kLaterParts = 1 << 20;
constexpr std::size_t kHugePage = 2 << 20;
/// What is freed at the end of the heap beyond this goes back to the system.
constexpr int kKept = 1 << 30;
/// Blocks from this size on get addresses of their own; the largest value that glibc allows.
constexpr int kOwnAddresses = 32 << 20;

std::uintptr_t heap_end() { return reinterpret_cast<std::uintptr_t>(::sbrk(0)); }

}  // namespace

void prepare_heap() {
  ::mallopt(M_MMAP_THRESHOLD, kOwnAddresses);
  ::mallopt(M_TRIM_THRESHOLD, kKept);
  const std::uintptr_t before = heap_end();
  ::mallopt(M_TOP_PAD, kFirstPart);
  void* volatile block = std::malloc(kLaterParts);  // more than is left: the heap grows
  std::free(block);
  ::mallopt(M_TOP_PAD, kLaterParts);
  const std::uintptr_t after = heap_end();
  const std::uintptr_t first = (before + kHugePage - 1) / kHugePage * kHugePage;
  const std::uintptr_t last = after / kHugePage * kHugePage;
  // Where the system has no huge pages the heap is as good as before.
  if (first < last) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
}

}  // namespace conddp
