#include "nlp/ipopt_library.hpp"

#include "base/shared_library.hpp"

namespace conddp {

const IpoptLibrary& ipopt_library() {
  static const SharedLibrary library("the solver 'ipopt'", CONDDP_IPOPT_MODULE);
  static const auto* const functions =
      static_cast<const IpoptLibrary*>(library.symbol("conddp_ipopt_library"));
  return *functions;
}

}  // namespace conddp
