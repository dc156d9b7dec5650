#include "terminal/heap.hpp"

#include <cstdint>
#include <cstdlib>
#include <new>

#include <malloc.h>
#include <sys/mman.h>
#include <unistd.h>

namespace conddp {
namespace {

constexpr std::size_t kFirstPart = 64 << 20;  // bytes
constexpr std::size_t kLaterParts = 1 << 20;
constexpr std::size_t kHugePage = 2 << 20;
/// Freed memory at the end of the heap beyond this size returns to the system.
constexpr int kKept = 1 << 30;
/// Blocks of at least this size get separate mappings; the largest value that glibc allows.
constexpr int kOwnAddresses = 32 << 20;

std::uintptr_t heap_end() { return reinterpret_cast<std::uintptr_t>(::sbrk(0)); }

}  // namespace

void prepare_heap() {
  ::mallopt(M_MMAP_THRESHOLD, kOwnAddresses);
  ::mallopt(M_TRIM_THRESHOLD, kKept);
  const std::uintptr_t before = heap_end();
  ::mallopt(M_TOP_PAD, kFirstPart);
  void* volatile block = std::malloc(kLaterParts);  // larger than the rest: the heap grows
  std::free(block);
  ::mallopt(M_TOP_PAD, kLaterParts);
  const std::uintptr_t after = heap_end();
  const std::uintptr_t first = (before + kHugePage - 1) / kHugePage * kHugePage;
  const std::uintptr_t last = after / kHugePage * kHugePage;
  // Without huge pages, the heap works as before.
  if (first < last) ::madvise(reinterpret_cast<void*>(first), last - first, MADV_HUGEPAGE);
}

}  // namespace conddp

// The C library cuts aligned blocks out of larger ones, which takes longer than plain blocks and
// fragments the heap. Here they lie in plain blocks; the pointer to the plain block precedes the
// returned address. That address is at least 16 bytes into the block, because requested alignments
// are multiples of 32 and plain blocks are aligned to 16.

void* operator new(std::size_t size, std::align_val_t alignment) {
  const auto step = static_cast<std::size_t>(alignment);
  void* const block = ::operator new(size + step);
  const auto place = (reinterpret_cast<std::uintptr_t>(block) + step) & ~(step - 1);
  reinterpret_cast<void**>(place)[-1] = block;
  return reinterpret_cast<void*>(place);
}

void operator delete(void* place, std::align_val_t) noexcept {
  if (place != nullptr) ::operator delete(static_cast<void**>(place)[-1]);
}

void operator delete(void* place, std::size_t, std::align_val_t alignment) noexcept {
  ::operator delete(place, alignment);
}
