#include "nlp/ipopt_library.hpp"

#include <filesystem>
#include <mutex>

#include <fmt/format.h>

#include "base/shared_library.hpp"
#include "nlp/interior_point.hpp"
#include "nlp/ipopt_options.hpp"

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

InteriorPointAnswer minimise(NonlinearProgram& program, const Eigen::VectorXd& start,
                             const InteriorPointSettings& settings,
                             const std::function<bool(const InteriorPointIterate&)>& on_iterate) {
  // Ipopt's linear solver has memory that all solves of a process share.
  static std::mutex one_at_a_time;
  const std::lock_guard lock(one_at_a_time);
  return ipopt_library().minimise(program, start, settings, on_iterate);
}

const std::vector<std::string>& ipopt_option_names() { return ipopt_library().option_names(); }

bool is_integer_option(std::string_view name) { return ipopt_library().is_integer_option(name); }

std::optional<IpoptOptionFault> check_ipopt_option(std::string_view name, const IpoptValue& value) {
  return ipopt_library().check_option(name, value);
}

std::optional<std::size_t> first_unusable_ipopt_option(const IpoptOptions& options) {
  return ipopt_library().first_unusable(options);
}

}  // namespace conddp
