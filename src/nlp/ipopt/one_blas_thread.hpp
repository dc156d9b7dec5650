#pragma once

namespace conddp {

/// While it lives, products of an OpenBLAS that has threads use one: sums depend on how many share
/// them, and answers must not. Any other BLAS is left as it is.
class OneBlasThread {
 public:
  OneBlasThread();
  ~OneBlasThread();
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  int threads_before_ = 0;  ///< 0: there is nothing to put back
};

}  // namespace conddp
