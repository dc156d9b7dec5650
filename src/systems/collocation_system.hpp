#pragma once

#include "systems/system.hpp"

namespace conddp {

/// Rules whose last stage is the end of a step: stage i stands at x_i = x + h Σ_j a_ij k_j with the
/// slopes k_j = f(x_j, u), u held or linear in time.
/// - Lobatto IIIA, whose first stage is the beginning of the step: of two stages the trapezoidal
///   rule (order 2), of three Hermite and Simpson's (order 4), whose middle stage lies on the cubic
///   through both ends;
/// - Radau IIA of two and three stages (order 3 and 5), which damp what is infinitely stiff (Hairer
///   and Wanner, Solving Ordinary Differential Equations II, tables IV.5.5 and IV.5.6).
enum class CollocationRule { trapezoidal, hermite_simpson, radau3, radau5 };

/// A system whose steps are implicit: the control is w = (u, k_1, k_2 …) with the slopes of the
/// stages behind the beginning, accelerations of a second-order system and tangent velocities of a
/// first-order one. f, fx and fu are those of the system inside, of which the slope at the knot's
/// own state comes. That the others obey k_i = f(x_i, u) is a constraint (collocation_residual).
/// Positions of a second-order system are integrated by the same rule from the velocities of the
/// stages.
class CollocationSystem : public System {
 public:
  /// Throws std::invalid_argument where the state space is curved or the system knows no time.
  CollocationSystem(std::shared_ptr<const System> inside, CollocationRule rule);

  /// The system without the slopes, whose controls are the actuators.
  const std::shared_ptr<const System>& inside() const { return inside_; }
  const CollocationSystem* as_collocation() const override { return this; }
  const MultibodySystem* robot_inside() const override { return inside_->robot_inside(); }
  std::vector<std::string> failed_functions() const override { return inside_->failed_functions(); }
  bool has_claimed_hessian() const override { return inside_->has_claimed_hessian(); }
  CollocationRule rule() const { return rule_; }
  /// Stages whose slopes are controls: 1 to later_stages(), the last one the end of the step.
  int later_stages() const;
  /// When a later stage is, as a share of the step.
  double time(int stage) const;
  /// With which share of the step the slope of a stage counts at the end of it; 0 is the one at the
  /// beginning.
  double weight(int stage) const;
  /// Where the slopes of a later stage start in w: rows() numbers.
  int slopes(int stage) const { return actuators() + (stage - 1) * rows(); }
  int actuators() const override { return inside_->nu(); }

  /// x_i, nx numbers, of a step of h from the system's data at (x, w).
  template <class S>
  void stage(int i, const S* x, const S* w, const S& h, const SystemData<S>& data, S* out) const;
  /// ∂x_i/∂(x, w), ndx x (ndx + nu) by columns, and with `by_step` a further column by h. The data
  /// must have been differentiated.
  template <class S>
  void differentiate_stage(int i, const S* x, const S* w, const S& h, const SystemData<S>& data,
                           bool by_step, S* X) const;

  /// What a step's later stages need, in SystemData::later.
  template <class S>
  struct Later : SystemData<S> {
    Later(const CollocationSystem& system, std::unique_ptr<SystemData<S>> inside);
    std::unique_ptr<SystemData<S>> inside;  ///< of the system inside at a stage
    AlignedVector<S> x, X;                  ///< a stage and its derivative, with that by h
    AlignedVector<S> u;                     ///< the controls there, where they are linear
  };

#define CONDDP_OVERRIDE(S)                                                         \
  std::unique_ptr<SystemData<S>> create_data(S) const override;                    \
  void evaluate(const S* x, const S* w, SystemData<S>& data) const override {      \
    inside_->evaluate(x, w, data);                                                 \
  }                                                                                \
  void differentiate(const S* x, const S* w, SystemData<S>& data) const override { \
    inside_->differentiate(x, w, data);                                            \
  }                                                                                \
  void update_kinematics(const S* x, SystemData<S>& data) const override {         \
    inside_->update_kinematics(x, data);                                           \
  }
  CONDDP_FOR_EACH_SCALAR(CONDDP_OVERRIDE)
#undef CONDDP_OVERRIDE

 private:
  template <class S>
  void differentiate_by_step(int i, const S* x, const S* w, const S& h, const SystemData<S>& data,
                             S* column) const;

  std::shared_ptr<const System> inside_;
  CollocationRule rule_;
};

}  // namespace conddp
