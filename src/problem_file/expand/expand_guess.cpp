#include "problem_file/expand/expand_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

OrderedJson expand_states_guess(const GuessSpec& guess) {
  if (guess.states_file) return expand_data_file(*guess.states_file);
  if (guess.states != GuessSpec::States::kKeyframes)
    return OrderedJson(word_of(kStatesGuessWords, guess.states));
  OrderedJson keyframes = OrderedJson::array();
  for (const KeyframeSpec& keyframe : guess.keyframes) {
    OrderedJson entry = OrderedJson::object();
    if (keyframe.time) entry["time"] = keyframe.time->value;
    if (keyframe.knot) entry["knot"] = keyframe.knot->value;
    entry["state"] = expand_state(keyframe.state);
    keyframes.push_back(std::move(entry));
  }
  return {{"keyframes", std::move(keyframes)},
          {"interpolation", word_of(kInterpolationWords, guess.interpolation)}};
}

OrderedJson expand_controls_guess(const GuessSpec& guess) {
  OrderedJson json = OrderedJson::object();
  if (guess.controls_file) json = expand_data_file(*guess.controls_file);
  if (guess.constant) json["constant"] = expand_components(*guess.constant);
  if (guess.random) json["random"] = {{"seed", guess.random->seed}, {"scale", guess.random->scale}};
  if (json.empty()) return OrderedJson(word_of(kControlsGuessWords, guess.controls));
  return json;
}

}  // namespace

OrderedJson expand_guess(const GuessSpec& guess) {
  return {{"states", expand_states_guess(guess)}, {"controls", expand_controls_guess(guess)}};
}

}  // namespace conddp
