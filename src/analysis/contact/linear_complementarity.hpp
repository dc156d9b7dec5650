#pragma once

#include <optional>

#include <Eigen/Core>

namespace conddp {

/// A solution z of 0 ≤ z ⊥ M z + q ≥ 0 by Lemke's complementary pivoting with the covering vector
/// of ones; ties are broken lexicographically, so that redundant rows do not make it cycle (Cottle,
/// Pang, Stone: The Linear Complementarity Problem, 2009, 4.4 and 4.9). None where it ends on a ray
/// or numbers are not finite. It finds a solution wherever there is one for copositive-plus M, and
/// for the problems of contact with friction of Anitescu and Potra (1997).
std::optional<Eigen::VectorXd> solve_lcp(const Eigen::MatrixXd& M, const Eigen::VectorXd& q);

}  // namespace conddp
