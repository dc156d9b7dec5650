#include "nlp/ipopt/repeatable_algebra.hpp"

#include <dlfcn.h>

namespace conddp {
namespace {

/// A function of what came with Ipopt; null where that has none of this name. Which BLAS it is, the
/// system decides when it is loaded.
template <class Function>
Function* loaded_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

RepeatableAlgebra::RepeatableAlgebra() {
  if (const auto begin_again = loaded_function<void()>("SCOTCH_randomReset")) begin_again();
  const auto get = loaded_function<int()>("openblas_get_num_threads");
  const auto set = loaded_function<void(int)>("openblas_set_num_threads");
  if (get == nullptr || set == nullptr || get() == 1) return;
  threads_before_ = get();
  set(1);
}

RepeatableAlgebra::~RepeatableAlgebra() {
  if (threads_before_ > 0) loaded_function<void(int)>("openblas_set_num_threads")(threads_before_);
}

}  // namespace conddp
