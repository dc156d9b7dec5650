#include <limits>

#include "problem_file/model/enum_names.hpp"
#include "problem_file/read/read_sections.hpp"

namespace conddp {
namespace {

/// All numbers of a state, the name of a configuration, or the parts of a state.
struct StateOrNameForm {
  bool read(const YamlReader& reader, StateSpec& state) const {
    if (reader.is_sequence())
      state = {.place = reader.place(), .state = reader.numbers()};
    else if (reader.is_scalar() && !reader.is_number())
      state = {.place = reader.place(), .configuration = reader.name()};
    else
      state = read_state(reader).value_or(StateSpec{});
    return true;
  }
  std::optional<OrderedJson> expand(const StateSpec& state) const { return expand_map(state); }
  OrderedJson schema(const StateSpec& /*names the type*/, SchemaDefinitions& definitions) const {
    return {{"anyOf",
             {map_schema<StateSpec>(definitions), NameForm().schema(), NumbersForm().schema()}}};
  }
};

}  // namespace

static void describe(Keys& keys, KeyframeSpec& keyframe) {
  keys.about({.definition = "keyframe",
              .title = "Keyframe",
              .says = "A state that the first trajectory passes through",
              .examples = R"([{"time": 1.5, "state": "standing"},
                              {"knot": 20, "state": {"values": {"theta": 1}}}])",
              .rules = R"("oneOf": [{"required": ["time"]}, {"required": ["knot"]}])"});
  if (YamlMap* map = keys.reading()) map->exclusive({"time", "knot"});
  keys({"time", "When, s from the start"}, keyframe.time, NumberForm{kNotNegative});
  keys({"knot", "Node: a number from 0, or a phase, its first node, and 'phase + 3'"},
       keyframe.knot, KnotForm{});
  keys({.name = "state",
        .says = "A state, the name of a configuration, or all numbers of the state",
        .required = true},
       keyframe.state, StateOrNameForm{});
  if (!keys.found("time") && !keys.found("knot")) keys.error("a keyframe needs 'time' or 'knot'");
}

static void describe(Keys& keys, GuessSpec::Random& random) {
  keys.about({.definition = "random_controls",
              .title = "Random controls",
              .says = "Normal random numbers",
              .examples = R"([{"seed": 1, "scale": 0.1}])"});
  keys({"seed", "The same seed gives the same numbers everywhere"}, random.seed,
       IntegerForm{0, std::numeric_limits<long long>::max()});
  keys({.name = "scale", .says = "Standard deviation, in the controls' units", .required = true},
       random.scale, NumberForm{kNotNegative});
}

static void describe(Keys& keys, GuessSpec::Sampling& sampling) {
  keys.about({.definition = "sampling",
              .title = "Start by sampling",
              .says =
                  "The best of many rollouts around the guess of the other keys, whose controls "
                  "are moved by splines with normal random numbers",
              .examples = R"([{}, {"samples": 256, "knots": 8}])"});
  if (YamlMap* map = keys.reading()) sampling.knots.place = map->reader().place();
  keys({"method", "How the distribution changes from round to round"}, sampling.method,
       WordForm{kSamplingWords, "method of sampling"});
  keys({"samples", "Rollouts per round, their number"}, sampling.samples, IntegerForm{2, 100'000});
  keys({"knots", "Nodes of the spline of each control, evenly in time, their number"},
       sampling.knots, IntegerForm{1, 1000});
  keys({"spline", "Between the nodes"}, sampling.spline, WordForm{kInterpolationWords, "spline"});
  keys({"rounds", "Number of rounds"}, sampling.rounds, IntegerForm{1, 10'000});
  keys({"seed", "The same seed gives the same rollouts, whatever the number of threads"},
       sampling.seed, IntegerForm{0, std::numeric_limits<long long>::max()});
}

namespace {

struct KeyframesForm {
  bool read(const YamlReader& reader, GuessSpec& guess) const {
    guess.states = GuessSpec::States::kKeyframes;
    const bool good = MapsForm().read(reader, guess.keyframes);
    if (good && guess.keyframes.empty()) reader.error("there is no keyframe");
    return good;
  }
  std::optional<OrderedJson> expand(const GuessSpec& guess) const {
    return MapsForm().expand(guess.keyframes);
  }
  OrderedJson schema(const GuessSpec& guess, SchemaDefinitions& definitions) const {
    OrderedJson schema = MapsForm().schema(guess.keyframes, definitions);
    schema["minItems"] = 1;
    return schema;
  }
};

/// The keys of guessed states between keyframes.
void describe_keyframes(Keys& keys, GuessSpec& guess) {
  keys.about({.title = "States between keyframes",
              .examples = R"([{"keyframes": [{"knot": 20, "state": "standing"}]}])",
              .rules = R"("required": ["keyframes"])"});
  keys({"keyframes", "In the order of time; knots interpolate between them"}, guess,
       KeyframesForm{});
  keys({"interpolation",
        "linear: straight from one to the next, rotations the shortest way; cubic: by a natural "
        "cubic spline"},
       guess.interpolation, WordForm{kInterpolationWords, "interpolation"});
}

/// A way to guess states, keyframes, or a file.
struct StatesForm {
  bool read(const YamlReader& reader, GuessSpec& guess) const {
    guess.states_place = reader.place();
    if (reader.is_scalar()) {
      const auto states = reader.choice(
          kStatesGuessWords, "way to guess states (nor a mapping with 'keyframes' or 'file')");
      guess.states = states.value_or(GuessSpec::States::kInitial);
      return states.has_value();
    }
    YamlMap map(reader);
    if (!map.valid()) return false;
    map.exclusive({"keyframes", "file"});
    KeyReader keys(map);
    if (map.find("keyframes")) return describe_keyframes(keys, guess), true;
    guess.states = GuessSpec::States::kFile;
    describe(keys, guess.states_file.emplace());
    return true;
  }
  std::optional<OrderedJson> expand(GuessSpec guess) const {
    if (guess.states_file) return expand_map(*guess.states_file);
    if (guess.states != GuessSpec::States::kKeyframes)
      return OrderedJson(word_of(kStatesGuessWords, guess.states));
    return GroupValue([&](Keys& keys) { describe_keyframes(keys, guess); }).expand();
  }
  OrderedJson schema(GuessSpec guess, SchemaDefinitions& definitions) const {
    const GroupValue keyframes([&](Keys& keys) { describe_keyframes(keys, guess); });
    return {{"anyOf",
             {WordForm(kStatesGuessWords, "").schema(), keyframes.schema(definitions),
              map_schema<DataFileSpec>(definitions)}}};
  }
};

/// A way to guess controls, a constant or a file, and random numbers that are added.
struct ControlsForm {
  bool read(const YamlReader& reader, GuessSpec& guess) const {
    guess.controls_place = reader.place();
    if (reader.is_scalar()) {
      const auto controls = reader.choice(
          kControlsGuessWords,
          "way to guess controls (nor a mapping with 'constant', 'file' or 'random')");
      guess.controls = controls.value_or(GuessSpec::Controls::kZero);
      return controls.has_value();
    }
    YamlMap map(reader);
    if (!map.valid()) return false;
    map.exclusive({"constant", "file"});
    KeyReader keys(map);
    describe_numbers(keys, guess);
    if (guess.constant) guess.controls = GuessSpec::Controls::kConstant;
    if (map.find("file") || (!map.find("constant") && !map.find("random"))) {
      guess.controls = GuessSpec::Controls::kFile;
      describe(keys, guess.controls_file.emplace());
    }
    return true;
  }
  std::optional<OrderedJson> expand(GuessSpec guess) const {
    OrderedJson json = OrderedJson::object();
    if (guess.controls_file) json = expand_map(*guess.controls_file);
    KeyWriter keys;
    describe_numbers(keys, guess);
    json.update(keys.json);
    return json.empty() ? OrderedJson(word_of(kControlsGuessWords, guess.controls)) : json;
  }
  OrderedJson schema(GuessSpec guess, SchemaDefinitions& definitions) const {
    const GroupValue numbers([&](Keys& keys) { describe_numbers(keys, guess); });
    map_schema<DataFileSpec>(definitions);
    OrderedJson from_file = definitions.at("data_file");
    from_file["title"] = "Controls from a file";
    from_file["examples"] = OrderedJson::parse(R"([{"file": "motion.csv", "columns": ["u/hip"]}])");
    from_file.erase("description");
    from_file["properties"]["random"] = map_schema<GuessSpec::Random>(definitions);
    return {{"anyOf",
             {WordForm(kControlsGuessWords, "").schema(), numbers.schema(definitions),
              std::move(from_file)}}};
  }

 private:
  static void describe_numbers(Keys& keys, GuessSpec& guess) {
    keys.about({.title = "Constant or random controls",
                .examples = R"([{"constant": 0.5}, {"random": {"seed": 1, "scale": 0.1}}])",
                .rules = R"("anyOf": [{"required": ["constant"]}, {"required": ["random"]}])"});
    keys({"constant", "The same at every knot"}, guess.constant, ComponentsForm{});
    keys({"random"}, guess.random, MapForm{});
  }
};

}  // namespace

void describe(Keys& keys, GuessSpec& guess) {
  keys.about({.definition = "initial_guess",
              .title = "First trajectory",
              .says = "Where the solver starts",
              .examples = R"([{"states": "initial", "controls": "quasi_static"},
                              {"file": "out/reach/solution.json"}])"});
  std::optional<Name> file;
  keys({"file",
        "A former solution.json or a CSV file for states and controls; relative to the problem "
        "file"},
       file, NameForm{});
  if (YamlMap* map = keys.reading()) {
    map->exclusive({"file", "states"});
    map->exclusive({"file", "controls"});
    if (file) {
      guess.states = GuessSpec::States::kFile;
      guess.controls = GuessSpec::Controls::kFile;
      guess.states_place = guess.controls_place = file->place;
      guess.states_file = guess.controls_file =
          DataFileSpec{*file, map->reader().folder() / file->value, {}};
    }
  }
  keys({.name = "states",
        .says = "initial: the initial state everywhere; interpolate: straight to the target of the "
                "terminal costs; keyframes or a file",
        .fallback = R"("initial")"},
       guess, StatesForm{});
  keys({.name = "controls",
        .says = "zero; quasi_static or gravity: those that hold the guessed states against "
                "gravity, together with contact forces in contact-implicit problems; constant; a "
                "file; random ones are added to the others",
        .fallback = R"("zero")"},
       guess, ControlsForm{});
  keys({"sampling"}, guess.sampling, MapForm{});
}

}  // namespace conddp
