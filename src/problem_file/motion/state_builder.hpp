#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "problem_file/model/components.hpp"
#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Converts states of a file into numbers: states of the system, without augmented states.
class StateBuilder {
 public:
  StateBuilder(const Plant& plant, Diagnostics& out);

  /// Missing values are neutral. Unknown names and wrong sizes are reported.
  std::optional<std::vector<double>> build(const StateSpec& spec) const;
  /// The state of a configuration (at rest), or the initial state for "initial".
  std::optional<std::vector<double>> named(const Name& name) const;
  /// Warns of joint positions of a state outside their limits, each at the place that `place_of`
  /// returns for its name; NaN entries are skipped. `subject` names the state. True if there are
  /// any.
  bool check_limits(std::string_view subject, const std::vector<double>& x,
                    const std::function<Place(const std::string&)>& place_of) const;
  /// Defines "initial" from here on.
  void set_initial(std::vector<double> state) { initial_ = std::move(state); }
  const std::vector<double>& initial() const { return initial_; }

 private:
  void apply(const StateSpec& spec, const PlantPart& part, std::vector<double>& x) const;
  /// Places the frames of a state, unless there are more errors than that.
  void place(const StateSpec& spec, int errors, std::vector<double>& x) const;
  void apply_joints(const StateSpec& spec, const PlantPart& part, std::vector<double>& x) const;
  void apply_part(const NamedState& part, std::vector<double>& x) const;
  /// The robot of this name; an unknown one is reported.
  const PlantPart* find_part(const Name& name) const;
  void apply_base(const BaseSpec& base, const PlantPart& part, std::vector<double>& x) const;
  void apply_planar_base(const BaseSpec& base, const PlantPart& part, std::vector<double>& x) const;
  void apply_base_velocity(const TwistSpec& twist, const PlantPart& part,
                           std::vector<double>& x) const;
  void apply_planar_velocity(const TwistSpec& twist, int joint, std::vector<double>& x) const;
  void apply_displacement(const DisplacementSpec& displaced, const PlantPart& part,
                          std::vector<double>& x) const;
  void apply_configuration(const Name& name, const PlantPart& part, std::vector<double>& x) const;
  /// A list of the full state, or of all numbers except a clock and parameters; false for any other
  /// length.
  bool apply_list(const std::vector<double>& list, std::vector<double>& x) const;
  void apply_columns(const NamedNumbers& values, std::vector<double>& x) const;
  /// The default state.
  std::vector<double> usual_state() const;
  std::optional<std::vector<double>> checked(std::vector<double> x, const Place& place) const;
  /// True if a robot has a floating base.
  bool floats(const PlantPart& part) const;
  /// A part for all robots together: full names with prefixes, no base.
  PlantPart whole() const;

  const Plant& plant_;
  Diagnostics& out_;
  std::vector<double> initial_;
};

}  // namespace conddp
