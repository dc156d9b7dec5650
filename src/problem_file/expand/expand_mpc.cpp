#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/spec/enum_names.hpp"
#include "problem_file/yaml/canonical_definition.hpp"

namespace conddp {
namespace {

OrderedJson expand_mpc_plant(const MpcPlantSpec& plant) {
  OrderedJson json = {{"set", OrderedJson::object()}};
  for (const Setting& setting : plant.settings)
    json["set"][setting.key.value] = OrderedJson::parse(canonical_value(setting.value));
  if (plant.integrator) json["integrator"] = word_of(kIntegratorWords, plant.integrator->value);
  if (plant.dt) json["dt"] = plant.dt->value;
  json["contacts"] = plant.simulated_contacts ? "simulated" : "scheduled";
  if (!plant.simulated_contacts) return json;
  json["ground"] = OrderedJson::array();
  for (const TouchedSpec& shape : plant.ground) json["ground"].push_back(expand_touched(shape));
  return json;
}

OrderedJson expand_disturbance(const DisturbanceSpec& disturbance) {
  OrderedJson json = {{"at", disturbance.at.value}};
  if (disturbance.jump) json["jump"] = expand_components(*disturbance.jump);
  if (!disturbance.push) return json;
  json["frame"] = disturbance.push->frame.value;
  json["force"] = expand_vector(disturbance.push->wrench.linear);
  json["torque"] = expand_vector(disturbance.push->wrench.angular);
  json["duration"] = disturbance.duration;
  return json;
}

OrderedJson expand_late(const LateSpec& late) {
  OrderedJson json = {{"late", late.share}, {"at", late.at.value}};
  if (late.duration) json["duration"] = *late.duration;
  json["seed"] = late.seed;
  return json;
}

OrderedJson expand_disturbances(const MpcSpec& mpc) {
  OrderedJson json = OrderedJson::array();
  for (const DisturbanceSpec& disturbance : mpc.disturbances)
    json.push_back(expand_disturbance(disturbance));
  if (mpc.noise)
    json.push_back({{"noise", "state"},
                    {"sigma", expand_components(mpc.noise->sigma)},
                    {"seed", mpc.noise->seed}});
  for (const LateSpec& late : mpc.late) json.push_back(expand_late(late));
  return json;
}

OrderedJson expand_window_end(const MpcSpec& mpc) {
  if (mpc.terminal_lqr) return {{"lqr", expand_terminal_lqr(*mpc.terminal_lqr)}};
  return word_of(kWindowEndWords, mpc.window_end.value);
}

OrderedJson expand_held_state(const FallbackSpec& fallback) {
  if (fallback.by_lqr) return {{"lqr", expand_terminal_lqr(*fallback.by_lqr)}};
  return fallback.name ? OrderedJson(fallback.name->value) : expand_state(fallback.to);
}

OrderedJson expand_fallback(const FallbackSpec& fallback) {
  return {{"after", fallback.after}, {"to", expand_held_state(fallback)}};
}

}  // namespace

OrderedJson expand_mpc(const ProblemSpec& spec, const Plant& plant) {
  const MpcSpec& mpc = *spec.mpc;
  OrderedJson json = {
      {"horizon", mpc.horizon.value}, {"tick", mpc.tick.value}, {"duration", mpc.duration.value}};
  json["iterations"] = mpc.iterations ? OrderedJson(*mpc.iterations) : OrderedJson("tolerances");
  // Phases replace the gait in the expanded file: no cycles can be repeated, and no commands can
  // steer it.
  const bool gait = mpc.repeat.value == AfterTheEnd::kGait;
  json["repeat"] = word_of(kRepeatWords, gait ? AfterTheEnd::kHold : mpc.repeat.value);
  json["terminal"] = expand_window_end(mpc);
  json["delay"] = mpc.delay.value;
  json["predict"] = mpc.predict;
  if (mpc.feedback_rate) json["feedback"]["rate"] = mpc.feedback_rate->value;
  json["plant"] = expand_mpc_plant(mpc.plant);
  json["disturbances"] = expand_disturbances(mpc);
  json["swings"] = word_of(kSwingStartWords, mpc.measured_swings.has_value());
  if (mpc.retime)
    json["retime"] = {{"early", mpc.retime->early.value}, {"late", mpc.retime->late.value}};
  if (mpc.fallback) json["fallback"] = expand_fallback(*mpc.fallback);
  ProblemSpec of_states = spec;
  of_states.terminal_constraints = mpc.stop_when;
  json["stop_when"] = expand_terminal_constraints(of_states, plant);
  return json;
}

}  // namespace conddp
