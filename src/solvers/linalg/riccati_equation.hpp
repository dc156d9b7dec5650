#pragma once

#include <complex>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// A linear-quadratic regulator in discrete time: the least Σ ½ (xᵀQ x + 2 xᵀS u + uᵀR u) over all
/// steps x⁺ = A x + B u.
struct RegulatorProblem {
  Eigen::MatrixXd A, B;
  Eigen::MatrixXd Q, R;  ///< symmetric
  Eigen::MatrixXd S;     ///< as large as B
};

/// What it costs from x on is ½ xᵀP x, with u = −K x.
struct Regulator {
  Eigen::MatrixXd P;  ///< symmetric, positive semidefinite: the stabilizing solution of
                      ///< P = Q + AᵀPA − (AᵀPB + S)(R + BᵀPB)⁻¹(BᵀPA + Sᵀ)
  Eigen::MatrixXd K;
  Eigen::VectorXcd eigenvalues;  ///< of A − B K, the largest modulus first
  double residual = 0;           ///< of the equation, by the largest entry of P
};

/// A motion x ~ λᵏ of a linear system that something does not move, or does not see.
struct LinearMode {
  std::complex<double> eigenvalue;
  Eigen::VectorXd share;  ///< how much each state takes part, the largest 1
};

/// Why there is no regulator.
enum class RegulatorFault {
  none,
  control_cost,      ///< R is not positive definite
  state_cost,        ///< the stage cost is not convex
  not_stabilizable,  ///< no control moves a mode that does not decay
  not_detectable,    ///< a mode that does not decay costs nothing
  inaccurate,        ///< rounding spoils the solution
};

struct RegulatorResult {
  std::optional<Regulator> regulator;
  RegulatorFault fault = RegulatorFault::none;
  double eigenvalue = 0;           ///< the least one of the cost at fault
  std::optional<LinearMode> mode;  ///< the one at fault
};

/// The modes that no control moves: y with yᴴA = λ yᴴ and yᴴB = 0. By orthogonal transformations,
/// so that modes that belong together, or nearly, are found.
std::vector<LinearMode> unreachable_modes(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// Solves the discrete algebraic Riccati equation by the structure-preserving doubling algorithm
/// (Chu, Fan, Lin, Wang 2004), which doubles the horizon with each step, and refines the solution
/// by steps of Newton's method (Hewer 1971).
RegulatorResult solve_regulator(const RegulatorProblem& problem);

}  // namespace conddp
