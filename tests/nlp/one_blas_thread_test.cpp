#include "nlp/one_blas_thread.hpp"

#include <dlfcn.h>

#include <gtest/gtest.h>

namespace conddp {
namespace {

/// The program or shared library that an address belongs to.
const void* place_of(const void* address) {
  Dl_info info{};
  return dladdr(address, &info) != 0 ? info.dli_fbase : nullptr;
}

TEST(OneBlasThread, ProductsOfBlasAreThoseOfTheSystem) {
  const void* product = dlsym(RTLD_DEFAULT, "dgemm_");
  ASSERT_NE(product, nullptr);
  EXPECT_NE(place_of(product), place_of(reinterpret_cast<const void*>(&place_of)));
}

TEST(OneBlasThread, AnOpenBlasUsesOneThreadWhileItLives) {
  const auto threads = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  if (threads == nullptr) GTEST_SKIP() << "the system's BLAS is another one";
  const int before = threads();
  {
    const OneBlasThread one_thread;
    EXPECT_EQ(threads(), 1);
  }
  EXPECT_EQ(threads(), before);
}

}  // namespace
}  // namespace conddp
