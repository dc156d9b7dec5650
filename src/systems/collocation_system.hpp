#pragma once

#include "systems/system.hpp"

namespace conddp {

/// Rules whose last stage is the end of a step: stage i is x_i = x + h Σ_j a_ij k_j with the slopes
/// k_j = f(x_j, u). The control u is constant or linear in time.
/// - Lobatto IIIA, whose first stage is the beginning of the step. With two stages it is the
///   trapezoidal rule (order 2). With three it is the Hermite-Simpson rule (order 4), whose middle
///   stage lies on the cubic through both ends;
/// - Radau IIA with two and three stages (order 3 and 5), which damps infinitely stiff modes
///   (Hairer and Wanner, Solving Ordinary Differential Equations II, tables IV.5.5 and IV.5.6).
enum class CollocationRule { trapezoidal, hermite_simpson, radau3, radau5 };

/// A system with implicit steps. The control is w = (u, k_1, k_2 …) with the slopes k_i of the
/// later stages. Slopes are accelerations of a second-order system, or tangent velocities of a
/// first-order one. The wrapped system's f, fx and fu give the slope at the knot's own state. A
/// constraint enforces k_i = f(x_i, u) for the other slopes (collocation_residual). The same rule
/// integrates the positions of a second-order system from the velocities of the stages.
class CollocationSystem : public System {
 public:
  /// Throws std::invalid_argument if the state space is curved or the system is not in continuous
  /// time.
  CollocationSystem(std::shared_ptr<const System> inside, CollocationRule rule);

  /// The system without the slopes; its controls are the actuators.
  const std::shared_ptr<const System>& inside() const { return inside_; }
  const CollocationSystem* as_collocation() const override { return this; }
  const MultibodySystem* robot_inside() const override { return inside_->robot_inside(); }
  std::vector<std::string> failed_functions() const override { return inside_->failed_functions(); }
  bool has_claimed_hessian() const override { return inside_->has_claimed_hessian(); }
  CollocationRule rule() const { return rule_; }
  /// Number of stages whose slopes are controls. They have indices 1 to later_stages(); the last is
  /// the end of the step.
  int later_stages() const;
  /// Time of a later stage, as a fraction of the step.
  double time(int stage) const;
  /// Weight of a stage's slope at the end of the step; stage 0 is the beginning.
  double weight(int stage) const;
  /// Index in w of the slopes of a later stage, rows() numbers.
  int slopes(int stage) const { return actuators() + (stage - 1) * rows(); }
  int actuators() const override { return inside_->nu(); }

  /// Writes x_i (nx numbers) for a step of length h, from the system's data at (x, w).
  template <class S>
  void stage(int i, const S* x, const S* w, const S& h, const SystemData<S>& data, S* out) const;
  /// Writes ∂x_i/∂(x, w), ndx x (ndx + nu) by columns, and with `by_step` an additional column for
  /// h. The data must have been differentiated.
  template <class S>
  void differentiate_stage(int i, const S* x, const S* w, const S& h, const SystemData<S>& data,
                           bool by_step, S* X) const;

  /// Workspace for the later stages of a step, stored in SystemData::later.
  template <class S>
  struct Later : SystemData<S> {
    Later(const CollocationSystem& system, std::unique_ptr<SystemData<S>> inside);
    std::unique_ptr<SystemData<S>> inside;  ///< data of the wrapped system at a stage
    AlignedVector<S> x, X;  ///< a stage and its derivative, including that with respect to h
    AlignedVector<S> u;     ///< controls at a stage if they are linear in time
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
