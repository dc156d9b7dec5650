#pragma once

#include <span>
#include <vector>

#include <Eigen/Core>

#include "ocp/problem/problem.hpp"

namespace conddp {

/// Controls as a linear function of parameters θ around a nominal:
/// u_k[i] = ū_k[i] + Σ_j w_j θ_{first + j}, clamped to the bounds of the knot. A channel is one
/// control over time; its values at the nodes of a spline are consecutive parameters.
class ControlSplines {
 public:
  /// `nominal` has the shape of the problem; both must outlive this object.
  ControlSplines(const ShootingProblem& problem, const Trajectory& nominal);

  /// Appends a channel with a parameter per spline node, whose normal noise has the standard
  /// deviation `scale`, in the control's unit. Returns its first parameter.
  int add_channel(int nodes, double scale);
  /// Makes an entry of a knot's control follow a channel, with a weight per spline node.
  void add_entry(int knot, int control, int channel, std::span<const double> weights);

  const ShootingProblem& problem() const { return problem_; }
  const Trajectory& nominal() const { return nominal_; }
  int parameters() const { return static_cast<int>(scales_.size()); }
  /// Standard deviation of the noise, one per parameter.
  const std::vector<double>& scales() const { return scales_; }

  /// Writes the clamped controls of a knot. `theta` has parameters() numbers, S = double or a Lane
  /// of samples.
  template <class S>
  void controls(int knot, const S* theta, S* u) const {
    const auto ubar = nominal_.u(knot);
    for (int i = 0; i < ubar.size(); ++i) u[i] = S(ubar[i]);
    for (const Entry& entry : entries_[knot])
      for (int j = 0; j < entry.count; ++j)
        u[entry.control] += S(weights_[entry.weights + j]) * theta[entry.channel + j];
    const KnotModel& model = *problem_.knot(knot).model;
    for (int i = 0; i < ubar.size(); ++i)
      u[i] = max(S(model.control_lower()[i]), min(S(model.control_upper()[i]), u[i]));
  }

 private:
  struct Entry {
    int control, channel, weights, count;
  };

  const ShootingProblem& problem_;
  const Trajectory& nominal_;
  std::vector<double> scales_, weights_;
  std::vector<std::vector<Entry>> entries_;  ///< by knot
};

}  // namespace conddp
