#include "problem_file/residuals/reference_form.hpp"

#include "problem_file/values/key_forms.hpp"

namespace conddp {
namespace {

using Value = std::optional<ReferenceValueSpec>;
using Numbers = std::optional<std::vector<double>>;
using Needed = ReferenceForm::Needed;

Value read_numbers(const YamlReader& reader, const CostSpec&) {
  ReferenceValueSpec value{.place = reader.place()};
  if (!ComponentsForm().read(reader, value.components.emplace())) return std::nullopt;
  return value;
}
OrderedJson expand_given_numbers(const ReferenceValueSpec& value) {
  return *ComponentsForm().expand(*value.components);
}
Value zero_numbers(const CostSpec&, const Place& place) {
  ReferenceValueSpec value{.place = place};
  value.components = ComponentsSpec{.place = place, .scalar = 0.0};
  return value;
}

Value read_whole_state(const YamlReader& reader, const CostSpec& cost) {
  if (!reader.is_map()) {
    const Value numbers = read_numbers(reader, cost);
    const bool one = numbers && numbers->components->form == ComponentsSpec::Form::kScalar;
    if (one && cost.keys.find(key::columns) == nullptr)
      reader.error("one number is not a state",
                   "a configuration's name, 'initial', a list as [1], or '{values: {column: "
                   "number}}'; beside 'columns' one number stands for each of them");
    return numbers;
  }
  ReferenceValueSpec value{.place = reader.place()};
  value.state = read_state(reader);
  if (!value.state) return std::nullopt;
  return value;
}
OrderedJson expand_state_or_numbers(const ReferenceValueSpec& value) {
  return value.state ? expand_map(*value.state) : expand_given_numbers(value);
}
Value zero_state(const CostSpec& cost, const Place& place) {
  if (cost.keys.find(key::columns) != nullptr) return zero_numbers(cost, place);
  ReferenceValueSpec value{.place = place};
  value.state = StateSpec{.place = place};
  return value;
}

Value read_point(const YamlReader& reader, const CostSpec&) {
  Vector3<double> position;
  if (!VectorForm{"[x, y, z] in m"}.read(reader, position)) return std::nullopt;
  ReferenceValueSpec value{.place = reader.place()};
  value.pose = PoseSpec{.place = reader.place(), .position = position};
  return value;
}
OrderedJson expand_point(const ReferenceValueSpec& value) {
  return *VectorForm{}.expand(*value.pose->position);
}
Value zero_point(const CostSpec&, const Place& place) {
  ReferenceValueSpec value{.place = place};
  value.pose = PoseSpec{.place = place, .position = Vector3<double>::zero()};
  return value;
}
Numbers point_numbers(const PoseSpec& pose, Diagnostics&) {
  return std::vector{pose.position->x, pose.position->y, pose.position->z};
}

Value read_whole_pose(const YamlReader& reader, const CostSpec&) {
  ReferenceValueSpec value{.place = reader.place()};
  return read_map(reader, value.pose.emplace()) ? Value(std::move(value)) : std::nullopt;
}
Value read_rotation(const YamlReader& reader, const CostSpec& cost) {
  Value value = read_whole_pose(reader, cost);
  if (value && value->pose->position)
    reader.error("a rotation has no position", "use the residual 'frame_placement'");
  return value;
}
OrderedJson expand_given_pose(const ReferenceValueSpec& value) { return expand_map(*value.pose); }
Value no_zero(const CostSpec&, const Place&) { return std::nullopt; }
Numbers rotation_numbers(const PoseSpec& pose, Diagnostics& out) {
  if (!pose.orientation) {
    out.error(pose.place, "the reference lacks 'orientation' or 'rpy'");
    return std::nullopt;
  }
  const Quaternion<double>& q = *pose.orientation;
  return std::vector{q.x, q.y, q.z, q.w};
}
Numbers pose_numbers(const PoseSpec& pose, Diagnostics& out) {
  if (!pose.position) {
    out.error(pose.place, "the reference lacks 'position'");
    return std::nullopt;
  }
  Numbers numbers = point_numbers(pose, out);
  const Numbers rotation = rotation_numbers(pose, out);
  if (!rotation) return std::nullopt;
  numbers->insert(numbers->end(), rotation->begin(), rotation->end());
  return numbers;
}

Value read_velocity(const YamlReader& reader, const CostSpec&) {
  ReferenceValueSpec value{.place = reader.place()};
  return TwistForm().read(reader, value.twist.emplace()) ? Value(std::move(value)) : std::nullopt;
}
OrderedJson expand_velocity(const ReferenceValueSpec& value) { return expand_map(*value.twist); }
Value zero_velocity(const CostSpec&, const Place& place) {
  ReferenceValueSpec value{.place = place};
  value.twist = TwistSpec{.place = place};
  return value;
}

}  // namespace

const ReferenceForm kStateReference{
    .read = read_whole_state, .expand = expand_state_or_numbers, .zero = zero_state};
const ReferenceForm kNumbersReference{
    .read = read_numbers, .expand = expand_given_numbers, .zero = zero_numbers};
const ReferenceForm kRowsReference{
    .of_state = false, .read = read_numbers, .expand = expand_given_numbers, .zero = zero_numbers};
const ReferenceForm kControlReference{.of_state = false,
                                      .holds = true,
                                      .read = read_numbers,
                                      .expand = expand_given_numbers,
                                      .zero = zero_numbers};
const ReferenceForm kPointReference{.needed = Needed::kWithoutBarrier,
                                    .is_point = true,
                                    .read = read_point,
                                    .expand = expand_point,
                                    .zero = zero_point,
                                    .numbers = point_numbers};
const ReferenceForm kRotationReference{.needed = Needed::kAlways,
                                       .read = read_rotation,
                                       .expand = expand_given_pose,
                                       .zero = no_zero,
                                       .numbers = rotation_numbers};
const ReferenceForm kPoseReference{.needed = Needed::kAlways,
                                   .read = read_whole_pose,
                                   .expand = expand_given_pose,
                                   .zero = no_zero,
                                   .numbers = pose_numbers};
const ReferenceForm kTwistReference{
    .read = read_velocity, .expand = expand_velocity, .zero = zero_velocity};

}  // namespace conddp
