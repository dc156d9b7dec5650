#pragma once

#include "problem_file/plant/plant.hpp"

namespace conddp {

/// Parts of build_plant for robots from URDF files.

/// `sha256` receives the SHA-256 of the URDF file.
std::optional<RobotModel> load_robot(const RobotSpec& spec, const std::string& prefix,
                                     const Vector3<double>& gravity, std::string& sha256,
                                     Diagnostics& out);
void add_external_wrenches(const std::vector<PlantPart>& parts, RobotModel& model,
                           Diagnostics& out);
/// Adds the parameters of robots and the loads that depend on them. Reports names that are already
/// taken. Robots with a parameter of the same name share it. Returns the initial values in the
/// order of the model's parameters.
std::vector<double> add_parameters(const std::vector<PlantPart>& parts, RobotModel& model,
                                   Diagnostics& out);
std::optional<Actuation> make_actuation(const std::vector<PlantPart>& parts,
                                        const RobotModel& model, Diagnostics& out);
/// Clears the damping and friction of robots whose file does not enable them.
std::optional<PassiveForces> make_passive_forces(const std::vector<PlantPart>& parts,
                                                 RobotModel& model, Diagnostics& out);

}  // namespace conddp
