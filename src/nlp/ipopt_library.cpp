#include "nlp/ipopt_library.hpp"

#include "base/shared_library.hpp"

namespace conddp {

const IpoptLibrary& ipopt_library() {
  constexpr const char* kFromTool = "$ORIGIN/" CONDDP_MODULES_FROM_TOOL "/" CONDDP_IPOPT_MODULE;
  // A RUNPATH would do for the first, too, but the linker would look there for every other library
  // of every program. Programs that use the installed package have one.
  static const SharedLibrary library("the solver 'ipopt'", {kFromTool, CONDDP_IPOPT_MODULE});
  static const auto* const functions =
      static_cast<const IpoptLibrary*>(library.symbol("conddp_ipopt_library"));
  return *functions;
}

}  // namespace conddp
