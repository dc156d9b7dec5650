#pragma once

#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "problem_file/plant/plant.hpp"
#include "problem_file/spec/components.hpp"

namespace conddp {

/// Turns what a file says about states into numbers: states of the system, without augmented
/// states.
class StateBuilder {
 public:
  StateBuilder(const Plant& plant, Diagnostics& out);

  /// What is not mentioned is neutral. Unknown names and wrong sizes are reported.
  std::optional<std::vector<double>> build(const StateSpec& spec) const;
  /// The state of a configuration (at rest), or the initial one for "initial".
  std::optional<std::vector<double>> named(const Name& name) const;
  /// Warns of joints that a state has outside of their limits, each at the place that `place_of`
  /// has for its name; entries that are no numbers are left out. `subject` has the joints. Whether
  /// there are any.
  bool check_limits(std::string_view subject, const std::vector<double>& x,
                    const std::function<Place(const std::string&)>& place_of) const;
  /// From here on "initial" is known.
  void set_initial(std::vector<double> state) { initial_ = std::move(state); }
  const std::vector<double>& initial() const { return initial_; }

 private:
  void apply(const StateSpec& spec, const PlantPart& part, std::vector<double>& x) const;
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
  /// A list of the whole state, or of all but a clock and parameters; false where it is neither.
  bool apply_list(const std::vector<double>& list, std::vector<double>& x) const;
  void apply_columns(const NamedNumbers& values, std::vector<double>& x) const;
  /// What a state is where nothing is said.
  std::vector<double> usual_state() const;
  std::optional<std::vector<double>> checked(std::vector<double> x, const Place& place) const;
  /// Whether a robot has a floating base.
  bool floats(const PlantPart& part) const;
  /// The part that stands for all robots: names have their prefix, there is no base.
  PlantPart whole() const;

  const Plant& plant_;
  Diagnostics& out_;
  std::vector<double> initial_;
};

}  // namespace conddp
