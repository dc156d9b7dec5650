#pragma once

#include <optional>

#include <Eigen/Core>

namespace conddp {

/// Solves 0 ≤ z ⊥ M z + q ≥ 0 by Lemke's complementary pivoting with the covering vector of ones.
/// Ties are broken lexicographically, so redundant rows do not cause cycling (Cottle, Pang, Stone:
/// The Linear Complementarity Problem, 2009, 4.4 and 4.9). Returns nullopt if pivoting ends on a
/// ray or numbers are not finite. It finds a solution, if one exists, for copositive-plus M and for
/// the frictional contact problems of Anitescu and Potra (1997).
std::optional<Eigen::VectorXd> solve_lcp(const Eigen::MatrixXd& M, const Eigen::VectorXd& q);

}  // namespace conddp
