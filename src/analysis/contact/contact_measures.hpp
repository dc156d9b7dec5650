#pragma once

#include <string>

#include "analysis/contact/contact_motion.hpp"

namespace conddp {

/// The worst value of a figure over a motion, and its place.
struct WorstFigure {
  double value = 0;
  int knot = -1;     ///< the step, or −1 if nothing is above 0
  std::string what;  ///< the candidate, stop or joint

  /// Keeps NaN once it is met.
  void meet(double candidate, int at, const std::string& name);
};

/// Figures of a motion that follow from its plant, positions, velocities, controls and forces only.
/// Forces over the weight m g are dimensionless.
struct ContactMeasures {
  WorstFigure stepping;         ///< residual of a step's equations over h m g
  WorstFigure complementarity;  ///< |min(f, φ)| of normal forces and stops, N or m (Nm or rad)
  WorstFigure product;          ///< f φ, J
  WorstFigure penetration;      ///< rigid contacts and stops at nodes, m or rad
  WorstFigure between;          ///< penetration of rigid contacts at tenths of steps, m
  WorstFigure signs;            ///< pulling force over the weight
  WorstFigure friction;     ///< |f − P(f − v)|, P projects on the admissible friction, N or m/s
  WorstFigure cone;         ///< friction beyond μ f_n, over the weight
  WorstFigure dissipation;  ///< |f_t·v_t + μ f_n ‖v_t‖| over the weight, m/s
  WorstFigure slip;         ///< ‖v_t‖ where the friction force lies inside the cone, m/s
  WorstFigure distant;      ///< gap across which a force acts, m
  WorstFigure work;         ///< work of contacts in a step, J; zero for inelastic ones
  double energy_start = 0, energy_end = 0;  ///< J
  double work_controls = 0;                 ///< Σ h uᵀBᵀv⁺, J
  double work_contacts = 0;                 ///< contacts, stops and dry friction, J; at most 0
  double work_damping = 0;                  ///< damping and smoothed friction, J
  /// Energy that the stepping scheme itself loses, the rest of the balance, J; negative for a gain.
  double stepping_loss() const {
    return energy_start + work_controls + work_contacts + work_damping - energy_end;
  }
};

/// Measures a motion in scalar code that shares nothing with solvers or transcription
/// (ContactMechanics). A force counts as acting above a millionth of the weight.
ContactMeasures measure_contacts(const ContactMotion& motion);

}  // namespace conddp
