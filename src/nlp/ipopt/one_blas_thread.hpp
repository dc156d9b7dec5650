#pragma once

namespace conddp {

/// While alive, limits a multithreaded OpenBLAS to one thread: sums depend on the number of
/// threads, and answers must not. Any other BLAS is left unchanged.
class OneBlasThread {
 public:
  OneBlasThread();
  ~OneBlasThread();
  OneBlasThread(const OneBlasThread&) = delete;
  OneBlasThread& operator=(const OneBlasThread&) = delete;

 private:
  int threads_before_ = 0;  ///< 0 if there is nothing to restore
};

}  // namespace conddp
