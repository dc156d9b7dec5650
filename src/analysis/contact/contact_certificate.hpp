#pragma once

#include <functional>
#include <optional>
#include <string>

#include "analysis/certificate/certificate.hpp"
#include "analysis/certificate/replay.hpp"
#include "analysis/contact/contact_motion.hpp"
#include "analysis/contact/contact_simulator.hpp"

namespace conddp {

/// A contact-implicit motion, stepped anew by ContactSimulator.
struct ContactReplay {
  int substeps = 0;  ///< steps of the finer grid per planned step
  /// Every step from its own planned state, in the plan's contact mode if it has a solution.
  ReplayRun each_step;
  /// Steps of that run with a second solution, and the deviation of the worst such solution from
  /// the plan.
  int ambiguous_steps = 0;
  ReplayRun ambiguous;
  ReplayRun each_step_fine;                ///< the same in steps of h / substeps
  ReplayRun controls;                      ///< controls alone from the first state on, likewise
  ReplayRun controls_fine;                 ///< the same in steps of h / substeps
  std::optional<ReplayRun> feedback_fine;  ///< with gains, if the answer has any
};

/// `gains`: K, nu x ndx per knot of the problem, for all controls of a step; only the rows of the
/// actuators count.
ContactReplay replay_contacts(const ContactMotion& motion,
                              const std::vector<Eigen::MatrixXd>& gains, int substeps = 10);

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

/// Certificate of a contact-implicit motion.
struct ContactCertificate {
  ContactMeasures measures;
  std::vector<ContactStretch> sequence;
  std::vector<std::string> candidates;  ///< names of the candidates
  int first_knot = 0;                   ///< first knot of the sequence
  std::optional<ContactReplay> replay;
};

/// Computes measures, sequence and names, but no replay.
ContactCertificate certify_contacts(const ContactMotion& motion);

/// Checks that a converged contact-implicit answer must pass. Its steps are steps of the plant, and
/// each pair of force and distance is complementary. Nothing penetrates or pulls, friction obeys
/// Coulomb's law, and no force acts at a distance. Each check claims 0. docs/verification.md has
/// the formulas and tolerances. `place` names a step and its candidate, stop or joint.
std::vector<Check> contact_checks(
    const ContactMotion& motion, const ContactMeasures& measures,
    const SolverOptions::Tolerances& tolerances,
    const std::function<std::string(int knot, const std::string& what)>& place);

}  // namespace conddp
