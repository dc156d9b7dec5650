#include "solvers/ipopt/hessian_alternation.hpp"

#include <algorithm>

#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

/// Doublings of the patience, which keep it within an int.
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
  } else if (iterate.regularization > 0 && ++bad_steps_ >= with_patience(1)) {
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
  if (iterate.trials >= tuning::kPoorTrials || !(error <= tuning::kPoorGrowth * last_error_))
    ++bad_steps_;
  const bool judged =
      iterate.barrier == barrier_ && iterations_ >= with_patience(tuning::kWatchedIpopt);
  if (bad_steps_ >= with_patience(tuning::kPoorSteps) ||
      (judged && !(error <= tuning::kTighter * watched_error_)))
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
