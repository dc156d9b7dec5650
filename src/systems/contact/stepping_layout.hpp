#pragma once

#include <array>
#include <utility>
#include <vector>

#include "systems/contact/contact_candidate.hpp"
#include "systems/system.hpp"

namespace conddp {

/// Forces of maximally dissipative dry friction: each ≥ 0, along ± the tangents, with a sum of at
/// most `budget`. Pairs: f_i ⊥ s_i = γ ± v_t, and γ ⊥ s_γ = budget − Σ f_i.
struct FrictionIndices {
  int count = 0;  ///< directions: two per tangent, positive sign first; 0: no friction
  std::array<int, 4> force{}, slip{};  ///< f_i and s_i
  int gamma = 0, rest = 0;             ///< γ and s_γ
};

/// Maximally dissipative friction in the cone ‖f_t‖ ≤ μ f_n for a slip v_t along two tangents. The
/// vector e is the used fraction of friction: f_t = −μ f_n e and v_t = γ e with ‖e‖ ≤ 1 and the
/// single pair γ ⊥ s = 1 − ‖e‖². For f_n > 0 these are the conditions of the cone, (μ f_n, f_t) ⊥
/// (γ, v_t) in second-order cones. In contrast to the latter, all rows have full rank at the tip of
/// the cone too.
struct ConeIndices {
  /// Equations: v_t = γ e, f_t = −μ f_n e, s = 1 − ‖e‖².
  static constexpr int kRows = 5;
  bool present = false;
  std::array<int, 2> force{}, use{};  ///< f_t and e, along the tangents
  int speed = 0, rest = 0;            ///< γ and s
};

/// Layout of the controls w of a stepping system: the actuators u, the accelerations a, then forces
/// and the slacks of their complementarity conditions. All forces and slacks belong to the end of
/// the step. Forces are means over the step, N or Nm.
struct SteppingLayout {
  struct Candidate {
    int force = 0, gap = 0;    ///< f_n and s_n = φ, or φ + f_n/stiffness
    FrictionIndices friction;  ///< for the pyramid
    ConeIndices cone;          ///< for the cone
  };
  /// One side of a stop: its force, ≥ 0 and directed away from the limit, and the distance to it.
  struct Stop {
    int joint = 0;
    int position = 0, velocity = 0;  ///< index in configurations and velocities
    bool upper = false;
    double limit = 0;  ///< rad or m
    int force = 0, distance = 0;
  };

  int actuators = 0;     ///< size of u, which comes first
  int acceleration = 0;  ///< start of a
  int nv = 0;
  std::vector<Candidate> candidates;  ///< in the order of the description, like the next two
  std::vector<Stop> stops;            ///< finite sides, lower before upper
  std::vector<FrictionIndices> frictions;
  std::vector<int> friction_velocities;  ///< velocity indices of the joints with friction
  std::vector<std::pair<int, int>> pairs;  ///< all complementarity conditions: 0 ≤ w_i ⊥ w_j ≥ 0
  std::vector<Column> columns;             ///< names and units of all of w

  int size() const { return static_cast<int>(columns.size()); }

  /// The layout for a robot with these actuators.
  SteppingLayout(const RobotModel& robot, const std::vector<Column>& actuator_columns,
                 const ImplicitContacts& contacts);
};

}  // namespace conddp
