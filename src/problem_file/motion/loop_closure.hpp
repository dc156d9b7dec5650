#pragma once

#include <string>
#include <vector>

#include "systems/multibody/multibody.hpp"

namespace conddp {

/// Contacts of a system as equations of the configuration, and their solution next to a state.
class LoopClosure {
 public:
  /// `system` holds the contacts; x has nx numbers.
  LoopClosure(const MultibodySystem& system, const std::vector<double>& x);

  /// Length of each contact's error in the state: m, with angles of surfaces times 1 m.
  const std::vector<double>& gaps() const { return gaps_; }
  /// Joint positions of the closed configuration that differ from those of the state, as in
  /// "{knee: 0.8123, ankle: -0.2}". Empty if Newton's method does not find it.
  std::string closed_joints() const;

 private:
  /// Errors of all contacts, and their Jacobian (rows x nv), at x_.
  void linearize();
  std::vector<double> gaps_now() const;

  const MultibodySystem& system_;
  MultibodySystem::Data<double> data_;
  std::vector<double> x_, start_;
  Eigen::VectorXd error_;
  Eigen::MatrixXd jacobian_;
  std::vector<double> gaps_;
};

}  // namespace conddp
