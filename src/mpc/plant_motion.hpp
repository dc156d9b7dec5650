#pragma once

#include <cstdint>
#include <span>
#include <string_view>

namespace conddp {

/// Motion of a plant, step by step.
class PlantMotion {
 public:
  virtual ~PlantMotion() = default;

  /// Latest end of a step from `time`, s.
  virtual double next_stop(double time) const = 0;
  /// Applies the instantaneous events at a time to x.
  virtual void pass_instants(double time, double* x) = 0;
  /// Advances x by a step with a constant control.
  virtual void step(double time, double length, const double* u, double* x) = 0;
  /// Contacts that are closed after the last step, one bit each in the order of the file. 0 if the
  /// plant does not find contacts itself.
  virtual std::uint32_t closed_contacts() const { return 0; }
  /// Reason why the last step failed and left a non-finite state; empty if it succeeded.
  virtual std::string_view failure() const { return {}; }
  /// Forces of all contacts on the robot during the last step, N, in the order of the file. Three
  /// numbers each in world axes, NaN if the contact was open. Empty if the plant does not find
  /// contacts itself.
  virtual std::span<const double> contact_forces() const { return {}; }
};

}  // namespace conddp
