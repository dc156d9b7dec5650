#pragma once

#include "problem_file/model/spec_values.hpp"

namespace conddp {

enum class GaitType { stand, walk, trot, pace, bound, jump };

/// A foot of a gait: role, contact, and lift-off time.
struct FootSpec {
  std::string role;  ///< LF, ...; the contact's name in a gait without roles
  Name contact;
  double start = 0;  ///< share of the cycle at the first lift-off, in [0, 1)
};

/// Velocity command of the base from a time on.
struct GaitCommand {
  Place place;
  Located<double> at;   ///< s
  double x = 0, y = 0;  ///< m/s forward and to the left, in the heading of the base
  double turn = 0;      ///< rad/s
};

/// Motion of a gait's base at a node of its phases, relative to its start.
struct WayPoint {
  int node;
  PlanarMotion motion;
};

/// Bounds between which the solver chooses the duration of every phase, as shares of the duration
/// that it has without them.
struct FreeSharesSpec {
  Place place;
  double lower = 0.5, upper = 2;
};

/// Cycles with lift-offs and touch-downs of the feet. Phases and swings follow from them.
struct GaitSpec {
  Place place;
  Located<GaitType> type;
  std::vector<FootSpec> feet;
  int cycles = 1;
  Located<double> period;      ///< s
  Located<double> duty{0.5};   ///< stance share of the cycle
  Located<double> dt;          ///< s
  double step_length = 0;      ///< m per cycle
  double step_height = 0.05;   ///< m
  double direction = 0;        ///< rad to the left of the base's heading
  double turn = 0;             ///< rad per cycle
  Located<double> begin{0.2};  ///< s of standing before the first foot lifts
  Located<double> end{0.2};    ///< s of standing after the last touch-down
  std::optional<FreeSharesSpec> free_durations;
  std::vector<GaitCommand> commands;  ///< by time; replace length, direction and turn
  bool impulses = false;              ///< touch-downs are impulses
  double weight = 1e4;                ///< of the swing costs
};

}  // namespace conddp
