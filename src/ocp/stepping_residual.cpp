#include "ocp/stepping_residual.hpp"

#include <algorithm>

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
    for (const int i : indices) blocks.push_back({1, {ndx + i}});
    return blocks;
  }
  std::vector<int> indices_;
};

/// The structure of the rows of a stepping system.
struct StepBlocks {
  std::vector<RowBlock> blocks;
  std::vector<std::string> names;
  std::vector<int> forces;  ///< entries of the control that act in the equations of motion, past u
  /// One for each row behind those of motion: the constant derivatives by entries of the control,
  /// which are the last ones of the row.
  std::vector<std::vector<double>> constants;

  StepBlocks(const SteppingSystem& system, int ndx) : n_(system.nv()), ndx_(ndx) {
    const SteppingLayout& w = system.layout();
    motion(system);
    for (std::size_t c = 0; c < w.candidates.size(); ++c) {
      const SteppingLayout::Candidate& at = w.candidates[c];
      const ContactCandidate& candidate = system.contacts().candidates[c];
      const std::vector<int>& joints = system.geometry()[c].columns();
      const std::string name = "contact/" + candidate.name;
      Entries entries{{at.gap, 1}};
      if (candidate.stiffness) entries.emplace_back(at.force, -1 / *candidate.stiffness);
      add(name + "/gap", w, joints, true, entries);
      friction(name, w, joints, true, at.friction);
      if (at.friction.count > 0) budget(name, w, at.friction, {{at.force, -candidate.friction}});
    }
    for (const SteppingLayout::Stop& stop : w.stops)
      add("stop/" + system.multibody().robot().joints[stop.joint].name +
              (stop.upper ? "/upper" : "/lower"),
          w, {stop.joint}, true, {{stop.distance, 1}});
    for (std::size_t i = 0; i < w.frictions.size(); ++i) {
      const int joint = system.contacts().frictions[i].joint;
      const std::string name = "friction/" + system.multibody().robot().joints[joint].name;
      friction(name, w, {joint}, false, w.frictions[i]);
      budget(name, w, w.frictions[i], {});
    }
  }

 private:
  /// Entries of the control and the constant derivatives by them.
  using Entries = std::vector<std::pair<int, double>>;

  /// A row that depends on q (if asked for), v and a of some joints, and on entries of the control.
  void add(const std::string& name, const SteppingLayout& w, const std::vector<int>& joints,
           bool position, Entries entries) {
    RowBlock block{1, {}};
    if (position) block.columns = joints;
    for (const int j : joints) block.columns.push_back(n_ + j);
    for (const int j : joints) block.columns.push_back(ndx_ + w.acceleration + j);
    std::sort(entries.begin(), entries.end());
    std::vector<double>& slopes = constants.emplace_back();
    for (const auto& [i, slope] : entries) {
      block.columns.push_back(ndx_ + i);
      slopes.push_back(slope);
    }
    blocks.push_back(std::move(block));
    names.push_back(name);
  }

  void friction(const std::string& name, const SteppingLayout& w, const std::vector<int>& joints,
                bool position, const FrictionIndices& f) {
    for (int i = 0; i < f.count; ++i)
      add(name + "/slip" + std::to_string(i), w, joints, position, {{f.slip[i], 1}, {f.gamma, -1}});
  }

  /// What friction has left; `entries`: what its budget comes from.
  void budget(const std::string& name, const SteppingLayout& w, const FrictionIndices& f,
              Entries entries) {
    for (int i = 0; i < f.count; ++i) entries.emplace_back(f.force[i], 1);
    entries.emplace_back(f.rest, 1);
    add(name + "/budget", w, {}, false, std::move(entries));
  }

  /// The block of the equations of motion: q, v, u, a, then forces.
  void motion(const SteppingSystem& system) {
    const SteppingLayout& w = system.layout();
    for (const auto& c : w.candidates) {
      forces.push_back(c.force);
      forces.insert(forces.end(), c.friction.force.begin(),
                    c.friction.force.begin() + c.friction.count);
    }
    for (const auto& s : w.stops) forces.push_back(s.force);
    for (const auto& f : w.frictions)
      forces.insert(forces.end(), f.force.begin(), f.force.begin() + 2);
    std::sort(forces.begin(), forces.end());
    RowBlock block{n_, column_range(0, 2 * n_)};
    for (int i = 0; i < w.actuators + n_; ++i) block.columns.push_back(ndx_ + i);
    for (const int i : forces) block.columns.push_back(ndx_ + i);
    blocks.push_back(std::move(block));
    for (const Joint& joint : system.multibody().robot().joints)
      names.push_back("motion/" + joint.name);
  }

  int n_, ndx_;
};

class SteppingResidual : public ResidualBase<SteppingResidual> {
 public:
  SteppingResidual(SystemPointer system, const StepBlocks& structure)
      : ResidualBase(structure.blocks, 1, true),
        system_(std::move(system)),
        n_(system_->nv()),
        constants_(structure.constants),
        force_column_(system_->layout().size(), -1) {
    for (std::size_t i = 0; i < structure.forces.size(); ++i)
      force_column_[structure.forces[i]] =
          2 * n_ + system_->layout().actuators + n_ + static_cast<int>(i);
  }

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
      jacobian = differentiate_candidate(static_cast<int>(c), h, data, row, jacobian);
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

 private:
  /// Calls use(entry of the control, row of the geometry, sign) for each force of a candidate.
  template <class F>
  static void for_each_force(const SteppingLayout::Candidate& at, F use) {
    use(at.force, 0, 1.0);
    for (int i = 0; i < at.friction.count; ++i)
      use(at.friction.force[i], 1 + i / 2, i % 2 == 0 ? 1.0 : -1.0);
  }

  /// The generalised force of a joint's own forces: use(entry of the control, joint, sign).
  template <class F>
  void for_each_joint_force(F use) const {
    const SteppingLayout& w = system_->layout();
    for (const SteppingLayout::Stop& stop : w.stops)
      use(stop.force, stop.joint, stop.upper ? -1.0 : 1.0);
    for (std::size_t i = 0; i < w.frictions.size(); ++i)
      for (int k = 0; k < 2; ++k)
        use(w.frictions[i].force[k], system_->contacts().frictions[i].joint, k == 0 ? 1.0 : -1.0);
  }

  template <class S>
  void write_values(const S* u, const SteppingSystem::Data<S>& data, S* r) const {
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
    r += n_;
    for (std::size_t c = 0; c < w.candidates.size(); ++c) {
      const SteppingLayout::Candidate& at = w.candidates[c];
      const ContactCandidate& candidate = system_->contacts().candidates[c];
      const std::vector<int>& joints = system_->geometry()[c].columns();
      const CandidateRows<S>& rows = data.candidates[c];
      const int k = static_cast<int>(joints.size());
      *r = u[at.gap] - rows.gap;
      if (candidate.stiffness) *r -= S(1 / *candidate.stiffness) * u[at.force];
      ++r;
      r = write_friction(
          at.friction, S(candidate.friction) * u[at.force], u,
          [&](int tangent) {
            S speed(0.0);
            for (int j = 0; j < k; ++j)
              speed += rows.rows[(1 + tangent) * k + j] * data.v[joints[j]];
            return speed;
          },
          r);
    }
    for (const SteppingLayout::Stop& stop : w.stops) {
      const S above = data.q[stop.joint] - S(stop.limit);
      *r++ = u[stop.distance] - (stop.upper ? -above : above);
    }
    for (std::size_t i = 0; i < w.frictions.size(); ++i) {
      const JointFriction& friction = system_->contacts().frictions[i];
      r = write_friction(
          w.frictions[i], S(friction.limit), u, [&](int) { return data.v[friction.joint]; }, r);
    }
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
            // J is that of q⁺ = q + h v + h² a.
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
    return jacobian + n_ * static_cast<int>(blocks().front().columns.size());
  }

  template <class S>
  S* differentiate_candidate(int c, const S& h, const SteppingSystem::Data<S>& data,
                             const std::vector<double>*& row_constants, S* jacobian) const {
    const SteppingLayout::Candidate& at = system_->layout().candidates[c];
    const std::vector<int>& joints = system_->geometry()[c].columns();
    const CandidateRows<S>& rows = data.candidates[c];
    const int k = static_cast<int>(joints.size()), m = static_cast<int>(rows.rows.size());
    for (int j = 0; j < k; ++j) {
      jacobian[j] = -rows.rows[j];
      jacobian[k + j] = h * jacobian[j];
      jacobian[2 * k + j] = h * jacobian[k + j];
    }
    jacobian += 3 * k;
    jacobian = write_constants(*row_constants++, jacobian);
    const FrictionIndices& f = at.friction;
    for (int i = 0; i < f.count; ++i) {
      const S sign(i % 2 == 0 ? -1.0 : 1.0);
      const int row = 1 + i / 2;
      for (int j = 0; j < k; ++j) {
        S speed(0.0);
        for (int l = 0; l < k; ++l) speed += rows.slopes[j * m + row * k + l] * data.v[joints[l]];
        jacobian[j] = sign * speed;
        jacobian[k + j] = h * jacobian[j] + sign * rows.rows[row * k + j];
        jacobian[2 * k + j] = h * jacobian[k + j];
      }
      jacobian = write_constants(*row_constants++, jacobian + 3 * k);
    }
    if (f.count > 0) jacobian = write_constants(*row_constants++, jacobian);
    return jacobian;
  }

  SystemPointer system_;
  int n_;
  std::vector<std::vector<double>> constants_;
  std::vector<int> force_column_;  ///< of entries of w, in the block of the equations of motion
};

}  // namespace

std::shared_ptr<const Residual> stepping_residual(const SystemPointer& system, int ndx) {
  return std::make_shared<SteppingResidual>(system, StepBlocks(*system, ndx));
}

std::vector<std::string> stepping_row_names(const SteppingSystem& system) {
  return StepBlocks(system, system.ndx()).names;
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
