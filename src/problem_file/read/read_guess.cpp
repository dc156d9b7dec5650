#include <limits>

#include <fmt/format.h>

#include "problem_file/read/read_sections.hpp"
#include "problem_file/spec/enum_names.hpp"

namespace conddp {
namespace {

/// All numbers of a state, the name of a configuration, or the parts of a state.
StateSpec read_state_or_name(const YamlReader& reader) {
  if (reader.is_sequence()) return {.place = reader.place(), .state = reader.numbers()};
  if (reader.is_scalar() && !reader.is_number())
    return {.place = reader.place(), .configuration = reader.name()};
  return read_state(reader).value_or(StateSpec{});
}

KeyframeSpec read_keyframe(const YamlReader& reader) {
  KeyframeSpec keyframe{.place = reader.place()};
  YamlMap map(reader);
  if (!map.valid()) return keyframe;
  map.exclusive({"time", "knot"});
  if (const auto r = map.find("time"))
    keyframe.time = {r->number(kNotNegative).value_or(0), r->place()};
  if (const auto r = map.find("knot"))
    keyframe.knot = {static_cast<int>(r->integer(0, 1'000'000).value_or(0)), r->place()};
  if (!map.find("time") && !map.find("knot")) reader.error("a keyframe needs 'time' or 'knot'");
  map.require("state");
  map.read("state", keyframe.state, read_state_or_name);
  return keyframe;
}

std::vector<KeyframeSpec> read_keyframes(const YamlReader& reader) {
  std::vector<KeyframeSpec> keyframes;
  const auto items = reader.items();
  if (!items) return keyframes;
  for (const YamlReader& item : *items) keyframes.push_back(read_keyframe(item));
  if (items->empty()) reader.error("there is no keyframe");
  return keyframes;
}

void read_states(const YamlReader& reader, const std::filesystem::path& folder, GuessSpec& guess) {
  using States = GuessSpec::States;
  guess.states_place = reader.place();
  if (reader.is_scalar()) {
    guess.states = reader
                       .choice(kStatesGuessWords,
                               "way to guess states (nor a mapping with 'keyframes' or "
                               "'file')")
                       .value_or(States::kInitial);
    return;
  }
  YamlMap map(reader);
  if (!map.valid()) return;
  map.exclusive({"keyframes", "file"});
  if (const auto r = map.find("keyframes")) {
    guess.states = States::kKeyframes;
    guess.keyframes = read_keyframes(*r);
    map.choice("interpolation", guess.interpolation, kInterpolationWords, "interpolation");
  } else {
    guess.states = States::kFile;
    guess.states_file = read_data_file(map, folder);
  }
}

void read_random(const YamlReader& reader, GuessSpec& guess) {
  YamlMap map(reader);
  if (!map.valid()) return;
  GuessSpec::Random random;
  if (const auto r = map.find("seed"))
    random.seed = static_cast<std::uint64_t>(
        r->integer(0, std::numeric_limits<long long>::max()).value_or(0));
  if (const auto r = map.require("scale")) random.scale = r->number(kNotNegative).value_or(0);
  guess.random = random;
}

void read_controls(const YamlReader& reader, const std::filesystem::path& folder,
                   GuessSpec& guess) {
  using Controls = GuessSpec::Controls;
  guess.controls_place = reader.place();
  if (reader.is_scalar()) {
    guess.controls = reader
                         .choice(kControlsGuessWords,
                                 "way to guess controls (nor a mapping with 'constant', "
                                 "'file' or 'random')")
                         .value_or(Controls::kZero);
    return;
  }
  YamlMap map(reader);
  if (!map.valid()) return;
  map.exclusive({"constant", "file"});
  if (const auto r = map.find("constant")) {
    guess.controls = Controls::kConstant;
    guess.constant = read_components(*r);
  }
  if (const auto r = map.find("random")) read_random(*r, guess);
  if (map.find("file") || (!guess.constant && !guess.random)) {
    guess.controls = Controls::kFile;
    guess.controls_file = read_data_file(map, folder);
  }
}

}  // namespace

GuessSpec read_guess(const YamlReader& reader, const std::filesystem::path& folder) {
  GuessSpec guess;
  YamlMap map(reader);
  if (!map.valid()) return guess;
  map.exclusive({"file", "states"});
  map.exclusive({"file", "controls"});
  if (const auto r = map.find("file")) {
    guess.states = GuessSpec::States::kFile;
    guess.controls = GuessSpec::Controls::kFile;
    guess.states_place = guess.controls_place = r->place();
    if (const auto name = r->name())
      guess.states_file = guess.controls_file = DataFileSpec{*name, folder / name->value, {}};
  }
  if (const auto r = map.find("states")) read_states(*r, folder, guess);
  if (const auto r = map.find("controls")) read_controls(*r, folder, guess);
  return guess;
}

}  // namespace conddp
