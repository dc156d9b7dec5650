#pragma once

#include <functional>
#include <vector>

#include "mpc/time_line.hpp"

namespace conddp {

/// A swing of a foot on a time line.
struct FootSwing {
  int foot = 0;
  std::vector<int> nodes;       ///< from lift-off to touch-down, in order
  std::vector<int> references;  ///< offset of the foot's reference in each node's parameters; 3
                                ///< numbers, m
};

/// Swings of feet along references.
struct FootSwings {
  int feet = 0;
  std::vector<FootSwing> swings;
  /// Writes the positions of the feet at a state, 3 numbers each, m.
  std::function<void(const double* x, double* places)> find_feet;
};

/// Starts swings at the actual positions of the feet instead of their footholds. At lift-off, the
/// reference of a swing is displaced to the foot. The displacement decays until touch-down, so that
/// the swing ends at its planned foothold.
class SwingStarts {
 public:
  /// Throws std::invalid_argument if swings do not fit the time line.
  SwingStarts(FootSwings swings, const TimeLine& line);

  /// Finds the feet in the state at a time (s) of the line. A foot that already swings keeps the
  /// lift-off position seen before.
  void see(const TimeLine& line, double time, const double* x);
  /// Displaces the references of current and next swings in the parameters of a node.
  void displace(int node, double* parameters) const;

 private:
  struct Reference {
    int swing, parameter;
    double share;  ///< of the displacement at lift-off
  };

  FootSwings swings_;
  std::vector<std::vector<Reference>> references_;  ///< by node
  std::vector<int> next_;                           ///< next or current swing of each foot
  std::vector<double> places_, displacements_;      ///< of the feet, m
};

}  // namespace conddp
