#include "solvers/common/guess.hpp"

#include <iterator>
#include <stdexcept>

#include <fmt/format.h>

#include "base/random_numbers.hpp"

namespace conddp {

void check_shape(const ShootingProblem& problem, const Trajectory& guess) {
  bool fits = guess.knots() == problem.knots() && guess.nx() == problem.nx();
  for (int k = 0; fits && k < problem.knots(); ++k) fits = guess.nu(k) == problem.nu(k);
  if (!fits) throw std::invalid_argument("the guess does not have the shape of the problem");
}

void clamp_guess(const ControlBounds& bounds, Trajectory& trajectory, std::string& start) {
  const int clamped = bounds.clamp(trajectory);
  if (clamped == 0) return;
  fmt::format_to(std::back_inserter(start), "; {} control {} moved to a bound", clamped,
                 clamped == 1 ? "entry" : "entries");
}

void correct_states(const ShootingProblem& problem, Trajectory& trajectory, std::string& start) {
  const Eigen::Map<const Eigen::VectorXd> x0(problem.initial_state().data(), problem.nx());
  const double off = (trajectory.x(0) - x0).lpNorm<Eigen::Infinity>();
  trajectory.x(0) = x0;
  for (int k = 0; k <= problem.knots(); ++k) {
    if (trajectory.x(k).allFinite() && !problem.manifold().normalize(trajectory.x(k).data())) {
      throw std::invalid_argument(
          fmt::format("state {} of the guess: a quaternion is far from unit length", k));
    }
  }
  if (off != 0) fmt::format_to(std::back_inserter(start), "; x_0 corrected by {:.2g}", off);
}

Trajectory perturb_guess(const ShootingProblem& problem, const Trajectory& guess, double spread,
                         std::uint64_t seed) {
  Trajectory start = guess;
  NormalNumbers normal(seed);
  Eigen::VectorXd dx(problem.ndx());
  for (int k = 0; k <= problem.knots(); ++k) {
    for (double& d : dx) d = spread * normal.next();
    if (k > 0) problem.manifold().integrate(guess.x(k).data(), dx.data(), start.x(k).data());
    if (k == problem.knots()) break;
    for (int i = 0; i < problem.nu(k); ++i) start.u(k)[i] += spread * normal.next();
  }
  return start;
}

}  // namespace conddp
