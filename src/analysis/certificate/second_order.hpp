#pragma once

#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "analysis/certificate/judged_point.hpp"
#include "analysis/certificate/kinks.hpp"

namespace conddp {

/// Sign of the Lagrangian's Hessian on the tangent space of the active constraints.
enum class Curvature {
  positive,   ///< positive even without weakly active rows: a strict local minimum
  negative,   ///< negative in a direction that no constraint forbids: no minimum
  undecided,  ///< zero to rounding, negative only where weakly active rows may forbid it, or
              ///< unknown beyond a kink
};

/// Second-order model at a trajectory: cost, dynamics and active constraints, with exact Hessians
/// of the Lagrangian. Figures are in the unit of the costs.
struct SecondOrder {
  Curvature curvature = Curvature::undecided;
  /// Cost decrease predicted by Newton's step along the active constraints, limited by the inactive
  /// ones.
  double gain = 0;
  /// Size of the predicted cost change from closing gaps and violations.
  double repair = 0;
  /// Sum of |∂L/∂u| times the range of each control; 0 without constraints.
  double slope = 0;
  /// Size of the costs: the sum of their absolute values, or their change under moves of all states
  /// and controls by their ranges if that is smaller.
  double cost_size = 0;
  double negligible = 0;  ///< cost change that counts as nothing
  double resolution = 0;  ///< smallest cost change that can be resolved
  /// Smallest eigenvalue of a stage's reduced Hessian, relative to its terms, and the knot of that
  /// stage. Infinite and −1 if the curvature is positive.
  double least = std::numeric_limits<double>::infinity();
  int knot = -1;
  /// If the curvature is negative: a direction (δx_k, δu_k) of each node along the dynamics and
  /// active constraints, and ½ dᵀ∇²L d. The direction extends by at most one range and as far as
  /// inactive constraints allow.
  std::vector<Eigen::VectorXd> direction;
  double bend = 0;
  /// Of an undecided model: largest move that closes gaps and violations of held rows, in ranges,
  /// as a multiple of the largest of these.
  double amplification = 0;
  /// Name of an equation whose rows follow from others, or that hardly any control moves, if this
  /// leaves the curvature, the gain or the repair undecided.
  std::string doubtful;
  std::optional<FallingKink> kink;  ///< of a model that is positive to one side of it

  /// Largest share of the cost that is left to gain, to repair, or along a slope.
  double share() const;
  /// Share of the cost that rounding may hide.
  double hidden_share() const;
  /// Multiplies all figures in the unit of the costs.
  void scale(double factor);
};

/// Names in documents of the figures in the unit of the costs.
inline constexpr std::pair<const char*, double SecondOrder::*> kSecondOrderFigures[] = {
    {"bend", &SecondOrder::bend},           {"gain", &SecondOrder::gain},
    {"repair", &SecondOrder::repair},       {"slope", &SecondOrder::slope},
    {"cost_size", &SecondOrder::cost_size}, {"resolution", &SecondOrder::resolution}};

/// Riccati recursion on the null space of the active constraints (Laine, Tomlin 2019). It uses only
/// the trajectory, its derivatives and multipliers. The reduced Hessian of the whole horizon is
/// positive definite if that of each stage is.
SecondOrder second_order(const JudgedPoint& point);

}  // namespace conddp
