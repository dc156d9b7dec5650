#pragma once

#include "ocp/terms/residual.hpp"
#include "systems/multibody/multibody.hpp"

namespace conddp {

/// Helpers shared by residuals of multibody systems.

template <class S>
MultibodySystem::Data<S>& multibody_data(const ResidualInput<S>& in) {
  return static_cast<MultibodySystem::Data<S>&>(in.system);
}

/// Writes rows x columns.count() of a Jacobian. `kernel(out)` writes it with the robot's own
/// columns: in place, or through scratch memory if joints mimic others.
template <class S, class Kernel>
void write_columns(const ReducedColumns& columns, int rows, MultibodySystem::Data<S>& data,
                   S* jacobian, Kernel kernel) {
  if (columns.identity()) return kernel(jacobian);
  kernel(data.mimic.columns.data());
  columns.gather(data.mimic.columns.data(), rows, jacobian);
}

}  // namespace conddp
