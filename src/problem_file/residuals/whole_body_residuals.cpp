#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "robot/dynamics.hpp"

namespace conddp {
namespace {

const std::vector<std::string> kMomentumNames = {"px", "py", "pz", "lx", "ly", "lz"};

std::optional<CostResidual> make_com_position(const ResidualContext& context) {
  CostResidual result;
  result.residual = com_position_residual(context.plant.multibody());
  result.rows = {"axes of the position", kPositionNames};
  result.parameters = StateManifold::flat(3);
  result.in_state = [system = context.plant.multibody()](const std::vector<double>& x) {
    RobotData<double> data = data_in_state(*system, x);
    update_composite_inertias(system->robot(), data);
    const Vector3<double> c = center_of_mass(system->robot(), data);
    return std::vector{c.x, c.y, c.z};
  };
  return result;
}

std::optional<CostResidual> make_control_gravity(const ResidualContext& context) {
  const std::vector<std::string> tangent = tangent_names(*context.plant.system).names;
  std::vector<std::string> names;
  for (const int row : context.plant.multibody()->actuated_rows()) names.push_back(tangent[row]);
  CostResidual result;
  result.residual = control_gravity_residual(context.plant.multibody(), context.ndx);
  result.rows = {"actuated forces", names};
  return result;
}

std::optional<CostResidual> make_momentum(const ResidualContext& context) {
  CostResidual result;
  result.residual = centroidal_momentum_residual(context.plant.multibody());
  result.rows = result.references = {"components of the momentum", kMomentumNames};
  result.parameters = StateManifold::flat(6);
  result.in_state = [system = context.plant.multibody()](const std::vector<double>& x) {
    RobotData<double> data = data_in_state(*system, x);
    update_composite_inertias(system->robot(), data);
    const Force<double> h = centroidal_momentum(system->robot(), data);
    return std::vector{h[0], h[1], h[2], h[3], h[4], h[5]};
  };
  return result;
}

}  // namespace

std::span<const ResidualDefinition> whole_body_residuals() {
  static const ResidualDefinition all[] = {
      {.name = "com_position",
       .description = "center of mass minus a point of the world",
       .unit = "m",
       .synonyms = {"com", "center_of_mass"},
       .needs = {.robot = true},
       .reference = &kPointReference,
       .is_point = [](const CostSpec&) { return true; },
       .make = make_com_position},
      {.name = "control_gravity",
       .description = "actuated forces minus those that hold the robot against gravity",
       .unit = "Nm or N",
       .synonyms = {"gravity_torque", "gravity"},
       .needs = {.robot = true, .control = true},
       .make = make_control_gravity},
      {.name = "centroidal_momentum",
       .description = "momentum about the center of mass minus a reference",
       .unit = "kg m/s and kg m²/s",
       .synonyms = {"momentum", "angular_momentum"},
       .needs = {.robot = true},
       .reference = &kNumbersReference,
       .make = make_momentum}};
  return all;
}

}  // namespace conddp
