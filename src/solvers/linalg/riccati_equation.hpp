#pragma once

#include <complex>
#include <optional>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// A linear-quadratic regulator problem in discrete time: minimize Σ ½ (xᵀQ x + 2 xᵀS u + uᵀR u)
/// over all steps x⁺ = A x + B u.
struct RegulatorProblem {
  Eigen::MatrixXd A, B;
  Eigen::MatrixXd Q, R;  ///< symmetric
  Eigen::MatrixXd S;     ///< same size as B
};

/// The regulator u = −K x. Its cost from x on is ½ xᵀP x.
struct Regulator {
  Eigen::MatrixXd P;  ///< symmetric, positive semidefinite: the stabilizing solution of
                      ///< P = Q + AᵀPA − (AᵀPB + S)(R + BᵀPB)⁻¹(BᵀPA + Sᵀ)
  Eigen::MatrixXd K;
  Eigen::VectorXcd eigenvalues;  ///< of A − B K, the largest modulus first
  double residual = 0;           ///< of the equation, relative to the largest entry of P
};

/// An unreachable or unobservable motion x ~ λᵏ of a linear system.
struct LinearMode {
  std::complex<double> eigenvalue;
  Eigen::VectorXd share;  ///< participation of each state, scaled to a maximum of 1
};

/// Reasons why no regulator exists.
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
  double eigenvalue = 0;           ///< smallest eigenvalue of the cost at fault
  std::optional<LinearMode> mode;  ///< the mode at fault
};

/// Modes that no control moves: y with yᴴA = λ yᴴ and yᴴB = 0. Orthogonal transformations also find
/// modes that coincide or nearly coincide.
std::vector<LinearMode> unreachable_modes(const Eigen::MatrixXd& A, const Eigen::MatrixXd& B);

/// Solves the discrete algebraic Riccati equation by the structure-preserving doubling algorithm
/// (Chu, Fan, Lin, Wang 2004), which doubles the horizon with each step. Steps of Newton's method
/// (Hewer 1971) refine the solution.
RegulatorResult solve_regulator(const RegulatorProblem& problem);

}  // namespace conddp
