#pragma once

#include <vector>

#include <Eigen/Core>

#include "spatial/aligned.hpp"

namespace conddp {

/// States x₀ … x_N and controls u₀ … u_{N−1}; the number of controls may differ between knots.
class Trajectory {
 public:
  Trajectory() = default;
  /// nx numbers per state, nu[k] controls at knot k (N = nu.size()); all zero.
  Trajectory(int nx, const std::vector<int>& nu) : nx_(nx), x_((nu.size() + 1) * nx, 0.0) {
    offset_.reserve(nu.size() + 1);
    for (int n : nu) offset_.push_back(offset_.back() + n);
    u_.assign(offset_.back(), 0.0);
  }

  int knots() const { return static_cast<int>(offset_.size()) - 1; }
  int nx() const { return nx_; }
  int nu(int k) const { return offset_[k + 1] - offset_[k]; }

  Eigen::Map<Eigen::VectorXd> x(int k) { return {x_.data() + k * nx_, nx_}; }
  Eigen::Map<const Eigen::VectorXd> x(int k) const { return {x_.data() + k * nx_, nx_}; }
  Eigen::Map<Eigen::VectorXd> u(int k) { return {u_.data() + offset_[k], nu(k)}; }
  Eigen::Map<const Eigen::VectorXd> u(int k) const { return {u_.data() + offset_[k], nu(k)}; }

  /// True for the same shape and the same numbers; NaN differs from NaN.
  bool operator==(const Trajectory& other) const = default;

 private:
  int nx_ = 0;
  std::vector<int> offset_{0};
  AlignedVector<double> x_;
  AlignedVector<double> u_;
};

}  // namespace conddp
