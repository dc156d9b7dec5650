#include "solvers/ipopt/hessian_alternation.hpp"

#include <algorithm>

namespace conddp {
namespace {

/// A step is poor if its line search takes this many trials, or the error grows by more than this
/// factor.
constexpr int kPoorTrials = 3;
constexpr double kPoorGrowth = 2;
/// Initial patience: poor steps until Gauss-Newton Hessians are given up, and regularized steps
/// until exact ones are.
constexpr int kPoorSteps = 2, kRegularizedSteps = 1;
/// Initial requirement: the error falls by this factor within this many iterations of one barrier.
constexpr int kWatchedIterations = 5;
constexpr double kWantedFall = 10;
/// Limits how often the patience with either kind doubles.
constexpr int kMostDoublings = 10;

/// Error of the barrier problem, where complementarity is meant to equal the barrier.
double error_of(const InteriorPointIterate& iterate) {
  return std::max({iterate.dual_infeasibility, iterate.infeasibility,
                   iterate.complementarity - iterate.barrier});
}

}  // namespace

void HessianAlternation::begin(const InteriorPointIterate& first) {
  *this = HessianAlternation();
  watched_error_ = last_error_ = error_of(first);
  barrier_ = first.barrier;
}

void HessianAlternation::watch(const InteriorPointIterate& iterate) {
  // The restoration phase has its own Hessian.
  if (iterate.restoration) return;
  const double error = error_of(iterate);
  ++iterations_;
  if (gauss_newton_) {
    watch_gauss_newton(iterate, error);
  } else if (iterate.regularization > 0 && ++bad_steps_ >= with_patience(kRegularizedSteps)) {
    ++returns_;
    change();
  }
  if (iterations_ == 0 || iterate.barrier != barrier_) {
    iterations_ = 0;
    watched_error_ = error;
    barrier_ = iterate.barrier;
  }
  last_error_ = error;
}

void HessianAlternation::watch_gauss_newton(const InteriorPointIterate& iterate, double error) {
  if (iterate.trials >= kPoorTrials || !(error <= kPoorGrowth * last_error_)) ++bad_steps_;
  const bool judged =
      iterate.barrier == barrier_ && iterations_ >= with_patience(kWatchedIterations);
  if (bad_steps_ >= with_patience(kPoorSteps) ||
      (judged && !(error * kWantedFall <= watched_error_)))
    change();
  else if (judged)
    iterations_ = 0;
}

int HessianAlternation::with_patience(int count) const {
  return count << std::min(returns_, kMostDoublings);
}

void HessianAlternation::change() {
  gauss_newton_ = !gauss_newton_;
  bad_steps_ = iterations_ = 0;
}

}  // namespace conddp
