#pragma once

#include <string>

#include "analysis/contact/contact_motion.hpp"

namespace conddp {

/// The worst value of a figure over a motion, and where it is.
struct WorstFigure {
  double value = 0;
  int knot = -1;     ///< the step, −1 where nothing is above 0
  std::string what;  ///< the candidate, stop or joint

  /// Not-a-number stays.
  void meet(double candidate, int at, const std::string& name);
};

/// What a motion looks like to whoever knows its plant, positions, velocities, controls and forces
/// alone. Forces over the weight m g are without unit.
struct ContactMeasures {
  WorstFigure stepping;         ///< residual of a step's equations over h m g
  WorstFigure complementarity;  ///< |min(f, φ)| of normal forces and stops, N or m (Nm or rad)
  WorstFigure product;          ///< f φ, J
  WorstFigure penetration;      ///< of rigid contacts and stops at nodes, m or rad
  WorstFigure between;          ///< of rigid contacts at tenths of steps, m
  WorstFigure signs;            ///< of forces that pull, over the weight
  WorstFigure friction;     ///< |f − P(f − v)|, P on the forces that friction allows, N or m/s
  WorstFigure cone;         ///< friction beyond μ f_n, over the weight
  WorstFigure dissipation;  ///< |f_t·v_t + μ f_n ‖v_t‖| over the weight, m/s
  WorstFigure slip;         ///< ‖v_t‖ where the friction force lies inside the cone, m/s
  WorstFigure distant;      ///< gap across which a force acts, m
  WorstFigure work;         ///< that contacts do in a step, J: inelastic ones do none
  double energy_start = 0, energy_end = 0;  ///< J
  double work_controls = 0;                 ///< Σ h uᵀBᵀv⁺, J
  double work_contacts = 0;                 ///< of contacts, stops, dry friction; not above 0
  double work_damping = 0;                  ///< of damping and smoothed friction, J
  /// What the stepping scheme itself loses or gains: the rest of the balance, J.
  double stepping_loss() const {
    return energy_start + work_controls + work_contacts + work_damping - energy_end;
  }
};

/// Measures a motion in scalar code that shares nothing with solvers or transcription
/// (ContactMechanics). A force counts as acting from a millionth of the weight on.
ContactMeasures measure_contacts(const ContactMotion& motion);

}  // namespace conddp
