#pragma once

#include "problem_file/spec/spec_values.hpp"

namespace conddp {

enum class GaitType { stand, walk, trot, pace, bound, jump };

/// A foot of a gait: what the gait calls it, its contact, and when it lifts.
struct FootSpec {
  std::string role;  ///< LF, ...; the contact's name where the gait has no roles
  Name contact;
  double start = 0;  ///< share of the cycle after which it first lifts, from 0 to 1 (excluded)
};

/// How fast and where to a robot is to go from a time on.
struct GaitCommand {
  Place place;
  Located<double> at;   ///< s
  double x = 0, y = 0;  ///< m/s forward and to the left, as the base points
  double turn = 0;      ///< rad/s
};

/// Where the base of a gait is at a node of its phases, as seen from where it begins.
struct WayPoint {
  int node;
  PlanarMotion motion;
};

/// Cycles in which feet lift and touch down one after the other, from which phases and swings
/// follow.
struct GaitSpec {
  Place place;
  Located<GaitType> type;
  std::vector<FootSpec> feet;
  int cycles = 1;
  Located<double> period;             ///< s
  Located<double> duty{0.5};          ///< share of the cycle that a foot stands
  Located<double> dt;                 ///< s
  double step_length = 0;             ///< m a cycle
  double step_height = 0.05;          ///< m
  double direction = 0;               ///< rad from where the base points to the left
  double turn = 0;                    ///< rad a cycle
  Located<double> begin{0.2};         ///< s of standing before the first foot lifts
  Located<double> end{0.2};           ///< s of standing after the last touch-down
  std::vector<GaitCommand> commands;  ///< in place of length, direction and turn, by their times
  bool impulses = false;              ///< whether touch-downs are impulses
  double weight = 1e4;                ///< of the costs on the swings
};

}  // namespace conddp
