#include "nlp/ipopt_library.hpp"

#include <filesystem>
#include <string>

#include "base/shared_library.hpp"

namespace conddp {
namespace {

/// Where the module is beside this program. Not by the linker's $ORIGIN, which means the object
/// that calls dlopen: under sanitizers that is their library.
std::string module_of_this_program() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  return (program.parent_path() / CONDDP_MODULES_FROM_TOOL / CONDDP_IPOPT_MODULE).string();
}

}  // namespace

const IpoptLibrary& ipopt_library() {
  // A RUNPATH would do for the first, too, but the linker would look there for every other library
  // of every program. Programs that use the installed package have one.
  static const SharedLibrary library("the solver 'ipopt'",
                                     {module_of_this_program().c_str(), CONDDP_IPOPT_MODULE});
  static const auto* const functions =
      static_cast<const IpoptLibrary*>(library.symbol("conddp_ipopt_library"));
  return *functions;
}

}  // namespace conddp
