#include "nlp/ipopt/one_blas_thread.hpp"

#include <dlfcn.h>

namespace conddp {
namespace {

/// A function of the BLAS loaded with Ipopt; null if the BLAS lacks a function of this name. The
/// system chooses the BLAS at load time.
template <class Function>
Function* blas_function(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

OneBlasThread::OneBlasThread() {
  const auto get = blas_function<int()>("openblas_get_num_threads");
  const auto set = blas_function<void(int)>("openblas_set_num_threads");
  if (get == nullptr || set == nullptr || get() == 1) return;
  threads_before_ = get();
  set(1);
}

OneBlasThread::~OneBlasThread() {
  if (threads_before_ > 0) blas_function<void(int)>("openblas_set_num_threads")(threads_before_);
}

}  // namespace conddp
