#include "ocp/residuals/stepping_rows.hpp"

#include <algorithm>

namespace conddp {

SteppingRows::SteppingRows(const SteppingSystem& system, int ndx) : n_(system.nv()), ndx_(ndx) {
  const SteppingLayout& w = system.layout();
  find_forces(w);
  motion(system);
  for (std::size_t c = 0; c < w.candidates.size(); ++c) candidate(system, c);
  for (const SteppingLayout::Stop& stop : w.stops)
    add("stop/" + system.multibody().robot().joints[stop.joint].name +
            (stop.upper ? "/upper" : "/lower"),
        w, {stop.velocity}, true, {{stop.distance, 1}});
  for (std::size_t i = 0; i < w.frictions.size(); ++i) {
    const int joint = system.contacts().frictions[i].joint;
    const std::string name = "friction/" + system.multibody().robot().joints[joint].name;
    friction(name, w, {w.friction_velocities[i]}, false, w.frictions[i]);
    budget(name, w, w.frictions[i], {});
  }
}

void SteppingRows::candidate(const SteppingSystem& system, std::size_t c) {
  const SteppingLayout& w = system.layout();
  const SteppingLayout::Candidate& at = w.candidates[c];
  const ContactCandidate& candidate = system.contacts().candidates[c];
  const std::vector<int>& joints = system.geometry()[c].columns();
  const std::string name = "contact/" + candidate.name;
  Entries entries{{at.gap, 1}};
  if (candidate.stiffness) entries.emplace_back(at.force, -1 / *candidate.stiffness);
  add(name + "/gap", w, joints, true, entries);
  friction(name, w, joints, true, at.friction);
  if (at.friction.count > 0) budget(name, w, at.friction, {{at.force, -candidate.friction}});
  if (at.cone.present) cone(name, w, joints, at);
}

void SteppingRows::add(const std::string& name, const SteppingLayout& w,
                       const std::vector<int>& joints, bool position, Entries entries) {
  RowBlock block{1, {}};
  if (position) block.columns = joints;
  for (const int j : joints) block.columns.push_back(n_ + j);
  for (const int j : joints) block.columns.push_back(ndx_ + w.acceleration + j);
  std::sort(entries.begin(), entries.end());
  std::vector<double>& slopes = constants.emplace_back();
  for (const auto& [i, slope] : entries) {
    block.columns.push_back(ndx_ + i);
    block.affine_columns.push_back(ndx_ + i);
    slopes.push_back(slope);
  }
  blocks.push_back(std::move(block));
  names.push_back(name);
}

void SteppingRows::friction(const std::string& name, const SteppingLayout& w,
                            const std::vector<int>& joints, bool position,
                            const FrictionIndices& f) {
  for (int i = 0; i < f.count; ++i)
    add(name + "/slip" + std::to_string(i), w, joints, position, {{f.slip[i], 1}, {f.gamma, -1}});
}

void SteppingRows::budget(const std::string& name, const SteppingLayout& w,
                          const FrictionIndices& f, Entries entries) {
  for (int i = 0; i < f.count; ++i) entries.emplace_back(f.force[i], 1);
  entries.emplace_back(f.rest, 1);
  add(name + "/budget", w, {}, false, std::move(entries));
}

void SteppingRows::find_forces(const SteppingLayout& w) {
  for (const auto& c : w.candidates) {
    forces.push_back(c.force);
    forces.insert(forces.end(), c.friction.force.begin(),
                  c.friction.force.begin() + c.friction.count);
    if (c.cone.present) forces.insert(forces.end(), c.cone.force.begin(), c.cone.force.end());
  }
  for (const auto& s : w.stops) forces.push_back(s.force);
  for (const auto& f : w.frictions)
    forces.insert(forces.end(), f.force.begin(), f.force.begin() + 2);
  std::sort(forces.begin(), forces.end());
}

void SteppingRows::motion(const SteppingSystem& system) {
  const SteppingLayout& w = system.layout();
  RowBlock block{n_, column_range(0, 2 * n_)};
  for (int i = 0; i < w.actuators + n_; ++i) block.columns.push_back(ndx_ + i);
  for (const int i : forces) block.columns.push_back(ndx_ + i);
  block.affine_columns = column_range(ndx_, w.actuators);
  for (const int i : forces) block.affine_columns.push_back(ndx_ + i);
  blocks.push_back(std::move(block));
  // Strips the "a" of the accelerations' names, which belong to the same coordinates.
  for (int i = 0; i < n_; ++i)
    names.push_back("motion" + w.columns[w.acceleration + i].name.substr(1));
}

void SteppingRows::add_curved(const std::string& name, const SteppingLayout& w,
                              const std::vector<int>& joints, bool position,
                              const std::vector<int>& entries) {
  Entries list;
  for (const int i : entries) list.emplace_back(i, 0);
  add(name, w, joints, position, list);
  blocks.back().affine_columns.clear();
  constants.back().clear();
}

void SteppingRows::cone(const std::string& name, const SteppingLayout& w,
                        const std::vector<int>& joints, const SteppingLayout::Candidate& at) {
  const ConeIndices& c = at.cone;
  for (int i = 0; i < 2; ++i)
    add_curved(name + "/slip" + std::to_string(i), w, joints, true, {c.use[i], c.speed});
  for (int i = 0; i < 2; ++i)
    add_curved(name + "/friction" + std::to_string(i), w, {}, false,
               {at.force, c.force[i], c.use[i]});
  add_curved(name + "/use", w, {}, false, {c.use[0], c.use[1], c.rest});
}

}  // namespace conddp
