#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace conddp {

/// How the state of a plant moves, from step to step.
class PlantMotion {
 public:
  virtual ~PlantMotion() = default;

  /// The longest that a step from here may last, s.
  virtual double next_stop(double time) const = 0;
  /// Moves x over what happens in no time at a time.
  virtual void pass_instants(double time, double* x) = 0;
  /// Moves x on by a step with a control that is held.
  virtual void step(double time, double length, const double* u, double* x) = 0;
  /// The contacts that are closed after the last step, one bit each in the order of the file; of a
  /// plant that does not find them itself none.
  virtual std::uint32_t closed_contacts() const { return 0; }
  /// Why the last step could not be made, which left a state that is not finite; empty where it
  /// could.
  virtual std::string_view failure() const { return {}; }
  /// The forces of all contacts on the robot during the last step, N, in the order of the file:
  /// three numbers each in the axes of the world, not numbers where the contact was open. Of a
  /// plant that does not find its contacts itself none.
  virtual std::span<const double> contact_forces() const { return {}; }
};

}  // namespace conddp
