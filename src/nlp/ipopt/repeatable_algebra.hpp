#pragma once

namespace conddp {

/// While it lives, the linear algebra below Ipopt gives the same bits as whenever another one
/// lives. Products of an OpenBLAS that has threads use one: sums depend on how many share them. Any
/// other BLAS is left as it is. SCOTCH, which orders systems, begins with the same random numbers:
/// they otherwise go on from where the solve before ended.
class RepeatableAlgebra {
 public:
  RepeatableAlgebra();
  ~RepeatableAlgebra();
  RepeatableAlgebra(const RepeatableAlgebra&) = delete;
  RepeatableAlgebra& operator=(const RepeatableAlgebra&) = delete;

 private:
  int threads_before_ = 0;  ///< 0: there is nothing to put back
};

}  // namespace conddp
