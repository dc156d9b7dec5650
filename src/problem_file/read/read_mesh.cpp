#include "problem_file/read/read_sections.hpp"

namespace conddp {

void describe(Keys& keys, MeshSpec& mesh) {
  constexpr int kMostFactor = 10'000;
  static const NumberRange kError{1e-12, 1, false, false, "a number from 1e-12 to 1"};
  keys.about({.definition = "mesh",
              .title = "A grid that is refined",
              .says = "The problem is solved again on finer grids, each from the answer before, "
                      "until a replay of the controls in a tenth of the steps agrees",
              .examples = R"([{"error": 1.0e-6}])"});
  keys({.name = "error",
        .says = "How far a state may lie from that of the replay, in its unit",
        .required = true},
       mesh.error, NumberForm{kError});
  keys({"factor", "Into how many each step of the phases is cut to begin with"}, mesh.factor,
       IntegerForm{1, kMostFactor});
  for (const char* limit : {"rounds", "knots"})
    keys.removed(limit, "leave it out: refinement ends at 10000 knots");
}

}  // namespace conddp
