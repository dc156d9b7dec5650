#pragma once

#include <functional>
#include <vector>

#include "mpc/time_line.hpp"

namespace conddp {

/// A swing of a foot on a time line.
struct FootSwing {
  int foot = 0;
  std::vector<int> nodes;       ///< from lift-off to touch-down, in order
  std::vector<int> references;  ///< where in the parameters of each its place stands, 3 numbers, m
};

/// Swings of feet that references lead.
struct FootSwings {
  int feet = 0;
  std::vector<FootSwing> swings;
  /// Writes the places of the feet in a state, 3 numbers each, m.
  std::function<void(const double* x, double* places)> find_feet;
};

/// Lets swings begin where the feet are, wherever their footholds are. At lift-off the reference of
/// a swing is displaced to the foot, until touch-down by less and less: it ends where it was to.
class SwingStarts {
 public:
  /// Throws std::invalid_argument where swings are not those of the line.
  SwingStarts(FootSwings swings, const TimeLine& line);

  /// Finds the feet in the state at a time (s) of the line. Those that swing by then have lifted
  /// off where they were seen before.
  void see(const TimeLine& line, double time, const double* x);
  /// Displaces what the parameters of a node have of the swings that are under way or next.
  void displace(int node, double* parameters) const;

 private:
  struct Reference {
    int swing, parameter;
    double share;  ///< of the displacement at lift-off
  };

  FootSwings swings_;
  std::vector<std::vector<Reference>> references_;  ///< node by node
  std::vector<int> next_;                           ///< swing of each foot, or the one under way
  std::vector<double> places_, displacements_;      ///< of the feet, m
};

}  // namespace conddp
