#include "problem_file/lower/rewriting.hpp"

#include "problem_file/lower/gait.hpp"
#include "problem_file/lower/grid.hpp"
#include "problem_file/lower/homotopy_numbers.hpp"
#include "problem_file/lower/loops.hpp"
#include "problem_file/lower/parameter_values.hpp"
#include "problem_file/lower/srdf.hpp"
#include "problem_file/lower/start.hpp"
#include "problem_file/lower/urdf_shapes.hpp"

namespace conddp {

std::span<const DocumentRewriting> document_rewritings() {
  static constexpr DocumentRewriting kAll[] = {
      {"homotopy", [](DocumentDraft& draft,
                      Diagnostics& out) { place_homotopy(draft.root, draft.homotopy_share, out); }},
      {"parameters", [](DocumentDraft& draft,
                        Diagnostics& out) { draft.names = place_parameters(draft.root, out); }},
  };
  return kAll;
}

std::span<const SpecRewriting> spec_rewritings() {
  static constexpr SpecRewriting kAll[] = {
      {"srdf", read_srdf},
      {"collision", add_urdf_shapes},
      {"gait",
       [](ProblemSpec& spec, Diagnostics& out) {
         add_gait(spec, out);
         number_knots(spec, out);
         check_knots(spec, out);  // numbers refer to these phases; later ones change them
       }},
      {"loops", add_loops},
      {"start", choose_start},
      {"mesh", cut_steps}};
  return kAll;
}

}  // namespace conddp
