#pragma once

#include <cstddef>
#include <new>
#include <vector>

namespace conddp {

/// Allocates on cache-line boundaries, so that lanes and vectorized matrices never straddle a cache
/// line.
template <class T>
struct CacheAligned {
  using value_type = T;
  CacheAligned() = default;
  template <class U>
  CacheAligned(const CacheAligned<U>&) {}  // NOLINT(google-explicit-constructor)

  T* allocate(std::size_t n) {
    return static_cast<T*>(::operator new(n * sizeof(T), std::align_val_t(64)));
  }
  void deallocate(T* p, std::size_t) { ::operator delete(p, std::align_val_t(64)); }
  friend bool operator==(CacheAligned, CacheAligned) { return true; }
};

/// Workspace storage: sized once, aligned to cache lines.
template <class T>
using AlignedVector = std::vector<T, CacheAligned<T>>;

}  // namespace conddp
