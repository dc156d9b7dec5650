#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

#include "ocp/terms/residual.hpp"
#include "solvers/stages/box_qp.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {

/// The controls and contact forces that hold a robot in a guessed step: within their limits the
/// smallest of those that leave the least of the equations of motion, min ‖r + G y‖² + ρ ‖y‖².
/// Forces of a candidate are sums of those along the edges of its pyramid (four edges stand for a
/// cone), not negative, and no larger than what a relaxed pair admits at its gap: so nothing pulls,
/// and nothing holds from afar.
class HoldingForces {
 public:
  /// `product`: force times distance that a pair may have, N m. ndx is that of the knot model.
  HoldingForces(const std::shared_ptr<const SteppingSystem>& system, int ndx, double product);

  /// Writes the actuators and the forces of w for a step of h from x, with the accelerations that w
  /// has; limits are those of w. Returns the largest entry of what is left, N or Nm.
  double find(const double* x, double h, const std::vector<double>& lower,
              const std::vector<double>& upper, Eigen::Ref<Eigen::VectorXd> w);

 private:
  /// An unknown: by how much it changes entries of w.
  struct Unknown {
    std::vector<std::pair<int, double>> entries;
    double lower = 0, upper = kUnlimited;
    int distance_row = -1;  ///< of the stepping equations: its value is −φ where slacks are zero
    int share = 1;          ///< how many unknowns have that distance
  };

  void add_candidates();
  void add_joints();
  int row(const std::string& name) const;
  /// The y within its bounds of which ‖load + G y‖² + ρ ‖y‖² is smallest; zero where that is not
  /// defined.
  Eigen::VectorXd smallest(const Eigen::MatrixXd& G, const Eigen::Ref<const Eigen::VectorXd>& load,
                           const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);
  /// The entries of w that the unknowns stand for.
  void write(const Eigen::VectorXd& y, Eigen::Ref<Eigen::VectorXd> w) const;

  std::shared_ptr<const SteppingSystem> system_;
  std::shared_ptr<const Residual> equations_;
  std::vector<std::string> row_names_;
  std::unique_ptr<SystemData<double>> data_;
  double product_;
  std::vector<Unknown> unknowns_;
  std::vector<int> column_;  ///< of entries of w in the block of the equations of motion, or −1
  BoxQp qp_;
};

}  // namespace conddp
