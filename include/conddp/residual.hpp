// Residuals r(x, u; parameters): what costs and constraints are built from.
//
// What is there: state_residual, control_residual, frame_position_residual, contact_force_residual,
// distance_residual, ... (residuals.hpp below). A cost is a residual and an Activation, a(r), by
// default ½‖r‖²; a constraint is a residual and a set (ConstraintTerm).
//
// A residual of your own derives from ResidualBase and writes its values and its Jacobian:
//
//   class LoadPosition : public ResidualBase<LoadPosition> {  // (s + l sin φ, −l cos φ) −
//   reference
//    public:
//     explicit LoadPosition(double length)
//         : ResidualBase({{.rows = 2, .columns = {0, 1}}}, /*parameters*/ 2, /*control*/ false),
//           length_(length) {}
//     template <class S>
//     void evaluate_as(const ResidualInput<S>& in, S* r) const {
//       r[0] = in.x[0] + S(length_) * sin(in.x[1]) - in.parameters[0];
//       r[1] = -S(length_) * cos(in.x[1]) - in.parameters[1];
//     }
//     template <class S>
//     void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
//       evaluate_as(in, r);
//       jacobian[0] = S(1.0), jacobian[1] = S(0.0);  // column 0, by the position s
//       jacobian[2] = S(length_) * cos(in.x[1]), jacobian[3] = S(length_) * sin(in.x[1]);
//     }
//   ...
//
// Its blocks say on which columns of z = (tangent at x, u) their rows depend; solvers compute and
// store nothing else. The Jacobian is packed, block after block, each by columns. `in.parameters`
// are numbers that every knot has of its own, usually the reference. Like rates of systems, both
// functions are called with double, Lane and dual numbers, and do not branch on values.
#pragma once

#include "ocp/residuals/residuals.hpp"
#include "ocp/terms/activation.hpp"
#include "ocp/terms/constraint.hpp"
#include "ocp/terms/residual.hpp"
