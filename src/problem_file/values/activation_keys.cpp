#include "problem_file/values/activation_keys.hpp"

#include <string>

#include <fmt/format.h>

#include "problem_file/model/enum_names.hpp"

namespace conddp {
namespace {

const WordForm kKind(kActivationWords, "activation");

void report_missing_bounds(const YamlReader& reader) {
  reader.error("a barrier needs its bounds",
               "write '{kind: quadratic_barrier, lower: ..., upper: ...}' or 'from: urdf'");
}

/// Reports keys of other activations, and a barrier without bounds.
void check(YamlMap& map, ActivationKind kind) {
  bool any = false;
  for (const std::string_view key : {"from", "lower", "upper", "epsilon"}) {
    const auto value = map.find(key);
    if (!value) continue;
    any = true;
    if (key == "epsilon" && kind != ActivationKind::smooth_l1 && kind != ActivationKind::smooth_l2)
      value->error("'epsilon' belongs to the smooth norms");
    if (key != "epsilon" && kind != ActivationKind::quadratic_barrier)
      value->error("bounds belong to the activation 'quadratic_barrier'");
  }
  if (!any && kind == ActivationKind::quadratic_barrier) report_missing_bounds(map.reader());
}

}  // namespace

void describe(Keys& keys, ActivationSpec& activation) {
  keys.about({.title = "Activation with its parameters",
              .examples = R"([{"kind": "smooth_l1", "epsilon": 0.01}])"});
  const int errors = keys.errors();
  keys({.name = "kind", .says = "Which activation", .required = true}, activation.kind, kKind);
  const bool known = keys.errors() == errors;
  const bool barrier = activation.kind == ActivationKind::quadratic_barrier;
  static constexpr Choice<bool> kSources[] = {{"urdf", true}};
  keys({.name = "from",
        .says = "Take the barrier's bounds from the robot's limits",
        .omitted = !barrier},
       activation.from_urdf, WordForm(kSources, "source of bounds"));
  keys({.name = "lower",
        .says = "Lower bounds of a barrier, in the residual's units; null: none",
        .omitted = !barrier},
       activation.lower, BoundsForm{});
  keys({.name = "upper",
        .says = "Upper bounds of a barrier, in the residual's units; null: none",
        .omitted = !barrier},
       activation.upper, BoundsForm{});
  keys({.name = "epsilon",
        .says = "Width of the smooth norms, in the residual's unit",
        .omitted = barrier || !has_keys(activation.kind)},
       activation.epsilon, NumberForm{kPositive});
  if (YamlMap* map = keys.reading(); map != nullptr && known) check(*map, activation.kind);
}

bool ActivationForm::read(const YamlReader& reader, ActivationSpec& activation) const {
  activation.place = reader.place();
  if (!reader.is_scalar()) return read_map(reader, activation);
  if (!kKind.read(reader, activation.kind)) return false;
  if (activation.kind == ActivationKind::quadratic_barrier) report_missing_bounds(reader);
  return true;
}

std::optional<OrderedJson> ActivationForm::expand(const ActivationSpec& activation) const {
  return has_keys(activation.kind) ? expand_map(activation) : kKind.expand(activation.kind);
}

OrderedJson ActivationForm::schema(const ActivationSpec& /*names the type*/,
                                   SchemaDefinitions& definitions) const {
  return defined(definitions, "activation", [&] {
    std::string meanings;
    OrderedJson words = OrderedJson::array();
    for (const auto& choice : kActivationWords) {
      meanings +=
          fmt::format("{} {}: {}", meanings.empty() ? ":" : ";", choice.word, choice.description);
      if (choice.value != ActivationKind::quadratic_barrier) words.push_back(choice.word);
    }
    return OrderedJson{
        {"title", "Activation"},
        {"default", "quadratic"},
        {"description", "How a residual r becomes a cost" + meanings},
        {"anyOf", {{{"enum", std::move(words)}}, map_schema<ActivationSpec>(definitions)}},
        {"examples", OrderedJson::parse(R"(["quadratic", {"kind": "smooth_l1", "epsilon": 0.01},
                                            {"kind": "quadratic_barrier", "from": "urdf"}])")}};
  });
}

}  // namespace conddp
