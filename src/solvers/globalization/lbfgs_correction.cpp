#include "solvers/globalization/lbfgs_correction.hpp"

#include <algorithm>
#include <cmath>

#include "ocp/evaluation/matrix_vector.hpp"
#include "solvers/common/tuning.hpp"

namespace conddp {

LbfgsCorrection::LbfgsCorrection(const ControlBounds& bounds)
    : bounds_(bounds), pairs_(tuning::kPairs) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(bounds.size());
  for (Pair& pair : pairs_) pair.s = pair.y = pair.w = zero;
  free_ = d_ = g_ = s_ = new_d_ = new_g_ = r_ = Ms_ = zero;
}

void LbfgsCorrection::clear() {
  count_ = 0;
  newest_ = -1;
  observed_ = stepped_ = false;
}

void LbfgsCorrection::stack(const std::vector<Eigen::VectorXd>& parts,
                            Eigen::VectorXd& whole) const {
  for (int k = 0; k < bounds_.knots(); ++k)
    whole.segment(bounds_.offset(k), parts[k].size()) = parts[k];
}

/// Marks the free entries. False if they differ from before, or if a control is still moving to the
/// bound that holds it.
bool LbfgsCorrection::free_entries(const Feedback& feedback, const ActiveSet& active_set) {
  bool same = true;
  for (int k = 0; k < bounds_.knots(); ++k) {
    for (int i = 0; i < feedback.k[k].size(); ++i) {
      const bool held = active_set.holds(k, i);
      double& free = free_[bounds_.offset(k) + i];
      same = same && free == (held ? 0 : 1) && (!held || feedback.k[k][i] == 0);
      free = held ? 0 : 1;
    }
  }
  return same;
}

void LbfgsCorrection::observe(const Feedback& feedback, const BackwardSweep& sweep,
                              const ActiveSet& active_set) {
  if (!free_entries(feedback, active_set)) clear();
  stack(feedback.k, new_d_);
  for (int k = 0; k < bounds_.knots(); ++k) {
    const auto d = new_d_.segment(bounds_.offset(k), feedback.k[k].size());
    multiply(sweep.Quu(k), d.data(), new_g_.data() + bounds_.offset(k));
  }
  new_d_.array() *= free_.array();
  new_g_.array() *= -free_.array();
  if (observed_ && stepped_) add_pair(sweep);
  d_.swap(new_d_);
  g_.swap(new_g_);
  observed_ = true;
  stepped_ = false;
}

void LbfgsCorrection::add_pair(const BackwardSweep& sweep) {
  const int next = (newest_ + 1) % tuning::kPairs;
  Pair& pair = pairs_[next];
  pair.s = s_.cwiseProduct(free_);
  pair.y = new_g_ - g_;
  pair.w = d_ - new_d_;
  pair.curvature = pair.s.dot(pair.y);
  for (int k = 0; k < bounds_.knots(); ++k) {
    const int at = bounds_.offset(k);
    multiply(sweep.Quu(k), pair.s.data() + at, Ms_.data() + at);
  }
  const double model = pair.s.dot(Ms_);
  if (!(pair.curvature * tuning::kLargestFactor > model &&
        pair.curvature < tuning::kLargestFactor * model)) {
    count_ = 0;
    return;
  }
  newest_ = next;
  count_ = std::min(count_ + 1, tuning::kPairs);
}

bool LbfgsCorrection::correct(Feedback& feedback) {
  if (!observed_ || count_ == 0) return false;
  // Gauss-Newton converges fast without correction if a direction is a small share of the former
  // one, new_d_.
  const double ratio = std::sqrt(std::max(0.0, d_.dot(g_) / new_d_.dot(new_g_)));
  if (ratio < tuning::kShortStep) return false;
  apply_inverse();
  const double slope = -g_.dot(r_), plain = g_.dot(d_);
  if (!(slope < plain / tuning::kLargestFactor && slope > tuning::kLargestFactor * plain)) {
    count_ = 0;
    return false;
  }
  for (int k = 0; k < bounds_.knots(); ++k) {
    const auto free = free_.segment(bounds_.offset(k), feedback.k[k].size());
    const auto r = r_.segment(bounds_.offset(k), feedback.k[k].size());
    feedback.k[k] = (free.array() != 0).select(-r, feedback.k[k]);
  }
  return true;
}

/// r ← H g, from M⁻¹ g = −d. The first loop subtracts from M⁻¹ g what it subtracts from g.
void LbfgsCorrection::apply_inverse() {
  Eigen::VectorXd& q = new_g_;
  q = g_;
  r_ = -d_;
  for (int i = 0; i < count_; ++i) {
    Pair& pair = pairs_[(newest_ - i + tuning::kPairs) % tuning::kPairs];
    pair.weight = pair.s.dot(q) / pair.curvature;
    q -= pair.weight * pair.y;
    r_ -= pair.weight * pair.w;
  }
  for (int i = count_ - 1; i >= 0; --i) {
    const Pair& pair = pairs_[(newest_ - i + tuning::kPairs) % tuning::kPairs];
    r_ += (pair.weight - pair.y.dot(r_) / pair.curvature) * pair.s;
  }
}

void LbfgsCorrection::restore(Feedback& feedback) const {
  for (int k = 0; k < bounds_.knots(); ++k)
    for (int i = 0; i < feedback.k[k].size(); ++i) {
      const int at = bounds_.offset(k) + i;
      if (free_[at] != 0) feedback.k[k][i] = d_[at];
    }
}

void LbfgsCorrection::step_taken(const Feedback& feedback) {
  stack(feedback.k, s_);
  stepped_ = true;
}

}  // namespace conddp
