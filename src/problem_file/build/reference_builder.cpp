#include "problem_file/build/reference_builder.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "base/spelling.hpp"
#include "robot/dynamics.hpp"
#include "robot/frames.hpp"

namespace conddp {
namespace {

using Numbers = std::optional<std::vector<double>>;

class ReferenceBuilder {
 public:
  ReferenceBuilder(const CostSpec& cost, const CostResidual& residual, const Plant& plant,
                   const StateBuilder& states, Diagnostics& out)
      : cost_(cost), residual_(residual), plant_(plant), states_(states), out_(out) {}

  Numbers value(const ReferenceValueSpec& spec) const {
    if (spec.name) {
      const Numbers state = states_.named(*spec.name);
      return state ? from_state(*state) : std::nullopt;
    }
    if (spec.state) {
      const Numbers state = states_.build(*spec.state);
      return state ? from_state(*state) : std::nullopt;
    }
    if (spec.components) return from_components(*spec.components);
    if (spec.twist) {
      const auto& [linear, angular] = std::pair(spec.twist->linear, spec.twist->angular);
      return std::vector{linear.x, linear.y, linear.z, angular.x, angular.y, angular.z};
    }
    return from_pose(*spec.pose);
  }

  /// Warns of positions outside of the joints' limits; whether there are any. Zero may stand for a
  /// joint that is not mentioned, and the initial state has been looked at.
  bool check_limits(const ReferenceValueSpec& spec, const std::vector<double>& value) const {
    if (cost_.kind != ResidualKind::kState && cost_.kind != ResidualKind::kJointPosition)
      return false;
    if (spec.name && spec.name->value == "initial") return false;
    std::vector<double> x(plant_.system->manifold().nx(), std::nan(""));
    for (std::size_t i = 0; i < value.size(); ++i) {
      const std::size_t entry = residual_.indices.empty() ? i : residual_.indices[i];
      if (entry < x.size() && value[i] != 0) x[entry] = value[i];
    }
    const auto place_of = [&](const std::string& joint) {
      Place place = spec.place;
      const auto look = [&](const auto& named) {
        for (const auto& [name, number] : named)
          if (name.value == joint || name.value == "q/" + joint) place = name.place;
      };
      if (spec.components) look(spec.components->map);
      if (spec.state) look(spec.state->joints);
      return place;
    };
    return states_.check_limits(fmt::format("the reference of '{}'", cost_.name.value), x,
                                place_of);
  }

  /// What stands for a reference that the file leaves out.
  Numbers absent() const {
    switch (cost_.kind) {
      case ResidualKind::kFramePosition:
      case ResidualKind::kComPosition:
        if (cost_.activation.kind == ActivationKind::quadratic_barrier) break;
        [[fallthrough]];
      case ResidualKind::kFrameRotation:
      case ResidualKind::kFramePlacement:
        out_.error(cost_.name.place, fmt::format("'{}' needs a reference", cost_.name.value),
                   "a configuration's name, 'initial', or numbers");
        return std::nullopt;
      default:
        break;
    }
    return residual_.parameters.neutral();
  }

 private:
  /// The value of the residual's quantity in a state.
  Numbers from_state(const std::vector<double>& x) const {
    if (!residual_.indices.empty()) {
      std::vector<double> values;
      for (const int i : residual_.indices)
        values.push_back(cost_.kind == ResidualKind::kJointAcceleration ? 0.0 : x[i]);
      return values;
    }
    if (cost_.kind == ResidualKind::kState) return x;
    const MultibodySystem& system = *plant_.multibody();
    const RobotModel& robot = plant_.robot();
    RobotData<double> data(robot);
    const std::vector<double> q =
        system.expand_configuration(std::vector(x.begin(), x.begin() + system.nq()));
    update_placements(robot, q.data(), data);
    if (cost_.kind == ResidualKind::kComPosition) {
      update_composite_inertias(robot, data);
      const Vector3<double> c = center_of_mass(robot, data);
      return std::vector{c.x, c.y, c.z};
    }
    if (cost_.kind == ResidualKind::kFrameVelocity ||
        cost_.kind == ResidualKind::kCentroidalMomentum) {
      const std::vector<double> velocity =
          system.expand_velocity(std::vector(x.begin() + system.nq(), x.end()));
      update_velocities(robot, velocity.data(), data);
      if (cost_.kind == ResidualKind::kCentroidalMomentum) {
        update_composite_inertias(robot, data);
        const Force<double> h = centroidal_momentum(robot, data);
        return std::vector{h[0], h[1], h[2], h[3], h[4], h[5]};
      }
      const Motion<double> v = conddp::frame_velocity(robot, data, residual_.frame, cost_.axes);
      return std::vector{v[0], v[1], v[2], v[3], v[4], v[5]};
    }
    const SE3<double> pose = conddp::frame_placement(robot, data, residual_.frame);
    return pose_numbers(pose.p, quaternion(pose.R));
  }

  Numbers pose_numbers(const Vector3<double>& p, const Quaternion<double>& q) const {
    if (cost_.kind == ResidualKind::kFrameRotation) return std::vector{q.x, q.y, q.z, q.w};
    if (cost_.kind == ResidualKind::kFramePlacement)
      return std::vector{p.x, p.y, p.z, q.x, q.y, q.z, q.w};
    return std::vector{p.x, p.y, p.z};
  }

  Numbers from_pose(const PoseSpec& pose) const {
    const bool position = cost_.kind != ResidualKind::kFrameRotation;
    const bool rotation =
        cost_.kind == ResidualKind::kFrameRotation || cost_.kind == ResidualKind::kFramePlacement;
    if ((position && !pose.position) || (rotation && !pose.orientation)) {
      out_.error(pose.place, position && !pose.position
                                 ? "the reference lacks 'position'"
                                 : "the reference lacks 'orientation' or 'rpy'");
      return std::nullopt;
    }
    return pose_numbers(pose.position.value_or(Vector3<double>::zero()),
                        pose.orientation.value_or(Quaternion<double>::identity()));
  }

  Numbers from_components(const ComponentsSpec& spec) const {
    if (cost_.kind == ResidualKind::kState && !cost_.columns &&
        spec.form == ComponentsSpec::Form::kScalar) {
      out_.error(spec.place, "one number is not a state",
                 "a configuration's name, 'initial', a list, or '{values: {column: number}}'");
      return std::nullopt;
    }
    Numbers numbers = resolve(spec, residual_.references, 0.0, out_);
    if (numbers && !residual_.parameters.normalize(numbers->data())) {
      out_.error(spec.place, "a quaternion of the state has not length 1");
      return std::nullopt;
    }
    return numbers;
  }

  const CostSpec& cost_;
  const CostResidual& residual_;
  const Plant& plant_;
  const StateBuilder& states_;
  Diagnostics& out_;
};

/// The columns of a file that hold a reference: those named, else those of the quantity itself.
std::optional<std::vector<std::string>> file_columns(const CostSpec& cost,
                                                     const CostResidual& residual,
                                                     const Plant& plant, Diagnostics& out) {
  const DataFileSpec& file = *cost.reference->file;
  const std::size_t count = residual.parameters.nx();
  std::vector<std::string> columns;
  if (!file.columns.empty()) {
    for (const Name& name : file.columns) columns.push_back(name.value);
    if (columns.size() == count) return columns;
    out.error(file.file.place, fmt::format("the cost '{}' takes {} columns, not {}",
                                           cost.name.value, count, columns.size()));
    return std::nullopt;
  }
  const ComponentNames states = state_names(*plant.system);
  if (cost.kind == ResidualKind::kControl) return control_names(plant.actuated()).names;
  if (cost.kind == ResidualKind::kState && !cost.columns) return states.names;
  if (cost.kind == ResidualKind::kState || cost.kind == ResidualKind::kJointPosition ||
      cost.kind == ResidualKind::kJointVelocity) {
    for (const int i : residual.indices) columns.push_back(states.names[i]);
    return columns;
  }
  out.error(file.file.place, fmt::format("say which {} columns of the file to use", count),
            "columns: [...]");
  return std::nullopt;
}

}  // namespace

std::optional<TimeSeries> series_of(const DataFileSpec& file, const DataTable& table,
                                    const std::vector<std::string>& columns,
                                    const StateManifold& manifold, Diagnostics& out) {
  std::vector<std::size_t> indices;
  bool complete = true;
  for (const std::string& column : columns) {
    const auto index = table.find(column);
    if (index) {
      indices.push_back(*index);
      continue;
    }
    out.error(file.file.place, fmt::format("'{}' has no column '{}'", file.file.value, column),
              name_hint(column, table.columns, "its columns"));
    complete = false;
  }
  if (!complete) return std::nullopt;
  TimeSeries series(manifold);
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    std::vector<double> value;
    for (const std::size_t i : indices)
      if (table.rows[row][i]) value.push_back(*table.rows[row][i]);
    if (value.size() != indices.size()) continue;
    if (!manifold.normalize(value.data())) {
      out.error(file.file.place,
                fmt::format("'{}' has a quaternion that has not length 1 at t = {}",
                            file.file.value, table.times[row]));
      return std::nullopt;
    }
    series.append(table.times[row], std::move(value));
  }
  if (!series.empty()) return series;
  out.error(file.file.place, fmt::format("'{}' has no complete row", file.file.value));
  return std::nullopt;
}

std::optional<TimeSeries> build_reference(const CostSpec& cost, const CostResidual& residual,
                                          const Plant& plant, const StateBuilder& states,
                                          const std::vector<double>& times, Diagnostics& out) {
  const ReferenceBuilder builder(cost, residual, plant, states, out);
  const StateManifold& manifold = residual.parameters;
  if (!cost.reference) {
    const auto value = builder.absent();
    if (!value) return std::nullopt;
    return TimeSeries(manifold, *value);
  }
  const ReferenceSpec& spec = *cost.reference;
  if (spec.file) {
    const auto columns = file_columns(cost, residual, plant, out);
    if (!columns) return std::nullopt;
    const auto table = load_data_table(spec.file->path, spec.file->file.place, out);
    if (!table) return std::nullopt;
    return series_of(*spec.file, *table, *columns, manifold, out);
  }
  TimeSeries series(manifold);
  bool complete = true, outside = false;
  for (std::size_t i = 0; i < spec.values.size(); ++i) {
    double time = spec.times.empty() ? 0.0 : spec.times[i].value;
    if (!spec.knots.empty()) {
      const Located<int>& knot = spec.knots[i];
      if (knot.value >= static_cast<int>(times.size())) {
        out.error(knot.place, fmt::format("knot {} lies behind the last one, {}", knot.value,
                                          times.size() - 1));
        complete = false;
        continue;
      }
      time = times[knot.value];
    }
    const auto value = builder.value(spec.values[i]);
    complete &= value.has_value();
    if (!value) continue;
    outside = outside || builder.check_limits(spec.values[i], *value);
    series.append(time, *value);
  }
  if (!complete) return std::nullopt;
  return series;
}

}  // namespace conddp
