#include "nlp/ipopt_library.hpp"

#include <filesystem>
#include <string>

#include <fmt/format.h>

#include "base/shared_library.hpp"

namespace conddp {
namespace {

/// Path of the module, relative to this program. The linker's $ORIGIN refers to the object that
/// calls dlopen; under sanitizers, that is their library.
std::string module_of_this_program() {
  std::error_code error;
  const std::filesystem::path program = std::filesystem::read_symlink("/proc/self/exe", error);
  const auto module = program.parent_path() / CONDDP_MODULES_FROM_TOOL / CONDDP_IPOPT_MODULE;
  return module.lexically_normal().string();
}

SharedLibrary load() {
  const std::string own = module_of_this_program();
  try {
    // A RUNPATH could replace the first path, but the linker would also search it for all other
    // libraries of all programs. Programs that use the installed package have a RUNPATH.
    return SharedLibrary("the solver 'ipopt'", {own.c_str(), CONDDP_IPOPT_MODULE});
  } catch (const LibraryError& error) {
    throw LibraryError(fmt::format("{}; it is expected as '{}'", error.what(), own));
  }
}

}  // namespace

const IpoptLibrary& ipopt_library() {
  static const SharedLibrary library = load();
  static const auto* const functions =
      static_cast<const IpoptLibrary*>(library.symbol("conddp_ipopt_library"));
  return *functions;
}

}  // namespace conddp
