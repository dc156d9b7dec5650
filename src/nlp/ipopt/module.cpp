// The only symbol of the shared library that conddp loads for the solver `ipopt`.
#include <cstddef>
#include <optional>
#include <stdexcept>

#include "nlp/ipopt/ipopt_minimise.hpp"
#include "nlp/ipopt/registered_options.hpp"
#include "nlp/ipopt_library.hpp"
#include "nlp/ipopt_options.hpp"

namespace conddp {
namespace {

/// minimize ½‖y‖² subject to y₀ + y₁ = 1, y₀ − y₁ ≤ 3, 0 ≤ y₀
class TrialProgram : public NonlinearProgram {
 public:
  TrialProgram() {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    lower_ = Eigen::Vector2d(0, -kInfinity);
    upper_ = Eigen::Vector2d::Constant(kInfinity);
    row_lower_ = Eigen::Vector2d(1, -kInfinity);
    row_upper_ = Eigen::Vector2d(1, 3);
    for (int row = 0; row < 2; ++row)
      for (int column = 0; column < 2; ++column) jacobian_.add(row, column);
    for (int i = 0; i < 2; ++i) hessian_.add(i, i);
  }
  void set_point(const double* y) override { y_ = Eigen::Vector2d(y); }
  double objective() override { return y_.squaredNorm() / 2; }
  void gradient(double* out) override { Eigen::Map<Eigen::Vector2d>{out} = y_; }
  void constraints(double* out) override {
    Eigen::Map<Eigen::Vector2d>{out} << y_[0] + y_[1], y_[0] - y_[1];
  }
  void jacobian(double* out) override { Eigen::Map<Eigen::Vector4d>{out} << 1, 1, 1, -1; }
  void hessian(double weight, const double*, double* out) override {
    Eigen::Map<Eigen::Vector2d>{out}.setConstant(weight);
  }

 private:
  Eigen::Vector2d y_;
};

bool starts_with(const IpoptOptions& options) {
  TrialProgram program;
  try {
    ipopt_minimise(program, Eigen::Vector2d(0.25, 0.5), {.options = options},
                   [](const InteriorPointIterate&) { return true; });
    return true;
  } catch (const std::invalid_argument&) {
    return false;
  }
}

/// First option that keeps this Ipopt from starting, together with those before it: its build, or
/// the libraries on this machine, do not support the option. Solves a program of two variables.
std::optional<std::size_t> first_unusable_option(const IpoptOptions& options) {
  if (starts_with(options)) return std::nullopt;
  std::size_t count = 1;
  while (count < options.size() &&
         starts_with(IpoptOptions(options.begin(), options.begin() + static_cast<long>(count))))
    ++count;
  return count - 1;
}

}  // namespace
}  // namespace conddp

extern "C" __attribute__((visibility("default"))) const conddp::IpoptLibrary conddp_ipopt_library;

extern "C" const conddp::IpoptLibrary conddp_ipopt_library = {
    .minimise = conddp::ipopt_minimise,
    .option_names = conddp::registered_option_names,
    .is_integer_option = conddp::is_registered_integer,
    .check_option = conddp::check_registered_option,
    .first_unusable = conddp::first_unusable_option,
};
