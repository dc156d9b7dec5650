#include "systems/multibody/mimic_map.hpp"

#include <algorithm>
#include <stdexcept>

namespace conddp {
namespace {

/// For each joint the index of its entry in model.mimics; −1 for independent joints.
std::vector<int> checked_mimics(const RobotModel& model) {
  std::vector<int> entry(model.joint_count(), -1);
  const auto refuse = [&](const Mimic& mimic, const char* why) {
    throw std::invalid_argument("joint " + model.joints[mimic.joint].name + " cannot mimic joint " +
                                model.joints[mimic.leader].name + ": " + why);
  };
  for (std::size_t i = 0; i < model.mimics.size(); ++i) {
    const Mimic& mimic = model.mimics[i];
    if (model.joints[mimic.joint].type == JointType::floating ||
        model.joints[mimic.leader].type == JointType::floating)
      refuse(mimic, "both need exactly one coordinate");
    if (entry[mimic.joint] >= 0) refuse(mimic, "it mimics another one already");
    entry[mimic.joint] = static_cast<int>(i);
  }
  for (const Mimic& mimic : model.mimics)
    if (entry[mimic.leader] >= 0) refuse(mimic, "that one mimics another joint itself");
  return entry;
}

}  // namespace

MimicMap::MimicMap(const RobotModel& model)
    : identity_(model.mimics.empty()),
      position_(model.joint_count(), -1),
      velocity_(model.joint_count(), -1) {
  const std::vector<int> mimics = checked_mimics(model);
  for (int i = 0; i < model.joint_count(); ++i) {
    if (mimics[i] >= 0) continue;
    position_[i] = nq_;
    velocity_[i] = nv_;
    nq_ += model.joints[i].nq();
    nv_ += model.joints[i].nv();
  }
  for (int i = 0; i < model.joint_count(); ++i) {
    if (mimics[i] >= 0) {  // a leader may come after its followers
      const Mimic& mimic = model.mimics[mimics[i]];
      configurations_.push_back({position_[mimic.leader], mimic.multiplier, mimic.offset});
      velocities_.push_back({velocity_[mimic.leader], mimic.multiplier, 0});
      continue;
    }
    for (int k = 0; k < model.joints[i].nq(); ++k)
      configurations_.push_back({position_[i] + k, 1, 0});
    for (int k = 0; k < model.joints[i].nv(); ++k) velocities_.push_back({velocity_[i] + k, 1, 0});
  }
}

std::optional<int> MimicMap::position(int joint) const {
  return position_[joint] < 0 ? std::nullopt : std::optional(position_[joint]);
}

std::optional<int> MimicMap::velocity(int joint) const {
  return velocity_[joint] < 0 ? std::nullopt : std::optional(velocity_[joint]);
}

template <class S>
void MimicMap::expand_configuration(const S* q, S* full) const {
  for (const Entry& e : configurations_) *full++ = q[e.source] * e.factor + S(e.offset);
}

template <class S>
void MimicMap::expand_velocity(const S* v, S* full) const {
  for (const Entry& e : velocities_) *full++ = v[e.source] * e.factor;
}

template <class S>
void MimicMap::reduce_force(const S* full, S* f) const {
  std::fill_n(f, nv_, S(0.0));
  for (const Entry& e : velocities_) f[e.source] += *full++ * e.factor;
}

template <class S>
void MimicMap::reduce_matrix(const S* full, S* A) const {
  std::fill_n(A, nv_ * nv_, S(0.0));
  for (const Entry& column : velocities_) {
    S* out = A + column.source * nv_;
    for (const Entry& row : velocities_) out[row.source] += *full++ * (row.factor * column.factor);
  }
}

template <class S>
void MimicMap::reduce_symmetric(const S* full, S* A) const {
  std::fill_n(A, nv_ * nv_, S(0.0));
  const int n = static_cast<int>(velocities_.size());
  for (int c = 0; c < n; ++c)
    for (int r = c; r < n; ++r) {
      const Entry &row = velocities_[r], &column = velocities_[c];
      // The full entries (r, c) and (c, r) add up on the reduced diagonal.
      const double twice = r != c && row.source == column.source ? 2 : 1;
      A[std::min(row.source, column.source) * nv_ + std::max(row.source, column.source)] +=
          full[c * n + r] * (twice * row.factor * column.factor);
    }
}

ReducedColumns::ReducedColumns(const MimicMap& map, const std::vector<int>& full_columns)
    : identity_(map.identity()) {
  for (const int full : full_columns) columns_.push_back(map.column(full));
  std::sort(columns_.begin(), columns_.end());
  columns_.erase(std::unique(columns_.begin(), columns_.end()), columns_.end());
  for (const int full : full_columns) {
    const auto place = std::lower_bound(columns_.begin(), columns_.end(), map.column(full));
    entries_.push_back({static_cast<int>(place - columns_.begin()), map.factor(full)});
  }
}

template <class S>
void ReducedColumns::gather(const S* full, int rows, S* out) const {
  std::fill_n(out, rows * columns_.size(), S(0.0));
  for (const Entry& e : entries_) {
    S* column = out + e.target * rows;
    for (int i = 0; i < rows; ++i) column[i] += *full++ * e.factor;
  }
}

#define CONDDP_INSTANTIATE(S)                                       \
  template void MimicMap::expand_configuration(const S*, S*) const; \
  template void MimicMap::expand_velocity(const S*, S*) const;      \
  template void MimicMap::reduce_force(const S*, S*) const;         \
  template void MimicMap::reduce_matrix(const S*, S*) const;        \
  template void MimicMap::reduce_symmetric(const S*, S*) const;     \
  template void ReducedColumns::gather(const S*, int, S*) const;
CONDDP_FOR_EACH_SCALAR(CONDDP_INSTANTIATE)
#undef CONDDP_INSTANTIATE

}  // namespace conddp
