#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

namespace conddp {

/// All complementary pairs 0 ≤ z ⊥ w ≥ 0 at an iterate: z are impulses (N s) or slacks of speed
/// (m/s), w = value + slope dv + coupling z velocities or impulses.
struct ContactPairs {
  Eigen::VectorXd value;
  Eigen::MatrixXd slope;     ///< pairs x nv
  Eigen::MatrixXd push;      ///< pairs x nv: transposed, generalised impulses per unit of z
  Eigen::MatrixXd coupling;  ///< pairs x pairs
  std::vector<bool> budget;  ///< whether w is an impulse and z a speed, else the other way round

  ContactPairs(int count, int nv);

  /// What friction may have: constant plus factor times the impulse of the pair `normal`.
  struct Budget {
    double constant = 0, factor = 0;
    int normal = -1;
  };
  /// The next pair; returns which one it is.
  int add(double value, const Eigen::RowVectorXd& slope, const Eigen::RowVectorXd& push);
  /// Friction along a basis of tangents at a velocity: both signs of each, then the slack of speed.
  void add_friction(const Eigen::MatrixXd& tangents, const Eigen::MatrixXd& slopes,
                    const Eigen::VectorXd& v, const Budget& available);
  /// The next pairs are at rest: w is one and z has no effect.
  void rest(int count);
  /// Of the edges of a budget the one whose w is the least, none where it has no edges.
  std::optional<int> slowest_edge(int budget, const Eigen::VectorXd& w) const;

 private:
  int filled_ = 0;
};

}  // namespace conddp
