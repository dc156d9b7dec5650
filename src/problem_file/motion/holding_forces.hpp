#pragma once

#include <utility>
#include <vector>

#include <Eigen/Core>

#include "ocp/terms/residual.hpp"
#include "solvers/stages/box_qp.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {

/// The controls and contact forces that hold a robot in a guessed step. They minimize ‖r + G y‖² +
/// ρ ‖y‖² within their limits: the residual of the equations of motion, and among its minimizers
/// the smallest forces. Forces of a candidate are sums of nonnegative forces along the edges of its
/// pyramid (four edges for a cone). They are bounded by the force that a relaxed pair admits at its
/// gap, so contacts neither pull nor act at a distance.
class HoldingForces {
 public:
  /// `product`: force times distance that a pair may have, N m. `ndx`: that of the knot model.
  HoldingForces(const std::shared_ptr<const SteppingSystem>& system, int ndx, double product);

  /// Writes the actuators and the forces into w for a step of h from x, with the accelerations in
  /// w. The limits have the layout of w. Returns the largest entry of the remaining residual, N or
  /// Nm.
  double find(const double* x, double h, const std::vector<double>& lower,
              const std::vector<double>& upper, Eigen::Ref<Eigen::VectorXd> w);

 private:
  /// An unknown: its coefficients in entries of w.
  struct Unknown {
    std::vector<std::pair<int, double>> entries;
    double lower = 0, upper = kUnlimited;
    int distance_row = -1;  ///< of the stepping equations: its value is −φ for zero slacks
    int share = 1;          ///< number of unknowns with that distance
  };

  void add_candidates();
  void add_joints();
  int row(const std::string& name) const;
  /// The y within its bounds that minimizes ‖load + G y‖² + ρ ‖y‖²; zero if undefined.
  Eigen::VectorXd smallest(const Eigen::MatrixXd& G, const Eigen::Ref<const Eigen::VectorXd>& load,
                           const Eigen::VectorXd& lower, const Eigen::VectorXd& upper);
  /// Writes the entries of w for given unknowns.
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
