#pragma once

#include "ocp/knot/knot_model.hpp"

namespace conddp {

/// Lane part of a scalar: itself, or the value of a dual number.
inline Lane& lane_of(Lane& a) { return a; }
inline Lane& lane_of(Dual<Lane>& a) { return a.v; }

/// Inputs and workspace for one evaluation of a model, with one knot per lane.
template <class S>
struct KnotBatch {
  explicit KnotBatch(const KnotModel& model)
      : work(model),
        x(model.nx(), S(0.0)),
        u(model.nu(), S(0.0)),
        x_next(model.nx(), S(0.0)),
        parameters(model.parameter_count(), S(0.0)),
        tangent(model.ndx(), S(0.0)),
        lambda(model.ndx(), S(0.0)),
        pulled(model.nz(), S(0.0)),
        penalty(model.constraint_rows(), S(0.0)),
        shift(model.constraint_rows(), S(0.0)),
        multiplier(model.constraint_rows(), S(0.0)),
        dt(0.0),
        cost_scale(0.0) {}

  KnotInput<S> input() const { return at(x.data(), u.data()); }
  /// Input with a state and a control stored elsewhere.
  KnotInput<S> at(const S* state, const S* control) const {
    KnotInput<S> in{state, control, parameters.data(), dt, cost_scale};
    if (augmented) {
      in.penalty = penalty.data();
      in.shift = shift.data();
      in.multiplier = multiplier.data();
    }
    return in;
  }

  KnotWorkspace<S> work;
  AlignedVector<S> x, u, x_next, parameters;
  AlignedVector<S> tangent, lambda, pulled;     ///< scratch: ndx, ndx, nz
  AlignedVector<S> penalty, shift, multiplier;  ///< by constraint row, if augmented
  bool augmented = false;
  S dt, cost_scale;
};

}  // namespace conddp
