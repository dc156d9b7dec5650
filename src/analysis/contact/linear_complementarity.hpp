#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// All complementary pairs 0 ≤ z ⊥ w ≥ 0 at an iterate. The z are impulses (N s) or speed slacks
/// (m/s). The w = value + slope dv + coupling z are velocities or impulses.
struct ContactPairs {
  Eigen::VectorXd value;
  Eigen::MatrixXd slope;     ///< pairs x nv
  Eigen::MatrixXd push;      ///< pairs x nv, transposed: generalized impulses per unit of z
  Eigen::MatrixXd coupling;  ///< pairs x pairs
  std::vector<bool> budget;  ///< true if w is an impulse and z a speed, otherwise the reverse

  ContactPairs(int count, int nv);

  /// Available friction: constant plus factor times the impulse of the pair `normal`.
  struct Budget {
    double constant = 0, factor = 0;
    int normal = -1;
  };
  /// Adds the next pair and returns its index.
  int add(double value, const Eigen::RowVectorXd& slope, const Eigen::RowVectorXd& push);
  /// Adds friction along a basis of tangents at a velocity: both signs of each, then the speed
  /// slack.
  void add_friction(const Eigen::MatrixXd& tangents, const Eigen::MatrixXd& slopes,
                    const Eigen::VectorXd& v, const Budget& available);
  /// Sets the next pairs to rest: w = 1, and z has no effect.
  void rest(int count);
  /// The edge of a budget with the smallest w; nullopt for a budget without edges.
  std::optional<int> slowest_edge(int budget, const Eigen::VectorXd& w) const;

 private:
  int filled_ = 0;
};

/// Solves 0 ≤ z ⊥ M z + q ≥ 0 by Lemke's complementary pivoting with the covering vector of ones.
/// Ties are broken lexicographically, so redundant rows do not cause cycling (Cottle, Pang, Stone:
/// The Linear Complementarity Problem, 2009, 4.4 and 4.9). Returns nullopt if pivoting ends on a
/// ray or numbers are not finite. It finds a solution, if one exists, for copositive-plus M and for
/// the frictional contact problems of Anitescu and Potra (1997).
std::optional<Eigen::VectorXd> solve_lcp(const Eigen::MatrixXd& M, const Eigen::VectorXd& q);

}  // namespace conddp
