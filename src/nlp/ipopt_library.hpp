#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

namespace conddp {

class NonlinearProgram;
struct InteriorPointAnswer;
struct InteriorPointIterate;
struct InteriorPointSettings;
struct IpoptOptionFault;

/// Functions of the shared library built from nlp/ipopt, for interior_point.hpp and
/// ipopt_options.hpp. Only this library links Ipopt, whose BLAS and linear solver take longer to
/// load than most commands to run.
struct IpoptLibrary {
  InteriorPointAnswer (*minimise)(NonlinearProgram& program, const Eigen::VectorXd& start,
                                  const InteriorPointSettings& settings,
                                  const std::function<bool(const InteriorPointIterate&)>&);
  const std::vector<std::string>& (*option_names)();
  bool (*is_integer_option)(std::string_view name);
  std::optional<IpoptOptionFault> (*check_option)(
      std::string_view name, const std::variant<int, double, std::string>& value);
  std::optional<std::size_t> (*first_unusable)(
      const std::vector<std::pair<std::string, std::variant<int, double, std::string>>>& options);
};

/// Loads the library on the first call. Throws LibraryError if it is missing.
const IpoptLibrary& ipopt_library();

}  // namespace conddp
