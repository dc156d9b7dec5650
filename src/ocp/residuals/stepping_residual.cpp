#include "ocp/residuals/stepping_residual.hpp"

#include <algorithm>

#include "ocp/residuals/stepping_rows.hpp"

namespace conddp {
namespace {

using SystemPointer = std::shared_ptr<const SteppingSystem>;

class ChosenControls : public ResidualBase<ChosenControls> {
 public:
  ChosenControls(int ndx, std::vector<int> indices)
      : ResidualBase(blocks_of(ndx, indices), 0, true), indices_(std::move(indices)) {}

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    for (std::size_t i = 0; i < indices_.size(); ++i) r[i] = in.u[indices_[i]];
  }
  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    evaluate_as(in, r);
    std::fill_n(jacobian, size(), S(1.0));
  }

 private:
  static std::vector<RowBlock> blocks_of(int ndx, const std::vector<int>& indices) {
    std::vector<RowBlock> blocks;
    for (const int i : indices) blocks.push_back({1, {ndx + i}, true});
    return blocks;
  }
  std::vector<int> indices_;
};

class SteppingResidual : public ResidualBase<SteppingResidual> {
 public:
  SteppingResidual(SystemPointer system, const SteppingRows& structure)
      : ResidualBase(structure.blocks, 1, true),
        system_(std::move(system)),
        n_(system_->nv()),
        constants_(structure.constants),
        force_column_(system_->layout().size(), -1) {
    for (std::size_t i = 0; i < structure.forces.size(); ++i)
      force_column_[structure.forces[i]] =
          2 * n_ + system_->layout().actuators + n_ + static_cast<int>(i);
  }

  Reads reads() const override { return Reads::kinematics; }

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    auto& data = static_cast<SteppingSystem::Data<S>&>(in.system);
    system_->take_step(in.x, in.u, in.parameters[0], false, data);
    write_values(in.u, data, r);
  }

  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    auto& data = static_cast<SteppingSystem::Data<S>&>(in.system);
    system_->take_step(in.x, in.u, in.parameters[0], true, data);
    write_values(in.u, data, r);
    std::fill_n(jacobian, jacobian_size(), S(0.0));
    const S h = in.parameters[0];
    jacobian = differentiate_motion(in.u, h, data, jacobian);
    const SteppingLayout& w = system_->layout();
    const std::vector<double>* row = constants_.data();
    for (std::size_t c = 0; c < w.candidates.size(); ++c)
      jacobian = differentiate_candidate(static_cast<int>(c), in.u, h, data, row, jacobian);
    differentiate_joints(h, row, jacobian);
  }

 private:
  /// Rows of stops and dry friction, `row` being the first of them.
  template <class S>
  void differentiate_joints(const S& h, const std::vector<double>* row, S* jacobian) const {
    const SteppingLayout& w = system_->layout();
    for (const SteppingLayout::Stop& stop : w.stops) {
      const S slope(stop.upper ? 1.0 : -1.0);
      *jacobian++ = slope;
      *jacobian++ = h * slope;
      *jacobian++ = h * h * slope;
      jacobian = write_constants(*row++, jacobian);
    }
    for (const FrictionIndices& f : w.frictions) {
      for (int i = 0; i < f.count; ++i) {
        const S slope(i == 0 ? -1.0 : 1.0);
        *jacobian++ = slope;
        *jacobian++ = h * slope;
        jacobian = write_constants(*row++, jacobian);
      }
      jacobian = write_constants(*row++, jacobian);
    }
  }

  /// Calls use(entry of the control, row of the geometry, sign) for each force of a candidate.
  template <class F>
  static void for_each_force(const SteppingLayout::Candidate& at, F use) {
    use(at.force, 0, 1.0);
    for (int i = 0; i < at.friction.count; ++i)
      use(at.friction.force[i], 1 + i / 2, i % 2 == 0 ? 1.0 : -1.0);
    for (int i = 0; at.cone.present && i < 2; ++i) use(at.cone.force[i], 1 + i, 1.0);
  }

  /// Calls use(entry of the control, velocity, sign) for each generalized force of stops and dry
  /// friction.
  template <class F>
  void for_each_joint_force(F use) const {
    const SteppingLayout& w = system_->layout();
    for (const SteppingLayout::Stop& stop : w.stops)
      use(stop.force, stop.velocity, stop.upper ? -1.0 : 1.0);
    for (std::size_t i = 0; i < w.frictions.size(); ++i)
      for (int k = 0; k < 2; ++k)
        use(w.frictions[i].force[k], w.friction_velocities[i], k == 0 ? 1.0 : -1.0);
  }

  template <class S>
  void write_values(const S* u, const SteppingSystem::Data<S>& data, S* r) const {
    const SteppingLayout& w = system_->layout();
    write_motion(u, data, r);
    r += n_;
    for (std::size_t c = 0; c < w.candidates.size(); ++c)
      r = write_candidate(static_cast<int>(c), u, data, r);
    for (const SteppingLayout::Stop& stop : w.stops) {
      const S above = data.q[stop.position] - S(stop.limit);
      *r++ = u[stop.distance] - (stop.upper ? -above : above);
    }
    for (std::size_t i = 0; i < w.frictions.size(); ++i) {
      const JointFriction& friction = system_->contacts().frictions[i];
      r = write_friction(
          w.frictions[i], S(friction.limit), u,
          [&](int) { return data.v[w.friction_velocities[i]]; }, r);
    }
  }

  template <class S>
  void write_motion(const S* u, const SteppingSystem::Data<S>& data, S* r) const {
    const SteppingLayout& w = system_->layout();
    std::copy_n(data.motion.data(), n_, r);
    for (std::size_t c = 0; c < w.candidates.size(); ++c) {
      const std::vector<int>& joints = system_->geometry()[c].columns();
      const int k = static_cast<int>(joints.size());
      for_each_force(w.candidates[c], [&](int entry, int row, double sign) {
        for (int j = 0; j < k; ++j)
          r[joints[j]] -= S(sign) * u[entry] * data.candidates[c].rows[row * k + j];
      });
    }
    for_each_joint_force(
        [&](int entry, int joint, double sign) { r[joint] -= S(sign) * u[entry]; });
  }

  /// Rows of gap and friction.
  template <class S>
  S* write_candidate(int c, const S* u, const SteppingSystem::Data<S>& data, S* r) const {
    const SteppingLayout::Candidate& at = system_->layout().candidates[c];
    const ContactCandidate& candidate = system_->contacts().candidates[c];
    const std::vector<int>& joints = system_->geometry()[c].columns();
    const CandidateRows<S>& rows = data.candidates[c];
    const int k = static_cast<int>(joints.size());
    *r = u[at.gap] - rows.gap;
    if (candidate.stiffness) *r -= S(1 / *candidate.stiffness) * u[at.force];
    ++r;
    const S budget = S(candidate.friction) * u[at.force];
    const auto speed = [&](int tangent) {
      S sum(0.0);
      for (int j = 0; j < k; ++j) sum += rows.rows[(1 + tangent) * k + j] * data.v[joints[j]];
      return sum;
    };
    r = write_friction(at.friction, budget, u, speed, r);
    return at.cone.present ? write_cone(at.cone, budget, u, speed, r) : r;
  }

  /// s_i − (γ ± speed along the tangent) for each direction, s_γ − (budget − Σ f_i).
  template <class S, class Speed>
  static S* write_friction(const FrictionIndices& f, const S& budget, const S* u, Speed speed,
                           S* r) {
    if (f.count == 0) return r;
    S rest = budget;
    for (int i = 0; i < f.count; ++i) {
      const S v = speed(i / 2);
      *r++ = u[f.slip[i]] - u[f.gamma] - (i % 2 == 0 ? v : -v);
      rest -= u[f.force[i]];
    }
    *r++ = u[f.rest] - rest;
    return r;
  }

  /// γ e − v_t, f_t + budget e, s − (1 − ‖e‖²).
  template <class S, class Speed>
  static S* write_cone(const ConeIndices& cone, const S& budget, const S* u, Speed speed, S* r) {
    S rest = u[cone.rest] - S(1.0);
    for (int i = 0; i < 2; ++i) {
      const S e = u[cone.use[i]];
      r[i] = u[cone.speed] * e - speed(i);
      r[2 + i] = u[cone.force[i]] + budget * e;
      rest += e * e;
    }
    r[4] = rest;
    return r + ConeIndices::kRows;
  }

  template <class S>
  static S* write_constants(const std::vector<double>& slopes, S* jacobian) {
    for (const double slope : slopes) *jacobian++ = S(slope);
    return jacobian;
  }

  template <class S>
  S* differentiate_motion(const S* u, const S& h, SteppingSystem::Data<S>& data,
                          S* jacobian) const {
    const SteppingLayout& w = system_->layout();
    S* by_q = jacobian;
    S* by_v = jacobian + n_ * n_;
    S* by_u = jacobian + 2 * n_ * n_;
    S* by_a = by_u + n_ * w.actuators;
    std::copy_n(data.motion_q.data(), n_ * n_, by_q);
    std::copy_n(data.motion_v.data(), n_ * n_, by_v);
    std::copy_n(data.motion_a.data(), n_ * n_, by_a);
    const std::vector<double>& B = system_->multibody().actuation().B;
    for (int i = 0; i < n_ * w.actuators; ++i) by_u[i] = S(-B[i]);
    const S h2 = h * h;
    for (std::size_t c = 0; c < w.candidates.size(); ++c) {
      const std::vector<int>& joints = system_->geometry()[c].columns();
      const CandidateRows<S>& rows = data.candidates[c];
      const int k = static_cast<int>(joints.size());
      const int m = static_cast<int>(rows.rows.size());
      for_each_force(w.candidates[c], [&](int entry, int row, double sign) {
        const S force = S(sign) * u[entry];
        S* column = jacobian + force_column_[entry] * n_;
        for (int j = 0; j < k; ++j) column[joints[j]] = S(-sign) * rows.rows[row * k + j];
        for (int i = 0; i < k; ++i)
          for (int j = 0; j < k; ++j) {
            // J is evaluated at q⁺ = q + h v + h² a.
            const int e = joints[i] * n_ + joints[j];
            const S slope = force * rows.slopes[i * m + row * k + j];
            by_q[e] -= slope;
            by_v[e] -= h * slope;
            by_a[e] -= h2 * slope;
          }
      });
    }
    for_each_joint_force([&](int entry, int joint, double sign) {
      jacobian[force_column_[entry] * n_ + joint] = S(-sign);
    });
    const auto& curved = system_->configurations().curved();
    for (std::size_t p = 0; p < curved.size(); ++p)
      system_->bend(data, static_cast<int>(p), h, n_, curved[p].dx, by_q, by_v, by_a);
    return jacobian + n_ * static_cast<int>(blocks().front().columns.size());
  }

  template <class S>
  S* differentiate_candidate(int c, const S* u, const S& h, const SteppingSystem::Data<S>& data,
                             const std::vector<double>*& row_constants, S* jacobian) const {
    const SteppingLayout::Candidate& at = system_->layout().candidates[c];
    const CandidateRows<S>& rows = data.candidates[c];
    const int k = static_cast<int>(system_->geometry()[c].columns().size());
    for (int j = 0; j < k; ++j) {
      jacobian[j] = -rows.rows[j];
      jacobian[k + j] = h * jacobian[j];
      jacobian[2 * k + j] = h * jacobian[k + j];
    }
    bend_row(c, h, data, jacobian);
    jacobian += 3 * k;
    jacobian = write_constants(*row_constants++, jacobian);
    const FrictionIndices& f = at.friction;
    for (int i = 0; i < f.count; ++i) {
      jacobian = differentiate_speed(c, i / 2, i % 2 == 0 ? -1 : 1, h, data, jacobian);
      jacobian = write_constants(*row_constants++, jacobian);
    }
    if (f.count > 0) jacobian = write_constants(*row_constants++, jacobian);
    if (!at.cone.present) return jacobian;
    row_constants += ConeIndices::kRows;
    return differentiate_cone(c, u, h, data, jacobian);
  }

  template <class S>
  S* differentiate_cone(int c, const S* u, const S& h, const SteppingSystem::Data<S>& data,
                        S* jacobian) const {
    const SteppingLayout::Candidate& at = system_->layout().candidates[c];
    const ConeIndices& cone = at.cone;
    const S mu(system_->contacts().candidates[c].friction);
    for (int i = 0; i < 2; ++i) {
      jacobian = differentiate_speed(c, i, -1, h, data, jacobian);
      *jacobian++ = u[cone.speed];
      *jacobian++ = u[cone.use[i]];
    }
    for (int i = 0; i < 2; ++i) {
      *jacobian++ = mu * u[cone.use[i]];
      *jacobian++ = S(1.0);
      *jacobian++ = mu * u[at.force];
    }
    for (int i = 0; i < 2; ++i) *jacobian++ = S(2.0) * u[cone.use[i]];
    *jacobian++ = S(1.0);
    return jacobian;
  }

  /// Derivatives by q, v and a of sign times the velocity along a tangent of a candidate.
  template <class S>
  S* differentiate_speed(int c, int tangent, double sign, const S& h,
                         const SteppingSystem::Data<S>& data, S* jacobian) const {
    const std::vector<int>& joints = system_->geometry()[c].columns();
    const CandidateRows<S>& rows = data.candidates[c];
    const int k = static_cast<int>(joints.size()), m = static_cast<int>(rows.rows.size());
    const int row = 1 + tangent;
    for (int j = 0; j < k; ++j) {
      S speed(0.0);
      for (int l = 0; l < k; ++l) speed += rows.slopes[j * m + row * k + l] * data.v[joints[l]];
      jacobian[j] = S(sign) * speed;
      jacobian[k + j] = h * jacobian[j] + S(sign) * rows.rows[row * k + j];
      jacobian[2 * k + j] = h * jacobian[k + j];
    }
    bend_row(c, h, data, jacobian);
    return jacobian + 3 * k;
  }

  /// Corrects the derivatives of a candidate's row by q, v and a for floating bases.
  template <class S>
  void bend_row(int c, const S& h, const SteppingSystem::Data<S>& data, S* row) const {
    const std::vector<int>& columns = system_->geometry()[c].columns();
    const int k = static_cast<int>(columns.size());
    const auto& curved = system_->configurations().curved();
    for (std::size_t p = 0; p < curved.size(); ++p) {
      const auto at = std::find(columns.begin(), columns.end(), curved[p].dx);
      if (at == columns.end()) continue;
      system_->bend(data, static_cast<int>(p), h, 1, static_cast<int>(at - columns.begin()), row,
                    row + k, row + 2 * k);
    }
  }

  SystemPointer system_;
  int n_;
  std::vector<std::vector<double>> constants_;
  std::vector<int> force_column_;  ///< of entries of w, in the block of the equations of motion
};

/// The same with a step that a free duration scales. Rows depend on it by v⁺ = v + h a and q⁺ = q ⊕
/// h v⁺ alone, so ∂r/∂h = ∂r/∂q v⁺ + ∂r/∂v a, also on curved parts, where v⁺ is its own image.
class FreeStepping : public ResidualBase<FreeStepping> {
 public:
  FreeStepping(SystemPointer system, const SteppingRows& structure, const FreeDuration& duration)
      : ResidualBase(with_duration(structure.blocks, system->ndx() + duration.choice), 1, true),
        system_(system),
        of_step_(std::move(system), structure),
        duration_(duration) {}

  template <class S>
  void evaluate_as(const ResidualInput<S>& in, S* r) const {
    const S h = step(in);
    of_step_.evaluate_as<S>({in.x, in.u, &h, in.system, in.end}, r);
  }

  template <class S>
  void differentiate_as(const ResidualInput<S>& in, S* r, S* jacobian) const {
    auto& data = static_cast<SteppingSystem::Data<S>&>(in.system);
    data.jacobian.resize(of_step_.jacobian_size());
    const S h = step(in), slope = in.parameters[0] * S(1 / duration_.written);
    of_step_.differentiate_as<S>({in.x, in.u, &h, in.system, in.end}, r, data.jacobian.data());
    const S* a = in.u + system_->layout().acceleration;
    const S* from = data.jacobian.data();
    const int nv = system_->nv();
    for (const RowBlock& block : of_step_.blocks()) {
      const int rows = block.rows, states = state_columns(block);
      const S* next = from + static_cast<std::ptrdiff_t>(rows) * block.columns.size();
      S* by_duration = std::copy(from, from + rows * states, jacobian);
      std::fill_n(by_duration, rows, S(0.0));
      for (int c = 0; c < states; ++c) {
        const int column = block.columns[c];
        const S rate = slope * (column < nv ? data.v[column] : a[column - nv]);
        for (int i = 0; i < rows; ++i) by_duration[i] += rate * from[c * rows + i];
      }
      jacobian = std::copy(from + rows * states, next, by_duration + rows);
      from = next;
    }
  }

 private:
  template <class S>
  S step(const ResidualInput<S>& in) const {
    return in.parameters[0] * in.x[system_->nx() + duration_.choice] * S(1 / duration_.written);
  }
  /// Number of a block's columns that are coordinates of the robot's state.
  int state_columns(const RowBlock& block) const {
    const auto& columns = block.columns;
    return static_cast<int>(std::ranges::lower_bound(columns, system_->ndx()) - columns.begin());
  }
  static std::vector<RowBlock> with_duration(std::vector<RowBlock> blocks, int column) {
    for (RowBlock& block : blocks) {
      block.columns.insert(std::ranges::lower_bound(block.columns, column), column);
      block.affine = false;
    }
    return blocks;
  }

  SystemPointer system_;
  SteppingResidual of_step_;
  FreeDuration duration_;
};

}  // namespace

std::shared_ptr<const Residual> stepping_residual(const SystemPointer& system, int ndx,
                                                  const std::optional<FreeDuration>& duration) {
  const SteppingRows structure(*system, ndx);
  if (duration) return std::make_shared<FreeStepping>(system, structure, *duration);
  return std::make_shared<SteppingResidual>(system, structure);
}

std::vector<std::string> stepping_row_names(const SteppingSystem& system) {
  return SteppingRows(system, system.ndx()).names;
}

std::shared_ptr<const Residual> stepping_pairs_residual(const SteppingSystem& system, int ndx) {
  std::vector<int> indices;
  for (const auto& [z, s] : system.layout().pairs) {
    indices.push_back(z);
    indices.push_back(s);
  }
  return chosen_controls_residual(ndx, indices);
}

std::shared_ptr<const Residual> chosen_controls_residual(int ndx, const std::vector<int>& indices) {
  return std::make_shared<ChosenControls>(ndx, indices);
}

}  // namespace conddp
