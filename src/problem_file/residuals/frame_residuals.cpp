#include "problem_file/data/time_series.hpp"
#include "problem_file/model/enum_names.hpp"
#include "problem_file/residuals/cost_residual.hpp"
#include "problem_file/residuals/reference_form.hpp"
#include "problem_file/residuals/residual_keys.hpp"
#include "problem_file/residuals/residual_table.hpp"
#include "robot/frames.hpp"

namespace conddp {
namespace {

const Key<FrameAxes> kAxes{"axes", FrameAxes::world_aligned};

const std::vector<std::string> kRotationNames = {"rx", "ry", "rz"};
const std::vector<std::string> kPoseNames = {"x", "y", "z", "rx", "ry", "rz"};

const Key<Name> kRelativeTo{"relative_to"};

/// The frame, and the one it is seen from.
std::optional<FramePair> frame_of(const ResidualContext& context) {
  const RobotModel& robot = context.plant.robot();
  const auto frame = find_frame(robot, *context.cost.keys.find(key::frame), "", context.out);
  const Name* seen_from = context.cost.keys.find(kRelativeTo);
  if (!frame || seen_from == nullptr)
    return frame ? std::optional<FramePair>(*frame) : std::nullopt;
  const auto base = find_frame(robot, *seen_from, "", context.out);
  return base ? std::optional<FramePair>({*frame, base}) : std::nullopt;
}

/// Reference of a frame in a state: numbers of its pose.
template <class Numbers>
std::function<std::vector<double>(const std::vector<double>&)> of_pose(const Plant& plant,
                                                                       const FramePair& frame,
                                                                       Numbers numbers) {
  return [system = plant.multibody(), frame, numbers](const std::vector<double>& x) {
    const RobotData<double> data = data_in_state(*system, x);
    const SE3<double> pose = relative_placement(system->robot(), data, frame);
    return numbers(pose.p, quaternion(pose.R));
  };
}

std::optional<CostResidual> make_position_of_frame(const ResidualContext& context) {
  const auto frame = frame_of(context);
  if (!frame) return std::nullopt;
  CostResidual result;
  if (!frame->base) result.frame = frame->frame;
  result.residual = frame_position_residual(context.plant.multibody(), *frame);
  result.rows = {"axes of the position", kPositionNames};
  result.parameters = StateManifold::flat(3);
  result.in_state =
      of_pose(context.plant, *frame, [](const Vector3<double>& p, const Quaternion<double>&) {
        return std::vector{p.x, p.y, p.z};
      });
  return result;
}

std::optional<CostResidual> make_rotation(const ResidualContext& context) {
  const auto frame = frame_of(context);
  if (!frame) return std::nullopt;
  CostResidual result;
  if (!frame->base) result.frame = frame->frame;
  result.residual = frame_rotation_residual(context.plant.multibody(), *frame);
  result.rows = {"axes of the rotation", kRotationNames};
  result.parameters = rotation_manifold();
  result.in_state =
      of_pose(context.plant, *frame, [](const Vector3<double>&, const Quaternion<double>& q) {
        return std::vector{q.x, q.y, q.z, q.w};
      });
  return result;
}

std::optional<CostResidual> make_placement(const ResidualContext& context) {
  const auto frame = frame_of(context);
  if (!frame) return std::nullopt;
  CostResidual result;
  if (!frame->base) result.frame = frame->frame;
  result.residual = frame_placement_residual(context.plant.multibody(), *frame);
  result.rows = {"axes of the placement", kPoseNames};
  result.parameters = pose_manifold();
  result.in_state =
      of_pose(context.plant, *frame, [](const Vector3<double>& p, const Quaternion<double>& q) {
        return std::vector{p.x, p.y, p.z, q.x, q.y, q.z, q.w};
      });
  return result;
}

std::optional<CostResidual> make_velocity_of_frame(const ResidualContext& context) {
  const auto frame = frame_of(context);
  if (!frame) return std::nullopt;
  const FrameAxes axes = context.cost.keys.value(kAxes);
  CostResidual result;
  if (!frame->base) result.frame = frame->frame;
  result.residual = frame_velocity_residual(context.plant.multibody(), *frame, axes);
  result.rows = {"axes of the velocity", kTwistNames};
  result.parameters = StateManifold::flat(6);
  result.in_state = [system = context.plant.multibody(), frame = *frame,
                     axes](const std::vector<double>& x) {
    const RobotData<double> data = data_in_state(*system, x);
    const Motion<double> v = relative_velocity(system->robot(), data, frame, axes);
    return std::vector{v[0], v[1], v[2], v[3], v[4], v[5]};
  };
  return result;
}

constexpr std::string_view kOfSwings =
    "For frame_position and frame_placement, instead of a reference: an arch from the frame's "
    "former place, over every run of consecutive phases of the cost";

std::vector<PlanarMotion> read_motions(const YamlReader& reader) {
  std::vector<PlanarMotion> motions;
  const auto items = reader.items();
  if (!items) return motions;
  for (const YamlReader& item : *items) MotionForm().read(item, motions.emplace_back());
  if (items->empty()) reader.error("there is no landing", "write one '[x, y, yaw]' a swing");
  return motions;
}

std::optional<OrderedJson> expand_motions(const std::vector<PlanarMotion>& motions) {
  if (motions.empty()) return std::nullopt;
  OrderedJson json = OrderedJson::array();
  for (const PlanarMotion& motion : motions) json.push_back(*MotionForm().expand(motion));
  return json;
}

}  // namespace

void describe(Keys& keys, SwingSpec& swing) {
  keys.about({.definition = "swing",
              .title = "Swing",
              .says = kOfSwings,
              .examples = R"([{"height": 0.06, "step": [0.15, 0, 0]},
                              {"height": 0.06, "displaced": [[0.1, 0, 0], [0.3, 0, 0.2]]}])"});
  keys({.name = "height", .says = "Of the arch over the straight line, m", .required = true},
       swing.height, NumberForm{kNotNegative});
  keys({"landing", "Where it touches down, in the world, m; by default where it lifted off"},
       swing.landing, VectorForm{"[x, y, z] in m"});
  keys(
      {"displaced",
       "The same for each run: where the frame stood at first, displaced with the base by [x, y, "
       "yaw] (m, rad) and kept on the plane of its contact"},
      CustomValue{
          [&swing](const YamlReader& reader) { swing.displaced = read_motions(reader); },
          [&swing] { return expand_motions(swing.displaced); },
          R"({"type": "array", "minItems": 1, "items": {"$ref": "#/definitions/planar_motion"}})"});
  keys({"step", "The same, from where it lifted off, m"}, swing.step, VectorForm{"[x, y, z] in m"});
  YamlMap* map = keys.reading();
  if (map == nullptr) return;
  map->exclusive({"landing", "step"});
  map->exclusive({"landing", "displaced"});
  map->exclusive({"step", "displaced"});
  if (!swing.landing && !swing.step && swing.displaced.empty())
    swing.step = Vector3<double>::zero();
}

std::span<const ResidualDefinition> frame_residuals() {
  static const ResidualKey frame =
      residual_key(key::frame, {.says = "For residuals on frames"}, NameForm{}, {.required = true});
  static const ResidualKey relative_to =
      residual_key(kRelativeTo,
                   {.says = "For residuals on frames: another frame, from which this one is seen "
                            "in place of the world"},
                   NameForm{}, {.excludes = "swing"});
  static const ResidualKey axes =
      residual_key(kAxes, {.says = "For frame_velocity: the axes in which it is expressed"},
                   WordForm(kAxesWords, "system of axes"));
  static const ResidualKey swing =
      residual_key(key::swing, {.says = kOfSwings}, MapForm{},
                   {.of_constraints = false, .of_last_node = false, .excludes = "reference"});
  static const ResidualDefinition all[] = {
      {.name = "frame_position",
       .description = "the origin of a frame minus a point of the world",
       .unit = "m",
       .synonyms = {"position", "translation", "end_effector", "ee_position"},
       .needs = {.robot = true},
       .keys = {&frame, &relative_to, &swing},
       .reference = &kPointReference,
       .is_point = [](const CostSpec&) { return true; },
       .make = make_position_of_frame},
      {.name = "frame_rotation",
       .description = "rotation vector from a reference to a frame",
       .unit = "rad",
       .synonyms = {"rotation", "orientation"},
       .needs = {.robot = true},
       .keys = {&frame, &relative_to},
       .reference = &kRotationReference,
       .make = make_rotation},
      {.name = "frame_placement",
       .description = "logarithm of a frame's pose seen from a reference",
       .unit = "m, rad",
       .synonyms = {"pose", "placement", "frame_pose"},
       .needs = {.robot = true},
       .keys = {&frame, &relative_to, &swing},
       .reference = &kPoseReference,
       .make = make_placement},
      {.name = "frame_velocity",
       .description = "velocity of a frame minus a reference",
       .unit = "m/s and rad/s",
       .synonyms = {"velocity", "twist"},
       .needs = {.robot = true},
       .keys = {&frame, &relative_to, &axes},
       .reference = &kTwistReference,
       .make = make_velocity_of_frame}};
  return all;
}

}  // namespace conddp
