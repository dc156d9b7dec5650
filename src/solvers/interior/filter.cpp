#include "solvers/interior/filter.hpp"

#include <algorithm>
#include <cmath>

#include "solvers/common/tuning.hpp"

namespace conddp {
namespace {

using namespace tuning::interior;

}  // namespace

void Filter::start(double theta) {
  least_ = kThetaMin * std::max(1.0, theta);
  largest_ = kThetaMax * std::max(1.0, theta);
  clear();
}

void Filter::clear() {
  entries_.clear();
  forgotten_ = 0;
  present_ = largest_;
}

bool Filter::forget(double theta) {
  if (entries_.empty() || forgotten_ == kForgotten) return false;
  entries_.clear();
  ++forgotten_;
  present_ = std::max(theta, least_);
  return true;
}

bool Filter::accepts(double length, double slope, const std::pair<double, double>& from,
                     const std::pair<double, double>& trial) {
  const auto& [theta, phi] = trial;
  const auto dominates = [&](const auto& entry) {
    return theta >= entry.first && phi >= entry.second;
  };
  if (!std::isfinite(theta + phi) || theta > present_ || std::ranges::any_of(entries_, dominates))
    return false;
  const auto& [theta0, phi0] = from;
  const double rounded = phi - tuning::kUlps * std::abs(phi0);
  if (slope < 0 && theta0 <= least_ &&
      length * std::pow(-slope, kPhiPower) > std::pow(theta0, kThetaPower))
    return rounded <= phi0 + kEtaPhi * length * slope;
  const double less_theta = (1 - kGammaTheta) * theta0, less_phi = phi0 - kGammaPhi * theta0;
  if (theta > less_theta && rounded > less_phi) return false;
  entries_.push_back({less_theta, less_phi});
  return true;
}

}  // namespace conddp
