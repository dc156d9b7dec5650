#pragma once

#include <optional>
#include <string>

#include "ocp/terms/constraint.hpp"
#include "ocp/terms/residual.hpp"
#include "systems/contact/stepping_system.hpp"

namespace conddp {

/// Residual of every step of a stepping system, zero at its end q⁺, v⁺:
/// - the equations of motion M(q⁺) a + c(q⁺, v⁺) − B u − Σ Jᵀf (backward Euler, with a = (v⁺ −
///   v)/h);
/// - for each candidate: s_n − φ(q⁺) [− f_n/stiffness], s_i − (γ ± D(q⁺) v⁺) for each direction of
///   friction, s_γ − (μ f_n − Σ f_i); with a cone instead (ConeIndices) γ e − v_t, f_t + μ f_n e
///   and s − (1 − ‖e‖²);
/// - for each stop: its distance from the limit; for each dry friction: the friction rows of a
///   candidate.
/// Parameter: the step h, s, which a free duration scales (not that of the midpoint rule, whose
/// steps have one length). ndx belongs to the knot model.
std::shared_ptr<const Residual> stepping_residual(
    const std::shared_ptr<const SteppingSystem>& system, int ndx,
    const std::optional<FreeDuration>& duration = {});
/// Names of the rows, for messages and files.
std::vector<std::string> stepping_row_names(const SteppingSystem& system);

/// z_0, s_0, z_1, s_1, …: the complementary pairs of a stepping system, for a constraint of kind
/// complementarity. ndx belongs to the knot model. No parameters.
std::shared_ptr<const Residual> stepping_pairs_residual(const SteppingSystem& system, int ndx);

/// Selected entries of the control. ndx belongs to the knot model. No parameters.
std::shared_ptr<const Residual> chosen_controls_residual(int ndx, const std::vector<int>& indices);

}  // namespace conddp
